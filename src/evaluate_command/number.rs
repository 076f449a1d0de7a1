//! The kinds of numbers, and how each is written.

use super::format::{ResultFormat, Shown};
use astro_float::{BigFloat, Consts, Radix, RoundingMode};
use robovec_ir::Function;
use robovec_ir::evaluate::{evaluate, evaluate_mixed};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::DoubleDouble;
use robovec_num::field::{Field, PrimeField};
use robovec_num::format::{Format, FormatError};
use robovec_num::hexadecimal;
use robovec_num::limits::NumberLimit;
use robovec_num::soft_float::FormatArithmetic;
use std::cell::RefCell;
use std::str::FromStr;

/// Number system of the evaluation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NumberSystem {
    /// A number format; values may have their own.
    Format(Format),
    /// Pairs of binary64, about 106 bits.
    DoubleDouble,
    /// A prime field that the seed chooses, with sines and cosines on a circle.
    Field,
    /// Floats of at least this many bits: the mantissa is whole 64-bit words.
    Bits(usize),
}

/// The widest floats; an operation on them still takes microseconds.
const WIDEST: usize = 16_384;

/// Bits of floats.
pub const BITS: NumberLimit = NumberLimit::whole(
    1,
    WIDEST as u64,
    "the time of an operation grows with the square of its bits",
);

impl Default for NumberSystem {
    fn default() -> NumberSystem {
        NumberSystem::Format(Format::BINARY64)
    }
}

impl FromStr for NumberSystem {
    type Err = String;

    fn from_str(text: &str) -> Result<NumberSystem, String> {
        match text {
            "double-double" => Ok(NumberSystem::DoubleDouble),
            "field" => Ok(NumberSystem::Field),
            _ if text.parse::<f64>().is_ok() => BITS
                .read_whole(text)
                .map(|bits| NumberSystem::Bits(bits as usize)),
            _ => match text.parse::<Format>() {
                Ok(format) => Ok(NumberSystem::Format(format)),
                Err(error @ FormatError::Width) => Err(error.to_string()),
                Err(FormatError::Unreadable) => Err(format!(
                    "expected f16, bf16, f32, f64, float(EXPONENT,MANTISSA), \
                     fixed(INTEGER,FRACTION), double-double, field, or a number of bits up to \
                     {WIDEST}"
                )),
            },
        }
    }
}

/// Arithmetic whose numbers can be shown.
pub(super) trait Show: Arithmetic {
    /// The assigned outputs of a function.
    fn evaluate(&self, function: &Function, inputs: &[f64]) -> Vec<Self::Number>
    where
        Self: Sized,
    {
        let literals = inputs.iter().map(|&number| self.literal(number));
        evaluate(function, self, &literals.collect::<Vec<_>>())
    }

    fn show(&self, number: Self::Number, format: ResultFormat) -> Shown;

    /// Forgets all numbers made so far.
    fn clear(&self) {}
}

/// A float: the shortest decimal of this number, or hexadecimal.
fn float(number: f64, decimal: String, format: ResultFormat) -> Shown {
    Shown {
        text: match format {
            ResultFormat::Hexadecimal => hexadecimal::format(number),
            ResultFormat::Text | ResultFormat::Csv | ResultFormat::Json => decimal,
        },
        quoted: !number.is_finite(),
    }
}

impl Show for FormatArithmetic {
    fn evaluate(&self, function: &Function, inputs: &[f64]) -> Vec<f64> {
        evaluate_mixed(function, self.format(), inputs)
    }

    fn show(&self, number: f64, format: ResultFormat) -> Shown {
        let decimal = match self.format() {
            Format::BINARY32 => format!("{:?}", number as f32),
            _ => format!("{number:?}"),
        };
        float(number, decimal, format)
    }
}

impl Show for PrimeField {
    fn show(&self, number: u64, _: ResultFormat) -> Shown {
        let residue = self.residue(number);
        Shown {
            text: residue.map_or_else(|| "undefined".to_owned(), |residue| residue.to_string()),
            quoted: true,
        }
    }
}

/// Bits that hold the sum of a pair whose halves are next to each other.
const PAIR: usize = 128;
const ROUNDING: RoundingMode = RoundingMode::ToEven;

impl Show for DoubleDouble {
    fn show(&self, number: Self::Number, _: ResultFormat) -> Shown {
        let bits = BigFloatArithmetic::new(PAIR);
        let [high, low] = [number.high, number.low].map(|half| bits.literal(half));
        let sum = bits.add(high, low);
        bits.show(sum, ResultFormat::Csv)
    }
}

/// Floats of a precision, places in a list, as the evaluator copies numbers.
pub(super) struct BigFloatArithmetic {
    precision: usize,
    numbers: RefCell<Vec<BigFloat>>,
    /// Digits of pi and the like, computed on first use; `None` without memory.
    constants: RefCell<Option<Consts>>,
}

impl BigFloatArithmetic {
    pub(super) fn new(precision: usize) -> BigFloatArithmetic {
        BigFloatArithmetic {
            precision,
            numbers: RefCell::default(),
            constants: RefCell::new(Consts::new().ok()),
        }
    }

    fn push(&self, number: BigFloat) -> usize {
        let mut numbers = self.numbers.borrow_mut();
        numbers.push(number);
        numbers.len() - 1
    }

    fn unary(&self, a: usize, operation: impl Fn(&BigFloat) -> BigFloat) -> usize {
        let result = operation(&self.numbers.borrow()[a]);
        self.push(result)
    }

    fn binary(
        &self,
        a: usize,
        b: usize,
        operation: impl Fn(&BigFloat, &BigFloat, usize, RoundingMode) -> BigFloat,
    ) -> usize {
        let result = {
            let numbers = self.numbers.borrow();
            operation(&numbers[a], &numbers[b], self.precision, ROUNDING)
        };
        self.push(result)
    }

    fn angle(
        &self,
        a: usize,
        operation: impl Fn(&BigFloat, usize, RoundingMode, &mut Consts) -> BigFloat,
    ) -> usize {
        let result = match self.constants.borrow_mut().as_mut() {
            Some(constants) => operation(
                &self.numbers.borrow()[a],
                self.precision,
                ROUNDING,
                constants,
            ),
            None => astro_float::NAN,
        };
        self.push(result)
    }
}

impl Arithmetic for BigFloatArithmetic {
    type Number = usize;

    fn literal(&self, number: f64) -> usize {
        self.push(BigFloat::from_f64(number, self.precision.max(64)))
    }
    fn neg(&self, a: usize) -> usize {
        self.unary(a, BigFloat::neg)
    }
    fn add(&self, a: usize, b: usize) -> usize {
        self.binary(a, b, BigFloat::add)
    }
    fn sub(&self, a: usize, b: usize) -> usize {
        self.binary(a, b, BigFloat::sub)
    }
    fn mul(&self, a: usize, b: usize) -> usize {
        self.binary(a, b, BigFloat::mul)
    }
    fn div(&self, a: usize, b: usize) -> usize {
        self.binary(a, b, BigFloat::div)
    }
    fn sin(&self, a: usize) -> usize {
        self.angle(a, BigFloat::sin)
    }
    fn cos(&self, a: usize) -> usize {
        self.angle(a, BigFloat::cos)
    }
    fn sqrt(&self, a: usize) -> usize {
        self.unary(a, |number| number.sqrt(self.precision, ROUNDING))
    }
    fn fma(&self, a: usize, b: usize, c: usize) -> usize {
        // The full product has at most as many bits as both factors.
        let product = self.binary(a, b, |a, b, _, _| a.mul_full_prec(b));
        self.add(product, c)
    }
}

impl Show for BigFloatArithmetic {
    fn show(&self, number: usize, _: ResultFormat) -> Shown {
        let numbers = self.numbers.borrow();
        let text = match self.constants.borrow_mut().as_mut() {
            Some(constants) => numbers[number].format(Radix::Dec, ROUNDING, constants),
            None => Ok("NaN".to_owned()),
        };
        Shown {
            text: text.unwrap_or_else(|_| "NaN".to_owned()),
            quoted: true,
        }
    }

    fn clear(&self) {
        self.numbers.borrow_mut().clear();
    }
}
