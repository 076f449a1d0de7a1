//! An order of values that does not depend on their original order.
//!
//! Ties are often broken by the order of a file: the same equations in another
//! order then make another program. Here every value is where the outputs first
//! need it: the last output first, of operands the one with the longest chain
//! first, and of equally long ones that with the smaller hash of the expression
//! it represents.

use crate::hash;
use robovec_framework::rewrite::{Rewriter, lay_out};
use robovec_ir::{Function, Level, Node, Operand, OperandKind, Value, ValueFormats};
use std::cmp::Reverse;

/// The function with its values in this order; those that no output needs
/// are after the others, as they came.
pub(super) fn by_outputs(function: &Function) -> Function {
    let order = order(function);
    let mut rewriter = Rewriter::unmapped(function, function.level);
    let count = function.nodes().len();
    rewriter.new.formats = function.formats.as_ref().map(|_| ValueFormats::new(count));
    for value in order {
        let node = *function.node(value);
        let operands = rewriter.translate_operands(&node);
        let written = rewriter.new.push(Node { operands, ..node });
        if let (Some(old), Some(new)) = (&function.formats, &mut rewriter.new.formats) {
            new.set(written, old.get(value));
        }
        rewriter.amend(value, written.into());
    }
    let ordered = rewriter.finish();
    match function.level {
        // Expressions stand before the definition they belong to.
        Level::Equations => lay_out(&ordered),
        _ => ordered,
    }
}

fn order(function: &Function) -> Vec<Value> {
    let keys = keys(function);
    let mut order = Vec::with_capacity(keys.len());
    let mut is_placed = vec![false; keys.len()];
    let outputs = function.assignments.iter().rev();
    let outputs = outputs.filter_map(|assignment| assignment.operand.value());
    let roots = outputs.chain(function.values().map(|(value, _)| value));
    // Values to place, with whether their operands have been.
    let mut open: Vec<(Value, bool)> = Vec::new();
    for root in roots {
        open.push((root, false));
        while let Some((value, is_ready)) = open.pop() {
            if is_placed[value.index()] {
                continue;
            }
            if is_ready {
                is_placed[value.index()] = true;
                order.push(value);
                continue;
            }
            open.push((value, true));
            let operands = function.node(value).operands().iter();
            let mut operands: Vec<Value> = operands.filter_map(|operand| operand.value()).collect();
            operands.sort_by_key(|operand| keys[operand.index()]);
            let unplaced = operands.into_iter().rev();
            open.extend(
                unplaced
                    .filter(|operand| !is_placed[operand.index()])
                    .map(|operand| (operand, false)),
            );
        }
    }
    order
}

/// For every value the operations of its longest chain, longer first, and the
/// hash of its expression.
fn keys(function: &Function) -> Vec<(Reverse<u32>, u64)> {
    let mut keys: Vec<(Reverse<u32>, u64)> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let key = |operand: &Operand| match operand.kind() {
            OperandKind::Value(value) => keys[value.index()],
            OperandKind::Constant(constant) => {
                let bits = function.constant_number(constant).to_bits();
                (Reverse(0), hash::of_words(&[1, bits]))
            }
            OperandKind::Input(input) => (Reverse(0), hash::of_words(&[2, input.0.into()])),
            OperandKind::None => (Reverse(0), 0),
        };
        let mut operands: Vec<(Reverse<u32>, u64)> = node.operands().iter().map(key).collect();
        if node.operation.is_commutative() {
            operands.sort_unstable();
        }
        let lengths = operands.iter().map(|(Reverse(length), _)| *length);
        let longest = lengths.fold(0, u32::max);
        let hashes: Vec<u64> = operands.iter().map(|(_, hash)| *hash).collect();
        let hash = hash::of_list(node.operation as u64, &hashes);
        keys.push((Reverse(longest + 1), hash));
    }
    keys
}
