//! Bounds over boxes: branch and bound on the ranges of a window's leaves.
//!
//! One enclosure bounds every operation alone, at the ranges where it loses
//! most. The state is not at all of these places together, and intervals do not
//! account for two operands that read one leaf. In small boxes neither matters:
//! the bound of a box tends to the sum over operations of adjoint times loss at
//! one state. So the box with the largest bound is cut in two until the bound
//! is near the value at a state, or the work is spent. The bound holds at every
//! moment, since the boxes left cover the ranges.

use super::{ConeWindow, WindowEnclosure, WindowLeaves, enclose};
use crate::adjoint::Tape;
use robovec_num::interval::Interval;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Leaves that are tried for a cut.
const TRIED: usize = 8;

/// Relative distance of the bound from that at a state at which cutting ends.
const NEAR: f64 = 1.0 / 128.0;

/// Quotient of the ends of a range beyond which it is cut at their geometric
/// mean.
const FAR: f64 = 4.0;

/// Results over boxes.
#[derive(Clone, PartialEq, Debug)]
pub struct SubdividedEnclosure {
    /// The range of the exact value.
    pub range: Interval,
    /// The error at most, over all boxes.
    pub error: f64,
    /// The part of the ranges, by volume, in which the error is finite.
    pub share: f64,
    /// The error at most in that part.
    pub finite: f64,
    /// Bound at the worst state that was tested: cutting on would not lower it
    /// further.
    pub at_a_state: f64,
    /// Boxes that cover the ranges.
    pub boxes: usize,
    /// Enclosures that were computed.
    pub enclosures: usize,
    /// The box with the largest bound.
    pub worst: Vec<Interval>,
}

/// A box, with its bounds.
struct LeafBox {
    ranges: Vec<Interval>,
    range: Interval,
    error: f64,
    /// Number of cuts: its volume is this number of halves of the whole.
    cuts: u32,
    /// Its number.
    index: usize,
}

/// The largest error first, then the box made first.
impl Ord for LeafBox {
    fn cmp(&self, other: &LeafBox) -> Ordering {
        let errors = self.error.total_cmp(&other.error);
        // Of boxes of which nothing is known the largest.
        let key = |leaf_box: &LeafBox| (Reverse(leaf_box.cuts), Reverse(leaf_box.index));
        errors.then_with(|| key(self).cmp(&key(other)))
    }
}

impl PartialOrd for LeafBox {
    fn partial_cmp(&self, other: &LeafBox) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for LeafBox {
    fn eq(&self, other: &LeafBox) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for LeafBox {}

struct BoxSearch<'a> {
    tape: &'a Tape,
    window: &'a ConeWindow,
    leaves: &'a WindowLeaves,
    /// Enclosures that may still be computed.
    left: usize,
    made: usize,
    /// Bound at the worst state that was tested.
    at_a_state: f64,
}

/// Bounds the error of a window over boxes, with at most this number of
/// enclosures.
pub fn subdivide(
    tape: &Tape,
    window: &ConeWindow,
    leaves: &WindowLeaves,
    most: usize,
) -> SubdividedEnclosure {
    let most = most.max(1);
    let mut search = BoxSearch {
        tape,
        window,
        leaves,
        left: most,
        made: 0,
        at_a_state: 0.0,
    };
    let whole = search.leaf_box(leaves.ranges.clone(), 0);
    let mut open = BinaryHeap::from([whole]);
    let mut done = Vec::new();
    while let Some(worst) = open.pop() {
        search.at_a_state = search.at_a_state.max(search.at(&worst.ranges));
        let near = worst.error <= search.at_a_state * (1.0 + NEAR);
        if near || search.left == 0 {
            open.push(worst);
            break;
        }
        match search.cut(&worst) {
            Some(halves) => open.extend(halves),
            None => done.push(worst),
        }
    }
    done.extend(open);
    done.sort_by(|a, b| b.cmp(a));
    summary(done, search.at_a_state, most - search.left)
}

/// Summary over boxes, the worst of which is the first.
fn summary(mut boxes: Vec<LeafBox>, at_a_state: f64, enclosures: usize) -> SubdividedEnclosure {
    let ranges = boxes.iter().map(|leaf_box| leaf_box.range);
    let range = ranges.reduce(Interval::hull);
    let finite = || boxes.iter().filter(|leaf_box| leaf_box.error.is_finite());
    // The smallest first, so that none is lost beside large ones.
    let mut cuts: Vec<u32> = finite().map(|leaf_box| leaf_box.cuts).collect();
    cuts.sort_unstable_by_key(|&cuts| Reverse(cuts));
    let share = cuts.iter().map(|&cuts| 0.5f64.powi(cuts as i32)).sum();
    SubdividedEnclosure {
        range: range.expect("the boxes cover the ranges"),
        error: boxes[0].error,
        share,
        finite: finite().map(|leaf_box| leaf_box.error).fold(0.0, f64::max),
        at_a_state,
        boxes: boxes.len(),
        enclosures,
        worst: boxes.swap_remove(0).ranges,
    }
}

impl BoxSearch<'_> {
    fn enclose(&mut self, ranges: &[Interval]) -> WindowEnclosure {
        self.left = self.left.saturating_sub(1);
        enclose(self.tape, self.window, self.leaves, ranges)
    }

    fn leaf_box(&mut self, ranges: Vec<Interval>, cuts: u32) -> LeafBox {
        let enclosure = self.enclose(&ranges);
        self.made += 1;
        LeafBox {
            range: enclosure.exact.last().copied().unwrap_or(Interval::WHOLE),
            error: enclosure.error,
            ranges,
            cuts,
            index: self.made,
        }
    }

    /// The bound at a state, other leaves in the middle of their ranges; zero
    /// where it has no end, since that is no reason to stop.
    fn at(&mut self, ranges: &[Interval]) -> f64 {
        let points = ranges.iter().map(|&range| Interval::point(middle(range)));
        let points: Vec<Interval> = points.collect();
        let error = self.enclose(&points).error;
        if error.is_finite() { error } else { 0.0 }
    }

    /// The halves of a box; `None` when no number lies between the ends of its
    /// ranges.
    fn cut(&mut self, worst: &LeafBox) -> Option<[LeafBox; 2]> {
        let leaf = self.chosen(worst)?;
        let range = worst.ranges[leaf];
        let middle = middle(range);
        Some(
            [(range.low, middle), (middle, range.high)].map(|(low, high)| {
                let mut ranges = worst.ranges.clone();
                ranges[leaf] = Interval::new(low, high);
                let mut half = self.leaf_box(ranges, worst.cuts + 1);
                // What holds in the whole box holds in its halves, where
                // enclosures need not be tighter.
                half.error = half.error.min(worst.error);
                half
            }),
        )
    }

    /// The leaf to cut: the widest of those without whose range the bound would
    /// be the lowest.
    ///
    /// A cut in two may lower the bound of neither half although more cuts in
    /// the same leaf do (of a range about zero). So slices are enclosed, at both
    /// ends and in the middle of a range: cuts can reach the worst of them.
    fn chosen(&mut self, worst: &LeafBox) -> Option<usize> {
        let candidates = self.candidates(&worst.ranges);
        if candidates.len() < 2 {
            return candidates.first().copied();
        }
        let mut state = worst.ranges.clone();
        let mut reached = Vec::with_capacity(candidates.len());
        for &leaf in &candidates {
            let Interval { low, high } = worst.ranges[leaf];
            let mut slice = worst.ranges.clone();
            let mut largest = f64::NEG_INFINITY;
            for place in [middle(worst.ranges[leaf]), low, high] {
                slice[leaf] = Interval::point(place);
                let error = self.enclose(&slice).error;
                if error > largest {
                    largest = error;
                    state[leaf] = slice[leaf];
                }
            }
            reached.push(largest);
        }
        self.at_a_state = self.at_a_state.max(self.at(&state));
        let least = reached.iter().copied().fold(f64::INFINITY, f64::min);
        let near = if worst.error.is_finite() {
            least + NEAR * worst.error
        } else {
            least
        };
        let place = reached.iter().position(|&error| error <= near)?;
        Some(candidates[place])
    }

    /// The leaves that a box can be cut in, the widest relative to its range
    /// first, of those with equal widths the first one.
    fn candidates(&self, ranges: &[Interval]) -> Vec<usize> {
        let width = |leaf: usize| {
            let (part, whole) = (ranges[leaf], self.leaves.ranges[leaf]);
            if is_far(part) {
                return 1.0;
            }
            (part.high - part.low) / (whole.high - whole.low)
        };
        let can = |&leaf: &usize| {
            let range = ranges[leaf];
            let middle = middle(range);
            range.low < middle && middle < range.high
        };
        let mut leaves: Vec<usize> = (0..ranges.len()).filter(can).collect();
        leaves.sort_by(|&a, &b| width(b).total_cmp(&width(a)));
        leaves.truncate(TRIED);
        leaves
    }
}

/// True for numbers of one sign and very different sizes.
fn is_far(range: Interval) -> bool {
    let (small, large) = (range.mignitude(), range.magnitude());
    small > 0.0 && large.is_finite() && large / small > FAR
}

/// A number between the ends of a range; NaN for one without ends. Of numbers
/// of very different sizes it is the geometric mean: quotients by them vary as
/// their logarithms.
fn middle(range: Interval) -> f64 {
    if is_far(range) {
        let mean = range.mignitude().sqrt() * range.magnitude().sqrt();
        return mean.copysign(range.low);
    }
    0.5 * range.low + 0.5 * range.high
}
