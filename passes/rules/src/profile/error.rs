//! The effect of a rule on rounding errors.

use super::super::rule::{Requirement, Rule};
use robovec_num::arithmetic::{Arithmetic, Binary32};
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::random::Random;

/// Errors of one side, in units in the last place of binary32.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct SideErrors {
    /// Half of the points have a smaller error.
    pub median: f64,
    /// All but one in a thousand have a smaller error.
    pub high: f64,
}

/// Errors of both sides at the same points.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct Transfer {
    /// Of the left side.
    pub left: SideErrors,
    /// Of the right side.
    pub right: SideErrors,
    /// Points where the exact value is a normal number, which were compared.
    pub points: usize,
}

/// Errors of both sides in binary32 against the left side in double-double
/// arithmetic, at inputs of either sign, log-uniform from 1e-3 to 1e3.
pub(super) fn transfer(rule: &Rule, points: usize) -> Transfer {
    let mut random = Random::new(11);
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for _ in 0..points {
        let values = (0..rule.variables.len()).map(|variable| {
            let drawn = random.log_uniform(-10, 9);
            let mut needed = rule.requirements(variable as u32);
            if needed.any(|requirement| requirement == Requirement::Positive) {
                drawn.abs()
            } else {
                drawn
            }
        });
        // The inputs are numbers of the format: their rounding is not the
        // rule's.
        let inputs: Vec<f32> = values.map(|value| value as f32).collect();
        let exact: Vec<Double> = inputs
            .iter()
            .map(|&input| DoubleDouble.literal(f64::from(input)))
            .collect();
        let reference = rule.left.evaluate(&DoubleDouble, &exact);
        let size = reference.high.abs();
        if !(f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&size) {
            continue;
        }
        let unit = last_place(size);
        let error = |computed: f32| reference.distance(f64::from(computed)) / unit;
        left.push(error(rule.left.evaluate(&Binary32, &inputs)));
        right.push(error(rule.right.evaluate(&Binary32, &inputs)));
    }
    Transfer {
        points: left.len(),
        left: spread(left),
        right: spread(right),
    }
}

/// The unit in the last place of binary32 at a normal number.
fn last_place(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    2f64.powi(exponent - 23)
}

fn spread(mut errors: Vec<f64>) -> SideErrors {
    errors.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let last = errors.len().checked_sub(1)?;
        errors.get((part * last as f64).round() as usize).copied()
    };
    SideErrors {
        median: at(0.5).unwrap_or(0.0),
        high: at(0.999).unwrap_or(0.0),
    }
}
