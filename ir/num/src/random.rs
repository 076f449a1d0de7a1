//! Random numbers that are the same on every machine and in every run:
//! SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
//! generators", OOPSLA 2014).

/// Difference of a number of the sequence to the one before.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A permutation of the 64-bit numbers in which every bit of the argument
/// reaches every bit of the result.
#[inline]
pub fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_add(STEP);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// The bits at a place, counted from 0, of the sequence of the seed 0.
#[inline]
pub fn bits_at(place: u64) -> u64 {
    mix(place.wrapping_mul(STEP))
}

/// A number from 0 to below 1: the upper 53 bits fill a binary64 mantissa.
#[inline]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        let bits = mix(self.0);
        self.0 = self.0.wrapping_add(STEP);
        bits
    }

    /// A number from 0 to below a count that is not zero.
    pub fn below(&mut self, count: usize) -> usize {
        assert!(count > 0, "nothing is below zero");
        (self.bits() % count as u64) as usize
    }

    /// A number from 0 to below 1.
    pub fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// A number from -1 to below 1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A number of either sign whose binary exponent is uniform in a range,
    /// both ends included, within -1022 to 1023: log-uniform by octaves, made
    /// of bits so that no library function decides its last place.
    pub fn log_uniform(&mut self, lowest: i32, highest: i32) -> f64 {
        assert!(lowest <= highest, "exponents are in order");
        assert!(
            -1022 <= lowest && highest <= 1023,
            "a normal number has the exponent"
        );
        let octaves = (highest - lowest + 1) as u64;
        let exponent = lowest + (self.bits() % octaves) as i32;
        let random = self.bits();
        let biased = (exponent + 1023) as u64;
        // The sign is no bit of the mantissa.
        f64::from_bits(random & (1 << 63) | biased << 52 | random & ((1 << 52) - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_that_of_the_paper() {
        // The first numbers of the seed 1234567, as the reference
        // implementation (splitmix64.c, Vigna 2015) gives them.
        let mut random = Random::new(1_234_567);
        let first = [(); 3].map(|()| random.bits());
        let known = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
        ];
        assert_eq!(first, known);
        let mut random = Random::new(0);
        assert!((0..9).all(|place| bits_at(place) == random.bits()));
    }

    #[test]
    fn both_signs_fill_their_octaves() {
        let mut random = Random::new(1);
        let mut quarters = [0; 4];
        for _ in 0..4000 {
            let number = random.log_uniform(3, 3);
            assert!((8.0..16.0).contains(&number.abs()), "{number}");
            let upper = usize::from(number.abs() >= 12.0);
            quarters[2 * usize::from(number < 0.0) + upper] += 1;
        }
        assert!(quarters.iter().all(|&count| count > 900), "{quarters:?}");
    }
}
