//! The evaluator, generic over the kind of number.

use crate::arithmetic::Arithmetic;
use crate::entity::{CAPACITY, OperandKind};
use crate::function::Function;
use crate::operation::Operation;

/// The value of every node, in program order, for the given flattened inputs.
///
/// # Panics
///
/// When `inputs` is not [`Function::input_len`] long or the function is not
/// well formed (the verifier accepts only those that are).
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
        let [a, b] = node.operands.map(|operand| {
            let (kind, place) = operand.parts();
            slots[starts[kind].wrapping_add(place)]
        });
        slots[index] = match node.operation {
            Operation::Copy => a,
            Operation::Neg => arithmetic.neg(a),
            Operation::Add => arithmetic.add(a, b),
            Operation::Sub => arithmetic.sub(a, b),
            Operation::Mul => arithmetic.mul(a, b),
            Operation::Div => arithmetic.div(a, b),
            Operation::Sin => arithmetic.sin(a),
            Operation::Cos => arithmetic.cos(a),
            Operation::Sqrt => arithmetic.sqrt(a),
        };
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
/// When `values` is not what [`evaluate_nodes`] gives for these inputs.
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
