//! Bounds of whole functions: ranges and rounding errors that hold in every
//! state, by norms of vectors in place of intervals.
//!
//! Along a chain of rotations the box of a vector grows at every joint, its
//! *norm* does not, nor does the norm of its error. A set of values is
//! taken as a vector; its norm and that of its error follow from the
//! definitions of its members, the latest first ([`layers`]):
//!
//! - a row `a c + b s` whose factors `c` and `s` have norm 1 is replaced by
//!   its operands `a` and `b`, once for two rows that are orthogonal, and the
//!   members that are not rotated stay beside them;
//! - products with a common factor are that factor times a vector;
//! - disjoint members add as squares, others by the triangle inequality.
//!
//! No vector has to be recognised: every set of values is one, and a set that
//! fits no rule has the norm of its members' intervals. Soundness therefore
//! never depends on the choice of sets, only tightness does.
//!
//! With `y = M x` and computed `y' = M' x'`, `y' - y = M' (x' - x) + (M' - M)
//! x`, and every operation inside adds its own rounding: no second-order term
//! is left out.

mod layers;
mod terms;
#[cfg(test)]
mod tests;

use crate::adjoint::{Tape, TapeSlot};
use crate::interval::{GivenData, given, operate, rounded};
use layers::{Layer, LayerFactor, decompose, is_pair};
use robovec_ir::{Format, Operation};
use robovec_num::interval::Interval;
use std::collections::HashMap;

/// Factor that covers the roundings of the bounds' own arithmetic, fewer than a
/// thousand operations of binary64 per rule.
const OUTWARD: f64 = 1.0 + 1e-12;

/// Maximum number of sets bounded, per node.
const SETS: usize = 64;

/// Ranges and errors of all slots of a tape.
#[derive(Clone, Debug)]
pub struct NormBounds {
    /// Range of the exact value.
    pub exact: Vec<Interval>,
    /// Largest absolute difference between the computed value and the exact
    /// one; infinite where nothing is proved.
    pub error: Vec<f64>,
}

/// Norms of a set of values.
#[derive(Clone, Copy, PartialEq, Debug)]
struct SetNorm {
    /// Largest norm of the exact values.
    exact: f64,
    /// Largest norm of their errors.
    error: f64,
}

/// A sorted list of slots, one of them more than once where a vector has
/// equal elements.
type SlotSet = Vec<usize>;

/// Bounds every value of a tape, given the range of every input element.
///
/// # Panics
///
/// Panics when there is not one range per input element.
pub fn norm_bounds(
    tape: &Tape,
    inputs: &[Interval],
    format: Format,
    data: GivenData,
) -> NormBounds {
    assert_eq!(inputs.len(), tape.inputs(), "one range per input element");
    let mut norms = Norms::new(tape, inputs, format, data);
    for node in 0..tape.nodes() {
        norms.value(node);
    }
    NormBounds {
        exact: norms.exact,
        error: norms.error,
    }
}

struct Norms<'a> {
    tape: &'a Tape,
    format: Format,
    exact: Vec<Interval>,
    error: Vec<f64>,
    /// Largest loss of every node by its own rounding.
    local: Vec<f64>,
    uses: Vec<u32>,
    known: HashMap<SlotSet, SetNorm>,
    /// Maximum number of sets in `known`.
    most: usize,
}

impl<'a> Norms<'a> {
    fn new(tape: &'a Tape, inputs: &[Interval], format: Format, data: GivenData) -> Norms<'a> {
        let mut norms = Norms {
            tape,
            format,
            exact: vec![Interval::ZERO; tape.slots()],
            error: vec![0.0; tape.slots()],
            local: vec![0.0; tape.slots()],
            uses: terms::uses(tape),
            known: HashMap::new(),
            most: SETS * tape.nodes() + 4096,
        };
        for slot in tape.nodes()..tape.slots() {
            let range = match tape.slot(slot) {
                TapeSlot::Input(input) => inputs[input.index()],
                TapeSlot::Constant(constant) => Interval::point(tape.constants()[constant.index()]),
                TapeSlot::Nothing | TapeSlot::Value(_) => Interval::ZERO,
            };
            let (exact, _, lost) = given(tape.slot(slot).into(), data, format, range);
            norms.exact[slot] = exact;
            norms.error[slot] = lost;
        }
        norms
    }

    /// The range of a slot's value in the format.
    fn computed(&self, slot: usize) -> Interval {
        let error = self.error[slot];
        if error == 0.0 {
            self.exact[slot]
        } else if error.is_finite() {
            self.exact[slot].widened(error)
        } else {
            Interval::WHOLE
        }
    }

    /// Bounds the next value, first from those of its operands, then as a
    /// vector of one element.
    fn value(&mut self, node: usize) {
        let operation = self.tape.operation(node);
        let places = self.tape.operands(node);
        self.exact[node] = operate(operation, &places, &self.exact);
        let carried = self.carried(operation, places);
        self.round(node, carried);
        let sum = matches!(
            operation,
            Operation::Add | Operation::Sub | Operation::Fma | Operation::Fms | Operation::Fnma
        );
        if !sum {
            return;
        }
        let mut norm = self.norm(vec![node]);
        if norm.exact < self.exact[node].magnitude() {
            self.exact[node] = self.exact[node].clamped(Interval::within(norm.exact));
            // In the smaller range its own rounding loses less.
            self.round(node, carried);
            norm = self.norm(vec![node]);
        }
        self.error[node] = norm.error.min(self.error[node]);
    }

    /// Sets the loss and the error of a node, given the error of its
    /// operands.
    fn round(&mut self, node: usize, carried: f64) {
        let operation = self.tape.operation(node);
        if !carried.is_finite() || !self.exact[node].is_finite() {
            self.local[node] = f64::INFINITY;
            self.error[node] = f64::INFINITY;
            return;
        }
        let operands = self.tape.operands(node).map(|slot| self.computed(slot));
        let before = self.exact[node].widened(carried);
        let (_, lost) = rounded(operation, operands, before, self.format);
        self.local[node] = lost;
        self.error[node] = if carried + lost == 0.0 {
            0.0
        } else {
            (carried + lost) * OUTWARD
        };
    }

    /// The error of a result that comes from the errors of its operands.
    fn carried(&self, operation: Operation, places: [usize; 3]) -> f64 {
        let [a, b, c] = places.map(|slot| self.error[slot]);
        let size = |operand: usize| self.exact[places[operand]].magnitude();
        let product = || carried(size(1), a) + carried(size(0), b) + carried(a, b);
        let error = match operation {
            Operation::Copy | Operation::Neg | Operation::Sin | Operation::Cos => a,
            Operation::Add | Operation::Sub => a + b,
            Operation::Mul => product(),
            Operation::Fma | Operation::Fms | Operation::Fnma => product() + c,
            Operation::Div => {
                let (least, quotient) = (self.exact[places[1]].mignitude(), size(0));
                let divisor = least - b;
                if divisor > 0.0 {
                    (a + quotient / least * b) / divisor
                } else {
                    f64::INFINITY
                }
            }
            Operation::Sqrt if a == 0.0 => 0.0,
            Operation::Sqrt => {
                let (exact, computed) = (self.exact[places[0]].low, self.computed(places[0]).low);
                if computed >= 0.0 {
                    (a / (exact.max(0.0).sqrt() + computed.sqrt())).min(a.sqrt())
                } else {
                    f64::INFINITY
                }
            }
        };
        if error.is_nan() {
            f64::INFINITY
        } else {
            error * OUTWARD
        }
    }

    /// The norms of a set, from the definitions of its members as far as
    /// that is better than their intervals. Those of its parts are kept; its
    /// own are not, since the bounds of a value change while it is bounded.
    fn norm(&mut self, set: SlotSet) -> SetNorm {
        let root = set.clone();
        let mut open: Vec<(SlotSet, Option<Layers>)> = vec![(set, None)];
        while let Some((set, layers)) = open.pop() {
            if self.known.contains_key(&set) {
                continue;
            }
            let base = self.base(&set);
            // One value has its bounds already, but for the one asked for.
            let single = set.len() == 1 && set != root;
            if single || self.known.len() > self.most {
                self.known.insert(set, base);
                continue;
            }
            let layers = layers.or_else(|| decompose(self.tape, &self.uses, &set));
            let Some(layers) = layers else {
                self.known.insert(set, base);
                continue;
            };
            let wanted: Vec<SlotSet> = layers
                .sets()
                .filter(|set| !self.known.contains_key(*set))
                .cloned()
                .collect();
            if wanted.is_empty() {
                let found = self.combine(&layers);
                let best = SetNorm {
                    exact: found.exact.min(base.exact),
                    error: found.error.min(base.error),
                };
                self.known.insert(set, best);
            } else {
                open.push((set, Some(layers)));
                open.extend(wanted.into_iter().map(|set| (set, None)));
            }
        }
        let found = self.known.remove(&root);
        found.expect("the set is bounded after its parts")
    }

    /// The norms of a set from the bounds of its members alone.
    fn base(&self, set: &[usize]) -> SetNorm {
        if let &[one, other] = set
            && is_pair(self.tape, one, other)
        {
            let argument = self.tape.operands(one)[0];
            let lost = length([self.local[one], self.local[other]]);
            return SetNorm {
                exact: 1.0,
                error: (self.error[argument] + lost) * OUTWARD,
            };
        }
        let exact = set.iter().map(|&slot| self.exact[slot].magnitude());
        SetNorm {
            exact: length(exact),
            error: length(set.iter().map(|&slot| self.error[slot])),
        }
    }

    /// The norms of a sum of layers.
    fn combine(&self, layers: &Layers) -> SetNorm {
        // Layers with disjoint members add as squares.
        let mut groups: Vec<(u64, Vec<SetNorm>)> = Vec::new();
        for layer in &layers.parts {
            let norm = self.layer(layer);
            match groups
                .iter_mut()
                .find(|(members, _)| members & layer.members == 0)
            {
                Some((members, norms)) => {
                    *members |= layer.members;
                    norms.push(norm);
                }
                None => groups.push((layer.members, vec![norm])),
            }
        }
        let total = |of: fn(&SetNorm) -> f64| -> f64 {
            groups
                .iter()
                .map(|(_, norms)| length(norms.iter().map(of)))
                .sum()
        };
        let lost = layers.nodes.iter().map(|nodes| {
            let nodes = nodes.iter().map(|&node| self.local[node]);
            nodes.sum::<f64>()
        });
        SetNorm {
            exact: total(|norm| norm.exact) * OUTWARD,
            error: (total(|norm| norm.error) + length(lost)) * OUTWARD,
        }
    }

    /// The norms of one layer: of a matrix in blocks times a vector.
    fn layer(&self, layer: &Layer) -> SetNorm {
        let set = self.known[&layer.set];
        let (mut scale, mut factor_error) = (f64::from(layer.kept), f64::from(layer.kept));
        let mut moved = Vec::new();
        for block in &layer.blocks {
            let norm = self.factor(&block.factor);
            scale = scale.max(norm.exact);
            factor_error = factor_error.max(norm.exact + norm.error);
            moved.push(carried(self.known[&block.operands].exact, norm.error));
        }
        let found = SetNorm {
            exact: times(scale, set.exact) * OUTWARD,
            error: (carried(factor_error, set.error) + length(moved)) * OUTWARD,
        };
        if layer.products.is_empty() {
            return found;
        }
        let mut sum = SetNorm {
            exact: 0.0,
            error: 0.0,
        };
        for &(a, b) in &layer.products {
            let [a, b] = [a, b].map(|slot| (self.exact[slot].magnitude(), self.error[slot]));
            sum.exact += times(a.0, b.0);
            sum.error += carried(b.0, a.1) + carried(a.0, b.1) + carried(a.1, b.1);
        }
        SetNorm {
            exact: found.exact.min(sum.exact * OUTWARD),
            error: found.error.min(sum.error * OUTWARD),
        }
    }

    /// The norm of a factor and of its error.
    fn factor(&self, factor: &LayerFactor) -> SetNorm {
        match factor {
            LayerFactor::Value(slot) => SetNorm {
                exact: self.exact[*slot].magnitude(),
                error: self.error[*slot],
            },
            LayerFactor::Inverse(slot) => {
                let (least, error) = (self.exact[*slot].mignitude(), self.error[*slot]);
                let computed = least - error;
                SetNorm {
                    exact: 1.0 / least,
                    error: if computed > 0.0 {
                        error / least / computed
                    } else {
                        f64::INFINITY
                    },
                }
            }
            LayerFactor::Row(set) => self.known[set],
        }
    }
}

/// A set as a sum of layers.
struct Layers {
    parts: Vec<Layer>,
    /// The nodes inside the definitions, per member.
    nodes: Vec<Vec<usize>>,
}

impl Layers {
    /// The sets whose norms it needs.
    fn sets(&self) -> impl Iterator<Item = &SlotSet> {
        self.parts.iter().flat_map(|layer| {
            let blocks = layer.blocks.iter().flat_map(|block| {
                let row = match &block.factor {
                    LayerFactor::Row(set) => Some(set),
                    _ => None,
                };
                row.into_iter().chain([&block.operands])
            });
            blocks.chain([&layer.set])
        })
    }
}

/// An error times a factor; an unbounded error stays unbounded, even times
/// zero.
fn carried(factor: f64, error: f64) -> f64 {
    if error == 0.0 || error.is_infinite() {
        error
    } else {
        factor * error
    }
}

/// A product of bounds of exact values, in which zero wins over infinity.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// The Euclidean norm, without overflow and underflow of squares.
fn length(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let numbers: Vec<f64> = numbers.into_iter().collect();
    let largest = numbers.iter().copied().fold(0.0, f64::max);
    if numbers.iter().any(|number| number.is_nan()) || largest.is_infinite() {
        return f64::INFINITY;
    }
    if largest == 0.0 {
        return 0.0;
    }
    if let [one] = numbers[..] {
        return one;
    }
    let squares = numbers.iter().map(|number| (number / largest).powi(2));
    largest * squares.sum::<f64>().sqrt() * OUTWARD
}
