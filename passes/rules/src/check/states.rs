//! Points of the reals at which rules are tried: near and far, whole and
//! broken, of either sign, at the numbers that are in the rule and close to
//! them, and where variables are equal or opposite.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::{Requirement, Rule};
use robovec_num::random::Random;

/// Draws points for a rule.
pub(super) struct RulePoints<'a> {
    rule: &'a Rule,
    random: Random,
    /// The numbers that are in the rule, without zero.
    numbers: Vec<f64>,
}

impl<'a> RulePoints<'a> {
    /// Points for a rule, others for another seed.
    pub(super) fn of(rule: &'a Rule, seed: u64) -> RulePoints<'a> {
        RulePoints {
            rule,
            random: Random::new(seed),
            numbers: numbers(&[&rule.left, &rule.right]),
        }
    }

    /// The next point. All conditions on variables hold.
    pub(super) fn next(&mut self) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(self.rule.variables.len());
        for variable in 0..self.rule.variables.len() as u32 {
            let mut value = self.draw(&values);
            for requirement in self.rule.requirements(variable) {
                if requirement == Requirement::Positive {
                    value = value.abs();
                }
                if !requirement.holds_for(value) {
                    value = 1.0 + self.random.below(9) as f64;
                }
            }
            values.push(value);
        }
        values
    }

    fn draw(&mut self, others: &[f64]) -> f64 {
        let random = &mut self.random;
        match random.below(8) {
            0 => random.below(19) as f64 - 9.0,
            1 => (random.below(65) as f64 - 32.0) / 8.0,
            2 | 3 => random.log_uniform(-10, 9),
            4 => random.log_uniform(-45, 44),
            5 if !others.is_empty() => {
                let other = others[random.below(others.len())];
                if random.below(2) == 0 { other } else { -other }
            }
            6 | 7 if !self.numbers.is_empty() => {
                let number = self.numbers[random.below(self.numbers.len())];
                let sign = if random.below(8) == 0 { -1.0 } else { 1.0 };
                let near = match random.below(4) {
                    0 => number,
                    1 => number + random.below(9) as f64 - 4.0,
                    _ => number * (1.0 + random.log_uniform(-52, -1)),
                };
                let near = sign * near;
                if near.is_finite() { near } else { number }
            }
            _ => random.log_uniform(-3, 3),
        }
    }
}

/// The numbers that are in patterns, each once, without zero.
pub(super) fn numbers(patterns: &[&Pattern]) -> Vec<f64> {
    let nodes = patterns.iter().flat_map(|pattern| &pattern.nodes);
    let mut numbers: Vec<f64> = nodes
        .filter_map(|node| match *node {
            PatternNode::Number(number) if number != 0.0 => Some(number),
            _ => None,
        })
        .collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    numbers
}
