//! The evaluator, generic over the kind of number.

use crate::arithmetic::Arithmetic;
use crate::entity::{Operand, OperandKind};
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
    let constants: Vec<A::Number> = function
        .constants()
        .iter()
        .map(|&number| arithmetic.literal(number))
        .collect();
    let mut values: Vec<A::Number> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let get = |operand: Operand| match operand.kind() {
            OperandKind::Value(value) => values[value.index()],
            OperandKind::Input(input) => inputs[input.index()],
            OperandKind::Constant(constant) => constants[constant.index()],
            OperandKind::None => arithmetic.literal(0.0),
        };
        let a = get(node.operands[0]);
        let result = match node.operation {
            Operation::Copy => a,
            Operation::Neg => arithmetic.neg(a),
            Operation::Add => arithmetic.add(a, get(node.operands[1])),
            Operation::Sub => arithmetic.sub(a, get(node.operands[1])),
            Operation::Mul => arithmetic.mul(a, get(node.operands[1])),
            Operation::Div => arithmetic.div(a, get(node.operands[1])),
            Operation::Sin => arithmetic.sin(a),
            Operation::Cos => arithmetic.cos(a),
            Operation::Sqrt => arithmetic.sqrt(a),
        };
        values.push(result);
    }
    values
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
