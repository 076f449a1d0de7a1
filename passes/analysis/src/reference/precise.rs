//! Arbitrary precision with a bound of its error, raised until one
//! binary64 number is nearest.
//!
//! The strategy is Ziv's ("Fast evaluation of elementary mathematical functions
//! with correctly rounded last bit", 1991), for whole functions: compute with
//! this number of bits and a radius; where the ends of the ball round to
//! different binary64 numbers, compute again with twice as many. A value that
//! is still not distinguished from zero with [`MAX_BITS`] bits counts as zero:
//! it is less than 2⁻⁹⁰⁰ of its largest terms, or zero by an identity that does
//! not hold in the prime field.
//!
//! Radii are counted in units of the precision's own rounding, so that they
//! neither sink below the range of binary64 nor depend on the precision to
//! first order.

use super::rounding::{from_binary64, magnitude, to_binary64};
use super::{ExactEvidence, ExactOutput};
use astro_float::{BigFloat, Consts, RoundingMode};
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::{Function, Operation};
use robovec_num::double_double::Double;

/// Bits of the first attempt: whole words of the library's.
const MIN_BITS: usize = 192;

/// Bits of the last attempt.
const MAX_BITS: usize = 1536;

const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// A number of arbitrary precision with a bound of its error.
#[derive(Clone)]
struct PreciseBall {
    value: BigFloat,
    /// An upper bound of its absolute value; infinite beyond the range of
    /// binary64.
    size: f64,
    /// The largest distance of the exact value, in units of the precision's
    /// rounding.
    radius: f64,
}

/// Computes the wanted assignments of a function so precisely that each is
/// within its bound of one binary64 number. `places` counts them from 0, in
/// ascending order; `zeros` states of all assignments which are zero by an
/// identity.
pub(super) fn evaluate(
    function: &Function,
    inputs: &[f64],
    places: &[usize],
    zeros: &[bool],
    constants: &mut Consts,
) -> Vec<ExactOutput> {
    let mut results: Vec<Option<ExactOutput>> = vec![None; places.len()];
    let mut bits = MIN_BITS;
    loop {
        let open: Vec<usize> = (0..places.len())
            .filter(|&index| results[index].is_none())
            .collect();
        let wanted: Vec<usize> = open.iter().map(|&index| places[index]).collect();
        if wanted.is_empty() {
            break;
        }
        let plan = EvaluationPlan::of(function, |index| wanted.binary_search(&index).is_ok());
        let balls = run(&plan, inputs, bits, constants);
        for (&index, ball) in open.iter().zip(&balls) {
            results[index] = settle(ball, zeros[places[index]], bits);
        }
        bits *= 2;
    }
    // The loop ends when all are settled, which the last attempt does.
    results.into_iter().flatten().collect()
}

/// Evaluates a plan with this number of bits.
fn run(
    plan: &EvaluationPlan,
    inputs: &[f64],
    bits: usize,
    constants: &mut Consts,
) -> Vec<PreciseBall> {
    let unit = 2f64.powi(-(bits.min(1000) as i32));
    plan.run_with(
        inputs,
        |number| PreciseBall {
            value: from_binary64(number, bits),
            size: number.abs(),
            radius: 0.0,
        },
        |operation, operands| apply(operation, operands, bits, unit, constants),
    )
}

/// One operation, rounded to this number of bits.
pub(crate) fn operate(
    operation: Operation,
    [a, b, c]: [&BigFloat; 3],
    bits: usize,
    constants: &mut Consts,
) -> BigFloat {
    match operation {
        Operation::Copy => a.clone(),
        Operation::Neg => a.neg(),
        Operation::Add => a.add(b, bits, ROUNDING),
        Operation::Sub => a.sub(b, bits, ROUNDING),
        Operation::Mul => a.mul(b, bits, ROUNDING),
        Operation::Div => a.div(b, bits, ROUNDING),
        Operation::Sin => a.sin(bits, ROUNDING, constants),
        Operation::Cos => a.cos(bits, ROUNDING, constants),
        Operation::Sqrt => a.sqrt(bits, ROUNDING),
        Operation::Fma | Operation::Fms | Operation::Fnma => {
            let product = a.mul_full_prec(b);
            match operation {
                Operation::Fma => product.add(c, bits, ROUNDING),
                Operation::Fms => product.sub(c, bits, ROUNDING),
                _ => c.sub(&product, bits, ROUNDING),
            }
        }
    }
}

fn apply(
    operation: Operation,
    [a, b, c]: [&PreciseBall; 3],
    bits: usize,
    unit: f64,
    constants: &mut Consts,
) -> PreciseBall {
    let operands = [&a.value, &b.value, &c.value];
    let value = operate(operation, operands, bits, constants);
    let size = magnitude(&value);
    let product = || a.size * b.radius + b.size * a.radius + 2.0 * unit * a.radius * b.radius;
    // Sizes are upper bounds by at most 2^-50; a divisor is told from zero
    // with that in mind.
    let carried = match operation {
        Operation::Copy | Operation::Neg => {
            return PreciseBall {
                value,
                size,
                radius: a.radius,
            };
        }
        Operation::Add | Operation::Sub => a.radius + b.radius,
        Operation::Mul => product(),
        Operation::Fma | Operation::Fms | Operation::Fnma => product() + c.radius,
        Operation::Div if a.radius == 0.0 && b.radius == 0.0 => 0.0,
        Operation::Div => {
            let nearest = b.size * (1.0 - 1e-12) - b.radius * unit;
            if nearest > 0.0 {
                (a.radius + size * b.radius) / nearest
            } else {
                f64::INFINITY
            }
        }
        Operation::Sin | Operation::Cos => a.radius.min(2.0 / unit),
        Operation::Sqrt if a.radius == 0.0 => 0.0,
        Operation::Sqrt => {
            let nearest = a.size * (1.0 - 1e-12) - a.radius * unit;
            if nearest > 0.0 {
                a.radius / nearest.sqrt()
            } else {
                f64::INFINITY
            }
        }
    };
    // Nothing is added where nothing was rounded, so that sums of short
    // numbers are known to be ties where they are.
    let exact = carried == 0.0 && !value.inexact();
    PreciseBall {
        radius: if exact { 0.0 } else { carried + size },
        size,
        value,
    }
}

/// The binary64 numbers of a value, when its bound leaves one choice or there
/// are no more bits to be had.
fn settle(ball: &PreciseBall, zero: bool, bits: usize) -> Option<ExactOutput> {
    let last = bits >= MAX_BITS;
    let high = to_binary64(&ball.value);
    let radius = ball.radius * super::ball::SLACK;
    if !high.is_finite() || !radius.is_finite() {
        // What is no number with few bits may be one with more: a divisor or
        // the argument of a root may have lost a term far smaller than others.
        return last.then_some(ExactOutput {
            value: Double::from(high),
            bound: f64::INFINITY,
            kind: ExactEvidence::Uncertain,
        });
    }
    // The radius in absolute terms, as a number of the library's: it may be
    // far below the range of binary64.
    let mut reach = from_binary64(radius, 64);
    if let (false, Some(exponent)) = (reach.is_zero(), reach.exponent()) {
        reach.set_exponent(exponent - bits as i32);
    }
    let ends = [
        ball.value.sub(&reach, bits + 64, ROUNDING),
        ball.value.add(&reach, bits + 64, ROUNDING),
    ];
    let [below, above] = ends.each_ref().map(to_binary64);
    let low = to_binary64(&ball.value.sub(&from_binary64(high, 64), bits, ROUNDING));
    let bound = radius * 2f64.powi(-(bits.min(1000) as i32)) + low.abs() * f64::EPSILON.powi(2);
    // A constant may vanish in the fields by accident, so that their word
    // alone is not enough.
    let straddles = ends[0].is_negative() != ends[1].is_negative();
    if straddles && (zero || last) {
        return Some(ExactOutput {
            value: Double::from(0.0),
            bound: 0.0,
            kind: ExactEvidence::Zero,
        });
    }
    let kind = if below == above {
        ExactEvidence::Precise(bits as u32)
    } else if !last {
        return None;
    } else {
        ExactEvidence::Uncertain
    };
    Some(ExactOutput {
        value: Double { high, low },
        bound,
        kind,
    })
}
