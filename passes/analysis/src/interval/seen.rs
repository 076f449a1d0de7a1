//! Errors that were seen: a window run at states of its ranges.
//!
//! A bound limits errors from above; the largest error can be smaller. The
//! error found here is a lower limit: no bound can be lower.

use super::decimal::exact_literal;
use super::{ConeWindow, GivenData, WindowLeaves};
use crate::adjoint::{Tape, half_ulp};
use robovec_ir::Format;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::interval::Interval;
use robovec_num::random::{mix, unit};
use robovec_num::soft_float::FormatArithmetic;

/// The largest error at random states, every other one inside a box (the one
/// with the largest bound), and the number of states that gave one: those
/// that overflow do not.
pub fn largest_seen(
    tape: &Tape,
    window: &ConeWindow,
    leaves: &WindowLeaves,
    inside: &[Interval],
    seed: u64,
    states: usize,
) -> (f64, usize) {
    let arithmetic = FormatArithmetic::new(leaves.format);
    let mut random = seed;
    let mut largest = 0.0f64;
    let mut counted = 0;
    for state in 0..states {
        let ranges = match state % 2 {
            0 => leaves.ranges.as_slice(),
            _ => inside,
        };
        let (mut exact, mut computed) = (Vec::new(), Vec::new());
        for (leaf, range) in ranges.iter().enumerate() {
            let [one, other] = [(); 2].map(|()| {
                random = mix(random.wrapping_add(1));
                unit(random)
            });
            let number = range.low + (range.high - range.low) * one;
            let real = leaves.data == GivenData::Real && leaves.is_input(leaf);
            let held = arithmetic.convert(number);
            exact.push(match (leaves.is_literal(leaf), real) {
                (true, _) => exact_literal(number, leaves.data),
                (false, true) => between(leaves.format, number, *range, other),
                (false, false) if range.contains(held) => Double::from(held),
                // Numbers of the format may lie outside of a narrow range.
                (false, false) => Double::from(f64::NAN),
            });
            computed.push(held);
        }
        for (&node, places) in window.nodes.iter().zip(&window.operands) {
            let operation = tape.operation(node);
            exact.push(DoubleDouble.apply(operation, places.map(|place| exact[place])));
            computed.push(arithmetic.apply(operation, places.map(|place| computed[place])));
        }
        if let (Some(&exact), Some(&computed)) = (exact.last(), computed.last()) {
            let error = (Double::from(computed) - exact).high.abs();
            if error.is_finite() {
                largest = largest.max(error);
                counted += 1;
            }
        }
    }
    (largest, counted)
}

/// A real number that binary64 rounds to this one, inside the range: between
/// the ends of those at places 0 and 1. In other formats the number itself.
pub fn between(format: Format, number: f64, range: Interval, place: f64) -> Double {
    let inner = range.low < number && number < range.high;
    if !inner || format != Format::BINARY64 {
        return Double::from(number);
    }
    // Less than half a unit, so that it is not rounded to a neighbour; below a
    // power of two the unit is half as large.
    let is_power = number.to_bits() << 12 == 0;
    let most = half_ulp(format, number) * if is_power { 0.475 } else { 0.95 };
    Double::from(number) + Double::from(most * (2.0 * place - 1.0))
}
