//! Numbers with their derivatives along a direction of a state, for laws of
//! force: one formula gives the force and, for small motions, its derivative.
//!
//! [`robovec_num::dual`] has the same for programs, whose operations are few;
//! laws also need arctangents and lengths.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number and its derivative.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(super) struct Varied {
    pub(super) value: f64,
    pub(super) slope: f64,
}

/// A vector along the axes of the base.
pub(super) type VariedVector = [Varied; 3];

impl Varied {
    /// A number that does not change.
    pub(super) fn fixed(value: f64) -> Varied {
        Varied { value, slope: 0.0 }
    }

    pub(super) fn sqrt(self) -> Varied {
        let value = self.value.sqrt();
        let slope = self.slope / (2.0 * value);
        Varied { value, slope }
    }

    pub(super) fn sin(self) -> Varied {
        Varied {
            value: self.value.sin(),
            slope: self.value.cos() * self.slope,
        }
    }

    pub(super) fn atan(self) -> Varied {
        Varied {
            value: self.value.atan(),
            slope: self.slope / (1.0 + self.value * self.value),
        }
    }

    /// Length of a vector with two components, one of which is not zero.
    pub(super) fn hypot(self, other: Varied) -> Varied {
        let value = self.value.hypot(other.value);
        let slope = self.value / value * self.slope + other.value / value * other.slope;
        Varied { value, slope }
    }
}

impl Neg for Varied {
    type Output = Varied;

    fn neg(self) -> Varied {
        Varied {
            value: -self.value,
            slope: -self.slope,
        }
    }
}

impl Add for Varied {
    type Output = Varied;

    fn add(self, other: Varied) -> Varied {
        Varied {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }
}

impl Sub for Varied {
    type Output = Varied;

    fn sub(self, other: Varied) -> Varied {
        self + -other
    }
}

impl Mul for Varied {
    type Output = Varied;

    fn mul(self, other: Varied) -> Varied {
        Varied {
            value: self.value * other.value,
            slope: self.slope * other.value + self.value * other.slope,
        }
    }
}

impl Mul<f64> for Varied {
    type Output = Varied;

    fn mul(self, factor: f64) -> Varied {
        Varied {
            value: self.value * factor,
            slope: self.slope * factor,
        }
    }
}

impl Div for Varied {
    type Output = Varied;

    fn div(self, other: Varied) -> Varied {
        let value = self.value / other.value;
        Varied {
            value,
            slope: (self.slope - value * other.slope) / other.value,
        }
    }
}

/// The product of two vectors that is a number.
pub(super) fn inner(a: VariedVector, b: VariedVector) -> Varied {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The product of two vectors that is a vector.
pub(super) fn outer(a: VariedVector, b: VariedVector) -> VariedVector {
    from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        a[next] * b[last] - a[last] * b[next]
    })
}

/// Motion of the point of an external force, along the axes of the base.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointMotion<N = f64> {
    /// Position of the point.
    pub place: [N; 3],
    /// Velocity of the point.
    pub velocity: [N; 3],
    /// Angular velocity of its body.
    pub spin: [N; 3],
    /// Axes of its body.
    pub axes: [[N; 3]; 3],
}

impl PointMotion {
    pub(super) fn along(&self, slope: &PointMotion) -> PointMotion<Varied> {
        let varied = |values: &[f64; 3], slopes: &[f64; 3]| {
            from_fn(|k| Varied {
                value: values[k],
                slope: slopes[k],
            })
        };
        PointMotion {
            place: varied(&self.place, &slope.place),
            velocity: varied(&self.velocity, &slope.velocity),
            spin: varied(&self.spin, &slope.spin),
            axes: from_fn(|axis| varied(&self.axes[axis], &slope.axes[axis])),
        }
    }

    pub(super) fn fixed(&self) -> PointMotion<Varied> {
        let fixed = |vector: [f64; 3]| vector.map(Varied::fixed);
        PointMotion {
            place: fixed(self.place),
            velocity: fixed(self.velocity),
            spin: fixed(self.spin),
            axes: self.axes.map(fixed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_differences() {
        type Formula = fn(Varied, Varied) -> Varied;
        let formulas: [Formula; 8] = [
            |a, b| a + b,
            |a, b| a - b,
            |a, b| a * b,
            |a, b| a / b,
            |a, b| (a * a + b * b).sqrt(),
            |a, b| a.sin() * 3.0 - b,
            |a, b| (a * b).atan(),
            Varied::hypot,
        ];
        let ([a, b], along, step) = ([0.7, -1.3], [0.4, 0.9], 1e-5);
        for (number, formula) in formulas.into_iter().enumerate() {
            let with = |value, slope| Varied { value, slope };
            let found = formula(with(a, along[0]), with(b, along[1]));
            let at = |t: f64| {
                let numbers = [a + t * along[0], b + t * along[1]].map(Varied::fixed);
                formula(numbers[0], numbers[1])
            };
            let difference = (at(step).value - at(-step).value) / (2.0 * step);
            assert!((found.slope - difference).abs() < 1e-8, "{number}");
            assert_eq!(at(0.0).slope, 0.0);
        }
    }
}
