//! The operations that are inside the expression of their only reader.

use robovec_ir::{Function, Node, Value};

/// Most operations of one expression.
const LARGEST: u32 = 24;

/// For each value whether it is inside the expression of its reader.
pub(crate) struct Inlining {
    /// True for values that have no variable.
    pub(crate) inlined: Vec<bool>,
    /// Operations of the expression that ends in each value.
    pub(crate) sizes: Vec<u32>,
}

impl Inlining {
    /// Puts every value inside its only reader's expression that may be
    /// there, as long as the expression stays short.
    pub(crate) fn new(function: &Function, may_stand: impl Fn(Value, &Node) -> bool) -> Inlining {
        let uses = function.use_counts();
        let mut inlined = vec![false; uses.len()];
        let mut sizes = vec![0u32; uses.len()];
        for (value, node) in function.values() {
            let inner = node.operands().iter().filter_map(|operand| operand.value());
            let inner = inner.filter(|value| inlined[value.index()]);
            let size = 1 + inner.map(|value| sizes[value.index()]).sum::<u32>();
            sizes[value.index()] = size;
            inlined[value.index()] =
                uses[value.index()] == 1 && size <= LARGEST && may_stand(value, node);
        }
        Inlining { inlined, sizes }
    }
}

/// For each value a flag: true when it is assigned to an output.
pub(crate) fn assigned(function: &Function) -> Vec<bool> {
    let mut assigned = vec![false; function.nodes().len()];
    let operands = function.assignments.iter().map(|output| output.operand);
    for value in operands.filter_map(|operand| operand.value()) {
        assigned[value.index()] = true;
    }
    assigned
}
