//! Fixed point against integers.

use crate::arithmetic::Arithmetic;
use crate::format::{FixedFormat, Format};
use crate::random::Random;
use crate::soft_float::FormatArithmetic;

/// `dividend / divisor` to the nearest integer, ties to even; `divisor > 0`.
fn nearest(dividend: i128, divisor: i128) -> i128 {
    let (quotient, rest) = (dividend.div_euclid(divisor), dividend.rem_euclid(divisor));
    match (2 * rest).cmp(&divisor) {
        std::cmp::Ordering::Less => quotient,
        std::cmp::Ordering::Greater => quotient + 1,
        std::cmp::Ordering::Equal => quotient + (quotient & 1),
    }
}

/// A number as a multiple of the unit.
struct Fixed {
    arithmetic: FormatArithmetic,
    fraction: u32,
    limit: i128,
}

impl Fixed {
    fn new(integer: u32, fraction: u32) -> Fixed {
        let format = Format::Fixed(FixedFormat { integer, fraction });
        Fixed {
            arithmetic: FormatArithmetic::new(format),
            fraction,
            limit: 1 << (integer + fraction),
        }
    }

    fn number(&self, multiple: i128) -> f64 {
        multiple as f64 / 2f64.powi(self.fraction as i32)
    }

    fn saturated(&self, multiple: i128) -> f64 {
        self.number(multiple.clamp(-self.limit, self.limit - 1))
    }

    fn compare(&self, [a, b, c]: [i128; 3]) {
        let one = 1i128 << self.fraction;
        let arithmetic = &self.arithmetic;
        let [x, y, z] = [a, b, c].map(|multiple| self.number(multiple));
        let check = |name: &str, got: f64, expected: i128| {
            let expected = self.saturated(expected);
            let format = arithmetic.format();
            assert_eq!(
                got.to_bits(),
                expected.to_bits(),
                "{name} of {x}, {y}, {z} in {format}: {got}, not {expected}"
            );
            assert_eq!(arithmetic.from_word(arithmetic.word(got)), got);
        };
        check("add", arithmetic.add(x, y), a + b);
        check("sub", arithmetic.sub(x, y), a - b);
        check("neg", arithmetic.neg(x), -a);
        check("mul", arithmetic.mul(x, y), nearest(a * b, one));
        check(
            "fma",
            arithmetic.fma(x, y, z),
            nearest(a * b + c * one, one),
        );
        check(
            "fms",
            arithmetic.fms(x, y, z),
            nearest(a * b - c * one, one),
        );
        check(
            "fnma",
            arithmetic.fnma(x, y, z),
            nearest(c * one - a * b, one),
        );
        let quotient = match (a.signum(), b.signum()) {
            (0, _) => 0,
            (1, 0) => self.limit,
            (-1, 0) => -self.limit,
            _ => nearest(a * one * b.signum(), b.abs()),
        };
        check("div", arithmetic.div(x, y), quotient);
        let radicand = (a.max(0) * one) as u128;
        let root = radicand.isqrt();
        // A root is no tie: twice the tie squared would be odd.
        let up = u128::from(radicand - root * root > root);
        check("sqrt", arithmetic.sqrt(x), (root + up) as i128);
    }

    fn operand(&self, random: &mut Random) -> i128 {
        let word = i128::from(random.bits() as i64);
        let width = 128 - (self.limit as u128).leading_zeros();
        let bits = (word >> (64 - width)).clamp(-self.limit, self.limit - 1);
        match random.below(4) {
            0 => bits >> random.below(width as usize),
            1 => bits >> (width / 2),
            _ => bits,
        }
    }

    fn all(&self, count: usize) {
        let half = (1i128 << self.fraction) / 2;
        let special = [
            0,
            1,
            2,
            half,
            half + 1,
            2 * half,
            2 * half + 1,
            3 * half,
            self.limit - 1,
        ];
        let special: Vec<i128> = special
            .iter()
            .flat_map(|&multiple| [multiple, -multiple, -multiple - 1])
            .map(|multiple| multiple.clamp(-self.limit, self.limit - 1))
            .collect();
        for &a in &special {
            for &b in &special {
                for &c in &special {
                    self.compare([a, b, c]);
                }
            }
        }
        let mut random = Random::new(u64::from(self.fraction));
        for _ in 0..count {
            self.compare([0; 3].map(|_: i128| self.operand(&mut random)));
        }
    }
}

#[test]
fn operations_are_those_of_integers() {
    for (integer, fraction) in [
        (12, 19),
        (0, 15),
        (7, 0),
        (31, 22),
        (0, 53),
        (20, 30),
        (25, 26),
    ] {
        Fixed::new(integer, fraction).all(20_000);
    }
}

#[test]
fn what_is_no_number_has_one_all_the_same() {
    let fixed = Fixed::new(3, 4).arithmetic;
    assert_eq!(fixed.convert(f64::NAN), 0.0);
    assert_eq!(fixed.convert(f64::INFINITY), 7.9375);
    assert_eq!(fixed.convert(f64::NEG_INFINITY), -8.0);
    assert_eq!(fixed.convert(1e300), 7.9375);
    assert_eq!(fixed.convert(-1e-300).to_bits(), 0);
    assert_eq!(fixed.convert(0.03125), 0.0, "a tie to even");
    assert_eq!(fixed.convert(0.09375), 0.125, "a tie to even");
    assert_eq!(fixed.div(0.0, 0.0), 0.0);
    assert_eq!(fixed.div(-1.0, 0.0), -8.0);
    assert_eq!(fixed.sqrt(-1.0), 0.0);
    assert_eq!(fixed.neg(-8.0), 7.9375);
    assert_eq!(fixed.word(-0.0625), 0xFF);
    assert_eq!(fixed.sin(1.0), 0.8125);
}
