//! The gain of rules on the critical paths of real functions.

use super::super::pattern::{Pattern, PatternNode};
use super::super::profile::{earliest_of, operations};
use super::super::rule::Rule;
use robovec_analysis::critical_path::{Weights, arrivals, longest, tails};
use robovec_ir::{Function, Machine, Operand, OperandKind, Operation, Value};

/// The gain of a rule on some functions, applied without other rules and at one
/// place at a time: an estimate, since a rewrite at one place changes the gain
/// at the next.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Debug)]
pub struct RuleGain {
    /// Total number of cycles by which values on a longest chain would be
    /// earlier than with any order of the operands of sums and products.
    pub cycles: u64,
    /// Operations saved at disjoint places, taken in program order: the
    /// reduction when the rule is used there.
    pub operations: u64,
    /// Places on a longest chain that the left side matches.
    pub critical_places: u64,
    /// All places that the left side matches.
    pub places: u64,
}

/// A function with its times.
pub(super) struct Timed<'a> {
    pub(super) function: &'a Function,
    pub(super) arrivals: Vec<u32>,
    pub(super) critical: Vec<bool>,
    pub(super) uses: Vec<u32>,
}

impl<'a> Timed<'a> {
    pub(super) fn new(function: &'a Function, weights: &Weights) -> Timed<'a> {
        let arrivals = arrivals(function, weights);
        let tails = tails(function, weights);
        let longest = longest(&arrivals);
        let through = arrivals.iter().zip(&tails);
        Timed {
            critical: through
                .map(|(arrival, tail)| arrival + tail == longest)
                .collect(),
            uses: function.use_counts(),
            arrivals,
            function,
        }
    }

    /// The values of a window that become unused once the root is computed
    /// otherwise, with the root.
    pub(super) fn freed(&self, window: &[Value]) -> Vec<Value> {
        let mut order = window.to_vec();
        // Users before what they use.
        order.sort_unstable_by_key(|&value| std::cmp::Reverse(value));
        order.dedup();
        let mut freed: Vec<Value> = Vec::with_capacity(order.len());
        for &value in &order {
            let reads = freed
                .iter()
                .flat_map(|&user| self.function.node(user).operands())
                .filter(|operand| operand.value() == Some(value));
            if freed.is_empty() || reads.count() == self.uses[value.index()] as usize {
                freed.push(value);
            }
        }
        freed
    }

    /// True for an operation of the machine: sines, cosines and copies are
    /// none.
    fn counts(&self, value: Value) -> bool {
        let operation = self.function.node(value).operation;
        !operation.is_trigonometric() && operation != Operation::Copy
    }
}

/// The gain of a rule from left to right.
pub(super) fn gain(rule: &Rule, functions: &[Timed<'_>], machine: &Machine) -> RuleGain {
    let weights = Weights::cycles(machine);
    let new_operations = operations(&rule.right);
    let mut gain = RuleGain::default();
    for timed in functions {
        let mut touched = vec![false; timed.function.nodes().len()];
        for (value, _) in timed.function.values() {
            let matches = matches(&rule.left, timed.function, value, rule.variables.len());
            if matches.is_empty() {
                continue;
            }
            gain.places += 1;
            let saved = matches.iter().filter_map(|found| {
                let covered = found.covered(value);
                if covered.iter().any(|inner| touched[inner.index()]) {
                    return None;
                }
                let freed = timed.freed(&covered);
                let counted = freed.iter().filter(|&&value| timed.counts(value));
                Some((counted.count() as i64 - new_operations, found))
            });
            // Of equal ones the first.
            let most = saved.reduce(|best, other| if other.0 > best.0 { other } else { best });
            if let Some((saved @ 1.., found)) = most {
                gain.operations += saved as u64;
                // Neither may be part of another place: the one is gone, of
                // the other the number of reads has changed.
                let bound = found.bound.iter().flatten();
                let bound = bound.filter_map(|operand| operand.value());
                for value in found.covered(value).into_iter().chain(bound) {
                    touched[value.index()] = true;
                }
            }
            if !timed.critical[value.index()] {
                continue;
            }
            gain.critical_places += 1;
            let now = i64::from(timed.arrivals[value.index()]);
            let earlier = matches.iter().map(|found| {
                let arrival = |variable: u32| {
                    let operand = found.bound[variable as usize]?;
                    Some(i64::from(operand.entry_or_default(&timed.arrivals)))
                };
                let left = earliest_of(&rule.left, &weights, &arrival).unwrap_or(0);
                now.min(left) - earliest_of(&rule.right, &weights, &arrival).unwrap_or(0)
            });
            gain.cycles += earlier.fold(0, i64::max) as u64;
        }
    }
    gain
}

/// A place where a pattern matches.
#[derive(Clone)]
struct PatternMatch {
    bound: Vec<Option<Operand>>,
    /// The values below the root that the pattern covers.
    inner: Vec<Value>,
}

impl PatternMatch {
    /// The root and the values below it that the pattern covers.
    fn covered(&self, root: Value) -> Vec<Value> {
        let mut covered = vec![root];
        covered.extend(&self.inner);
        covered
    }
}

/// Most matches at one place that are considered.
const MAX_MATCHES: usize = 64;

/// All matches of a pattern with a value, operands in either order.
fn matches(
    pattern: &Pattern,
    function: &Function,
    root: Value,
    variables: usize,
) -> Vec<PatternMatch> {
    let start = PatternMatch {
        bound: vec![None; variables],
        inner: Vec::new(),
    };
    let mut found = Vec::new();
    // What is still to be matched, beside what was bound so far.
    let mut open = vec![(vec![(pattern.root() as u32, Operand::from(root))], start)];
    while let Some((mut goals, mut state)) = open.pop() {
        if found.len() >= MAX_MATCHES {
            break;
        }
        let Some((index, operand)) = goals.pop() else {
            found.push(state);
            continue;
        };
        match pattern.nodes[index as usize] {
            PatternNode::Variable(variable) => {
                let place = &mut state.bound[variable as usize];
                if place.is_none_or(|bound| bound == operand) {
                    *place = Some(operand);
                    open.push((goals, state));
                }
            }
            PatternNode::Number(number) => {
                if function.number(operand) == Some(number) {
                    open.push((goals, state));
                }
            }
            PatternNode::Operation(operation, [a, b]) => {
                let OperandKind::Value(value) = operand.kind() else {
                    continue;
                };
                let node = function.node(value);
                if node.operation != operation {
                    continue;
                }
                if value != root {
                    state.inner.push(value);
                }
                let operands = node.operands();
                let [first, second] = match *operands {
                    [first, second] => [first, second],
                    [only] => {
                        goals.push((a, only));
                        open.push((goals, state));
                        continue;
                    }
                    _ => continue,
                };
                if operation.is_commutative() && first != second {
                    let mut other = goals.clone();
                    other.extend([(a, second), (b, first)]);
                    open.push((other, state.clone()));
                }
                goals.extend([(a, first), (b, second)]);
                open.push((goals, state));
            }
        }
    }
    found
}
