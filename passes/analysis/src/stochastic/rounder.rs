//! Rounding to a format, up or down by chance.

use super::{LANES, Unsupported};
use robovec_ir::Format;

/// The maximum number of bits of mantissa, or of a fixed-point number, that can
/// be sampled: binary64 has to hold a result with some bits to spare, whose
/// random choice decides.
pub const MAX_BITS: u32 = 40;

/// Rounds numbers of binary64 to a format: to one of the two neighbours, each
/// the likelier the nearer it is, so that the mean is the number itself.
pub(super) struct Rounder {
    kind: RounderKind,
    /// The addend of a number before cutting comes from 32 random bits, moved
    /// left or right to below the last place.
    left: u32,
    right: u32,
    /// Bits of binary64 below the last place of the format.
    cut: u64,
    /// Numbers from the first size on and below the second round by bits.
    normal: [f64; 2],
}

#[derive(Clone, Copy)]
enum RounderKind {
    /// The distance of numbers near zero, the largest finite number, and the
    /// size below which results are zero.
    Float { step: f64, largest: f64, flush: f64 },
    /// The step, and the ends of the range in steps.
    Fixed { step: f64, low: f64, high: f64 },
}

impl Rounder {
    pub(super) fn new(format: Format) -> Result<Rounder, Unsupported> {
        let bits = match format {
            Format::Float(float) => float.mantissa,
            Format::Fixed(fixed) => fixed.integer + fixed.fraction,
        };
        if bits > MAX_BITS {
            return Err(Unsupported { format });
        }
        let power = |exponent: i32| 2f64.powi(exponent);
        let (kind, normal) = match format {
            Format::Float(float) => {
                let (smallest, largest) = (float.smallest_exponent(), float.largest_exponent());
                let mantissa = float.mantissa as i32;
                let kind = RounderKind::Float {
                    // Below the least number of binary64 there is nothing.
                    step: power((smallest - mantissa).max(-1074)),
                    largest: (2.0 - power(-mantissa)) * power(largest),
                    flush: if float.subnormals {
                        0.0
                    } else {
                        power(smallest)
                    },
                };
                // In the last octave rounding can overflow.
                (kind, [power(smallest), power(largest)])
            }
            Format::Fixed(fixed) => {
                let end = power((fixed.integer + fixed.fraction) as i32);
                let kind = RounderKind::Fixed {
                    step: power(-(fixed.fraction as i32)),
                    low: -end,
                    high: end - 1.0,
                };
                (kind, [f64::INFINITY, 0.0])
            }
        };
        let below = 52 - bits;
        Ok(Rounder {
            kind,
            left: below.saturating_sub(32),
            right: 32u32.saturating_sub(below),
            cut: !((1u64 << below) - 1),
            normal,
        })
    }

    /// Rounds all lanes, each with 32 other random bits.
    #[inline]
    pub(super) fn round(&self, exact: [f64; LANES], random: [u32; LANES]) -> [f64; LANES] {
        let [low, high] = self.normal;
        let usual = exact.iter().fold(true, |usual, number| {
            let size = number.abs();
            usual & ((size >= low) & (size < high) | (size == 0.0))
        });
        if !usual {
            return self.round_rare(exact, random);
        }
        let mut rounded = exact;
        for (number, random) in rounded.iter_mut().zip(random) {
            // The bits of a size grow with it: adding below the last place
            // and cutting there rounds the size up with the right chance.
            let random = u64::from(random) << self.left >> self.right;
            *number = f64::from_bits((number.to_bits() + random) & self.cut);
        }
        rounded
    }

    #[cold]
    fn round_rare(&self, exact: [f64; LANES], random: [u32; LANES]) -> [f64; LANES] {
        let mut rounded = exact;
        for (number, random) in rounded.iter_mut().zip(random) {
            *number = self.round_one(*number, random);
        }
        rounded
    }

    fn round_one(&self, number: f64, random: u32) -> f64 {
        if !number.is_finite() {
            return match self.kind {
                RounderKind::Fixed { step, low, high } => (number / step).clamp(low, high) * step,
                RounderKind::Float { .. } => number,
            };
        }
        let chance = f64::from(random) / 4_294_967_296.0;
        match self.kind {
            RounderKind::Float { flush, .. } if number.abs() < flush => 0.0,
            RounderKind::Float { step, largest, .. } => {
                let rounded = if number.abs() < self.normal[0] {
                    steps(number / step, chance) * step
                } else {
                    let random = u64::from(random) << self.left >> self.right;
                    f64::from_bits((number.to_bits() + random) & self.cut)
                };
                if rounded.abs() > largest {
                    f64::INFINITY.copysign(rounded)
                } else {
                    rounded
                }
            }
            RounderKind::Fixed { step, low, high } => {
                steps(number / step, chance).clamp(low, high) * step
            }
        }
    }
}

/// One of the two whole numbers around a number.
fn steps(number: f64, chance: f64) -> f64 {
    let below = number.floor();
    if number - below > chance {
        below + 1.0
    } else {
        below
    }
}
