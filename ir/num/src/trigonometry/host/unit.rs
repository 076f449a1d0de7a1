//! Units, in a host or in hardware, that compute sine and cosine.

use super::cordic::Cordic;
use super::kernel::{HostKernel, fixed, half_unit, product};
use super::reduction::{self, FRACTION, reduce};
use super::{Implementation, ImplementationError, WithTrigonometry};
use crate::arithmetic::Arithmetic;
use crate::double_double::{Double, DoubleDouble};
use std::f64::consts::FRAC_PI_4;

/// An implementation with its constants.
#[derive(Clone, PartialEq, Debug)]
pub struct TrigonometricUnit {
    implementation: Implementation,
    core: TrigonometricCore,
}

#[derive(Clone, PartialEq, Debug)]
enum TrigonometricCore {
    Polynomial(HostKernel),
    /// Sine and cosine at the midpoint of every part of the octant.
    Table(Vec<[i64; 2]>, HostKernel),
    Cordic(Cordic),
}

/// The resources and cycles of an implementation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TrigonometricCost {
    /// Cycles from the angle to sine and cosine, when a multiplication takes
    /// 3 and an addition, a shift or a look-up 1; with the reduction's two
    /// multiplications.
    pub latency: u32,
    /// Bits of tables and constants, without those of the reduction.
    pub table_bits: u64,
}

/// Cycles of an integer multiplication in the estimate of [`TrigonometricCost`].
const MULTIPLICATION: u32 = 3;

impl TrigonometricUnit {
    /// Computes the constants.
    ///
    /// # Errors
    ///
    /// [`ImplementationError::Number`] for numbers out of their ranges.
    pub fn new(implementation: Implementation) -> Result<TrigonometricUnit, ImplementationError> {
        let core = match implementation.checked()? {
            Implementation::Polynomial { order, bits } => {
                TrigonometricCore::Polynomial(HostKernel::new(order, reach(FRAC_PI_4, bits), bits))
            }
            Implementation::Table {
                entries,
                degree,
                bits,
            } => {
                let half = FRAC_PI_4 / f64::from(2 * entries);
                let kernel = HostKernel::new(degree, reach(half, bits), bits);
                TrigonometricCore::Table(middles(entries, bits), kernel)
            }
            Implementation::Cordic { iterations, bits } => {
                TrigonometricCore::Cordic(Cordic::new(iterations, bits))
            }
        };
        Ok(TrigonometricUnit {
            implementation,
            core,
        })
    }

    /// The unit with this name.
    ///
    /// # Errors
    ///
    /// Fails when the name is that of no implementation.
    pub fn named(name: &str) -> Result<TrigonometricUnit, ImplementationError> {
        name.parse().and_then(TrigonometricUnit::new)
    }

    /// Sine and cosine of an angle in radians: multiples of `2^-bits`, the
    /// same bits on every platform. NaN for angles from
    /// [`reduction::LARGEST`] on.
    pub fn sine_and_cosine(&self, angle: f64) -> [f64; 2] {
        let Some(reduced) = reduce(angle) else {
            return [f64::NAN; 2];
        };
        let bits = self.implementation.bits();
        // At most 2^62.
        let fraction = reduced.fraction as i64;
        let found = match &self.core {
            TrigonometricCore::Polynomial(kernel) => kernel.at(reduction::radians(fraction, bits)),
            TrigonometricCore::Cordic(cordic) => cordic.at(reduction::radians(fraction, bits)),
            TrigonometricCore::Table(middles, kernel) => {
                let width = FRACTION - middles.len().trailing_zeros();
                let place = ((fraction >> width) as usize).min(middles.len() - 1);
                let middle = ((place as i64) << width) + (1 << (width - 1));
                let rest = reduction::radians(fraction - middle, bits);
                turned(middles[place], kernel.at(rest), bits)
            }
        };
        let scale = 2f64.powi(-(bits as i32));
        reduced.restore(found).map(|number| number as f64 * scale)
    }

    /// An arithmetic with the sines and cosines of this unit.
    pub fn within<A>(&self, arithmetic: A) -> WithTrigonometry<'_, A> {
        WithTrigonometry {
            arithmetic,
            unit: self,
        }
    }

    /// Upper bound of the error of every sine and cosine.
    pub fn proved_error(&self) -> f64 {
        let bits = self.implementation.bits();
        let half = half_unit(bits);
        let found = match &self.core {
            TrigonometricCore::Polynomial(kernel) => {
                let [sine, cosine] = kernel.errors();
                sine.max(cosine)
            }
            TrigonometricCore::Cordic(cordic) => cordic.error(),
            TrigonometricCore::Table(_, kernel) => {
                // s cos h + c sin h: the errors of cos h and sin h lie along
                // directions of which s and c are the cosines; those of the
                // entries count fully, and both products are rounded.
                let [sine, cosine] = kernel.errors();
                (sine + cosine) * (1.0 + half) + 2.0 * half * (1.0 + 1e-9) + 2.0 * half
            }
        };
        // No slope is steeper than 1; and a margin for this sum itself.
        (found + reduction::error(bits)) * (1.0 + 1e-12)
    }

    /// The estimated cost.
    pub fn cost(&self) -> TrigonometricCost {
        let bits = u64::from(self.implementation.bits());
        let reduction = 2 * MULTIPLICATION + 1;
        match &self.core {
            TrigonometricCore::Polynomial(kernel) => TrigonometricCost {
                latency: reduction + kernel.depth() * (MULTIPLICATION + 1),
                table_bits: 0,
            },
            TrigonometricCore::Table(middles, kernel) => TrigonometricCost {
                latency: reduction + 1 + (kernel.depth() + 1) * (MULTIPLICATION + 1),
                table_bits: middles.len() as u64 * 2 * bits,
            },
            TrigonometricCore::Cordic(_) => {
                let Implementation::Cordic { iterations, .. } = self.implementation else {
                    unreachable!("the core is that of the implementation")
                };
                TrigonometricCost {
                    latency: reduction + iterations,
                    table_bits: u64::from(iterations + 1) * bits,
                }
            }
        }
    }
}

/// A range, widened by the largest rounding error of an angle.
fn reach(range: f64, bits: u32) -> f64 {
    range + 2f64.powi(-(bits as i32))
}

/// Sine and cosine in the middle of every part of an octant.
fn middles(entries: u32, bits: u32) -> Vec<[i64; 2]> {
    let octant = Double {
        high: FRAC_PI_4,
        low: 3.061616997868383e-17,
    };
    (0..entries)
        .map(|place| {
            let parts = Double::from(f64::from(2 * entries));
            let angle = octant * Double::from(f64::from(2 * place + 1)) / parts;
            let exact = [DoubleDouble.sin(angle), DoubleDouble.cos(angle)];
            exact.map(|number| fixed(number, bits))
        })
        .collect()
}

/// Sine and cosine of a sum of two angles.
fn turned([s, c]: [i64; 2], [sine, cosine]: [i64; 2], bits: u32) -> [i64; 2] {
    [
        product(s, cosine, bits) + product(c, sine, bits),
        product(c, cosine, bits) - product(s, sine, bits),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{self, mix};

    const NAMES: [&str; 9] = [
        "polynomial(order=3 bits=30)",
        "polynomial(order=7 bits=30)",
        "polynomial(order=11 bits=50)",
        "table(entries=16 degree=2 bits=24)",
        "table(entries=64 degree=3 bits=36)",
        "table(entries=1024 degree=1 bits=20)",
        "cordic(iterations=12 bits=16)",
        "cordic(iterations=24 bits=30)",
        "cordic(iterations=40 bits=48)",
    ];

    fn unit(name: &str) -> TrigonometricUnit {
        TrigonometricUnit::new(name.parse().expect(name)).expect(name)
    }

    #[test]
    fn errors_stay_below_what_is_proved_and_come_near_it() {
        for name in NAMES {
            let unit = unit(name);
            let proved = unit.proved_error();
            let mut worst = 0.0f64;
            for index in 0..3000u64 {
                let random = random::unit(mix(index)) - 0.5;
                let size = [1.6, 8.0, 5e3, 1e9][index as usize % 4];
                let angle = random * size;
                let exact = [
                    DoubleDouble.sin(Double::from(angle)),
                    DoubleDouble.cos(Double::from(angle)),
                ];
                let found = unit.sine_and_cosine(angle);
                for (exact, found) in exact.into_iter().zip(found) {
                    worst = worst.max(exact.distance(found));
                }
            }
            assert!(worst <= proved, "{name}: {worst:e} above {proved:e}");
            assert!(
                proved <= 8.0 * worst,
                "{name}: {worst:e} far below {proved:e}"
            );
        }
    }

    #[test]
    fn known_angles_symmetry_and_costs() {
        for name in NAMES {
            let unit = unit(name);
            let [sine, cosine] = unit.sine_and_cosine(std::f64::consts::FRAC_PI_6);
            let error = unit.proved_error();
            assert!((sine - 0.5).abs() <= error, "{name}");
            assert!((cosine - 0.75f64.sqrt()).abs() <= error, "{name}");
        }
        let unit = unit("cordic(iterations=24 bits=30)");
        assert_eq!(unit.sine_and_cosine(0.7)[0], -unit.sine_and_cosine(-0.7)[0]);
        assert!(unit.sine_and_cosine(1e16)[0].is_nan());
        assert_eq!(unit.cost().latency, 7 + 24);
        assert_eq!(unit.cost().table_bits, 25 * 30);
    }
}
