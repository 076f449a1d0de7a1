//! Random numbers for trials: the same on every machine and in every run.

/// A sequence of random numbers (SplitMix64).
#[derive(Clone, Debug)]
pub(super) struct RuleRandom(u64);

impl RuleRandom {
    pub(super) fn new(seed: u64) -> RuleRandom {
        RuleRandom(seed)
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number below a limit that is not zero.
    pub(super) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    /// A number of either sign whose binary exponent is uniform in a range:
    /// log-uniform by octaves, made of bits so that no library function
    /// decides its last place.
    pub(super) fn log_uniform(&mut self, lowest: i32, highest: i32) -> f64 {
        let octaves = (highest - lowest + 1) as u64;
        let exponent = lowest + (self.next() % octaves) as i32;
        let random = self.next();
        let biased = (exponent + 1023).clamp(1, 2046) as u64;
        f64::from_bits(random & (1 << 63) | biased << 52 | random >> 12)
    }
}
