//! The steps of the operators and a model of their delays.
//!
//! Delays are those of a Cyclone V of speed grade 7, as the open synthesis
//! flow publishes them for its cells, with a guess of half a nanosecond for
//! every wire between two cells. Only their proportions matter here. A stage
//! of several steps is a little quicker than their sum, because logic of one
//! step shares tables with that of the next.
//!
//! **Invariant.** A list has one step per cut of the Verilog module, in the
//! same order; the tests of latency in simulation fail otherwise.

use super::OperatorCore;
use robovec_num::NumberFormat;

/// A step of an operator: what stands between two neighbouring cuts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CoreStep {
    /// The delay of its logic, in picoseconds.
    pub delay: u32,
    /// The bits of a register at its end.
    pub bits: u32,
}

/// A look-up table of six inputs and the wire to it.
const TABLE: u32 = 850;
/// Into a carry chain and out of it again, with the wire to it.
const CHAIN: u32 = 1300;
/// One place of a carry chain.
const CARRY: u32 = 36;
/// A multiplier block, with the wire to it.
const MULTIPLIER: u32 = 4400;
/// The bits of both factors that one multiplier block takes.
const BLOCK: u32 = 27;
/// A wire without logic.
const WIRE: u32 = 500;

fn tables(levels: u32) -> u32 {
    levels * TABLE
}

fn chain(places: u32) -> u32 {
    CHAIN + places * CARRY
}

/// A product of two numbers of so many bits: where one block does not do, the
/// products of the parts are added up.
fn multiplier(bits: u32) -> u32 {
    let parts = bits.div_ceil(BLOCK);
    let sums = (parts * parts).next_power_of_two().trailing_zeros();
    MULTIPLIER + sums * chain(2 * bits - BLOCK.min(bits))
}

/// Bits of the quotient or root that are found between two cuts: wide formats
/// would otherwise have more cuts than the mask has bits.
fn digits_per_cut(mantissa: u32) -> u32 {
    if mantissa > 40 { 2 } else { 1 }
}

/// Levels of six-input tables that combine so many bits into one.
fn reduction(bits: u32) -> u32 {
    let mut levels = 0;
    let mut left = bits;
    while left > 1 {
        left = left.div_ceil(6);
        levels += 1;
    }
    levels
}

/// Bits that count up to, but not including, a number: `$clog2`.
fn clog2(number: u32) -> u32 {
    number.next_power_of_two().trailing_zeros()
}

pub(super) fn of(core: OperatorCore, format: NumberFormat) -> Vec<CoreStep> {
    let mut steps = CoreSteps(Vec::new());
    match core {
        OperatorCore::Add => steps.add(format),
        OperatorCore::Multiply => steps.multiply(format),
        OperatorCore::Divide => steps.divide(format),
        OperatorCore::Root => steps.root(format),
        OperatorCore::Fused => steps.fused(format),
    }
    steps.0
}

struct CoreSteps(Vec<CoreStep>);

impl CoreSteps {
    fn step(&mut self, delay: u32, bits: u32) {
        self.0.push(CoreStep { delay, bits });
    }

    fn add(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let amount = clog2(m + 4);
        let sum = m + 5;
        self.step(chain(m.max(e)), 4 * e + 2 * m + 11);
        self.step(tables(3), 2 * m + amount + e + 6);
        self.shift_right(m + 3, amount, m + 5 + e);
        self.step(chain(sum / 2), 2 * sum - sum / 2 + e + 5);
        self.step(chain(sum - sum / 2), sum + clog2(sum) + e + 4);
        self.normalise(sum, format.subnormals, e + 4);
        self.pack(format, chain(e));
    }

    fn multiply(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let product = 2 * m + 2;
        let amount = clog2(product + 2);
        let wide = e.max(amount) + 2;
        self.step(tables(reduction(e)), 2 * (m + e) + 6);
        self.step(WIRE, 2 * (m + e) + 6);
        if format.subnormals {
            let count = clog2(m + 1);
            self.step(
                MULTIPLIER.max(tables(2 * count)),
                product + wide + count + 4,
            );
            self.step(chain(wide) + tables(2), product + wide + amount + 4);
            self.shift_right(product + 1, amount, wide + 4);
        } else {
            self.step(multiplier(m + 1), product + wide + 4);
            self.step(WIRE, product + wide + 4);
            self.step(tables(reduction(m)), m + 8 + wide);
        }
        self.step(tables(2) + chain(e), e + m + 6);
        self.pack(format, 0);
    }

    fn divide(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let wide = e.max(clog2(m + 1)) + 3;
        self.step(tables(2), 2 * (m + e) + 6);
        self.leading(format, 2, m + e + 6);
        self.step(2 * chain(wide), 2 * m + wide + 7);
        let digits = m + 3;
        let every = digits_per_cut(m);
        for cut in 1..=digits.div_ceil(every) {
            let known = (cut * every).min(digits);
            let steps = known - (cut - 1) * every;
            self.step(steps * (chain(m + 3) + TABLE), 2 * m + 3 + known + wide + 4);
        }
        let amount = clog2(m + 4);
        self.step(2 * chain(wide) + tables(1), m + 7 + amount + e);
        if format.subnormals {
            self.shift_right(m + 2, amount, e + 5);
        }
        self.pack(format, 0);
    }

    fn root(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let wide = e.max(clog2(m + 1)) + 3;
        self.step(tables(2), m + e + 5);
        self.leading(format, 1, 4);
        self.step(2 * chain(wide), m + wide + 6);
        let digits = m + 2;
        let every = digits_per_cut(m);
        for cut in 1..=digits.div_ceil(every) {
            let known = (cut * every).min(digits);
            let first = (cut - 1) * every;
            let delay = (first..known).map(|digit| chain(digit + 4) + TABLE).sum();
            // What is left of the radicand, the root and the remainder.
            let left = (m + 2).saturating_sub(2 * known);
            self.step(delay, left + 2 * known + 2 + wide + 4);
        }
        if format.subnormals && m as i32 >= format.largest_exponent() {
            self.shift_right(m + 2, clog2(m + 4), e + 5);
        }
        self.pack(format, 0);
    }

    fn fused(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let window = 3 * m + 5;
        let sum = window + 1;
        let amount = clog2(window + 1);
        let wide = e.max(clog2(sum)) + 3;
        let product = 2 * m + 2;
        self.step(tables(3), 3 * (m + e) + 8);
        self.leading(format, 2, 2 * m + 2 * e + 8);
        self.step(2 * chain(wide), 3 * m + 8 + wide + e);
        self.step(multiplier(m + 1), product + 2 * wide + e + m + 6);
        self.step(tables(3), product + amount + wide + m + 5);
        self.shift_right(window, amount, product + wide + 4);
        self.step(chain(sum / 2), 3 * sum - sum / 2 + wide + 6);
        self.step(chain(sum - sum / 2), 2 * sum + wide + 5);
        self.step(tables(2), sum + clog2(sum) + wide + 4);
        self.normalise(sum, format.subnormals, wide + 4);
        self.pack(format, chain(wide));
    }

    /// So many `fp_leading` beside each other.
    fn leading(&mut self, format: NumberFormat, operands: u32, payload: u32) {
        if !format.subnormals {
            return;
        }
        let first = self.0.len();
        self.normalise(format.mantissa + 1, false, format.exponent);
        for step in &mut self.0[first..] {
            step.bits = step.bits * operands + payload;
        }
    }

    /// `fp_shift_right`, with what travels beside it.
    fn shift_right(&mut self, width: u32, amount: u32, payload: u32) {
        let mut left = amount;
        while left > 0 {
            left = left.saturating_sub(2);
            let dropped = 3 * (1 << left);
            let levels = 1 + reduction(dropped.min(width));
            self.step(tables(levels), width + left + 1 + payload);
        }
    }

    /// `fp_normalise`, with what travels beside it.
    fn normalise(&mut self, width: u32, limited: bool, payload: u32) {
        let count = clog2(width);
        let mut left = count;
        while left > 0 {
            left = left.saturating_sub(2);
            let limit = if limited { left + 2 } else { 0 };
            let side = count - left + limit + 1 + payload;
            let choice = 1 + reduction(1 << left) + u32::from(limited);
            self.step(tables(choice), width + 2 + side);
            self.step(tables(1), width + side);
        }
    }

    /// `fp_pack`, after something that takes time in its first step.
    fn pack(&mut self, format: NumberFormat, entry: u32) {
        let size = format.exponent + format.mantissa;
        self.step(entry + tables(2), size + 2);
        self.step(chain(size / 2), size + 2);
        self.step(chain(size - size / 2), size + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_round_up() {
        let logarithms: Vec<u32> = [1, 2, 3, 4, 5, 28, 32, 33].map(clog2).into();
        assert_eq!(logarithms, [0, 1, 2, 2, 3, 5, 5, 6]);
        assert_eq!([1, 2, 6, 7, 36, 37].map(reduction), [0, 1, 1, 2, 2, 3]);
    }

    #[test]
    fn operators_of_binary32_have_enough_cuts_for_the_thesis() {
        // Tables 1.1 and 1.2 go up to 14 and 9 stages.
        let format = NumberFormat::BINARY32;
        assert_eq!(of(OperatorCore::Add, format).len(), 16);
        assert_eq!(of(OperatorCore::Multiply, format).len(), 11);
        let flushed = NumberFormat {
            subnormals: false,
            ..format
        };
        assert_eq!(of(OperatorCore::Add, flushed).len(), 16);
        assert_eq!(of(OperatorCore::Multiply, flushed).len(), 9);
        assert_eq!(of(OperatorCore::Divide, flushed).len(), 32);
        assert_eq!(of(OperatorCore::Root, flushed).len(), 30);
    }
}
