//! Finding the groups: signed sums and products.

use robovec_ir::{Function, Operand, Operation, Value};

/// How far a group reaches into the values that only it uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Reach {
    /// One operation is one group.
    Operation,
    /// A cascade: down the left operands (thesis 2.4.2).
    Cascade,
    /// The maximal sum or product (thesis 2.4.3).
    Maximal,
}

/// What a group computes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Family {
    /// A signed sum: additions, subtractions and minuses.
    Sum,
    /// A product: multiplications.
    Product,
}

impl Family {
    pub(super) fn of(operation: Operation) -> Option<Family> {
        match operation {
            Operation::Add | Operation::Sub | Operation::Neg => Some(Family::Sum),
            Operation::Mul => Some(Family::Product),
            Operation::Copy
            | Operation::Div
            | Operation::Sin
            | Operation::Cos
            | Operation::Sqrt => None,
        }
    }
}

/// A term of a sum or a factor of a product, in the function read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Leaf {
    pub(super) operand: Operand,
    /// True for a term that is subtracted; never for a factor.
    pub(super) negative: bool,
}

/// One group, taken apart; kept to be filled again and again.
#[derive(Default)]
pub(super) struct Group {
    /// Terms or factors, left to right, without the zeros of a sum.
    pub(super) leaves: Vec<Leaf>,
    /// Values absorbed into it.
    pub(super) inner: Vec<Value>,
    open: Vec<Leaf>,
}

/// The groups of a function: which values are part of the group of their one
/// user.
pub(super) struct Groups {
    absorbed: Vec<bool>,
}

impl Groups {
    pub(super) fn find(function: &Function, reach: Reach) -> Groups {
        let mut absorbed = vec![false; function.nodes().len()];
        if reach == Reach::Operation {
            return Groups { absorbed };
        }
        let uses = function.use_counts();
        for (_, node) in function.values() {
            let Some(family) = Family::of(node.operation) else {
                continue;
            };
            let minus = is_minus(function, node.operation, node.operands[0]);
            for (side, operand) in node.operands().iter().enumerate() {
                let Some(value) = operand.value() else {
                    continue;
                };
                let only_use = uses[value.index()] == 1;
                let same = Family::of(function.node(value).operation) == Some(family);
                let reached = reach == Reach::Maximal || side == 0 || minus;
                absorbed[value.index()] = only_use && same && reached;
            }
        }
        Groups { absorbed }
    }

    pub(super) fn is_absorbed(&self, value: Value) -> bool {
        self.absorbed[value.index()]
    }

    /// Takes the group of a value apart.
    pub(super) fn collect(&self, function: &Function, root: Value, group: &mut Group) {
        let Group {
            leaves,
            inner,
            open,
        } = group;
        leaves.clear();
        inner.clear();
        let sum = Family::of(function.node(root).operation) == Some(Family::Sum);
        open.push(Leaf {
            operand: root.into(),
            negative: false,
        });
        while let Some(leaf) = open.pop() {
            let expanded = leaf
                .operand
                .value()
                .filter(|&value| value == root || self.is_absorbed(value));
            let Some(value) = expanded else {
                if !(sum && function.number(leaf.operand) == Some(0.0)) {
                    leaves.push(leaf);
                }
                continue;
            };
            if value != root {
                inner.push(value);
            }
            let node = function.node(value);
            for (side, &operand) in node.operands().iter().enumerate().rev() {
                let minus = match node.operation {
                    Operation::Sub => side == 1,
                    Operation::Neg => true,
                    _ => false,
                };
                open.push(Leaf {
                    operand,
                    negative: leaf.negative ^ minus,
                });
            }
        }
    }
}

/// True for `0 - x` and `-x`.
pub(super) fn is_minus(function: &Function, operation: Operation, left: Operand) -> bool {
    match operation {
        Operation::Neg => true,
        Operation::Sub => function.number(left) == Some(0.0),
        _ => false,
    }
}
