//! The steps of the operators and a model of their delays.
//!
//! Delays are those of the cells of a device and of the nets between them
//! ([`Device`]). The delay of a stage is that of one step and of the signals
//! that pass through the steps before it ([`stage_delay`]). It is a little less
//! than that, because logic of one step shares tables with that of the next.
//!
//! **Invariant.** A list has one step per cut of the Verilog module, in the
//! same order; the tests of latency in simulation fail otherwise.

use super::OperatorCore;
use robovec_ir::machine::Device;
use robovec_num::NumberFormat;

/// A step of an operator: the logic between two neighbouring cuts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CoreStep {
    /// The delay of all its logic, in picoseconds.
    pub delay: u32,
    /// The delay up to the signals that the next step waits for: the bits that
    /// a shift drops are gathered in parallel, for instance.
    pub through: u32,
    /// The bits of a register at its end.
    pub bits: u32,
}

/// Bits of the quotient or root that are found between two cuts: wide formats
/// would otherwise have more cuts than the mask has bits.
fn digits_per_cut(mantissa: u32) -> u32 {
    if mantissa > 40 { 2 } else { 1 }
}

/// Levels of six-input tables that combine this number of bits into one.
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

/// The delay of a stage of these steps, in picoseconds.
pub fn stage_delay(steps: &[CoreStep]) -> u32 {
    let (mut longest, mut through) = (0, 0);
    for step in steps {
        longest = longest.max(through + step.delay);
        through += step.through;
    }
    longest
}

/// The steps of an operator on a device whose nets take this number of
/// picoseconds.
pub(super) fn of(
    core: OperatorCore,
    format: NumberFormat,
    device: &Device,
    net: u32,
) -> Vec<CoreStep> {
    let mut steps = CoreSteps {
        steps: Vec::new(),
        device,
        net,
    };
    match core {
        OperatorCore::Add => steps.add(format),
        OperatorCore::Multiply => steps.multiply(format),
        OperatorCore::Divide => steps.divide(format),
        OperatorCore::Root => steps.root(format),
        OperatorCore::Fused => steps.fused(format),
    }
    steps.steps
}

struct CoreSteps<'a> {
    steps: Vec<CoreStep>,
    device: &'a Device,
    net: u32,
}

impl CoreSteps<'_> {
    fn step(&mut self, delay: u32, bits: u32) {
        self.step_beside(delay, delay, bits);
    }

    fn step_beside(&mut self, through: u32, delay: u32, bits: u32) {
        self.steps.push(CoreStep {
            delay,
            through,
            bits,
        });
    }

    /// Levels of tables, each with the net to it.
    fn tables(&self, levels: u32) -> u32 {
        levels * (self.device.cells.table + self.net)
    }

    /// A carry chain, with the net to it.
    fn chain(&self, places: u32) -> u32 {
        self.device.cells.chain + self.net + places * self.device.cells.carry
    }

    /// A multiplier block, with the net to it.
    fn block(&self) -> u32 {
        self.device.cells.multiplier + self.net
    }

    /// Pieces that a factor is cut into for multiplier blocks.
    fn pieces(&self, bits: u32) -> u32 {
        bits.div_ceil(self.device.blocks.factor)
    }

    /// The sum of the products of the pieces of two factors.
    fn partial_sum(&self, bits: u32) -> u32 {
        let pieces = self.pieces(bits);
        if pieces == 1 {
            return 0;
        }
        // Compressors of three to two, then one chain.
        let mut addends = 2 * pieces - 1;
        let mut levels = 0;
        while addends > 2 {
            addends = addends.div_ceil(3) * 2 - u32::from(addends % 3 == 1);
            levels += 1;
        }
        self.tables(levels) + self.chain(2 * bits - bits.div_ceil(pieces))
    }

    /// A product of two numbers of this number of bits: where one block does
    /// not do, the products of the parts are added up.
    fn multiplier(&self, bits: u32) -> u32 {
        self.block() + self.partial_sum(bits)
    }

    fn add(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let amount = clog2(m + 4);
        let sum = m + 5;
        self.step(self.net, 2 * (m + e + 1));
        self.step(self.chain(m.max(e)), 4 * e + 2 * m + 11);
        self.step(self.tables(3), 2 * m + amount + e + 6);
        self.shift_right(m + 3, amount, m + 5 + e);
        self.step(self.chain(sum / 2), 2 * sum - sum / 2 + e + 5);
        self.step(self.chain(sum - sum / 2), sum + clog2(sum) + e + 4);
        self.normalise(sum, format.subnormals, e + 4);
        self.pack(format, self.chain(e));
    }

    fn multiply(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let product = 2 * m + 2;
        let amount = clog2(product + 2);
        let wide = e.max(amount) + 2;
        let pieces = self.pieces(m + 1);
        let partial = match pieces {
            1 => product,
            _ => 2 * pieces * pieces * (m + 1).div_ceil(pieces),
        };
        let operands = 2 * (m + e + 1 + e.div_ceil(4));
        let side = 2 * e + 8;
        self.step(self.net, 2 * (m + e + 1));
        self.step(self.tables(1), operands);
        // A table before the block says whether an operand is subnormal.
        let before = self.tables(1);
        if format.subnormals {
            let count = clog2(m + 1);
            self.step(
                before + self.block().max(self.tables(count)),
                partial + wide + count + 4,
            );
            let counted = self.chain(wide) + self.tables(2);
            let sum = self.partial_sum(m + 1);
            self.step(counted.max(sum), product + wide + amount + 4);
            self.shift_right(product + 1, amount, side);
        } else {
            self.step(before + self.block(), partial + wide + 4);
            let sum = self.partial_sum(m + 1).max(self.net);
            self.step(sum, product + wide + 4);
            self.step(self.tables(reduction(m)).max(self.chain(e)), m + 4 + side);
        }
        self.step(self.tables(2), e + m + 6);
        self.pack(format, 0);
    }

    fn divide(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let wide = e.max(clog2(m + 1)) + 3;
        self.step(self.tables(2), 2 * (m + e) + 6);
        self.leading(format, 2, m + e + 6);
        self.step(2 * self.chain(wide), 2 * m + wide + 7);
        let digits = m + 3;
        let every = digits_per_cut(m);
        for cut in 1..=digits.div_ceil(every) {
            let known = (cut * every).min(digits);
            let steps = known - (cut - 1) * every;
            self.step(
                steps * (self.chain(m + 3) + self.tables(1)),
                2 * m + 3 + known + wide + 4,
            );
        }
        let amount = clog2(m + 4);
        self.step(2 * self.chain(wide) + self.tables(1), m + 7 + amount + e);
        if format.subnormals {
            self.shift_right(m + 2, amount, e + 5);
        }
        self.pack(format, 0);
    }

    fn root(&mut self, format: NumberFormat) {
        let (e, m) = (format.exponent, format.mantissa);
        let wide = e.max(clog2(m + 1)) + 3;
        self.step(self.tables(2), m + e + 5);
        self.leading(format, 1, 4);
        self.step(2 * self.chain(wide), m + wide + 6);
        let digits = m + 2;
        let every = digits_per_cut(m);
        for cut in 1..=digits.div_ceil(every) {
            let known = (cut * every).min(digits);
            let first = (cut - 1) * every;
            let delay = (first..known)
                .map(|digit| self.chain(digit + 4) + self.tables(1))
                .sum();
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
        self.step(self.tables(3), 3 * (m + e) + 8);
        self.leading(format, 2, 2 * m + 2 * e + 8);
        self.step(2 * self.chain(wide), 3 * m + 8 + wide + e);
        self.step(self.multiplier(m + 1), product + 2 * wide + e + m + 6);
        self.step(self.tables(3), product + amount + wide + m + 5);
        self.shift_right(window, amount, product + wide + 4);
        self.step(self.chain(sum / 2), 3 * sum - sum / 2 + wide + 6);
        self.step(self.chain(sum - sum / 2), 2 * sum + wide + 5);
        self.step(self.tables(2), sum + clog2(sum) + wide + 4);
        self.normalise(sum, format.subnormals, wide + 4);
        self.pack(format, self.chain(wide));
    }

    /// Several `fp_leading` beside each other.
    fn leading(&mut self, format: NumberFormat, operands: u32, payload: u32) {
        if !format.subnormals {
            return;
        }
        let first = self.steps.len();
        self.normalise(format.mantissa + 1, false, format.exponent);
        for step in &mut self.steps[first..] {
            step.bits = step.bits * operands + payload;
        }
    }

    /// `fp_shift_right`, with the signals that pass through the same stages.
    fn shift_right(&mut self, width: u32, amount: u32, payload: u32) {
        let mut left = amount;
        while left > 0 {
            left = left.saturating_sub(2);
            let dropped = 3 * (1 << left);
            let levels = 1 + reduction(dropped.min(width));
            self.step_beside(
                self.tables(1),
                self.tables(levels),
                width + left + 1 + payload,
            );
        }
    }

    /// `fp_normalise`, with the signals that pass through the same stages.
    fn normalise(&mut self, width: u32, limited: bool, payload: u32) {
        let count = clog2(width);
        let mut left = count;
        while left > 0 {
            left = left.saturating_sub(2);
            let limit = if limited { left + 2 } else { 0 };
            let side = count - left + limit + 1 + payload;
            let choice = 1 + reduction(1 << left) + u32::from(limited);
            self.step(self.tables(choice), width + 2 + side);
            self.step(self.tables(1), width + side);
        }
    }

    /// `fp_pack`, after a step whose delay counts in its first stage.
    fn pack(&mut self, format: NumberFormat, entry: u32) {
        let size = format.exponent + format.mantissa;
        self.step(entry + self.tables(2), size + 2);
        self.step(self.chain(size / 2), size + 2);
        self.step(self.chain(size - size / 2), size + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::DeviceFamily;

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
        let device = DeviceFamily::default().device();
        let of = |core, format| super::of(core, format, device, device.nets.quick);
        assert_eq!(of(OperatorCore::Add, format).len(), 17);
        assert_eq!(of(OperatorCore::Multiply, format).len(), 11);
        let flushed = NumberFormat {
            subnormals: false,
            ..format
        };
        assert_eq!(of(OperatorCore::Add, flushed).len(), 17);
        assert_eq!(of(OperatorCore::Multiply, flushed).len(), 9);
        assert_eq!(of(OperatorCore::Divide, flushed).len(), 32);
        assert_eq!(of(OperatorCore::Root, flushed).len(), 30);
    }
}
