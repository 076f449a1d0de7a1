//! The evaluator, generic over the kind of number.

mod mixed;

use crate::entity::{CAPACITY, OperandKind};
use crate::function::Function;
pub use mixed::{MixedArithmetic, evaluate_mixed, evaluate_mixed_nodes, evaluate_nodes_in};
use robovec_num::arithmetic::Arithmetic;

/// The value of every node, in program order, for the given flattened inputs.
///
/// # Panics
///
/// Panics when `inputs` is not [`Function::input_len`] long or the function is
/// not well formed (the verifier accepts only those that are).
pub fn evaluate_nodes<A: Arithmetic>(
    function: &Function,
    arithmetic: &A,
    inputs: &[A::Number],
) -> Vec<A::Number> {
    assert_eq!(
        inputs.len(),
        function.input_len(),
        "one number per input element"
    );
    // Values, inputs and constants lie behind one another, so that fetching
    // an operand is an addition and not a branch that nobody can predict.
    let count = function.nodes().len();
    let zero = arithmetic.literal(0.0);
    let mut slots = Vec::with_capacity(count + inputs.len() + function.constants().len() + 1);
    slots.resize(count, zero);
    slots.extend_from_slice(inputs);
    let constants = function.constants().iter();
    slots.extend(constants.map(|&number| arithmetic.literal(number)));
    slots.push(zero);
    let none = slots.len() - 1;
    let starts = [0, count, count + inputs.len(), none.wrapping_sub(CAPACITY)];
    for (index, node) in function.nodes().iter().enumerate() {
        let operands = node.operands.map(|operand| {
            let (kind, place) = operand.parts();
            slots[starts[kind].wrapping_add(place)]
        });
        slots[index] = arithmetic.apply(node.operation, operands);
    }
    slots.truncate(count);
    slots
}

/// The value of every assignment, in the order of
/// [`Function::assignments`].
///
/// # Panics
///
/// As [`evaluate_nodes`].
pub fn evaluate<A: Arithmetic>(
    function: &Function,
    arithmetic: &A,
    inputs: &[A::Number],
) -> Vec<A::Number> {
    let values = evaluate_nodes(function, arithmetic, inputs);
    outputs(function, arithmetic, inputs, &values)
}

/// The value of every assignment, given those of all nodes.
///
/// # Panics
///
/// Panics when `values` is not the result of [`evaluate_nodes`] for these
/// inputs.
pub fn outputs<A: Arithmetic>(
    function: &Function,
    arithmetic: &A,
    inputs: &[A::Number],
    values: &[A::Number],
) -> Vec<A::Number> {
    function
        .assignments
        .iter()
        .map(|assignment| match assignment.operand.kind() {
            OperandKind::Value(value) => values[value.index()],
            OperandKind::Input(input) => inputs[input.index()],
            OperandKind::Constant(constant) => {
                arithmetic.literal(function.constant_number(constant))
            }
            OperandKind::None => arithmetic.literal(0.0),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse::parse_module;
    use robovec_num::arithmetic::{Binary32, Binary64};
    use robovec_num::double_double::DoubleDouble;
    use robovec_num::field::PrimeField;

    const FUSED: &str = "function f atomic {
      in x[1..3]
      out o[1..3]
      %a = fma(x[1], x[2], x[3])
      %b = fms(x[1], x[2], x[3])
      %c = fnma(x[1], x[2], x[3])
      o[1] = %a
      o[2] = %b
      o[3] = %c
    }";

    fn fused<A: Arithmetic>(arithmetic: &A, inputs: [f64; 3]) -> Vec<A::Number> {
        let module = parse_module("fused", FUSED).expect("it is well formed");
        let inputs = inputs.map(|number| arithmetic.literal(number));
        evaluate(&module.functions[0], arithmetic, &inputs)
    }

    #[test]
    fn a_fused_operation_rounds_once() {
        // (1 + e)(1 - e) - 1 = -e^2, which two roundings lose.
        let e = f64::EPSILON;
        let expected = [-e * e, 2.0, e * e];
        assert_eq!(fused(&Binary64, [1.0 + e, 1.0 - e, -1.0])[0], expected[0]);
        assert_eq!(fused(&Binary64, [1.0 + e, 1.0 - e, 1.0])[1], expected[0]);
        assert_eq!(fused(&Binary64, [1.0 + e, 1.0 - e, 1.0])[2], expected[2]);
        let e = f64::from(f32::EPSILON);
        let results = fused(&Binary32, [1.0 + e, 1.0 - e, 1.0]);
        assert_eq!(results, [2.0, (-e * e) as f32, (e * e) as f32]);
        // 1549 * 10831 = 2^24 + 3 lies in the middle between two binary32
        // numbers and a little less is nearer to the lower one; rounded to
        // binary64 on the way the little is lost.
        let little = 2f64.powi(-40);
        let sum = fused(&Binary32, [1549.0, 10831.0, -little])[0];
        assert_eq!(sum, 16_777_218.0);
        assert_eq!((1549.0 * 10831.0 - little) as f32, 16_777_220.0);
    }

    #[test]
    fn signs_are_those_of_the_names_in_every_arithmetic() {
        let inputs = [3.0, 5.0, 7.0];
        let expected = [22.0, 8.0, -8.0];
        assert_eq!(fused(&Binary64, inputs), expected);
        assert_eq!(
            fused(&Binary32, inputs),
            expected.map(|number| number as f32)
        );
        let reference = fused(&DoubleDouble, inputs);
        assert_eq!(
            reference,
            expected.map(|number| DoubleDouble.literal(number))
        );
        for field in PrimeField::pair(1, false) {
            assert_eq!(
                fused(&field, inputs),
                expected.map(|number| field.literal(number))
            );
        }
    }
}
