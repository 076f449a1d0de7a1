//! Rounding errors by reverse differentiation: the contribution of every
//! operation to the error of every output.
//!
//! One sweep back over a function gives, for a few outputs at a time
//! ([`LANES`]), the derivative of the output with respect to every value, its
//! *adjoint* (Linnainmaa 1976; Griewank and Walther, *Evaluating Derivatives*,
//! 2008, chapter 3). Three things follow from it:
//!
//! - a *bound* of an output's error, the sum of adjoint times half a unit in
//!   the last place over all operations ([`AdjointRun::outputs`]);
//! - the *signed prediction* of the error, the sum of adjoint times the
//!   rounding that an operation really made ([`AdjointRun::outputs`]);
//! - the *blame*: which operation, which source equation and which input the
//!   error comes from ([`Blame`]).
//!
//! Reason for points instead of boxes: along a chain of joints enclosures widen
//! by a constant factor per rotation (the wrapping effect) and are useless
//! after a few dozen; a sum of adjoints does not widen. Enclosures of small
//! windows are in [`super::interval`].
//!
//! Cost: a tape takes 13 bytes per operation, a run 50, a sweep 64; every sweep
//! of [`LANES`] outputs is one pass over the part of the function on which they
//! depend.

mod blame;
mod local;
mod partials;
mod precise;
mod run;
mod tape;
#[cfg(test)]
mod tests;

pub use blame::{Blame, EquationBlame, output_weights};
pub use local::half_ulp;
pub use partials::{tangent, third};
pub use run::AdjointRun;
pub use tape::{Tape, TapeSlot};

use partials::{EvaluationPair, secant};
use robovec_ir::Operation;
use robovec_num::arithmetic::Binary64;

/// Outputs differentiated at a time: one cache line of binary64 numbers.
pub const LANES: usize = 8;

/// One number per output of a sweep.
#[derive(Clone, Copy, PartialEq, Debug)]
#[repr(align(64))]
pub struct AdjointLanes(pub [f64; LANES]);

impl AdjointLanes {
    const ZERO: AdjointLanes = AdjointLanes([0.0; LANES]);

    #[inline]
    fn is_zero(&self) -> bool {
        // All lanes are looked at, which takes fewer instructions than
        // stopping early; NaN is not zero.
        self.0.iter().fold(true, |all, &lane| all & (lane == 0.0))
    }

    /// The absolute values.
    #[inline]
    fn size(&self) -> AdjointLanes {
        AdjointLanes(self.0.map(f64::abs))
    }

    /// Adds a multiple. With a factor that is not finite a lane of zeros
    /// stays: an output that does not depend on a value does not depend on
    /// its infinite derivative.
    #[inline]
    fn add_multiple(&mut self, factor: f64, other: &AdjointLanes) {
        if factor.is_finite() {
            for (sum, &lane) in self.0.iter_mut().zip(&other.0) {
                *sum += factor * lane;
            }
        } else {
            let lanes = self.0.iter_mut().zip(&other.0);
            for (sum, lane) in lanes.filter(|(_, lane)| **lane != 0.0) {
                *sum += factor * lane;
            }
        }
    }
}

/// The findings of sweeps about one output.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OutputError {
    /// The exact value, to binary64.
    pub exact: f64,
    /// Computed less exact.
    pub actual: f64,
    /// The signed prediction of `actual`.
    pub predicted: f64,
    /// No smaller than the size of `actual`; infinite where nothing can be
    /// stated, as after an overflow or a division by zero.
    pub bound: f64,
}

impl OutputError {
    /// Part that the prediction misses.
    fn miss(&self) -> f64 {
        (self.predicted - self.actual).abs()
    }
}

/// The derivatives of all operations of a function at one state.
#[derive(Clone, Debug)]
pub struct Adjoint<'a> {
    tape: &'a Tape,
    partials: Vec<[f64; 2]>,
}

/// The memory of a sweep, kept from one to the next.
#[derive(Default, Debug)]
pub struct Workspace {
    gradients: Vec<AdjointLanes>,
}

impl<'a> Adjoint<'a> {
    /// The derivatives at a state, by the values in binary64.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element.
    pub fn new(tape: &'a Tape, inputs: &[f64]) -> Adjoint<'a> {
        Adjoint::at(tape, &tape.evaluate(&Binary64, inputs))
    }

    /// The derivatives at a state whose values are known, slot by slot.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per slot.
    pub fn at(tape: &'a Tape, slots: &[f64]) -> Adjoint<'a> {
        assert_eq!(slots.len(), tape.slots(), "one number per slot");
        let nodes = 0..tape.nodes();
        let partials = nodes.map(|node| {
            let operands = tape.operands(node).map(|slot| slots[slot]);
            tangent(tape.operation(node), operands, slots[node])
        });
        Adjoint {
            tape,
            partials: partials.collect(),
        }
    }

    /// The quotients of differences between the exact values of all slots and
    /// computed ones, given these and their differences.
    fn between(tape: &'a Tape, exact: &[f64], computed: &[f64], errors: &[f64]) -> Adjoint<'a> {
        assert!(
            [exact, computed, errors]
                .iter()
                .all(|numbers| numbers.len() == tape.slots()),
            "one number per slot"
        );
        let nodes = 0..tape.nodes();
        let partials = nodes.map(|node| {
            let operands = tape.operands(node).map(|slot| EvaluationPair {
                exact: exact[slot],
                computed: computed[slot],
                error: errors[slot],
            });
            secant(tape.operation(node), operands, exact[node])
        });
        Adjoint {
            tape,
            partials: partials.collect(),
        }
    }

    /// Sweeps back from at most [`LANES`] assignments (by their places in
    /// [`robovec_ir::Function::assignments`]) and calls `visit` once for each
    /// slot on which one of them depends with the derivatives of all of them,
    /// 0 in lanes without one: nodes from the last to the first, then
    /// inputs and constants.
    ///
    /// # Panics
    ///
    /// Panics when more than [`LANES`] outputs are requested or one does not
    /// exist.
    pub fn sweep_lanes(
        &self,
        workspace: &mut Workspace,
        outputs: &[usize],
        visit: impl FnMut(usize, &AdjointLanes),
    ) {
        let slots = outputs.iter().map(|&output| self.tape.output_slot(output));
        let slots: Vec<usize> = slots.collect();
        self.sweep_slots(workspace, &slots, visit);
    }

    /// As [`Adjoint::sweep_lanes`], from any slots.
    ///
    /// # Panics
    ///
    /// Panics when more than [`LANES`] slots are requested or one does not
    /// exist.
    pub fn sweep_slots(
        &self,
        workspace: &mut Workspace,
        slots: &[usize],
        mut visit: impl FnMut(usize, &AdjointLanes),
    ) {
        assert!(slots.len() <= LANES, "at most {LANES} at a time");
        let tape = self.tape;
        let gradients = &mut workspace.gradients;
        // Every sweep leaves zeros behind, so only the first fills them in.
        gradients.resize(tape.slots(), AdjointLanes::ZERO);
        let mut end = 0;
        for (lane, &slot) in slots.iter().enumerate() {
            gradients[slot].0[lane] += 1.0;
            if slot < tape.nodes() {
                end = end.max(slot + 1);
            }
        }
        for node in (0..end).rev() {
            let gradient = gradients[node];
            if gradient.is_zero() {
                continue;
            }
            gradients[node] = AdjointLanes::ZERO;
            visit(node, &gradient);
            let [first, second] = self.partials[node];
            let [a, b, c] = tape.operands(node);
            gradients[a].add_multiple(first, &gradient);
            let operation = tape.operation(node);
            if operation.arity() > 1 {
                gradients[b].add_multiple(second, &gradient);
            }
            if operation.is_fused() {
                gradients[c].add_multiple(third(operation), &gradient);
            }
        }
        let leaves = gradients.iter_mut().enumerate().skip(tape.nodes());
        for (slot, gradient) in leaves.filter(|(_, gradient)| !gradient.is_zero()) {
            visit(slot, gradient);
            *gradient = AdjointLanes::ZERO;
        }
    }
}

/// True for operations whose result is an operand or its negative.
fn only_moves(operation: Operation) -> bool {
    matches!(operation, Operation::Copy | Operation::Neg)
}
