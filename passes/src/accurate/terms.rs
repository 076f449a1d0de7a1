//! The order of a sum, and its factored differences.
//!
//! A sum of `n` terms is computed by `n - 1` additions in the shape of a tree.
//! All its partial sums affect the outputs equally, so the cost of the
//! roundings of a tree is the sum of the squares of its partial sums, state by
//! state, each weighted with the effect of the sum on the outputs (Robertazzi
//! and Schwartz, *SIAM J. Sci. Stat. Comput.* 9, 1988, find for numbers of one
//! sign that the smallest should be added first; with signs, cancelling terms
//! should be combined first). Up to [`EXHAUSTIVE`] terms the best tree is found
//! among all, beyond that the two terms with the smallest sum are added again
//! and again; both keep to a deadline.
//!
//! Two products with a common factor that cancel are better subtracted before
//! they are multiplied: `a*b - a*c` rounds two large products, `a*(b - c)`
//! only small numbers; so it is with `a*a - b*b` and `(a - b)*(a + b)`.
//!
//! Subtracting numbers within a factor of two of each other is exact (Sterbenz,
//! *Floating-Point Computation*, 1974), and so is adding zero.

use super::profile::{LANES, StateLanes, squares};
use crate::sums::earliest::finish;
use crate::sums::groups::GroupFamily;
use crate::sums::writer::joining;
use robovec_ir::{Operand, Operation};
use std::array;

/// Sums of more terms are added greedily.
const EXHAUSTIVE: usize = 6;

/// Sums of more terms are unchanged.
pub(super) const MAX_TERMS: usize = 64;

/// An operand of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum StepSource {
    /// An operand of the function that is written.
    Operand(Operand),
    /// The result of a step.
    Step(usize),
}

/// An operation of a plan.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct SumStep {
    pub(super) operation: Operation,
    pub(super) operands: [StepSource; 2],
}

/// A factor of a product.
#[derive(Clone, Copy, Debug)]
pub(super) struct TermFactor {
    pub(super) source: StepSource,
    pub(super) lanes: StateLanes,
    pub(super) arrival: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SumTerm {
    pub(super) source: StepSource,
    /// True if the term is the negative of the source.
    pub(super) negative: bool,
    /// The term, with its sign.
    pub(super) lanes: StateLanes,
    pub(super) arrival: u32,
    /// The factors of a product without another reader.
    pub(super) factors: Option<[TermFactor; 2]>,
}

/// A way to compute a sum.
#[derive(Clone, Debug)]
pub(super) struct SumPlan {
    pub(super) steps: Vec<SumStep>,
    pub(super) result: StepSource,
    /// Time at which the result is available, in cycles.
    #[cfg(test)]
    pub(super) arrival: u32,
    /// The weighted squares of all roundings, those of products that only
    /// this sum reads included.
    pub(super) cost: f64,
}

/// The setting that a plan is made for.
pub(super) struct SumSetting {
    /// The adjoint of the sum, lane by lane: its effect on the outputs.
    pub(super) adjoint: StateLanes,
    /// Time at which the result is required.
    pub(super) deadline: u32,
    /// Cycles of an addition and of a multiplication.
    pub(super) add: u32,
    pub(super) multiply: u32,
}

/// A plan while it grows.
struct SumDraft<'a> {
    setting: &'a SumSetting,
    steps: Vec<SumStep>,
    terms: Vec<SumTerm>,
    cost: f64,
}

impl SumSetting {
    /// The cost of one rounding of these numbers.
    fn rounding(&self, lanes: &StateLanes) -> f64 {
        squares(&self.adjoint, lanes)
    }

    /// The cost of adding two terms.
    pub(super) fn addition(&self, a: &StateLanes, b: &StateLanes) -> f64 {
        let sum: StateLanes = array::from_fn(|lane| {
            let (a, b) = (a[lane], b[lane]);
            let (small, large) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
            let exact = small == 0.0 || (a * b < 0.0 && large <= 2.0 * small);
            if exact { 0.0 } else { a + b }
        });
        self.rounding(&sum)
    }

    /// Tests whether the terms can be added by the deadline.
    fn feasible(&self, arrivals: impl Iterator<Item = u32>) -> bool {
        finish(arrivals, self.add) <= self.deadline
    }
}

/// The best plan that meets the deadline, `None` when there is none. Without
/// `factoring` products are unchanged.
pub(super) fn plan(setting: &SumSetting, terms: &[SumTerm], factoring: bool) -> Option<SumPlan> {
    let products = terms.iter().filter(|term| term.factors.is_some());
    let mut draft = SumDraft {
        setting,
        steps: Vec::new(),
        cost: products.map(|term| setting.rounding(&term.lanes)).sum(),
        terms: terms.to_vec(),
    };
    if !setting.feasible(terms.iter().map(|term| term.arrival)) {
        return None;
    }
    if factoring && !draft.factor() {
        return None;
    }
    draft.close_sign();
    match draft.terms.len() {
        0..=EXHAUSTIVE => draft.exhaustive(),
        _ => draft.greedy(),
    }
    let [last] = draft.terms.as_slice() else {
        return None;
    };
    let met = last.arrival <= setting.deadline && !last.negative;
    met.then_some(SumPlan {
        steps: draft.steps,
        result: last.source,
        #[cfg(test)]
        arrival: last.arrival,
        cost: draft.cost,
    })
}

impl SumDraft<'_> {
    /// A sum of negative terms alone starts from zero.
    fn close_sign(&mut self) {
        if self.terms.iter().all(|term| term.negative) {
            self.terms.push(SumTerm {
                // The writer knows the absent operand as the number zero.
                source: StepSource::Operand(Operand::NONE),
                negative: false,
                lanes: [0.0; LANES],
                arrival: 0,
                factors: None,
            });
        }
    }

    fn step(&mut self, operation: Operation, operands: [StepSource; 2]) -> StepSource {
        self.steps.push(SumStep {
            operation,
            operands,
        });
        StepSource::Step(self.steps.len() - 1)
    }

    /// The sum or difference of two signed sources: the stored value, and a
    /// flag for the opposite sign.
    fn signed_sum(&mut self, a: (StepSource, bool), b: (StepSource, bool)) -> (StepSource, bool) {
        let (operation, operands, negative) = joining(GroupFamily::Sum, [a, b], false);
        (self.step(operation, operands), negative)
    }

    /// Replaces two terms by their sum.
    fn merge(&mut self, i: usize, j: usize) {
        let (a, b) = (self.terms[i], self.terms[j]);
        let (source, negative) = self.signed_sum((a.source, a.negative), (b.source, b.negative));
        self.cost += self.setting.addition(&a.lanes, &b.lanes);
        self.replace(
            i,
            j,
            SumTerm {
                source,
                negative,
                lanes: array::from_fn(|lane| a.lanes[lane] + b.lanes[lane]),
                arrival: a.arrival.max(b.arrival).saturating_add(self.setting.add),
                factors: None,
            },
        );
    }

    /// Puts a term instead of two.
    fn replace(&mut self, i: usize, j: usize, term: SumTerm) {
        let (first, second) = (i.min(j), i.max(j));
        self.terms.remove(second);
        self.terms[first] = term;
    }

    /// Factors the pair that gains most, until none gains; true when one did.
    fn factor(&mut self) -> bool {
        let mut found = false;
        loop {
            let mut best: Option<(f64, usize, usize, FactoredPair)> = None;
            for j in 0..self.terms.len() {
                for i in 0..j {
                    for difference in self.differences(i, j) {
                        let better = best.as_ref().is_none_or(|best| difference.gain > best.0);
                        if difference.gain > 0.0 && better && self.in_time(i, j, &difference) {
                            best = Some((difference.gain, i, j, difference));
                        }
                    }
                }
            }
            let Some((gain, i, j, difference)) = best else {
                return found;
            };
            found = true;
            self.cost -= gain;
            self.write(i, j, &difference);
        }
    }

    fn in_time(&self, i: usize, j: usize, difference: &FactoredPair) -> bool {
        let others = (0..self.terms.len()).filter(|&index| index != i && index != j);
        let arrivals = others.map(|index| self.terms[index].arrival);
        let arrival = difference.arrival(self.setting);
        arrival <= self.setting.deadline && self.setting.feasible(arrivals.chain([arrival]))
    }

    /// The ways to factor two terms.
    fn differences(&self, i: usize, j: usize) -> Vec<FactoredPair> {
        let (a, b) = (&self.terms[i], &self.terms[j]);
        let (Some(left), Some(right)) = (a.factors, b.factors) else {
            return Vec::new();
        };
        let sum: StateLanes = array::from_fn(|lane| a.lanes[lane] + b.lanes[lane]);
        let before = self.setting.rounding(&a.lanes)
            + self.setting.rounding(&b.lanes)
            + self.setting.addition(&a.lanes, &b.lanes);
        let product = self.setting.rounding(&sum);
        let mut found = Vec::new();
        for (side, other) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (common, same) = (left[side], right[other]);
            if common.source != same.source {
                continue;
            }
            let (b, c) = (left[1 - side], right[1 - other]);
            // The rounding of `b - c` is multiplied by the common factor;
            // where the difference is exact it costs nothing.
            let inner = self.setting.addition(&a.lanes, &self.terms[j].lanes);
            found.push(FactoredPair {
                gain: before - product - inner,
                common: Some(common),
                pair: [b, c],
                signs: [a.negative, self.terms[j].negative],
                lanes: sum,
            });
        }
        let square = |factors: &[TermFactor; 2]| factors[0].source == factors[1].source;
        if square(&left) && square(&right) && a.negative != b.negative {
            found.push(FactoredPair {
                gain: before - 3.0 * product,
                common: None,
                pair: [left[0], right[0]],
                signs: [a.negative, b.negative],
                lanes: sum,
            });
        }
        found
    }

    /// Writes a factored difference instead of its two terms.
    fn write(&mut self, i: usize, j: usize, difference: &FactoredPair) {
        let [b, c] = difference.pair;
        let [first, second] = difference.signs;
        let inner = self.signed_sum((b.source, first), (c.source, second));
        let ready = b.arrival.max(c.arrival).saturating_add(self.setting.add);
        let (other, inner, negative) = match difference.common {
            Some(common) => (common, inner.0, inner.1),
            None => {
                // With the signs of the terms, `inner` is `b - c` or `c - b`.
                let sum = self.step(Operation::Add, [b.source, c.source]);
                let lanes = array::from_fn(|lane| b.lanes[lane] + c.lanes[lane]);
                let factor = TermFactor {
                    source: sum,
                    lanes,
                    arrival: ready,
                };
                (factor, inner.0, false)
            }
        };
        let source = self.step(Operation::Mul, [other.source, inner]);
        let size = |lane: usize| (difference.lanes[lane] / other.lanes[lane]).abs();
        let factor = TermFactor {
            source: inner,
            lanes: array::from_fn(size),
            arrival: ready,
        };
        self.replace(
            i,
            j,
            SumTerm {
                source,
                negative,
                lanes: difference.lanes,
                arrival: difference.arrival(self.setting),
                factors: Some([other, factor]),
            },
        );
    }

    /// Adds the two terms with the smallest sum that leave the deadline
    /// within reach, until one is left.
    fn greedy(&mut self) {
        while self.terms.len() > 1 {
            let mut pairs = Vec::new();
            for j in 0..self.terms.len() {
                for i in 0..j {
                    let (a, b) = (&self.terms[i].lanes, &self.terms[j].lanes);
                    pairs.push((self.setting.addition(a, b), i, j));
                }
            }
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.2, a.1).cmp(&(b.2, b.1))));
            let in_time = |&&(_, i, j): &&(f64, usize, usize)| {
                let merged = self.terms[i].arrival.max(self.terms[j].arrival);
                let others = (0..self.terms.len()).filter(|&index| index != i && index != j);
                let merged = merged.saturating_add(self.setting.add);
                let arrivals = others.map(|index| self.terms[index].arrival);
                self.setting.feasible(arrivals.chain([merged]))
            };
            let Some(&(_, i, j)) = pairs.iter().find(in_time) else {
                return;
            };
            self.merge(i, j);
        }
    }

    /// Adds the terms by the best of all trees that meet the deadline, found
    /// subset by subset: of each, the cheapest tree for every finish.
    fn exhaustive(&mut self) {
        let count = self.terms.len();
        if count < 2 {
            return;
        }
        let full = (1usize << count) - 1;
        let mut sums = vec![[0.0; LANES]; full + 1];
        let mut trees: Vec<Vec<SubsetTree>> = vec![Vec::new(); full + 1];
        for subset in 1..=full {
            let lowest = subset.trailing_zeros() as usize;
            let rest = subset & (subset - 1);
            sums[subset] = array::from_fn(|lane| sums[rest][lane] + self.terms[lowest].lanes[lane]);
            if rest == 0 {
                let arrival = self.terms[lowest].arrival;
                trees[subset].push(SubsetTree {
                    cost: 0.0,
                    arrival,
                    split: 0,
                    sides: [0, 0],
                });
                continue;
            }
            // Each split is met once: the side with the lowest term is left.
            let mut right = rest;
            while right > 0 {
                let left = subset ^ right;
                let rounding = self.setting.addition(&sums[left], &sums[right]);
                let found = pairs_of(
                    &trees[left],
                    &trees[right],
                    rounding,
                    self.setting.add,
                    right,
                );
                trees[subset].extend(found);
                right = (right - 1) & rest;
            }
            keep_best(&mut trees[subset], self.setting.deadline);
        }
        let best = trees[full].iter().enumerate();
        let best = best.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost));
        if let Some((place, _)) = best {
            let terms = std::mem::take(&mut self.terms);
            let root = self.build(&terms, &trees, full, place);
            self.terms = vec![root];
        }
    }

    /// Writes the tree that was chosen; as deep as there are terms.
    fn build(
        &mut self,
        terms: &[SumTerm],
        trees: &[Vec<SubsetTree>],
        subset: usize,
        place: usize,
    ) -> SumTerm {
        let tree = trees[subset][place];
        if tree.split == 0 {
            return terms[subset.trailing_zeros() as usize];
        }
        let left = self.build(terms, trees, subset ^ tree.split, tree.sides[0] as usize);
        let right = self.build(terms, trees, tree.split, tree.sides[1] as usize);
        self.terms = vec![left, right];
        self.merge(0, 1);
        self.terms[0]
    }
}

/// A tree over a subset of the terms.
#[derive(Clone, Copy, Debug)]
struct SubsetTree {
    cost: f64,
    arrival: u32,
    /// The subset on the right, 0 for a single term.
    split: usize,
    /// The trees of the two subsets.
    sides: [u8; 2],
}

/// All pairs of trees of two subsets.
fn pairs_of<'a>(
    left: &'a [SubsetTree],
    right: &'a [SubsetTree],
    rounding: f64,
    add: u32,
    split: usize,
) -> Vec<SubsetTree> {
    let pair = |(i, a): (usize, &'a SubsetTree)| {
        right.iter().enumerate().map(move |(j, b)| SubsetTree {
            cost: a.cost + b.cost + rounding,
            arrival: a.arrival.max(b.arrival).saturating_add(add),
            split,
            sides: [i as u8, j as u8],
        })
    };
    left.iter().enumerate().flat_map(pair).collect()
}

/// Keeps the trees that no other beats in cost and finish; at most sixteen.
fn keep_best(trees: &mut Vec<SubsetTree>, deadline: u32) {
    trees.retain(|tree| tree.arrival <= deadline);
    // A stable order, so that equal trees are always chosen alike.
    trees.sort_by(|a, b| (a.arrival.cmp(&b.arrival)).then(a.cost.total_cmp(&b.cost)));
    let mut least = f64::INFINITY;
    trees.retain(|tree| {
        let better = tree.cost < least;
        least = least.min(tree.cost);
        better
    });
    trees.truncate(16);
}

/// A factored pair of products.
struct FactoredPair {
    gain: f64,
    /// The common factor; none for a difference of squares.
    common: Option<TermFactor>,
    pair: [TermFactor; 2],
    /// For each of the two terms whether it is negative.
    signs: [bool; 2],
    lanes: StateLanes,
}

impl FactoredPair {
    fn arrival(&self, setting: &SumSetting) -> u32 {
        let [b, c] = &self.pair;
        let inner = b.arrival.max(c.arrival).saturating_add(setting.add);
        let common = self.common.map_or(0, |common| common.arrival);
        inner.max(common).saturating_add(setting.multiply)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Input;

    fn input(index: u32, value: f64) -> TermFactor {
        TermFactor {
            source: StepSource::Operand(Input(index).into()),
            lanes: [value; LANES],
            arrival: 0,
        }
    }

    fn term(index: u32, value: f64, arrival: u32) -> SumTerm {
        SumTerm {
            source: StepSource::Operand(Input(index).into()),
            negative: value < 0.0,
            lanes: [value; LANES],
            arrival,
            factors: None,
        }
    }

    fn setting(deadline: u32) -> SumSetting {
        SumSetting {
            adjoint: [1.0; LANES],
            deadline,
            add: 12,
            multiply: 7,
        }
    }

    fn first(plan: &SumPlan) -> [StepSource; 2] {
        plan.steps[0].operands
    }

    #[test]
    fn small_terms_come_first_where_there_is_time() {
        for count in [5, 8] {
            let terms: Vec<SumTerm> = (0..count)
                .map(|index| term(index, 2f64.powi(-(index as i32)) * 1.1, 0))
                .collect();
            let free = plan(&setting(1000), &terms, false).expect("there is time");
            let two = [count - 2, count - 1].map(|index| terms[index as usize].source);
            assert!(first(&free).iter().all(|source| two.contains(source)));
            assert_eq!(free.arrival, 12 * (count - 1));
            let tight = plan(&setting(36), &terms, false).expect("36 cycles are enough");
            assert!(tight.arrival <= 36 && tight.cost >= free.cost);
            assert!(plan(&setting(24), &terms, false).is_none());
        }
    }

    #[test]
    fn what_cancels_meets_first() {
        let terms = [1000.0, 1.7, -999.0, 0.3].map(|value| term(value as u32, value, 0));
        let found = plan(&setting(1000), &terms, false).expect("there is time");
        assert_eq!(first(&found), [terms[0].source, terms[2].source]);
        assert_eq!(found.steps[0].operation, Operation::Sub);
    }

    #[test]
    fn a_common_factor_of_what_cancels_is_taken_out() {
        let [a, b, c] = [(0, 3.0), (1, 1.001), (2, 1.0)].map(|(i, value)| input(i, value));
        let product = |x: TermFactor, y: TermFactor, sign: f64| SumTerm {
            source: StepSource::Operand(Input(9).into()),
            negative: sign < 0.0,
            lanes: array::from_fn(|lane| sign * x.lanes[lane] * y.lanes[lane]),
            arrival: 7,
            factors: Some([x, y]),
        };
        let cancelling = [product(a, b, 1.0), product(c, a, -1.0)];
        let found = plan(&setting(19), &cancelling, true).expect("it is as fast");
        assert_eq!(found.steps.len(), 2);
        assert_eq!(found.steps[1].operation, Operation::Mul);
        let plain = plan(&setting(19), &cancelling, false).expect("as it was");
        assert!(found.cost < 1e-4 * plain.cost);
        let squares = [product(b, b, 1.0), product(c, c, -1.0)];
        let found = plan(&setting(19), &squares, true).expect("it is as fast");
        let operations = [Operation::Sub, Operation::Add, Operation::Mul];
        assert!(found.steps.iter().map(|step| step.operation).eq(operations));
    }

    #[test]
    fn negative_terms_alone_start_from_zero() {
        let terms = [-1.0f64, -2.0].map(|value| term(value.abs() as u32, value, 0));
        let found = plan(&setting(100), &terms, false).expect("there is time");
        assert_eq!(found.steps.len(), 2);
    }
}
