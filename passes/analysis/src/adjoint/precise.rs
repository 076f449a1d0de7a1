//! Sweeps in 1024 bits, where binary64 has no digits left.
//!
//! Adjoints are sums over paths, and paths may cancel: after a subtraction of
//! two numbers near 10^44 only rounding errors are left in binary64. Whether it
//! was so shows afterwards, since the prediction is then not the error. These
//! sweeps are for one output at a time, and every operation of theirs costs far
//! more.

use super::OutputError;
use super::partials::third;
use super::tape::Tape;
use crate::reference::precise::operate;
use crate::reference::rounding::{from_binary64, to_binary64};
use astro_float::{BigFloat, Consts, RoundingMode};
use robovec_ir::Operation;

/// More than paths of which one is 10^150 and another 10^-100 need.
const BITS: usize = 1024;

/// The derivatives between the exact and a computed run, as in
/// [`super::AdjointRun::adjoint`], and the rounding error of every operation.
pub(super) struct PreciseRun<'a> {
    tape: &'a Tape,
    exact: Vec<BigFloat>,
    computed: Vec<BigFloat>,
    /// Of every slot, computed less the exact result on computed operands.
    local: Vec<BigFloat>,
    partials: Vec<[BigFloat; 2]>,
    zero: BigFloat,
}

impl<'a> PreciseRun<'a> {
    /// A run by its computed slots and the input elements; `None` when the
    /// constants that sines need cannot be made.
    pub(super) fn new(tape: &'a Tape, computed: &[f64], inputs: &[f64]) -> Option<PreciseRun<'a>> {
        let mut constants = Consts::new().ok()?;
        let number = |number: f64| from_binary64(number, BITS);
        let computed: Vec<BigFloat> = computed.iter().map(|&slot| number(slot)).collect();
        let zero = number(0.0);
        let mut exact = vec![zero.clone(); tape.nodes()];
        let leaves = inputs.iter().chain(tape.constants()).chain(&[0.0]);
        exact.extend(leaves.map(|&leaf| number(leaf)));
        let (mut local, mut partials) = (Vec::new(), Vec::new());
        for node in 0..tape.nodes() {
            let operation = tape.operation(node);
            let slots = tape.operands(node);
            let mut apply = |slots: [&BigFloat; 3]| operate(operation, slots, BITS, &mut constants);
            exact[node] = apply(slots.map(|slot| &exact[slot]));
            let result = apply(slots.map(|slot| &computed[slot]));
            local.push(sub(&computed[node], &result));
            let pairs = [slots[0], slots[1]].map(|slot| [&exact[slot], &computed[slot]]);
            partials.push(secant(operation, pairs, &exact[node], &mut constants));
        }
        for slot in tape.nodes()..exact.len() {
            local.push(sub(&computed[slot], &exact[slot]));
        }
        Some(PreciseRun {
            tape,
            exact,
            computed,
            local,
            partials,
            zero,
        })
    }

    /// One sweep from a slot, given the largest rounding error of every
    /// operation.
    pub(super) fn sweep(&self, from: usize, bounds: &[f64]) -> OutputError {
        let tape = self.tape;
        let mut gradients = vec![self.zero.clone(); tape.slots()];
        gradients[from] = from_binary64(1.0, BITS);
        let (mut predicted, mut bound) = (self.zero.clone(), self.zero.clone());
        let mut visit = |slot: usize, gradient: &BigFloat| {
            if bounds[slot] != 0.0 {
                predicted = add(&predicted, &mul(gradient, &self.local[slot]));
                let most = from_binary64(bounds[slot], BITS);
                bound = add(&bound, &mul(&gradient.abs(), &most));
            }
        };
        for node in (0..tape.nodes().min(from + 1)).rev() {
            let gradient = gradients[node].clone();
            if gradient.is_zero() {
                continue;
            }
            visit(node, &gradient);
            let operation = tape.operation(node);
            let [first, second] = &self.partials[node];
            let last = from_binary64(third(operation), BITS);
            let operands = tape.operands(node).into_iter().zip([first, second, &last]);
            for (operand, factor) in operands.take(operation.arity()) {
                gradients[operand] = add(&gradients[operand], &mul(factor, &gradient));
            }
        }
        for (slot, gradient) in gradients.iter().enumerate().skip(tape.nodes()) {
            if !gradient.is_zero() {
                visit(slot, gradient);
            }
        }
        OutputError {
            exact: to_binary64(&self.exact[from]),
            actual: to_binary64(&sub(&self.computed[from], &self.exact[from])),
            predicted: to_binary64(&predicted),
            bound: to_binary64(&bound),
        }
    }
}

const ROUNDING: RoundingMode = RoundingMode::ToEven;

fn add(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.add(b, BITS, ROUNDING)
}

fn sub(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.sub(b, BITS, ROUNDING)
}

fn mul(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.mul(b, BITS, ROUNDING)
}

fn div(a: &BigFloat, b: &BigFloat) -> BigFloat {
    a.div(b, BITS, ROUNDING)
}

/// As [`super::partials::secant`]; operands are the exact number and the
/// computed one.
fn secant(
    operation: Operation,
    [a, b]: [[&BigFloat; 2]; 2],
    exact: &BigFloat,
    constants: &mut Consts,
) -> [BigFloat; 2] {
    let [none, half, one] = [0.0, 0.5, 1.0].map(|number| from_binary64(number, BITS));
    let minus = || one.neg();
    let mut wave = |of: Operation| {
        let mut apply = |of, x: &BigFloat| operate(of, [x, &none, &none], BITS, constants);
        // The mean of the angles, and sin(d)/d for half their difference.
        let distance = mul(&half, &sub(a[1], a[0]));
        let slope = apply(of, &add(a[0], &distance));
        if distance.is_zero() {
            slope
        } else {
            div(&mul(&slope, &apply(Operation::Sin, &distance)), &distance)
        }
    };
    match operation {
        Operation::Copy => [one, none],
        Operation::Neg => [minus(), none],
        Operation::Add => [one.clone(), one],
        Operation::Sub => [one.clone(), minus()],
        Operation::Mul | Operation::Fma | Operation::Fms => [b[0].clone(), a[1].clone()],
        Operation::Fnma => [b[0].neg(), a[1].neg()],
        Operation::Div => [div(&one, b[1]), div(&exact.neg(), b[1])],
        Operation::Sin => [wave(Operation::Cos), none],
        Operation::Cos => [wave(Operation::Sin).neg(), none],
        Operation::Sqrt => {
            let root = a[1].sqrt(BITS, ROUNDING);
            [div(&one, &add(&root, exact)), none]
        }
    }
}
