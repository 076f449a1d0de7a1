//! Ranges of the leaves of windows.

use super::super::adjoint::{Tape, TapeSlot};
use robovec_ir::View;
use robovec_ir::states::States;
use robovec_num::arithmetic::Binary64;
use robovec_num::interval::Interval;

/// The factor by which a value is assumed to range wider than the hull of its
/// samples: twice, about the same middle.
pub const MARGIN: f64 = 2.0;

robovec_num::named! {
    /// The basis of a range, the best first.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
    pub enum RangeBasis {
        /// It is that of a literal, or given for the input.
        Given = "given",
        /// It is the range from which random states draw the input.
        Drawn = "drawn",
        /// It is the hull of a value's samples with a margin, without proof.
        Assumed = "assumed",
    }
}

/// The range of a leaf.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LeafRange {
    /// The range of its values.
    pub range: Interval,
    /// Basis of the range.
    pub knowledge: RangeBasis,
}

/// The range of every input element of a function, as given by the states.
pub fn input_ranges(view: View<'_>, states: &States) -> Vec<LeafRange> {
    let mut inputs = Vec::with_capacity(view.function.input_len());
    for array in view.function.inputs() {
        let name = view.tables.symbols.text(array.name);
        for offset in 0..array.shape.len() as u32 {
            let (indices, _) = array.shape.indices(offset);
            let given = states.ranges().get(name, indices).is_some();
            let [low, high] = states.bounds(name, array, offset);
            inputs.push(LeafRange {
                range: Interval::new(low, high),
                knowledge: if given {
                    RangeBasis::Given
                } else {
                    RangeBasis::Drawn
                },
            });
        }
    }
    inputs
}

/// The ranges of all possible leaves of the windows of a function.
#[derive(Clone, Debug)]
pub struct Leaves<'a> {
    tape: &'a Tape,
    inputs: Vec<LeafRange>,
    /// The hull of the samples of every node.
    hulls: Vec<Interval>,
}

impl<'a> Leaves<'a> {
    /// The ranges of a function's inputs as given by the states, and of its
    /// nodes from this number of states.
    pub fn new(view: View<'_>, tape: &'a Tape, states: &States, samples: u32) -> Leaves<'a> {
        let inputs = input_ranges(view, states);
        let empty = Interval {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        };
        let mut hulls = vec![empty; tape.nodes()];
        for state in 0..samples {
            let values = tape.evaluate(&Binary64, &states.draw(view, state));
            for (hull, &value) in hulls.iter_mut().zip(&values) {
                *hull = hull.hull(Interval::point(value));
            }
        }
        Leaves {
            tape,
            inputs,
            hulls,
        }
    }

    /// The range of a slot as a leaf.
    pub fn of(&self, slot: usize) -> LeafRange {
        match self.tape.slot(slot) {
            TapeSlot::Input(input) => self.inputs[input.index()],
            TapeSlot::Constant(constant) => LeafRange {
                range: Interval::point(self.tape.constants()[constant.index()]),
                knowledge: RangeBasis::Given,
            },
            TapeSlot::Nothing => LeafRange {
                range: Interval::ZERO,
                knowledge: RangeBasis::Given,
            },
            TapeSlot::Value(value) => LeafRange {
                range: assumed(self.hulls[value.index()]),
                knowledge: RangeBasis::Assumed,
            },
        }
    }
}

/// A hull widened by [`MARGIN`] about its middle; a single number that much
/// to both sides.
fn assumed(hull: Interval) -> Interval {
    if hull.low > hull.high {
        // Nothing was sampled.
        return Interval::WHOLE;
    }
    let half = 0.5 * (hull.high - hull.low);
    let half = if half > 0.0 { half } else { hull.magnitude() };
    hull.widened((MARGIN - 1.0) * half)
}
