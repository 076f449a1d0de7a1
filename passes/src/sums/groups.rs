//! Finding the groups: signed sums and products.

use robovec_analysis::critical_path::Weights;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::{Function, Node, Operand, Operation, Value};

/// The reach of a group into the values that only it uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum GroupReach {
    /// One operation is one group.
    Operation,
    /// A cascade: down the left operands (thesis 2.4.2).
    Cascade,
    /// The maximal sum or product (thesis 2.4.3).
    Maximal,
}

/// The operation of a group.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum GroupFamily {
    /// A signed sum: additions, subtractions and minuses.
    Sum,
    /// A product: multiplications.
    Product,
}

impl GroupFamily {
    pub(crate) fn of(operation: Operation) -> Option<GroupFamily> {
        match operation {
            Operation::Add | Operation::Sub | Operation::Neg => Some(GroupFamily::Sum),
            Operation::Mul => Some(GroupFamily::Product),
            Operation::Copy
            | Operation::Div
            | Operation::Sin
            | Operation::Cos
            | Operation::Sqrt
            | Operation::Fma
            | Operation::Fms
            | Operation::Fnma => None,
        }
    }

    /// The weight of joining two terms or factors.
    pub(crate) fn weight(self, weights: &Weights) -> u32 {
        weights.of(match self {
            GroupFamily::Sum => Operation::Add,
            GroupFamily::Product => Operation::Mul,
        })
    }
}

/// A term of a sum or a factor of a product, in the function read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct GroupLeaf {
    pub(crate) operand: Operand,
    /// True for a term that is subtracted; never for a factor.
    pub(crate) negative: bool,
}

/// The groups of a function, taken apart once.
///
/// Leaves and absorbed values of all groups lie in two vectors, in order of
/// the groups' results.
pub(crate) struct OperandGroups {
    absorbed: Vec<bool>,
    /// Values of groups that must not change; empty when there are none.
    frozen: Vec<bool>,
    leaves: Vec<GroupLeaf>,
    inner: Vec<Value>,
    /// For each value the start of its leaves and absorbed values; those of the
    /// next value end them. Empty for all but the results of groups.
    starts: Vec<(u32, u32)>,
}

impl OperandGroups {
    pub(crate) fn find(function: &Function, reach: GroupReach) -> OperandGroups {
        OperandGroups::read(function, absorbed(function, reach), Vec::new())
    }

    /// As [`OperandGroups::find`], but those that may not be rewritten are taken
    /// apart into their operations, each frozen.
    pub(crate) fn find_allowed(
        function: &Function,
        reach: GroupReach,
        rewrites: &RewriteLimit,
    ) -> OperandGroups {
        let groups = OperandGroups::find(function, reach);
        let (mut absorbed, mut frozen) = (Vec::new(), Vec::new());
        for (root, node) in function.values() {
            let group = GroupFamily::of(node.operation).is_some() && !groups.is_absorbed(root);
            if !group || rewrites.allow(node.name, "group of terms or factors") {
                continue;
            }
            if frozen.is_empty() {
                frozen = vec![false; function.nodes().len()];
                absorbed = groups.absorbed.clone();
            }
            frozen[root.index()] = true;
            for inner in groups.inner(root) {
                frozen[inner.index()] = true;
                absorbed[inner.index()] = false;
            }
        }
        if frozen.is_empty() {
            groups
        } else {
            OperandGroups::read(function, absorbed, frozen)
        }
    }

    fn read(function: &Function, absorbed: Vec<bool>, frozen: Vec<bool>) -> OperandGroups {
        let count = function.nodes().len();
        assert_eq!(absorbed.len(), count, "every value is absorbed or not");
        assert!(
            frozen.is_empty() || frozen.len() == count,
            "all values may be frozen or none is"
        );
        let mut groups = OperandGroups {
            absorbed,
            frozen,
            leaves: Vec::with_capacity(count),
            inner: Vec::new(),
            starts: Vec::with_capacity(count + 1),
        };
        let mut open = Vec::new();
        for (value, node) in function.values() {
            groups.starts.push(groups.ends());
            let rewritten = !groups.is_absorbed(value) && !groups.is_frozen(value);
            if rewritten && GroupFamily::of(node.operation).is_some() {
                groups.collect(function, value, &mut open);
            }
        }
        groups.starts.push(groups.ends());
        groups
    }

    fn ends(&self) -> (u32, u32) {
        (self.leaves.len() as u32, self.inner.len() as u32)
    }

    /// True when the value is part of the group of its one user.
    pub(crate) fn is_absorbed(&self, value: Value) -> bool {
        self.absorbed[value.index()]
    }

    /// True when the operation of the value must not change.
    pub(crate) fn is_frozen(&self, value: Value) -> bool {
        !self.frozen.is_empty() && self.frozen[value.index()]
    }

    /// Terms or factors of the group of a value, left to right, without the
    /// zeros of a sum.
    pub(crate) fn leaves(&self, root: Value) -> &[GroupLeaf] {
        let (start, end) = (self.starts[root.index()].0, self.starts[root.index() + 1].0);
        &self.leaves[start as usize..end as usize]
    }

    /// The values absorbed into the group of a value.
    pub(crate) fn inner(&self, root: Value) -> &[Value] {
        let (start, end) = (self.starts[root.index()].1, self.starts[root.index() + 1].1);
        &self.inner[start as usize..end as usize]
    }

    /// Collects the group of a value.
    fn collect(&mut self, function: &Function, root: Value, open: &mut Vec<GroupLeaf>) {
        let node = function.node(root);
        let is_sum = GroupFamily::of(node.operation) == Some(GroupFamily::Sum);
        let inner = |operand: Operand| operand.value().filter(|&value| self.is_absorbed(value));
        // Most groups are one operation.
        if !node
            .operands
            .iter()
            .any(|&operand| inner(operand).is_some())
        {
            for leaf in operands_of(node, false) {
                self.leaf(function, is_sum, leaf);
            }
            return;
        }
        open.extend(operands_of(node, false).rev());
        while let Some(leaf) = open.pop() {
            let absorbed = leaf.operand.value();
            let absorbed = absorbed.filter(|&value| self.is_absorbed(value));
            let Some(value) = absorbed else {
                self.leaf(function, is_sum, leaf);
                continue;
            };
            self.inner.push(value);
            open.extend(operands_of(function.node(value), leaf.negative).rev());
        }
    }

    /// Adds a leaf, unless it is a zero of a sum.
    fn leaf(&mut self, function: &Function, is_sum: bool, leaf: GroupLeaf) {
        if !(is_sum && function.number(leaf.operand) == Some(0.0)) {
            self.leaves.push(leaf);
        }
    }
}

/// The operands of a sum or product as terms or factors, left to right; with
/// other signs when it is itself subtracted.
fn operands_of(
    node: &Node,
    negative: bool,
) -> impl DoubleEndedIterator<Item = GroupLeaf> + ExactSizeIterator + '_ {
    let operands = node.operands().iter().enumerate();
    operands.map(move |(side, &operand)| {
        let minus = match node.operation {
            Operation::Sub => side == 1,
            Operation::Neg => true,
            _ => false,
        };
        GroupLeaf {
            operand,
            negative: negative ^ minus,
        }
    })
}

/// For each value whether it is part of the group of its one user.
fn absorbed(function: &Function, reach: GroupReach) -> Vec<bool> {
    let mut absorbed = vec![false; function.nodes().len()];
    if reach == GroupReach::Operation {
        return absorbed;
    }
    let uses = function.use_counts();
    for node in function.nodes() {
        let Some(family) = GroupFamily::of(node.operation) else {
            continue;
        };
        let minus = is_minus(function, node.operation, node.operands[0]);
        for (side, operand) in node.operands().iter().enumerate() {
            let Some(value) = operand.value() else {
                continue;
            };
            let only_use = uses[value.index()] == 1;
            let same = GroupFamily::of(function.node(value).operation) == Some(family);
            let reached = reach == GroupReach::Maximal || side == 0 || minus;
            absorbed[value.index()] = only_use && same && reached;
        }
    }
    absorbed
}

/// The product that an operand is, when it has no other reader.
pub(crate) fn single_product(function: &Function, uses: &[u32], operand: Operand) -> Option<Value> {
    let value = operand.value()?;
    let single = uses[value.index()] == 1;
    (single && function.node(value).operation == Operation::Mul).then_some(value)
}

/// True for `0 - x` and `-x`.
pub(crate) fn is_minus(function: &Function, operation: Operation, left: Operand) -> bool {
    match operation {
        Operation::Neg => true,
        Operation::Sub => function.number(left) == Some(0.0),
        _ => false,
    }
}
