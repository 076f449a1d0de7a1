//! Evaluation where every value may have its own format.
//!
//! An operation takes its operands in the formats in which they were computed,
//! and its exact result is rounded once into the format of its value. A
//! constant is rounded into the format of the operation that reads it, which is
//! where such a machine would keep it; inputs, and constants that are outputs,
//! are in the format of the run.

use super::evaluate_nodes;
use crate::entity::{Operand, OperandKind, Value};
use crate::function::Function;
use crate::value_formats::ValueFormats;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::format::Format;
use robovec_num::soft_float::FormatArithmetic;
use robovec_num::trigonometry::host::{ImplementationError, KEY, TrigonometricUnit};

/// The arithmetic of every value of a function.
#[derive(Clone, Debug)]
pub struct MixedArithmetic<'a> {
    formats: Option<&'a ValueFormats>,
    /// Of values without a format, then those of the table.
    arithmetics: Vec<FormatArithmetic>,
}

impl<'a> MixedArithmetic<'a> {
    /// Values without a format are computed in `default`.
    pub fn new(formats: Option<&'a ValueFormats>, default: Format) -> MixedArithmetic<'a> {
        let Some(table) = formats.map(ValueFormats::table) else {
            return MixedArithmetic {
                formats,
                arithmetics: vec![FormatArithmetic::new(default)],
            };
        };
        let all = std::iter::once(&default).chain(table);
        MixedArithmetic {
            formats,
            arithmetics: all.map(|&format| FormatArithmetic::mixed(format)).collect(),
        }
    }

    /// The arithmetic a value is computed in.
    #[inline]
    pub fn of(&self, value: Value) -> &FormatArithmetic {
        let index = self.formats.map_or(0, |formats| formats.index(value));
        &self.arithmetics[index]
    }

    /// The arithmetic of inputs and of values without a format.
    pub fn default(&self) -> &FormatArithmetic {
        &self.arithmetics[0]
    }
}

/// The value of every node, in program order, for the given flattened inputs,
/// each value in its format or in `default`. Inputs are converted into
/// `default`; sines and cosines are those of the unit that the function names
/// ([`robovec_num::trigonometry::host`]), rounded once.
///
/// # Panics
///
/// As [`evaluate_nodes`].
pub fn evaluate_mixed_nodes(function: &Function, default: Format, inputs: &[f64]) -> Vec<f64> {
    evaluate_nodes_in(function, function.formats.as_ref(), default, inputs)
}

/// As [`evaluate_mixed_nodes`], with other formats than the function's own, for
/// trials.
///
/// # Panics
///
/// As [`evaluate_nodes`], and when the numbers of formats and nodes differ.
pub fn evaluate_nodes_in(
    function: &Function,
    formats: Option<&ValueFormats>,
    default: Format,
    inputs: &[f64],
) -> Vec<f64> {
    let mixed = MixedArithmetic::new(formats, default);
    let inputs: Vec<f64> = inputs
        .iter()
        .map(|&number| mixed.default().convert(number))
        .collect();
    let unit = function.trigonometry_unit();
    let unit = unit.map(|unit| unit.expect("the verifier accepts only names of units"));
    match (formats, &unit) {
        (None, None) => return evaluate_nodes(function, mixed.default(), &inputs),
        (None, Some(unit)) => {
            return evaluate_nodes(function, &unit.within(*mixed.default()), &inputs);
        }
        (Some(_), _) => {}
    }
    let mut values: Vec<f64> = Vec::with_capacity(function.nodes().len());
    for (value, node) in function.values() {
        let arithmetic = mixed.of(value);
        let fetch = |operand: Operand| match operand.kind() {
            OperandKind::Value(value) => values[value.index()],
            OperandKind::Input(input) => inputs[input.index()],
            OperandKind::Constant(constant) => {
                arithmetic.convert(function.constant_number(constant))
            }
            OperandKind::None => 0.0,
        };
        let operands = node.operands.map(fetch);
        let result = match &unit {
            Some(unit) => unit.within(*arithmetic).apply(node.operation, operands),
            None => arithmetic.apply(node.operation, operands),
        };
        values.push(result);
    }
    values
}

/// The value of every assignment, in the order of [`Function::assignments`];
/// see [`evaluate_mixed_nodes`].
///
/// # Panics
///
/// As [`evaluate_nodes`].
pub fn evaluate_mixed(function: &Function, default: Format, inputs: &[f64]) -> Vec<f64> {
    let values = evaluate_mixed_nodes(function, default, inputs);
    let arithmetic = FormatArithmetic::new(default);
    let inputs: Vec<f64> = inputs
        .iter()
        .map(|&number| arithmetic.convert(number))
        .collect();
    super::outputs(function, &arithmetic, &inputs, &values)
}

impl Function {
    /// The unit that computes its sines and cosines, which its metadata names;
    /// `None` when it names none.
    ///
    /// # Errors
    ///
    /// Fails when the name is that of no implementation.
    pub fn trigonometry_unit(&self) -> Option<Result<TrigonometricUnit, ImplementationError>> {
        self.metadata(KEY).map(TrigonometricUnit::named)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::evaluate;
    use crate::parse::parse_module;
    use robovec_num::arithmetic::Binary32;
    use robovec_num::trigonometry::host::WithTrigonometry;

    const MIXED: &str = "function f atomic {
      in x[1..2]
      out o[1..4]
      %a = x[1]*x[2] as f64
      %b = %a + 0.1 as f16
      %c = %a + 0.1
      %d = %c - %b as fixed(2,20)
      o[1] = %a
      o[2] = %b
      o[3] = %c
      o[4] = %d
    }";

    #[test]
    fn each_value_is_rounded_once_into_its_format() {
        let module = parse_module("mixed", MIXED).expect("it is well formed");
        let inputs = [0.3, 0.7];
        let [x, y] = inputs.map(|number| f64::from(number as f32));
        let results = evaluate_mixed(&module.functions[0], Format::BINARY32, &inputs);
        let half = FormatArithmetic::new("f16".parse().expect("a format"));
        let a = x * y;
        // Sums of two binary64 numbers this near are exact enough here.
        let b = half.convert(a + half.convert(0.1));
        let c = f64::from((a + f64::from(0.1f32)) as f32);
        let unit = 2f64.powi(20);
        let d = ((c - b) * unit).round_ties_even() / unit;
        assert_eq!(results, [a, b, c, d]);
        assert_ne!(b, c);
    }

    #[test]
    fn without_formats_it_is_the_evaluation_in_one() {
        let text = MIXED.replace(" as f64", "").replace(" as f16", "");
        let text = text.replace(" as fixed(2,20)", "");
        let module = parse_module("plain", &text).expect("it is well formed");
        let function = &module.functions[0];
        let singles = [0.3f32, 0.7].map(f64::from);
        let results = evaluate_mixed(function, Format::BINARY32, &singles);
        let binary32 = robovec_num::arithmetic::Binary32;
        let expected = crate::evaluate::evaluate(function, &binary32, &[0.3, 0.7]);
        assert_eq!(
            results,
            expected.into_iter().map(f64::from).collect::<Vec<_>>()
        );
        let doubles = evaluate_mixed(function, Format::BINARY64, &[0.3, 0.7]);
        assert_eq!(doubles[0], 0.3 * 0.7);
    }

    #[test]
    fn sines_come_from_the_unit_and_the_rest_does_not() {
        let text = "function f equations {
          meta trigonometry \"cordic(iterations=8 bits=12)\"
          in q
          out o[1..3]
          o[1] = sin(q)
          o[2] = cos(q)
          o[3] = q*q
        }";
        let module = parse_module("f", text).expect("it is well formed");
        let function = &module.functions[0];
        let unit = function
            .trigonometry_unit()
            .expect("it is named")
            .expect("it is one");
        let arithmetic = WithTrigonometry {
            arithmetic: Binary32,
            unit: &unit,
        };
        let found = evaluate(function, &arithmetic, &[0.7f32]);
        let expected = unit.sine_and_cosine(f64::from(0.7f32));
        assert_eq!(found[..2], expected.map(|number| number as f32));
        assert_eq!(found[2], 0.7f32 * 0.7f32);
        assert_ne!(found[0], 0.7f32.sin());
    }
}
