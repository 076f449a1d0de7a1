//! Random numbers of binary32.

use robovec_num::random::Random;

/// A sequence of such numbers.
#[derive(Clone, Debug)]
pub(super) struct Draw(Random);

impl Draw {
    pub(super) fn new(seed: u64) -> Draw {
        Draw(Random::new(seed))
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// A number between two, which binary32 holds when they are of its size.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        f64::from((low + (high - low) * self.0.unit()) as f32)
    }

    /// A number between `-bound` and `bound`.
    pub(super) fn within(&mut self, bound: f64) -> f64 {
        self.between(-bound, bound)
    }
}
