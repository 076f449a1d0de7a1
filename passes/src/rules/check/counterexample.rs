//! The smallest numbers that refute a rule.

use super::super::random::Random;
use super::super::rule::Rule;
use robovec_ir::arithmetic::Binary64;
use robovec_ir::double_double::DoubleDouble;
use std::fmt;

/// Numbers at which the two sides of a rule differ.
#[derive(Clone, PartialEq, Debug)]
pub struct Counterexample {
    /// True when the rule fails from right to left; left and right are then
    /// those of the reversed rule.
    pub backwards: bool,
    /// The variables' names and numbers.
    pub values: Vec<(String, f64)>,
    /// The left side there.
    pub left: f64,
    /// The right side there; not finite where it is not defined.
    pub right: f64,
    /// Left less right, in about 106 bits.
    pub difference: f64,
}

impl fmt::Display for Counterexample {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<String> = self
            .values
            .iter()
            .map(|(name, value)| format!("{name} = {}", number(*value)))
            .collect();
        if self.backwards {
            formatter.write_str("backwards, ")?;
        }
        let place = match values[..] {
            [] => "always".to_owned(),
            _ => values.join(", "),
        };
        let (left, right) = (number(self.left), number(self.right));
        write!(
            formatter,
            "{place}: the left side is {left}, the right side "
        )?;
        if !self.right.is_finite() {
            return write!(formatter, "is not defined");
        }
        if left == right {
            let sign = if self.difference > 0.0 {
                "less"
            } else {
                "more"
            };
            let difference = self.difference.abs();
            return write!(formatter, "is {difference:.1e} {sign}");
        }
        write!(formatter, "is {right}")
    }
}

/// A number for people: all digits when they are few.
pub(super) fn number(number: f64) -> String {
    let plain = format!("{number}");
    if plain.len() <= 20 {
        plain
    } else {
        format!("{number:e}")
    }
}

/// Points tried one after the other, smallest first.
const EXHAUSTIVE: usize = 60_000;
/// Points tried at random when no small one refutes the rule.
const RANDOM: usize = 20_000;

/// Where the right side must be defined although the left side is.
pub(super) fn undefined(rule: &Rule) -> Option<Counterexample> {
    in_each_direction(rule, &|rule| {
        smallest(rule, EXHAUSTIVE / 20, &|rule, values| {
            let found = compare(rule, values)?;
            (!found.right.is_finite()).then_some(found)
        })
    })
}

/// The smallest integers at which the sides differ; larger ones at random
/// when there are no small ones.
pub(super) fn search(rule: &Rule) -> Option<Counterexample> {
    in_each_direction(rule, &|rule| smallest(rule, EXHAUSTIVE, &compare)).or_else(|| {
        let mut random = Random::new(1);
        (0..RANDOM).find_map(|_| {
            let draw = |_| random.below(2001) as f64 - 1000.0;
            let values: Vec<f64> = rule.variables.iter().map(draw).collect();
            compare(rule, &values)
        })
    })
}

fn in_each_direction(
    rule: &Rule,
    search: &dyn Fn(&Rule) -> Option<Counterexample>,
) -> Option<Counterexample> {
    let directions = rule.directed();
    directions.iter().enumerate().find_map(|(index, rule)| {
        let found = search(rule)?;
        Some(Counterexample {
            backwards: index > 0,
            ..found
        })
    })
}

/// The first point that a test takes, by largest magnitude, then in the order
/// 0, 1, -1, 2, -2 … of the last variable, the one before, ….
fn smallest(
    rule: &Rule,
    budget: usize,
    test: &dyn Fn(&Rule, &[f64]) -> Option<Counterexample>,
) -> Option<Counterexample> {
    let count = rule.variables.len();
    let mut left = budget;
    for magnitude in 0..=64usize {
        let choices = 2 * magnitude + 1;
        let mut digits = vec![0usize; count];
        loop {
            // Points of smaller magnitude were tried before.
            let largest = digits.iter().map(|digit| digit.div_ceil(2)).max();
            if largest.unwrap_or(0) == magnitude {
                let values: Vec<f64> = digits.iter().map(|&digit| integer(digit)).collect();
                if let Some(found) = test(rule, &values) {
                    return Some(found);
                }
            }
            left = left.checked_sub(1)?;
            if !next(&mut digits, choices) {
                break;
            }
        }
    }
    None
}

/// 0, 1, -1, 2, -2 ….
fn integer(digit: usize) -> f64 {
    let magnitude = digit.div_ceil(2) as f64;
    if digit % 2 == 1 {
        magnitude
    } else {
        0.0 - magnitude
    }
}

/// Counts one up; false when all were counted.
fn next(digits: &mut [usize], base: usize) -> bool {
    for digit in digits.iter_mut().rev() {
        *digit += 1;
        if *digit < base {
            return true;
        }
        *digit = 0;
    }
    false
}

/// The sides at a point, when the conditions hold there, the left side is
/// defined, and they differ by more than rounding.
fn compare(rule: &Rule, values: &[f64]) -> Option<Counterexample> {
    let meets = |(variable, value): (usize, &f64)| {
        let mut needed = rule.requirements(variable as u32);
        needed.all(|requirement| requirement.holds_for(*value))
    };
    if !values.iter().enumerate().all(meets) {
        return None;
    }
    let left = rule.left.evaluate(&Binary64, values);
    if !left.is_finite() {
        return None;
    }
    let right = rule.right.evaluate(&Binary64, values);
    let doubles: Vec<_> = values.iter().map(|&value| value.into()).collect();
    let reference = rule.left.evaluate_all(&DoubleDouble, &doubles);
    let other = rule.right.evaluate_all(&DoubleDouble, &doubles);
    // What cancels leaves the rounding of what was there before.
    let scale = reference
        .iter()
        .chain(&other)
        .map(|double| double.high.abs());
    let scale = scale.filter(|size| size.is_finite()).fold(0.0, f64::max);
    let difference = match (reference.last(), other.last()) {
        (Some(&reference), Some(&other)) => (reference - other).high,
        _ => return None,
    };
    let differs = !right.is_finite() || difference.abs() > 1e-24 * scale;
    differs.then(|| Counterexample {
        backwards: false,
        values: rule
            .variables
            .iter()
            .cloned()
            .zip(values.iter().copied())
            .collect(),
        // One zero is enough for people.
        left: left + 0.0,
        right: right + 0.0,
        difference,
    })
}
