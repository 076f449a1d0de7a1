//! Random parameters, short enough to be written.

use robovec_num::random::Random;

#[derive(Clone, Debug)]
pub(crate) struct ParameterRandom(Random);

impl ParameterRandom {
    /// The sequence of a seed.
    pub(crate) fn new(seed: u64) -> ParameterRandom {
        ParameterRandom(Random::new(seed))
    }

    /// A number from 0 to below `count`, which is not zero.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.0.below(count)
    }

    /// True once in `count` times.
    pub(crate) fn once_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    /// A number in a range, with four digits, so that files stay short.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        debug_assert!(low <= high, "a range ends after its start");
        four_digits(low + (high - low) * self.0.unit())
    }

    /// As [`ParameterRandom::between`], of either sign.
    pub(crate) fn signed(&mut self, low: f64, high: f64) -> f64 {
        let size = self.between(low, high);
        if self.once_in(2) { -size } else { size }
    }
}

/// The nearest number with four significant digits.
pub(crate) fn four_digits(value: f64) -> f64 {
    let text = format!("{value:.3e}");
    text.parse().expect("the text of a number is one")
}
