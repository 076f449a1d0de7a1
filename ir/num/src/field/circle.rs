//! The field with angles that add up.
//!
//! In [`PrimeField`](super::PrimeField) the sine of a sum of angles is
//! unrelated to the sines of the angles. Here they are related: beside its
//! value modulo `p`, every number has a residue as an angle, a number modulo
//! the prime order `r` of a subgroup of the circle over the field. Sums,
//! differences, products and quotients of angles are taken modulo `r`, and the
//! sine and cosine of an angle `a` are the coordinates of the point `a·G` for a
//! generator `G` of the subgroup. So `sin(a + b)`, `cos(2*a)` and `sin(a/3)`
//! follow the addition theorems, for any expression of angles that is rational
//! in the inputs.
//!
//! The result of a sine, a cosine or a root is a new angle, drawn from its
//! value.
//!
//! Two functions that agree here at a random point agree over the reals except
//! for a chance of `degree / r`, as in the plain field: both images are rings,
//! and the points of the subgroup are as good as random points of the circle.

use super::{DrawRole, Field, FieldPoint, Prime, PrimeField, either_undefined};
use crate::arithmetic::Arithmetic;

/// A number and its residue as an angle.
#[derive(Clone, Copy, Debug)]
pub struct Angular {
    /// Modulo `p`; [`PrimeField::UNDEFINED`] as there.
    pub value: u64,
    /// Modulo `r`.
    angle: u64,
}

/// Two numbers are equal when their values are equal.
impl PartialEq for Angular {
    fn eq(&self, other: &Angular) -> bool {
        self.value == other.value
    }
}

impl Eq for Angular {}

/// The prime field on the circle, with sums of angles.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CircleField {
    plain: PrimeField,
    /// Cosine and sine of the angle 1.
    generator: [u64; 2],
}

const UNDEFINED: Angular = Angular {
    value: PrimeField::UNDEFINED,
    angle: 0,
};

impl CircleField {
    /// The field on the point that the plain field draws.
    pub fn new(plain: PrimeField) -> CircleField {
        let plain = PrimeField {
            circle: true,
            ..plain
        };
        // A point of the circle 24 times lies in the subgroup of order r; it
        // generates it unless it is the neutral point.
        let field = &plain.prime.field;
        let neutral = [field.one(), 0];
        let generator = (0..)
            .map(|trial| {
                let (cosine, sine) = plain.circle_point(plain.draw(trial, DrawRole::Generator));
                field.turned([cosine, sine], 24)
            })
            .find(|&point| point != neutral)
            .expect("nearly every point of the circle leads to a generator");
        CircleField { plain, generator }
    }

    /// Cosine and sine of an angle.
    fn point_at(&self, angle: u64) -> [u64; 2] {
        let Prime { field, order, .. } = &self.plain.prime;
        field.turned(self.generator, order.plain(angle))
    }

    /// A value that is a new angle, odd in the value.
    fn fresh(&self, value: u64) -> Angular {
        if PrimeField::is_undefined(value) {
            return UNDEFINED;
        }
        let order = &self.plain.prime.order;
        let (size, negative) = self.plain.without_sign(value);
        let angle = match size {
            0 => 0,
            size => order.spread(self.plain.bits(size, DrawRole::Angle)),
        };
        Angular {
            value,
            angle: if negative { order.neg(angle) } else { angle },
        }
    }
}

impl Arithmetic for CircleField {
    type Number = Angular;

    fn literal(&self, number: f64) -> Angular {
        if !number.is_finite() {
            return UNDEFINED;
        }
        Angular {
            value: self.plain.prime.field.literal(number),
            angle: self.plain.prime.order.literal(number),
        }
    }

    #[inline]
    fn neg(&self, a: Angular) -> Angular {
        Angular {
            value: self.plain.neg(a.value),
            angle: self.plain.prime.order.neg(a.angle),
        }
    }

    #[inline]
    fn add(&self, a: Angular, b: Angular) -> Angular {
        Angular {
            value: self.plain.add(a.value, b.value),
            angle: self.plain.prime.order.add(a.angle, b.angle),
        }
    }

    #[inline]
    fn sub(&self, a: Angular, b: Angular) -> Angular {
        Angular {
            value: self.plain.sub(a.value, b.value),
            angle: self.plain.prime.order.sub(a.angle, b.angle),
        }
    }

    #[inline]
    fn mul(&self, a: Angular, b: Angular) -> Angular {
        Angular {
            value: self.plain.mul(a.value, b.value),
            angle: self.plain.prime.order.mul(a.angle, b.angle),
        }
    }

    fn div(&self, a: Angular, b: Angular) -> Angular {
        if either_undefined(a.value, b.value) || b.value == 0 || b.angle == 0 {
            return UNDEFINED;
        }
        let order = &self.plain.prime.order;
        Angular {
            value: self.plain.div(a.value, b.value),
            angle: order.mul(a.angle, order.invert(b.angle)),
        }
    }

    fn sin(&self, a: Angular) -> Angular {
        if PrimeField::is_undefined(a.value) {
            return UNDEFINED;
        }
        self.fresh(self.point_at(a.angle)[1])
    }

    fn cos(&self, a: Angular) -> Angular {
        if PrimeField::is_undefined(a.value) {
            return UNDEFINED;
        }
        self.fresh(self.point_at(a.angle)[0])
    }

    fn sqrt(&self, a: Angular) -> Angular {
        self.fresh(self.plain.sqrt(a.value))
    }

    #[inline]
    fn fma(&self, a: Angular, b: Angular, c: Angular) -> Angular {
        self.add(self.mul(a, b), c)
    }
}

impl Field for CircleField {
    fn at(prime: Prime, point: FieldPoint) -> CircleField {
        CircleField::new(PrimeField::at(prime, point))
    }

    fn prime(&self) -> Prime {
        self.plain.prime
    }

    fn input(&self, index: u64) -> Angular {
        let angle = self.plain.bits(index, DrawRole::Turn);
        Angular {
            value: self.plain.input(index),
            angle: self.plain.prime.order.spread(angle),
        }
    }

    fn value(number: Angular) -> u64 {
        number.value
    }

    fn residue(&self, value: u64) -> Option<u64> {
        self.plain.residue(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Prime;

    fn fields() -> [CircleField; 2] {
        Prime::pair(3).map(|prime| CircleField::at(prime, FieldPoint { seed: 9 }))
    }

    fn samples(field: &CircleField) -> Vec<Angular> {
        let mut samples = field.point(12);
        samples.extend([0.0, 1.0, -0.5, 3.0, 1e-30].map(|number| field.literal(number)));
        samples
    }

    #[test]
    fn sines_and_cosines_of_sums_follow_the_theorems_of_addition() {
        for field in fields() {
            for &a in &samples(&field) {
                for &b in &samples(&field) {
                    let of = |angle| (field.cos(angle), field.sin(angle));
                    let ((ca, sa), (cb, sb)) = (of(a), of(b));
                    let sum = field.add(field.mul(sa, cb), field.mul(ca, sb));
                    assert_eq!(field.sin(field.add(a, b)), sum);
                    let sum = field.add(field.mul(ca, cb), field.mul(sa, sb));
                    assert_eq!(field.cos(field.sub(a, b)), sum);
                }
                let (half, two) = (field.literal(0.5), field.literal(2.0));
                let half = field.mul(half, a);
                let product = field.mul(field.sin(half), field.cos(half));
                assert_eq!(field.mul(two, product), field.sin(a));
                let third = field.div(a, field.literal(3.0));
                let (c, three) = (field.cos(third), field.literal(3.0));
                let cube = field.mul(field.literal(4.0), field.mul(c, field.mul(c, c)));
                assert_eq!(field.sub(cube, field.mul(three, c)), field.cos(a));
            }
        }
    }

    #[test]
    fn sines_and_cosines_have_their_parity_and_norm_and_no_period() {
        for field in fields() {
            assert_eq!(field.sin(field.literal(0.0)), field.literal(0.0));
            assert_eq!(field.cos(field.literal(-0.0)), field.literal(1.0));
            for &a in &samples(&field) {
                let (c, s) = (field.cos(a), field.sin(a));
                let norm = field.add(field.mul(c, c), field.mul(s, s));
                assert_eq!(norm, field.literal(1.0));
                assert_eq!(field.sin(field.neg(a)), field.neg(s));
                assert_eq!(field.cos(field.neg(a)), c);
                let nested = field.sin(field.add(s, a));
                assert_eq!(field.neg(nested), field.sin(field.neg(field.add(a, s))));
                for other in [1.0, 2.0, std::f64::consts::TAU, 2f64.powi(61)] {
                    let other = field.add(a, field.literal(other));
                    assert_ne!(field.sin(other), s);
                }
            }
        }
    }

    #[test]
    fn what_is_undefined_stays_undefined() {
        for field in fields() {
            let zero = field.literal(0.0);
            let one = field.literal(1.0);
            let undefined = field.div(one, zero);
            for number in [
                undefined,
                field.add(undefined, one),
                field.mul(undefined, zero),
                field.div(zero, undefined),
                field.sin(undefined),
                field.cos(undefined),
                field.sqrt(undefined),
                field.literal(f64::NAN),
            ] {
                assert!(CircleField::is_undefined(number));
            }
        }
    }
}
