//! Operands of any format, rounded once into another.

use super::operands::{any, near, special};
use super::reference::{quad_of, rounded};
use crate::NumberFormat;
use crate::arithmetic::Arithmetic;
use crate::format::Format;
use crate::random::Random;
use crate::soft_float::FormatArithmetic;
use rustc_apfloat::ieee::Quad;
use rustc_apfloat::{Float, Round, StatusAnd};

const TRUNCATE: Round = Round::TowardZero;

fn compare<const E: usize, const M: usize>(numbers: [f64; 3]) {
    let arithmetic = FormatArithmetic::mixed(Format::Float(NumberFormat {
        exponent: E as u32,
        mantissa: M as u32,
        subnormals: true,
    }));
    let [a, b, c] = numbers;
    let [x, y, z] = numbers.map(quad_of);
    let results: [(&str, f64, StatusAnd<Quad>); 7] = [
        ("add", arithmetic.add(a, b), x.add_r(y, TRUNCATE)),
        ("sub", arithmetic.sub(a, c), x.sub_r(z, TRUNCATE)),
        ("mul", arithmetic.mul(a, b), x.mul_r(y, TRUNCATE)),
        ("div", arithmetic.div(a, b), x.div_r(y, TRUNCATE)),
        ("fma", arithmetic.fma(a, b, c), x.mul_add_r(y, z, TRUNCATE)),
        ("fms", arithmetic.fms(a, b, c), x.mul_add_r(y, -z, TRUNCATE)),
        (
            "fnma",
            arithmetic.fnma(a, b, c),
            (-x).mul_add_r(y, z, TRUNCATE),
        ),
    ];
    for (name, got, expected) in results {
        let expected = if expected.value.is_zero() {
            // The sign of a difference that is zero depends on the rounding.
            0
        } else {
            rounded::<E, M>(expected)
        };
        let word = if got == 0.0 && expected == 0 {
            0
        } else {
            arithmetic.word(got)
        };
        if !got.is_nan() || arithmetic.from_word(expected).is_finite() {
            let format = arithmetic.format();
            assert_eq!(word, expected, "{name} of {numbers:?} in {format}: {got:e}");
        }
    }
    if a > 0.0 && a.is_finite() {
        // Rounded to binary64 first it is right, unless that is a tie.
        let root = arithmetic.convert(a.sqrt());
        let neighbours = [a.sqrt().next_down(), a.sqrt().next_up()];
        let got = arithmetic.sqrt(a);
        let either = neighbours.map(|near| arithmetic.convert(near));
        assert!(
            got == root || either.contains(&got),
            "root of {a:e}: {got:e}"
        );
    }
}

fn every_format(numbers: [f64; 3]) {
    compare::<5, 10>(numbers);
    compare::<8, 23>(numbers);
    compare::<8, 17>(numbers);
    compare::<11, 51>(numbers);
    compare::<11, 52>(numbers);
    compare::<9, 30>(numbers);
}

#[test]
fn operands_may_be_of_other_formats() {
    let format = NumberFormat::BINARY64;
    for &a in &special(format, false) {
        for &b in &special(format, true) {
            every_format([a, b, a ^ b].map(f64::from_bits));
        }
    }
    let mut random = Random::new(5);
    for _ in 0..10_000 {
        // Of the range of the narrower formats as often as of the whole.
        let mut a = any(&mut random, format);
        if random.below(2) == 0 {
            a = near(&mut random, format, 1f64.to_bits());
        }
        let b = near(&mut random, format, a);
        let c = near(
            &mut random,
            format,
            (f64::from_bits(a) * f64::from_bits(b)).to_bits(),
        );
        every_format([a, b, c].map(f64::from_bits));
    }
}

#[test]
fn flushing_judges_products_before_rounding() {
    let format: Format = "float(8,17,flush)".parse().expect("a format");
    let arithmetic = FormatArithmetic::mixed(format);
    let least = f64::from(f32::MIN_POSITIVE);
    // 2^-126 (1 - 2^-30) would round up to the least normal number.
    let below = 1.0 - 2f64.powi(-30);
    assert_eq!(arithmetic.mul(least, below), 0.0);
    assert_eq!(arithmetic.mul(least, 1.0), least);
    assert_eq!(arithmetic.convert(least * below), least);
    assert_eq!(
        arithmetic.convert(-least * 0.75).to_bits(),
        (-0.0f64).to_bits()
    );
    assert_eq!(arithmetic.div(least, 2.0), 0.0);
}

#[test]
fn flushing_judges_quotients_before_rounding() {
    let format: Format = "float(11,52,flush)".parse().expect("a format");
    let arithmetic = FormatArithmetic::new(format);
    // Half a unit below the least normal number, to which it would round.
    let below = 1.0 - f64::EPSILON / 2.0;
    let quotient = arithmetic.div(-below, 2f64.powi(1022));
    assert_eq!(quotient.to_bits(), (-0.0f64).to_bits());
    let fused = arithmetic.fma(below, f64::MIN_POSITIVE, 0.0);
    assert_eq!(fused.to_bits(), 0.0f64.to_bits());
}
