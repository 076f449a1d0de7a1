//! Fused operations as sums of a product and an addend.

use super::groups::GroupFamily;
use super::writer::joining;
use robovec_ir::{Function, Node, Operand, Operation};

/// Tests whether a fused operation subtracts its product, and its addend.
fn signs(operation: Operation) -> (bool, bool) {
    let (product, addend) = (Operation::Fnma, Operation::Fms);
    (operation == product, operation == addend)
}

/// The sum of two operands that a fused operation is, given its product.
pub(crate) fn apart<T>(operation: Operation, product: T, addend: T) -> (Operation, [T; 2]) {
    let (first, second) = signs(operation);
    let pair = [(product, first), (addend, second)];
    let (operation, operands, _) = joining(GroupFamily::Sum, pair, false);
    (operation, operands)
}

/// The fused operation whose product and addend change sign where requested,
/// and a flag: true when its result is stored negated.
pub(crate) fn turned(operation: Operation, product: bool, addend: bool) -> (Operation, bool) {
    let (first, second) = signs(operation);
    match (product ^ first, addend ^ second) {
        (false, false) => (Operation::Fma, false),
        (false, true) => (Operation::Fms, false),
        (true, false) => (Operation::Fnma, false),
        (true, true) => (Operation::Fma, true),
    }
}

/// A sum of two operands with the product on one side fused.
pub(crate) fn contraction(
    function: &Function,
    sum: &Node,
    side: usize,
) -> (Operation, [Operand; Operand::MAX_COUNT]) {
    let operation = match (sum.operation, side) {
        (Operation::Sub, 0) => Operation::Fms,
        (Operation::Sub, _) => Operation::Fnma,
        _ => Operation::Fma,
    };
    let [a, b, _] = match sum.operands[side].value() {
        Some(product) => function.node(product).operands,
        None => [Operand::NONE; Operand::MAX_COUNT],
    };
    (operation, [a, b, sum.operands[1 - side]])
}
