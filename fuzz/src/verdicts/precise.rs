//! Rules in numbers of 2,000 bits.

use astro_float::{BigFloat, Consts, RoundingMode};
use robovec_ir::Operation;
use robovec_num::random::Random;
use robovec_rules::{Pattern, PatternNode, Rule};

const BITS: usize = 2_048;
const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// Differences below this power of two of the largest number may be equal.
const EQUAL: i64 = -1_000;
/// Divisors must be larger than this power of two of the largest number, so
/// that hardly any bit is lost.
const CLOSE: i64 = -200;

/// Side of a comparison.
enum Side {
    /// Its value, and the largest exponent of all numbers on the way.
    Value(BigFloat, i64),
    /// Not defined, for certain.
    Undefined,
    /// Too close to decide.
    Unknown,
}

fn exponent(number: &BigFloat) -> i64 {
    if number.is_zero() {
        i64::MIN / 4
    } else {
        number.exponent().map_or(i64::MAX / 4, i64::from)
    }
}

fn evaluate(pattern: &Pattern, values: &[f64], constants: &mut Consts) -> Side {
    let mut numbers: Vec<BigFloat> = Vec::with_capacity(pattern.nodes.len());
    let (mut largest, mut exact) = (0i64, true);
    for node in &pattern.nodes {
        let number = match *node {
            PatternNode::Variable(variable) => BigFloat::from_f64(values[variable as usize], BITS),
            PatternNode::Number(number) => BigFloat::from_f64(number, BITS),
            PatternNode::Operation(operation, [a, b]) => {
                let (a, b) = (&numbers[a as usize], &numbers[b as usize]);
                let partial = match operation {
                    Operation::Div => Some(b),
                    Operation::Sqrt => Some(a),
                    _ => None,
                };
                if let Some(operand) = partial {
                    let clear = exponent(operand) > largest + CLOSE;
                    let is_root = operation == Operation::Sqrt;
                    if exact && operand.is_zero() && !is_root
                        || clear && is_root && operand.is_negative()
                    {
                        return Side::Undefined;
                    }
                    if !(clear || exact && operand.is_zero()) {
                        return Side::Unknown;
                    }
                }
                match operation {
                    Operation::Neg => a.neg(),
                    Operation::Add => a.add(b, BITS, ROUNDING),
                    Operation::Sub => a.sub(b, BITS, ROUNDING),
                    Operation::Mul => a.mul(b, BITS, ROUNDING),
                    Operation::Div => a.div(b, BITS, ROUNDING),
                    Operation::Sqrt => a.sqrt(BITS, ROUNDING),
                    Operation::Sin | Operation::Cos if exponent(a) > 300 => return Side::Unknown,
                    Operation::Sin => a.sin(BITS, ROUNDING, constants),
                    Operation::Cos => a.cos(BITS, ROUNDING, constants),
                    _ => return Side::Unknown,
                }
            }
        };
        exact &= !number.inexact();
        if number.is_nan() || number.is_inf() {
            return Side::Unknown;
        }
        largest = largest.max(exponent(&number));
        numbers.push(number);
    }
    match numbers.pop() {
        Some(number) => Side::Value(number, largest),
        None => Side::Unknown,
    }
}

/// Places at which rules are tried, by number.
fn place(rule: &Rule, number: usize) -> Vec<f64> {
    let mut random = Random::new(number as u64 + 1);
    let mut next = |limit: u64| random.bits() % limit;
    let nodes = rule.left.nodes.iter().chain(&rule.right.nodes);
    let numbers: Vec<f64> = nodes
        .filter_map(|node| match *node {
            PatternNode::Number(number) if number.abs() > 1e-200 && number.abs() < 1e200 => {
                Some(number)
            }
            _ => None,
        })
        .collect();
    let mut draw = || match next(6) {
        0 => next(9) as f64 - 4.0,
        1 => next(4001) as f64 / 8.0 - 250.0,
        2 if !numbers.is_empty() => numbers[next(numbers.len() as u64) as usize],
        3 if !numbers.is_empty() => {
            let near = numbers[next(numbers.len() as u64) as usize];
            near * (1.0 + (next(2001) as f64 - 1000.0) / 1024.0)
        }
        _ => (next(2_000_001) as f64 - 1e6) / 65536.0,
    };
    (0..rule.variables.len() as u32)
        .map(|variable| {
            let value: f64 = draw();
            let holds = rule
                .requirements(variable)
                .all(|needed| needed.holds_for(value));
            if holds { value } else { value.abs() + 1.5 }
        })
        .collect()
}

/// True when numbers show that a rule is false.
pub(super) fn is_false(rule: &Rule, places: usize) -> bool {
    let Ok(mut constants) = Consts::new() else {
        return false;
    };
    (0..places).any(|number| {
        let values = place(rule, number);
        let Side::Value(left, first) = evaluate(&rule.left, &values, &mut constants) else {
            return false;
        };
        match evaluate(&rule.right, &values, &mut constants) {
            Side::Unknown => false,
            Side::Undefined => true,
            Side::Value(right, second) => {
                let difference = left.sub(&right, BITS, ROUNDING);
                exponent(&difference) > first.max(second) + EQUAL
            }
        }
    })
}
