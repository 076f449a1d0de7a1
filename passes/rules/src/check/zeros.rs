//! The zeros of the numbers that decide about a rule: divisors, radicands and
//! sums. There signs change and holes open.

use super::super::pattern::{Pattern, PatternNode};
use super::counterexample::{Counterexample, compare, hole};
use super::joined::Joined;
use super::point::{RealPoint, SideValue, evaluate};
use super::states::{RulePoints, numbers};
use robovec_ir::Operation;

/// Number of points from which the lines along the axes start.
const BASES: usize = 4;
/// Nodes considered at most.
const MAX_NODES: usize = 24;
/// Lines searched at most.
const MAX_LINES: usize = 160;

/// Searches for zeros of the relevant nodes along the axes, and tries the rule
/// there, on both sides of them and further away.
pub(super) fn search(joined: &Joined<'_>) -> Option<Counterexample> {
    let rule = joined.rule;
    let mut states = RulePoints::of(rule, 5);
    let count = rule.variables.len();
    let bases: Vec<Vec<f64>> = (0..BASES)
        .map(|base| match base {
            0 => vec![1.0; count],
            1 => (0..count).map(|variable| variable as f64 + 2.0).collect(),
            _ => states.next(),
        })
        .collect();
    let grid = grid(joined);
    let mut lines = 0;
    for target in targets(joined) {
        let used = target.part.variables();
        for &variable in &used {
            for base in &bases {
                lines += 1;
                if lines > MAX_LINES {
                    return None;
                }
                let line = AxisLine {
                    joined,
                    target: &target,
                    variable: variable as usize,
                    base,
                };
                if let Some(found) = line.search(&grid) {
                    return Some(found);
                }
            }
        }
    }
    None
}

/// A node to find zeros of.
struct ZeroTarget {
    part: Pattern,
    /// The divisor of the right side that is zero together with the node.
    divisor: Option<Pattern>,
}

/// Factors of the divisors of the right side first, then radicands, then sums.
fn targets(joined: &Joined<'_>) -> Vec<ZeroTarget> {
    let all = joined.pattern.nodes.len();
    let mut targets: Vec<ZeroTarget> = Vec::new();
    let mut seen = vec![false; all];
    for [_, divisor] in joined.operands(Operation::Div, joined.left..all) {
        let mut stack = vec![divisor];
        while let Some(node) = stack.pop() {
            match joined.pattern.nodes[node] {
                PatternNode::Operation(Operation::Mul, [a, b]) if a == b => stack.push(a as usize),
                PatternNode::Operation(Operation::Mul, [a, b]) => {
                    stack.extend([b as usize, a as usize]);
                }
                PatternNode::Operation(
                    Operation::Neg | Operation::Copy | Operation::Div | Operation::Sqrt,
                    [a, _],
                ) => stack.push(a as usize),
                _ => {
                    seen[node] = true;
                    targets.push(ZeroTarget {
                        part: joined.part(node),
                        divisor: Some(joined.part(divisor)),
                    });
                }
            }
        }
    }
    let radicands = joined.operands(Operation::Sqrt, 0..all);
    let radicands: Vec<usize> = radicands.map(|[operand, _]| operand).collect();
    let sums = (0..all).filter(|&node| {
        matches!(
            joined.pattern.nodes[node],
            PatternNode::Operation(Operation::Add | Operation::Sub, _)
        )
    });
    for node in radicands.into_iter().chain(sums) {
        if !std::mem::replace(&mut seen[node], true) {
            targets.push(ZeroTarget {
                part: joined.part(node),
                divisor: None,
            });
        }
    }
    targets.truncate(MAX_NODES);
    targets
}

/// Numbers between which a node is considered, in rising order.
fn grid(joined: &Joined<'_>) -> Vec<f64> {
    let mut grid = vec![0.0];
    let far = (-1_000..=1_000).step_by(50);
    for power in (-12..=30).step_by(2).chain(far) {
        let number = 2f64.powi(power);
        grid.extend([number, -number]);
    }
    for number in numbers(&[&joined.pattern]).into_iter().take(12) {
        for scale in [0.25, 0.75, 1.5, 4.0] {
            grid.extend([number * scale, -number * scale]);
        }
    }
    grid.retain(|number| number.is_finite());
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    grid
}

/// A line along the axis of a variable.
struct AxisLine<'a> {
    joined: &'a Joined<'a>,
    target: &'a ZeroTarget,
    variable: usize,
    base: &'a [f64],
}

impl AxisLine<'_> {
    fn place(&self, value: f64, radius: f64) -> RealPoint {
        let mut place = RealPoint::exactly(self.base.to_vec());
        place.values[self.variable] = value;
        place.radii[self.variable] = radius;
        place
    }

    /// The sign of the node at a number; `None` where it is not known.
    fn sign(&self, value: f64) -> Option<i32> {
        let place = self.place(value, 0.0);
        match evaluate(&self.target.part, &place, &self.joined.fields) {
            SideValue::Defined(numbers) => numbers.last().map(|number| number.sign()),
            SideValue::Undefined | SideValue::Unknown => None,
        }
    }

    fn search(&self, grid: &[f64]) -> Option<Counterexample> {
        let mut before: Option<(f64, i32)> = None;
        for &value in grid {
            let sign = self.sign(value);
            if let (Some((last, first)), Some(sign)) = (before, sign)
                && first * sign <= 0
            {
                let ends = self.bisected((last, first), (value, sign));
                if let Some(found) = self.tried(ends) {
                    return Some(found);
                }
            }
            before = sign.map(|sign| (value, sign));
        }
        None
    }

    /// The ends of a change of sign: neighbours among the binary64 numbers,
    /// or twice the same number, where the node is zero.
    fn bisected(&self, (low, first): (f64, i32), (high, last): (f64, i32)) -> (f64, f64) {
        if first == 0 {
            return (low, low);
        }
        if last == 0 {
            return (high, high);
        }
        let (mut low, mut high) = (ordered(low), ordered(high));
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            match self.sign(from_ordered(middle)) {
                Some(0) => return (from_ordered(middle), from_ordered(middle)),
                Some(sign) if sign == first => low = middle,
                Some(_) => high = middle,
                None => break,
            }
        }
        (from_ordered(low), from_ordered(high))
    }

    /// Tries the rule at and around a zero.
    fn tried(&self, (low, high): (f64, f64)) -> Option<Counterexample> {
        let mut values = vec![low, high];
        let size = low.abs();
        for distance in [
            1.0,
            1e-3,
            size / 2.0,
            size * 1e-3,
            size * 1e-9,
            size * 1e-15,
        ] {
            values.extend([low - distance, high + distance]);
        }
        let found = values
            .into_iter()
            .filter(|value| value.is_finite())
            .find_map(|value| compare(self.joined, &self.place(value, 0.0)));
        if found.is_some() || low == high {
            return found;
        }
        let divisor = self.target.divisor.as_ref()?;
        let (first, last) = (self.sign(low)?, self.sign(high)?);
        if first * last != -1 {
            return None;
        }
        // Between them the node is zero, if it is defined all the way.
        let place = self.place(low, (high - low) * 1.01);
        let defined = [&self.target.part, divisor].iter().all(|part| {
            let outcome = evaluate(part, &place, &self.joined.fields);
            matches!(outcome, SideValue::Defined(_))
        });
        if defined {
            hole(self.joined, &place)
        } else {
            None
        }
    }
}

/// Binary64 numbers in order as whole numbers.
fn ordered(number: f64) -> i64 {
    let bits = (number + 0.0).to_bits() as i64;
    if bits < 0 { i64::MIN - bits } else { bits }
}

fn from_ordered(order: i64) -> f64 {
    let bits = if order < 0 { i64::MIN - order } else { order };
    f64::from_bits(bits as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_ordered_through_zero() {
        let numbers = [-1e300, -1.0, -5e-324, 0.0, 5e-324, 1.0, 1e300];
        for pair in numbers.windows(2) {
            assert!(ordered(pair[0]) < ordered(pair[1]));
        }
        for number in numbers {
            assert_eq!(from_ordered(ordered(number)), number);
        }
        assert_eq!(ordered(5e-324) - ordered(-5e-324), 2);
    }
}
