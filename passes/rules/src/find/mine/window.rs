//! Windows: connected sets of a few operations below one value.

use robovec_ir::{Function, Operation, Value};

/// Windows of one root at most; the operations read by many are few.
const MOST: usize = 3_000;

/// True for the operations of windows: those of rules with sums and products.
pub(super) fn belongs(operation: Operation) -> bool {
    matches!(
        operation,
        Operation::Add | Operation::Sub | Operation::Mul | Operation::Neg
    )
}

/// All windows of a root with two to `largest` operations, each once, as far
/// as operations other than the root are `eligible`. The root comes first.
/// False when there were more than are considered.
pub(super) fn each(
    function: &Function,
    root: Value,
    largest: usize,
    eligible: &dyn Fn(Value) -> bool,
    visit: &mut dyn FnMut(&[Value]),
) -> bool {
    /// A partial window: its values, the candidates for it, and all values
    /// considered so far, which are not considered again.
    #[derive(Clone)]
    struct Partial {
        inside: Vec<Value>,
        open: Vec<Value>,
        considered: Vec<Value>,
    }
    let offer = |partial: &mut Partial, value: Value| {
        for operand in function.node(value).operands() {
            if let Some(inner) = operand.value()
                && belongs(function.node(inner).operation)
                && eligible(inner)
                && !partial.considered.contains(&inner)
            {
                partial.open.push(inner);
                partial.considered.push(inner);
            }
        }
    };
    let mut first = Partial {
        inside: vec![root],
        open: Vec::new(),
        considered: Vec::new(),
    };
    offer(&mut first, root);
    let mut partials = vec![first];
    let mut count = 0;
    while let Some(mut partial) = partials.pop() {
        let next = if partial.inside.len() < largest {
            partial.open.pop()
        } else {
            None
        };
        let Some(next) = next else {
            if partial.inside.len() > 1 {
                if count == MOST {
                    return false;
                }
                count += 1;
                visit(&partial.inside);
            }
            continue;
        };
        let mut with = partial.clone();
        with.inside.push(next);
        offer(&mut with, next);
        partials.push(partial);
        partials.push(with);
    }
    true
}
