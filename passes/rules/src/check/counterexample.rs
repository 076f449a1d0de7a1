//! Numbers that refute a rule, the smallest where possible.
//!
//! Whatever is found is certain: the sides are computed with bounds of their
//! errors, and lie apart, or the right side is not defined.

use super::ball::ScaledBall;
use super::joined::Joined;
use super::point::{RealPoint, SideValue, evaluate};
use std::fmt;

/// Numbers at which the two sides of a rule differ.
#[derive(Clone, PartialEq, Debug)]
pub struct Counterexample {
    /// True when the rule fails from right to left; left and right are then
    /// those of the reversed rule.
    pub backwards: bool,
    /// True when the numbers are next to where the rule fails, which is at
    /// none that binary64 can write.
    pub near: bool,
    /// The variables' names and numbers.
    pub values: Vec<(String, f64)>,
    /// The left side there; infinite beyond the range of binary64.
    pub left: f64,
    /// The right side there; NaN where it is undefined.
    pub right: f64,
    /// False where the right side is not defined.
    pub defined: bool,
    /// Left less right, computed in about 106 bits.
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
        if self.near {
            formatter.write_str("near ")?;
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
        if !self.defined {
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

/// A number for users: all digits when they are few.
pub(super) fn number(number: f64) -> String {
    let plain = format!("{number}");
    if plain.len() <= 20 {
        plain
    } else {
        format!("{number:e}")
    }
}

/// Points tried one after the other, smallest first.
const EXHAUSTIVE: usize = 20_000;

/// The first point that refutes a rule, by largest magnitude, then in the
/// order 0, 1, -1, 2, -2 … of the last variable, the one before, ….
pub(super) fn smallest(joined: &Joined<'_>) -> Option<Counterexample> {
    let count = joined.rule.variables.len();
    let mut left = EXHAUSTIVE;
    for magnitude in 0..=64usize {
        let choices = 2 * magnitude + 1;
        let mut digits = vec![0usize; count];
        loop {
            // Points of smaller magnitude were tried before.
            let largest = digits.iter().map(|digit| digit.div_ceil(2));
            if largest.fold(0, usize::max) == magnitude {
                let values: Vec<f64> = digits.iter().map(|&digit| integer(digit)).collect();
                if let Some(found) = compare(joined, &RealPoint::exactly(values)) {
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
/// defined, and for certain the right side is not or has another value.
pub(super) fn compare(joined: &Joined<'_>, place: &RealPoint) -> Option<Counterexample> {
    if !place.meets(joined.rule) {
        return None;
    }
    let left = evaluate(&joined.rule.left, place, &joined.fields).value()?;
    let right = match evaluate(&joined.rule.right, place, &joined.fields) {
        SideValue::Unknown => return None,
        SideValue::Undefined => None,
        outcome => outcome.value(),
    };
    if right.is_some_and(|right| !left.is_apart_from(right)) {
        return None;
    }
    Some(example(joined, place, left, right))
}

/// A point at which the right side may be undefined; a counterexample when the
/// left side is defined there.
pub(super) fn hole(joined: &Joined<'_>, place: &RealPoint) -> Option<Counterexample> {
    if !place.meets(joined.rule) {
        return None;
    }
    let left = evaluate(&joined.rule.left, place, &joined.fields).value()?;
    Some(example(joined, place, left, None))
}

fn example(
    joined: &Joined<'_>,
    place: &RealPoint,
    left: ScaledBall,
    right: Option<ScaledBall>,
) -> Counterexample {
    assert_eq!(
        place.values.len(),
        joined.rule.variables.len(),
        "one number per variable"
    );
    let names = joined.rule.variables.iter().cloned();
    Counterexample {
        backwards: false,
        near: place.radii.iter().any(|&radius| radius > 0.0),
        values: names.zip(place.values.iter().copied()).collect(),
        left: left.middle(),
        right: right.map_or(f64::NAN, ScaledBall::middle),
        defined: right.is_some(),
        difference: right.map_or(f64::NAN, |right| left.plus(right.negative()).middle()),
    }
}
