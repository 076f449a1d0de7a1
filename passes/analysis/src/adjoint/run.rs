//! A run of a function in a number format, beside the exact one.

use super::precise::PreciseRun;
use super::{Adjoint, AdjointLanes, LANES, OutputError, Tape, Workspace, local};
use robovec_ir::evaluate::evaluate_mixed_nodes;
use robovec_ir::{Format, Function, Value};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::soft_float::FormatArithmetic;

/// The part of a bound that prediction and error may differ by; where they
/// differ by more, adjoints have cancelled and are computed again.
const CANCELLED: f64 = 1.0 / (1u64 << 24) as f64;

/// A run of a function in a format at one state: the computed values, the exact
/// ones, and the rounding error of every operation. All vectors are indexed by
/// slots of the [`Tape`].
#[derive(Clone, Debug)]
pub struct AdjointRun<'a> {
    tape: &'a Tape,
    exact: Vec<f64>,
    computed: Vec<f64>,
    errors: Vec<f64>,
    local: Vec<f64>,
    bounds: Vec<f64>,
}

/// Covers the rounding of the sums over adjoints themselves, which are computed
/// in binary64: a part of 2⁻²⁰ is far above it for any function that fits into
/// memory and far below the printed precision of a bound.
const SUMS: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;

impl<'a> AdjointRun<'a> {
    /// Runs a function in an arithmetic that computes in a format.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element.
    pub fn new<A>(tape: &'a Tape, arithmetic: &A, format: Format, inputs: &[f64]) -> AdjointRun<'a>
    where
        A: Arithmetic,
        A::Number: Into<f64>,
    {
        let computed = tape.evaluate(arithmetic, inputs);
        let computed = computed.into_iter().map(Into::into).collect();
        AdjointRun::beside(tape, computed, |_| format, inputs)
    }

    /// Runs a function in a format, its values in their own formats where
    /// it gives them some. The tape is the function's.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element.
    pub fn of(
        function: &Function,
        tape: &'a Tape,
        format: Format,
        inputs: &[f64],
    ) -> AdjointRun<'a> {
        assert_eq!(
            function.nodes().len(),
            tape.nodes(),
            "the tape is the function's"
        );
        let arithmetic = FormatArithmetic::new(format);
        let Some(formats) = &function.formats else {
            return AdjointRun::new(tape, &arithmetic, format, inputs);
        };
        let mut computed = evaluate_mixed_nodes(function, format, inputs);
        computed.extend(inputs.iter().map(|&input| arithmetic.convert(input)));
        // A literal is rounded by the operation that reads it, differently by
        // each, so its slot holds the literal itself.
        computed.extend(tape.constants().iter().chain(&[0.0]));
        let own = |node: usize| formats.get(Value(node as u32)).unwrap_or(format);
        AdjointRun::beside(tape, computed, own, inputs)
    }

    /// The computed slots with the known numbers beside them.
    fn beside(
        tape: &'a Tape,
        computed: Vec<f64>,
        format: impl Fn(usize) -> Format,
        inputs: &[f64],
    ) -> AdjointRun<'a> {
        let exact = tape.evaluate(&DoubleDouble, inputs);
        assert_eq!(computed.len(), exact.len(), "one number per slot");
        let both = exact.iter().zip(&computed);
        let errors = both.map(|(exact, &computed)| (Double::from(computed) - *exact).high);
        let errors = errors.collect();
        let exact: Vec<f64> = exact.into_iter().map(|number| number.high).collect();
        let local = local::errors(tape, &exact, &computed);
        AdjointRun {
            tape,
            bounds: local::bounds(tape, format, [&exact, &computed, &local]),
            local,
            exact,
            computed,
            errors,
        }
    }

    /// The tape that was run.
    pub fn tape(&self) -> &'a Tape {
        self.tape
    }

    /// The exact number of every slot, to binary64.
    pub fn exact(&self) -> &[f64] {
        &self.exact
    }

    /// The number that was computed for every slot.
    pub fn computed(&self) -> &[f64] {
        &self.computed
    }

    /// The error of every slot: computed less exact.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// The local error of every slot's operation: its result minus the exact
    /// one on the same operands; for inputs and literals the error of the
    /// conversion.
    pub fn local_errors(&self) -> &[f64] {
        &self.local
    }

    /// The most that the operation of every slot could lose.
    pub fn local_bounds(&self) -> &[f64] {
        &self.bounds
    }

    /// The derivatives between the exact and the computed run: quotients of
    /// differences, with which errors add up without a second-order term.
    pub fn adjoint(&self) -> Adjoint<'a> {
        Adjoint::between(self.tape, &self.exact, &self.computed, &self.errors)
    }

    /// Actual error, prediction and bound of assignments, by their places in
    /// [`robovec_ir::Function::assignments`].
    ///
    /// The bound covers this run whatever its rounding errors: the adjoints are
    /// those between the exact and the computed values, so no second-order term
    /// is left out, and the part that the prediction misses is added. For runs
    /// with other rounding errors it is of first order, since adjoints change
    /// with the errors and a result that crosses a power of two rounds by twice
    /// as much. It is computed in binary64, and widened by 2⁻²⁰ of its value
    /// for that; where the prediction shows that adjoints cancelled, in 1024
    /// bits.
    ///
    /// # Panics
    ///
    /// Panics when an output does not exist.
    pub fn outputs(&self, outputs: &[usize]) -> Vec<OutputError> {
        let slots = outputs.iter().map(|&output| self.tape.output_slot(output));
        self.slots(&slots.collect::<Vec<usize>>())
    }

    /// As [`AdjointRun::outputs`], for any slots.
    ///
    /// # Panics
    ///
    /// Panics when a slot does not exist.
    pub fn slots(&self, slots: &[usize]) -> Vec<OutputError> {
        let adjoint = self.adjoint();
        let mut workspace = Workspace::default();
        let mut results = Vec::with_capacity(slots.len());
        let mut precise = None;
        for group in slots.chunks(LANES) {
            let (mut predicted, mut bound) = (AdjointLanes::ZERO, AdjointLanes::ZERO);
            adjoint.sweep_slots(&mut workspace, group, |slot, gradient| {
                let (signed, largest) = (self.local[slot], self.bounds[slot]);
                // A bound that is NaN is neither.
                if largest != 0.0 {
                    predicted.add_multiple(signed, gradient);
                    bound.add_multiple(largest, &gradient.size());
                }
            });
            results.extend(group.iter().enumerate().map(|(lane, &slot)| {
                self.output(slot, (predicted.0[lane], bound.0[lane]), &mut precise)
            }));
        }
        results
    }

    /// Sums over adjoints at a slot, taken again with more digits where they
    /// cancelled.
    fn output(
        &self,
        slot: usize,
        (predicted, bound): (f64, f64),
        precise: &mut Option<PreciseRun<'a>>,
    ) -> OutputError {
        let mut output = OutputError {
            exact: self.exact[slot],
            actual: self.errors[slot],
            predicted,
            bound,
        };
        if output.miss() > CANCELLED * bound && bound.is_finite() {
            if precise.is_none() {
                let inputs = &self.exact[self.tape.nodes()..][..self.tape.inputs()];
                *precise = PreciseRun::new(self.tape, &self.computed, inputs);
            }
            if let Some(precise) = precise {
                output = precise.sweep(slot, &self.bounds);
            }
        }
        output.bound = output.bound * SUMS + output.miss();
        if output.bound.is_nan() {
            output.bound = f64::INFINITY;
        }
        output
    }
}
