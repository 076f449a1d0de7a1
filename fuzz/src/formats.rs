//! Programs whose values have their own formats, against another library.
//!
//! That library computes every operation in binary128 towards zero; where
//! that was not exact the last bit is set, so that its one rounding into the
//! format of the value is the right one.

use arbitrary::{Result, Unstructured};
use robovec_ir::evaluate::evaluate_mixed_nodes;
use robovec_ir::{
    Format, Function, Input, Level, Name, Node, Operand, OperandKind, Operation, Shape, SourceSet,
    Tables, Value, ValueFormats,
};
use robovec_num::NumberFormat;
use rustc_apfloat::ieee::{Double, IeeeFloat, Quad, Semantics};
use rustc_apfloat::{Float, FloatConvert, Round, Status, StatusAnd};
use std::cmp::Ordering;

/// Compares every value of a random program.
pub fn formats_agree(data: &[u8]) {
    // Too few bytes make no program.
    let _ = compare(&mut Unstructured::new(data));
}

/// A format of the other library.
struct Custom<const EXPONENT: usize, const MANTISSA: usize>;

impl<const EXPONENT: usize, const MANTISSA: usize> Semantics for Custom<EXPONENT, MANTISSA> {
    const BITS: usize = 1 + EXPONENT + MANTISSA;
    const EXP_BITS: usize = EXPONENT;
}

/// A number rounded into a format of the other library.
fn rounded<const E: usize, const M: usize>(number: Quad) -> f64 {
    let narrow: StatusAnd<IeeeFloat<Custom<E, M>>> =
        number.convert_r(Round::NearestTiesToEven, &mut false);
    let wide: StatusAnd<Double> = narrow.value.convert(&mut false);
    f64::from_bits(wide.value.to_bits() as u64)
}

/// A format in both libraries.
type Both = (u32, u32, fn(Quad) -> f64);

macro_rules! formats {
    ($(($exponent:literal, $mantissa:literal)),* $(,)?) => {
        [$(($exponent, $mantissa, rounded::<$exponent, $mantissa>)),*]
    };
}

const FORMATS: [Both; 18] = formats![
    (2, 1),
    (3, 4),
    (4, 3),
    (5, 2),
    (5, 10),
    (6, 9),
    (8, 7),
    (8, 10),
    (8, 17),
    (8, 23),
    (9, 24),
    (9, 25),
    (9, 50),
    (10, 24),
    (10, 51),
    (11, 20),
    (11, 51),
    (11, 52),
];

/// A format with its counterpart.
#[derive(Clone, Copy)]
struct Chosen {
    number: NumberFormat,
    round: fn(Quad) -> f64,
}

impl Chosen {
    fn any(bytes: &mut Unstructured<'_>) -> Result<Chosen> {
        let &(exponent, mantissa, round) = bytes.choose(&FORMATS)?;
        let subnormals = bytes.ratio(3, 4)?;
        let number = NumberFormat {
            exponent,
            mantissa,
            subnormals,
        };
        Ok(Chosen { number, round })
    }

    fn format(&self) -> Format {
        Format::Float(self.number)
    }

    /// Zero for numbers below the normal range, where the format has no
    /// subnormal numbers.
    fn flushed(&self, number: f64) -> f64 {
        let least = 2f64.powi(self.number.smallest_exponent());
        if !self.number.subnormals && number.abs() < least {
            0f64.copysign(number)
        } else {
            number
        }
    }

    fn convert(&self, number: f64) -> f64 {
        self.flushed((self.round)(quad(number)))
    }

    fn compute(&self, operation: Operation, [a, b, c]: [f64; 3]) -> f64 {
        let [x, y, z] = [a, b, c].map(quad);
        let result = match operation {
            Operation::Add => x.add_r(y, Round::TowardZero),
            Operation::Sub => x.sub_r(y, Round::TowardZero),
            Operation::Mul => x.mul_r(y, Round::TowardZero),
            Operation::Div => x.div_r(y, Round::TowardZero),
            Operation::Fma => x.mul_add_r(y, z, Round::TowardZero),
            Operation::Fms => x.mul_add_r(y, -z, Round::TowardZero),
            _ => (-x).mul_add_r(y, z, Round::TowardZero),
        };
        let inexact = u128::from(result.status.contains(Status::INEXACT));
        let odd = Quad::from_bits(result.value.to_bits() | inexact);
        let least = quad(2f64.powi(self.number.smallest_exponent()));
        let size = if odd.is_negative() { -odd } else { odd };
        // Results are judged before they are rounded.
        let tiny = size.partial_cmp(&least) == Some(Ordering::Less);
        if !self.number.subnormals && tiny {
            return if odd.is_negative() { -0.0 } else { 0.0 };
        }
        (self.round)(odd)
    }
}

fn quad(number: f64) -> Quad {
    let number = Double::from_bits(u128::from(number.to_bits()));
    let wide: StatusAnd<Quad> = number.convert(&mut false);
    wide.value
}

const INPUTS: u32 = 4;
const OPERATIONS: [Operation; 7] = [
    Operation::Add,
    Operation::Sub,
    Operation::Mul,
    Operation::Div,
    Operation::Fma,
    Operation::Fms,
    Operation::Fnma,
];

/// A number of any size, or one near 1 as those of programs are.
fn number(bytes: &mut Unstructured<'_>) -> Result<f64> {
    let bits: u64 = bytes.arbitrary()?;
    let mantissa = bits & (u64::MAX >> 12);
    Ok(match bytes.int_in_range(0..=3)? {
        0 => f64::from_bits(bits),
        1 => f64::from_bits(mantissa | (1023 - 8 + (bits >> 60)) << 52),
        2 => f64::from_bits(mantissa | (1023 - 512 + (bits >> 54)) << 52),
        _ => (bits >> 56) as f64 / 16.0 - 4.0,
    })
}

fn compare(bytes: &mut Unstructured<'_>) -> Result<()> {
    let default = Chosen::any(bytes)?;
    let mut tables = Tables::default();
    let mut function = Function::new("f", Level::Atomic);
    function.add_input(tables.symbols.intern("x"), Shape::Vector(INPUTS));
    let mut inputs = Vec::new();
    for _ in 0..INPUTS {
        inputs.push(number(bytes)?);
    }
    let count = bytes.int_in_range(1..=12)?;
    let mut formats = ValueFormats::new(count);
    let mut values: Vec<f64> = Vec::new();
    for index in 0..count as u32 {
        let own = if bytes.ratio(3, 4)? {
            Some(Chosen::any(bytes)?)
        } else {
            None
        };
        let &operation = bytes.choose(&OPERATIONS)?;
        let mut operands = [Operand::NONE; Operand::MAX_COUNT];
        for operand in &mut operands[..operation.arity()] {
            *operand = any_operand(bytes, &mut function, index)?;
        }
        let chosen = own.unwrap_or(default);
        let read = operands.map(|operand| match operand.kind() {
            OperandKind::Value(value) => values[value.index()],
            OperandKind::Input(input) => default.convert(inputs[input.index()]),
            OperandKind::Constant(constant) => chosen.convert(function.constant_number(constant)),
            OperandKind::None => 0.0,
        });
        values.push(chosen.compute(operation, read));
        let value = function.push(Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands,
            operation,
        });
        formats.set(value, own.map(|own| own.format()));
    }
    if formats.iter().any(|format| format.is_some()) {
        function.formats = Some(formats);
    }
    let found = evaluate_mixed_nodes(&function, default.format(), &inputs);
    for (index, (&found, &expected)) in found.iter().zip(&values).enumerate() {
        let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
        assert!(
            same,
            "value {index} is {found:e}, not {expected:e}: {function:?} of {inputs:?} in {}",
            default.format()
        );
    }
    Ok(())
}

fn any_operand(
    bytes: &mut Unstructured<'_>,
    function: &mut Function,
    values: u32,
) -> Result<Operand> {
    Ok(match bytes.int_in_range(0..=4)? {
        0 => {
            let constant = number(bytes)?;
            let finite = if constant.is_finite() { constant } else { 0.1 };
            function.constant(finite).into()
        }
        1 | 2 if values > 0 => Value(bytes.int_in_range(0..=values - 1)?).into(),
        _ => Input(bytes.int_in_range(0..=INPUTS - 1)?).into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn formats_agree_on_random_programs() {
        cases::of_sizes(200, 2000, compare);
    }
}
