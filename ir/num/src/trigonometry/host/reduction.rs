//! Any angle, reduced to an eighth of a turn.
//!
//! The octant of an angle, and the place within it, are the integer part and
//! the fraction of the angle times `4/π`. For an angle of thousands of turns
//! the fraction needs many more digits of `4/π` than a number has; so the
//! product is formed in full (Payne and Hanek 1983), from the 53 bits of the
//! angle and 192 bits of `4/π` after the point. Its fraction is right to 2^-62
//! for every angle below [`LARGEST`]: the wheel of a train that has run for
//! years, or an accumulated yaw, is reduced as exactly as 1 radian.

/// Angles from here on are not reduced: 2^50 rad.
pub const LARGEST: f64 = (1u64 << 50) as f64;

/// `4/π` less 1, 192 bits, the highest first.
const INVERSE: [u64; 3] = [
    0x45F3_06DC_9C88_2A53,
    0xF84E_AFA3_EA69_BB81,
    0xB6C5_2B32_7887_2083,
];

/// Bits of a fraction of an octant.
pub const FRACTION: u32 = 62;

/// `π/4` times 2^64.
const QUARTER_PI: u64 = 0xC90F_DAA2_2168_C235;

/// An angle in its octant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Reduced {
    /// The octant, 0 to 7, of the angle without its sign.
    pub octant: u8,
    /// True if the angle is negative.
    pub negative: bool,
    /// The distance from the nearest axis of the circle, as a fraction of an
    /// octant in units of 2^-62: 0 to 2^62, both included.
    pub fraction: u64,
}

/// Reduces an angle in radians; `None` when it is [`LARGEST`] or beyond, or
/// not a number.
pub fn reduce(angle: f64) -> Option<Reduced> {
    if angle.is_nan() || angle.abs() >= LARGEST {
        return None;
    }
    let bits = angle.to_bits();
    let negative = bits >> 63 == 1;
    let biased = (bits >> 52 & 0x7FF) as i32;
    let stored = bits & ((1 << 52) - 1);
    let (mantissa, exponent) = match biased {
        0 => (stored, -1074),
        _ => (stored | 1 << 52, biased - 1075),
    };
    // mantissa * (1 + INVERSE), in units of 2^-192, the lowest limb first.
    let mut limbs = [0u64; 4];
    let mut carry = 0u128;
    for (limb, &factor) in limbs.iter_mut().zip(INVERSE.iter().rev()) {
        let product = u128::from(mantissa) * u128::from(factor) + carry;
        *limb = product as u64;
        carry = product >> 64;
    }
    limbs[3] = mantissa + carry as u64;
    // The exponent is negative for all angles below 2^52.
    let [.., high, whole] = shifted(limbs, exponent.unsigned_abs());
    let octant = (whole & 7) as u8;
    // Rounded to the bits that are kept.
    let fraction = (high >> 2) + (high >> 1 & 1);
    let fraction = match octant % 2 {
        0 => fraction,
        _ => (1 << FRACTION) - fraction,
    };
    Some(Reduced {
        octant,
        negative,
        fraction,
    })
}

/// A number of four limbs, the lowest first, shifted right.
fn shifted(limbs: [u64; 4], by: u32) -> [u64; 4] {
    let (limb, bit) = ((by / 64) as usize, by % 64);
    let at = |index: usize| limbs.get(index).copied().unwrap_or(0);
    std::array::from_fn(|index| {
        let low = at(index + limb) >> bit;
        match bit {
            0 => low,
            _ => low | at(index + limb + 1) << (64 - bit),
        }
    })
}

/// A signed fraction of an octant in radians, in units of `2^-bits`, rounded
/// to nearest.
pub fn radians(fraction: i64, bits: u32) -> i64 {
    let product = i128::from(fraction) * i128::from(QUARTER_PI);
    let shift = FRACTION + 64 - bits;
    ((product + (1i128 << (shift - 1))) >> shift) as i64
}

/// The largest error of [`radians`] of [`reduce`] as the angle's distance from
/// its axis: the fraction is rounded, `4/π` and `π/4` are cut, and the result
/// is rounded.
pub fn error(bits: u32) -> f64 {
    2f64.powi(-61) + 2f64.powi(-(bits as i32) - 1)
}

impl Reduced {
    /// The sine and cosine of the angle, from those of its distance from the
    /// nearest axis.
    pub fn restore(self, [sine, cosine]: [i64; 2]) -> [i64; 2] {
        let [sine, cosine] = match self.octant {
            0 => [sine, cosine],
            1 => [cosine, sine],
            2 => [cosine, -sine],
            3 => [sine, -cosine],
            4 => [-sine, -cosine],
            5 => [-cosine, -sine],
            6 => [-cosine, sine],
            _ => [-sine, cosine],
        };
        if self.negative {
            [-sine, cosine]
        } else {
            [sine, cosine]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Arithmetic;
    use crate::double_double::{Double, DoubleDouble};
    use crate::random::{mix, unit};

    /// The sine of the angle that a reduction represents.
    fn sine(reduced: Reduced) -> Double {
        let fraction = Double::from(reduced.fraction as f64);
        let rest = Double::from((reduced.fraction as i64 - fraction.high as i64) as f64);
        let quarter = DoubleDouble.literal(2f64.powi(-62));
        let pi = Double {
            high: std::f64::consts::FRAC_PI_4,
            low: 3.061616997868383e-17,
        };
        let angle = (fraction + rest) * quarter * pi;
        let (s, c) = (DoubleDouble.sin(angle), DoubleDouble.cos(angle));
        let unsigned = match reduced.octant {
            0 | 3 => s,
            1 | 2 => c,
            4 | 7 => -s,
            _ => -c,
        };
        if reduced.negative {
            -unsigned
        } else {
            unsigned
        }
    }

    #[test]
    fn angles_of_all_sizes_reduce_to_the_same_sine() {
        for index in 0..4000u64 {
            let random = mix(index);
            let exponent = (random % 90) as i32 - 45;
            let unit = unit(random);
            let angle = (unit + 0.5) * 2f64.powi(exponent);
            let angle = if random & 1 == 0 { angle } else { -angle };
            let reduced = reduce(angle).expect("below the largest");
            let exact = DoubleDouble.sin(Double::from(angle));
            let error = (sine(reduced) - exact).high.abs();
            assert!(error < 2f64.powi(-60), "{angle}: {error:e}");
        }
    }

    #[test]
    fn hard_angles_and_the_ends_are_reduced() {
        // The double nearest to a multiple of π/2 (Kahan) is beyond reach;
        // this one, 11 million turns or so, is off by 1e-10 only.
        for angle in [0.0, -0.0, 5e-324, 1e-300, 71_610_457.0 / 2.0, 1e15] {
            let reduced = reduce(angle).expect("below the largest");
            let exact = DoubleDouble.sin(Double::from(angle));
            assert!(
                (sine(reduced) - exact).high.abs() < 2f64.powi(-60),
                "{angle}"
            );
        }
        for angle in [LARGEST, -LARGEST, f64::NAN, f64::INFINITY] {
            assert_eq!(reduce(angle), None);
        }
        assert_eq!(
            radians(1 << FRACTION, 40),
            (std::f64::consts::FRAC_PI_4 * 2f64.powi(40)).round() as i64
        );
        assert_eq!(radians(-1 << FRACTION, 20), -radians(1 << FRACTION, 20));
    }
}
