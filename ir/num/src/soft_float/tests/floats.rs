//! Every operation of a format, on words of that format.

use super::operands::{any, near, special};
use super::reference::{
    Other, converted, flushed, flushed_result, is_root, is_small, read, widened, written,
};
use crate::NumberFormat;
use crate::arithmetic::Arithmetic;
use crate::format::Format;
use crate::random::Random;
use crate::soft_float::FormatArithmetic;
use rustc_apfloat::{Float, Round};

/// A format with and without subnormal numbers, and its comparison.
struct Pair<const E: usize, const M: usize> {
    kept: FormatArithmetic,
    flushed: FormatArithmetic,
}

impl<const E: usize, const M: usize> Pair<E, M> {
    fn format(subnormals: bool) -> NumberFormat {
        NumberFormat {
            exponent: E as u32,
            mantissa: M as u32,
            subnormals,
        }
    }

    fn new() -> Pair<E, M> {
        Pair {
            kept: FormatArithmetic::new(Format::Float(Self::format(true))),
            flushed: FormatArithmetic::new(Format::Float(Self::format(false))),
        }
    }

    /// Compares an operation's results on words, with and without subnormal
    /// numbers: `ours` is computed, `other` gives the word and, for products,
    /// the number that decides about flushing.
    fn compare<const COUNT: usize>(
        &self,
        name: &str,
        words: [u64; COUNT],
        ours: impl Fn(&FormatArithmetic, [f64; COUNT]) -> f64,
        other: impl Fn([Other<E, M>; COUNT], bool) -> u64,
    ) {
        let check = |arithmetic: &FormatArithmetic, words: [u64; COUNT], flush: bool| {
            let operands = words.map(|word| arithmetic.from_word(word));
            let got = arithmetic.word(ours(arithmetic, operands));
            let got = if operands.iter().any(|a| a.is_nan()) || is_nan::<E, M>(got) {
                written(read::<E, M>(got))
            } else {
                got
            };
            let expected = other(words.map(read::<E, M>), flush);
            let expected = if flush {
                flushed::<E, M>(expected)
            } else {
                expected
            };
            assert_eq!(
                got,
                expected,
                "{name} of {operands:?} in {}: {got:#x}, not {expected:#x}",
                arithmetic.format()
            );
        };
        check(&self.kept, words, false);
        check(&self.flushed, words.map(flushed::<E, M>), true);
    }

    fn two(&self, words: [u64; 2]) {
        self.compare(
            "add",
            words,
            |x, [a, b]| x.add(a, b),
            |[a, b], _| written((a + b).value),
        );
        self.compare(
            "sub",
            words,
            |x, [a, b]| x.sub(a, b),
            |[a, b], _| written((a - b).value),
        );
        self.compare(
            "mul",
            words,
            |x, [a, b]| x.mul(a, b),
            |[a, b], flush| {
                let product = written((a * b).value);
                if !flush {
                    return product;
                }
                flushed_result(a.mul_r(b, Round::TowardZero).value, product)
            },
        );
        self.compare(
            "div",
            words,
            |x, [a, b]| x.div(a, b),
            |[a, b], flush| {
                let quotient = written((a / b).value);
                if !flush {
                    return quotient;
                }
                flushed_result(a.div_r(b, Round::TowardZero).value, quotient)
            },
        );
    }

    fn three(&self, words: [u64; 3]) {
        self.compare(
            "fma",
            words,
            |x, [a, b, c]| x.fma(a, b, c),
            |[a, b, c], flush| {
                let sum = written(a.mul_add(b, c).value);
                let truncated = a.mul_add_r(b, c, Round::TowardZero).value;
                // Zeros are exact, but for their sign.
                if !flush || truncated.is_zero() && is_small::<E, M>(sum) {
                    return sum;
                }
                flushed_result(truncated, sum)
            },
        );
    }

    /// Root, the way of a word into a number and back, and conversion.
    fn one(&self, word: u64, number: f64) {
        let wide = self.kept.from_word(word);
        let expected = widened::<E, M>(word);
        assert!(wide.to_bits() == expected.to_bits() || wide.is_nan() && expected.is_nan());
        if !wide.is_nan() {
            assert_eq!(self.kept.word(wide), word);
        }
        let expected = converted::<E, M>(number);
        let got = self.kept.word(self.kept.convert(number));
        assert!(
            got == expected || is_nan::<E, M>(got) && number.is_nan(),
            "{number:e}"
        );
        if !number.is_nan() {
            let got = self.flushed.word(self.flushed.convert(number));
            assert_eq!(got, flushed::<E, M>(expected), "{number:e}, flushed");
        }
        for arithmetic in [&self.kept, &self.flushed] {
            let square = arithmetic.from_word(word);
            let root = arithmetic.sqrt(square);
            if square > 0.0 && square.is_finite() {
                let (square, root) = (arithmetic.word(square), arithmetic.word(root));
                assert!(is_root::<E, M>(square, root), "root of {wide:e}");
            } else if square < 0.0 || square.is_nan() {
                assert!(root.is_nan());
            } else {
                assert_eq!(root.to_bits(), square.to_bits(), "zeros and infinity");
            }
        }
    }

    fn special(&self) {
        let words = special(Self::format(true), false);
        for &a in &words {
            self.one(a, widened::<E, M>(a));
            for &b in &words {
                self.two([a, b]);
            }
        }
        let words = special(Self::format(true), true);
        for &a in &words {
            for &b in &words {
                for &c in &words {
                    self.three([a, b, c]);
                }
            }
        }
    }

    fn random(&self, count: usize) {
        let format = Self::format(true);
        let mut random = Random::new((E * 64 + M) as u64);
        for _ in 0..count {
            let a = any(&mut random, format);
            let b = near(&mut random, format, a);
            self.two([a, b]);
            let c = self.kept.word(
                self.kept
                    .mul(self.kept.from_word(a), self.kept.from_word(b)),
            );
            self.three([a, b, near(&mut random, format, c)]);
            self.one(a, self.about(&mut random, b));
        }
    }

    /// Any binary64 number, or one near the middle after a number.
    fn about(&self, random: &mut Random, word: u64) -> f64 {
        let bits = random.bits();
        if bits & 1 == 0 {
            return f64::from_bits(bits);
        }
        let number = widened::<E, M>(word).to_bits();
        let half = 1u64 << 52 >> (M + 1);
        f64::from_bits((number + half).wrapping_add(bits >> 1 & 3).wrapping_sub(1))
    }
}

fn is_nan<const E: usize, const M: usize>(word: u64) -> bool {
    read::<E, M>(word).is_nan()
}

fn all(count: usize) {
    fn one<const E: usize, const M: usize>(count: usize) {
        let pair = Pair::<E, M>::new();
        pair.special();
        pair.random(count);
    }
    one::<5, 10>(count);
    one::<8, 7>(count);
    one::<8, 23>(count);
    one::<11, 52>(count);
    one::<8, 17>(count);
    one::<6, 9>(count);
    one::<11, 51>(count);
    one::<11, 50>(count);
    one::<9, 24>(count);
    one::<9, 25>(count);
    one::<10, 40>(count);
    // Too wide for rounding to odd, and with ends of their own.
    one::<9, 51>(count);
    one::<10, 52>(count);
    one::<11, 20>(count);
    one::<2, 1>(count);
}

#[test]
fn operations_are_those_of_another_library() {
    all(10_000);
}

#[test]
#[ignore = "minutes, in a release build"]
fn formats_agree_on_ten_million_operands_per_operation() {
    all(10_000_000);
}

#[test]
fn small_words_are_told() {
    assert!(is_small::<8, 23>(0x8000_0001) && !is_small::<8, 23>(0x0080_0000));
}

#[test]
fn what_rounds_beyond_the_largest_number_is_infinite() {
    for (exponent, mantissa) in [(8, 23), (9, 51), (10, 52), (6, 9)] {
        let arithmetic = FormatArithmetic::new(Format::Float(NumberFormat {
            exponent,
            mantissa,
            subnormals: true,
        }));
        let ones = (1u64 << mantissa) - 1;
        let largest = arithmetic.from_word(((1 << exponent) - 2) << mantissa | ones);
        let half = 2f64.powi((1 << (exponent - 1)) - 2 - mantissa as i32);
        assert_eq!(arithmetic.add(largest, half), f64::INFINITY);
        assert_eq!(arithmetic.add(largest, half / 2.0), largest);
        assert_eq!(arithmetic.sub(-largest, half), f64::NEG_INFINITY);
        // The word of NaN is the quiet one without a payload.
        let quiet = ((1 << exponent) - 1) << mantissa | 1 << (mantissa - 1);
        assert_eq!(arithmetic.word(f64::NAN), quiet);
    }
}
