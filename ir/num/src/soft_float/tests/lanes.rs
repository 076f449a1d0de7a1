//! Lanes against single numbers.

use super::operands::special;
use crate::arithmetic::Arithmetic;
use crate::format::Format;
use crate::random::Random;
use crate::soft_float::{FormatArithmetic, FormatLanes};
use std::array;

type One = fn(&FormatArithmetic, [f64; 3]) -> f64;
type All = fn(&FormatLanes<4>, [[f64; 4]; 3]) -> [f64; 4];

/// Operations on single numbers and on lanes.
const OPERATIONS: [(&str, One, All); 10] = [
    ("neg", |x, [a, ..]| x.neg(a), |x, [a, ..]| x.neg(a)),
    (
        "add",
        |x, [a, b, _]| x.add(a, b),
        |x, [a, b, _]| x.add(a, b),
    ),
    (
        "sub",
        |x, [a, b, _]| x.sub(a, b),
        |x, [a, b, _]| x.sub(a, b),
    ),
    (
        "mul",
        |x, [a, b, _]| x.mul(a, b),
        |x, [a, b, _]| x.mul(a, b),
    ),
    (
        "div",
        |x, [a, b, _]| x.div(a, b),
        |x, [a, b, _]| x.div(a, b),
    ),
    ("sqrt", |x, [a, ..]| x.sqrt(a), |x, [a, ..]| x.sqrt(a)),
    ("sin", |x, [a, ..]| x.sin(a), |x, [a, ..]| x.sin(a)),
    (
        "fma",
        |x, [a, b, c]| x.fma(a, b, c),
        |x, [a, b, c]| x.fma(a, b, c),
    ),
    (
        "fms",
        |x, [a, b, c]| x.fms(a, b, c),
        |x, [a, b, c]| x.fms(a, b, c),
    ),
    (
        "fnma",
        |x, [a, b, c]| x.fnma(a, b, c),
        |x, [a, b, c]| x.fnma(a, b, c),
    ),
];

/// Numbers of a format: special ones and random ones of all sizes.
fn numbers(arithmetic: &FormatArithmetic, random: &mut Random) -> Vec<f64> {
    let mut numbers: Vec<f64> = match arithmetic.format() {
        Format::Float(format) => {
            let words = special(format, false).into_iter();
            words.map(|word| arithmetic.from_word(word)).collect()
        }
        Format::Fixed(_) => vec![0.0, 1e300, -1e300],
    };
    for _ in 0..200 {
        let size = 2f64.powi(random.below(24) as i32 - 12);
        numbers.push(arithmetic.convert(size * random.signed()));
    }
    numbers
}

#[test]
fn lanes_give_the_bits_of_single_numbers() {
    let mut random = Random::new(1);
    let formats = [
        "f16",
        "bf16",
        "f32",
        "f64",
        "float(8,17)",
        "float(9,24)",
        "float(9,25)",
        "float(10,40)",
        "float(11,50)",
        "float(11,51)",
        "fixed(3,4)",
        "fixed(12,12)",
        "fixed(12,19)",
        "fixed(9,44)",
    ];
    let formats = formats.map(|name| name.parse().expect("a format"));
    let flushed = formats.into_iter().filter_map(|format| match format {
        Format::Float(mut float) => {
            float.subnormals = false;
            Some(Format::Float(float))
        }
        Format::Fixed(_) => None,
    });
    for format in formats.into_iter().chain(flushed) {
        let single = FormatArithmetic::new(format);
        let numbers = numbers(&single, &mut random);
        for _ in 0..2000 {
            let mut draw =
                || -> [f64; 4] { array::from_fn(|_| numbers[random.below(numbers.len())]) };
            let operands = [draw(), draw(), draw()];
            for (name, one, all) in OPERATIONS {
                let found = all(&FormatLanes(single), operands);
                for (lane, found) in found.into_iter().enumerate() {
                    let operands = operands.map(|lanes| lanes[lane]);
                    let expected = one(&single, operands);
                    assert!(
                        found.to_bits() == expected.to_bits()
                            || found.is_nan() && expected.is_nan(),
                        "{name} of {operands:?} in {format}: {found:e}, not {expected:e}"
                    );
                }
            }
        }
    }
}
