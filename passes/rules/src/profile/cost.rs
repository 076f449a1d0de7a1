//! The effect of a rule on operations and on the path.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::Rule;
use hashbrown::HashMap;
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Machine, Operation};

/// Changes from the left side to the right side; negative is better.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct CostChange {
    /// Operations, equal ones counted once; sines, cosines and copies do not
    /// count.
    pub operations: i64,
    /// Cycles from the time when all variables are available.
    pub cycles: i64,
    /// Cycles when this variable comes last, later than all others need: the
    /// variable with the greatest gain.
    pub late: Option<(String, i64)>,
}

pub(super) fn change(rule: &Rule, machine: &Machine) -> CostChange {
    let weights = Weights::cycles(machine);
    let all = |_: u32| Some(0);
    let path = |side: &Pattern, arrival: &dyn Fn(u32) -> Option<i64>| {
        arrival_of(side, &weights, arrival).unwrap_or(0)
    };
    let late = rule.left.variables().into_iter().map(|variable| {
        let only = |other: u32| (other == variable).then_some(0);
        let gain = path(&rule.right, &only) - path(&rule.left, &only);
        (rule.variables[variable as usize].clone(), gain)
    });
    CostChange {
        operations: operations(&rule.right) - operations(&rule.left),
        cycles: path(&rule.right, &all) - path(&rule.left, &all),
        // Of equals the first.
        late: late.min_by_key(|(_, gain)| *gain),
    }
}

/// Time at which the value of a pattern is available, if its variables are at
/// these times; `None` means long before all others.
fn arrival_of(
    pattern: &Pattern,
    weights: &Weights,
    arrival: &dyn Fn(u32) -> Option<i64>,
) -> Option<i64> {
    let mut times: Vec<Option<i64>> = Vec::with_capacity(pattern.nodes.len());
    for node in &pattern.nodes {
        let time = match *node {
            PatternNode::Variable(variable) => arrival(variable),
            PatternNode::Number(_) => None,
            PatternNode::Operation(operation, [a, b]) => times[a as usize]
                .max(times[b as usize])
                .map(|ready| ready + i64::from(weights.of(operation))),
        };
        times.push(time);
    }
    times.pop().flatten()
}

/// The same, with the operands of sums and products in the order of the
/// earliest result: nested ones are flattened, and the two earliest operands
/// are combined first.
pub(crate) fn earliest_of(
    pattern: &Pattern,
    weights: &Weights,
    arrival: &dyn Fn(u32) -> Option<i64>,
) -> Option<i64> {
    /// The operands of a sum, of a product, or one value.
    type Group = (Option<Operation>, Vec<Option<i64>>);
    let ready = |(operation, mut times): Group| {
        while times.len() > 1 {
            // The latest first, so that the earliest are taken off the end.
            times.sort_unstable_by_key(|&time| std::cmp::Reverse(time));
            let (one, other) = (times.pop().flatten(), times.pop().flatten());
            let weight = operation.map_or(0, |operation| i64::from(weights.of(operation)));
            times.push(one.max(other).map(|time| time + weight));
        }
        times.pop().flatten()
    };
    let mut groups: Vec<Group> = Vec::with_capacity(pattern.nodes.len());
    for node in &pattern.nodes {
        let group = match *node {
            PatternNode::Variable(variable) => (None, vec![arrival(variable)]),
            PatternNode::Number(_) => (None, vec![None]),
            PatternNode::Operation(operation, operands) => {
                let kind = match operation {
                    Operation::Add | Operation::Sub => Some(Operation::Add),
                    Operation::Mul => Some(Operation::Mul),
                    _ => None,
                };
                let mut times = Vec::new();
                for &operand in &operands[..operation.arity()] {
                    let (inner, inside) = groups[operand as usize].clone();
                    match kind {
                        Some(_) if inner == kind => times.extend(inside),
                        _ => times.push(ready((inner, inside))),
                    }
                }
                match kind {
                    Some(_) => (kind, times),
                    None => {
                        let weight = i64::from(weights.of(operation));
                        let last = times.into_iter().max().flatten();
                        (None, vec![last.map(|time| time + weight)])
                    }
                }
            }
        };
        groups.push(group);
    }
    groups.pop().and_then(ready)
}

/// The number of different operations of a pattern.
pub(crate) fn operations(pattern: &Pattern) -> i64 {
    let mut known: HashMap<(u8, u64, [u32; 2]), u32> = HashMap::new();
    let mut class: Vec<u32> = Vec::with_capacity(pattern.nodes.len());
    let mut count = 0;
    for node in &pattern.nodes {
        let key = match *node {
            PatternNode::Variable(variable) => (0, u64::from(variable), [0; 2]),
            PatternNode::Number(number) => (1, number.to_bits(), [0; 2]),
            PatternNode::Operation(operation, operands) => {
                let mut operands = operands.map(|operand| class[operand as usize]);
                if operation.is_commutative() {
                    operands.sort_unstable();
                }
                (2, operation as u64, operands)
            }
        };
        let next = known.len() as u32;
        let is_new = !known.contains_key(&key);
        class.push(*known.entry(key).or_insert(next));
        let counts = match node {
            PatternNode::Operation(operation, _) => {
                !operation.is_trigonometric() && *operation != Operation::Copy
            }
            PatternNode::Variable(_) | PatternNode::Number(_) => false,
        };
        count += i64::from(is_new && counts);
    }
    count
}
