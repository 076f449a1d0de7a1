//! Random numbers, the same everywhere.

/// A generator of pseudo-random numbers (SplitMix64): a few lines, and quite
/// good enough for parameters.
#[derive(Clone, Debug)]
pub(crate) struct SplitMix(u64);

impl SplitMix {
    /// The sequence of a seed.
    pub(crate) fn new(seed: u64) -> SplitMix {
        SplitMix(seed)
    }

    /// The next 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number from 0 to below `count`, which is not zero.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// True once in `count` times.
    pub(crate) fn once_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    /// A number in a range, with four digits, so that files stay short.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        four_digits(low + (high - low) * unit)
    }

    /// As [`SplitMix::between`], of either sign.
    pub(crate) fn signed(&mut self, low: f64, high: f64) -> f64 {
        let size = self.between(low, high);
        if self.once_in(2) { -size } else { size }
    }
}

/// The nearest number with four significant digits.
pub(crate) fn four_digits(value: f64) -> f64 {
    // The text of a finite number is a number.
    format!("{value:.3e}").parse().unwrap_or(value)
}
