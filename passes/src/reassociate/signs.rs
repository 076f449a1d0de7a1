//! The signs with which values should be stored.
//!
//! A sum with terms of both signs can be stored either way for nothing, all
//! other groups inherit their sign from their leaves. Going backwards from
//! the outputs, which need true signs, each group that would come out wrong
//! asks one leaf that can choose to be stored the other way. What cannot be
//! arranged costs a `0 - x` at the output later; the signs themselves are
//! tracked exactly while building, so a bad choice here is never wrong.

use crate::sums::groups::{GroupFamily, GroupLeaf, OperandGroups};
use robovec_ir::{Function, Operand, Operation, Value};

/// For each group root the sign it is asked to be stored with: true for
/// negated, `None` when nobody asks.
pub(super) struct Wishes(Vec<Option<bool>>);

impl Wishes {
    pub(super) fn of(&self, value: Value) -> Option<bool> {
        self.0[value.index()]
    }

    /// Asks for a sign.
    pub(super) fn ask(&mut self, value: Value, negative: bool) {
        self.0[value.index()] = Some(negative);
    }

    pub(super) fn find(function: &Function, groups: &OperandGroups) -> Wishes {
        let count = function.nodes().len();
        let mut wishes = Wishes(vec![None; count]);
        let natural = Natural::find(function, groups);
        for assignment in &function.assignments {
            if let Some(value) = assignment.operand.value() {
                wishes.0[value.index()] = Some(false);
            }
        }
        let mut operands = Vec::new();
        for (root, node) in function.values().rev() {
            let Some(wish) = wishes.of(root) else {
                continue;
            };
            if groups.is_absorbed(root) || natural.flippable_alone[root.index()] {
                continue;
            }
            if natural.negative[root.index()] == wish || !natural.flippable[root.index()] {
                continue;
            }
            let leaves = leaves_of(function, groups, root, node.operation, &mut operands);
            wishes.ask_one(&natural, leaves);
        }
        wishes
    }

    /// Asks the first leaf that can and that nobody has asked yet to change
    /// its sign.
    fn ask_one(&mut self, natural: &Natural, leaves: &[GroupLeaf]) {
        let asked = leaves
            .iter()
            .filter_map(|leaf| leaf.operand.value())
            .find(|value| natural.flippable[value.index()] && self.of(*value).is_none());
        if let Some(value) = asked {
            self.0[value.index()] = Some(!natural.negative[value.index()]);
        }
    }
}

/// The signs that come about when nobody asks for anything.
pub(super) struct Natural {
    pub(super) negative: Vec<bool>,
    /// The sign can be chosen, perhaps by asking a leaf.
    pub(super) flippable: Vec<bool>,
    /// The sign can be chosen without asking a leaf.
    pub(super) flippable_alone: Vec<bool>,
}

impl Natural {
    pub(super) fn find(function: &Function, groups: &OperandGroups) -> Natural {
        let count = function.nodes().len();
        let mut natural = Natural {
            negative: vec![false; count],
            flippable: vec![false; count],
            flippable_alone: vec![false; count],
        };
        let mut operands = Vec::new();
        for (root, node) in function.values() {
            if groups.is_absorbed(root) {
                continue;
            }
            let leaves = leaves_of(function, groups, root, node.operation, &mut operands);
            let signs = || {
                leaves
                    .iter()
                    .map(|leaf| leaf.negative ^ natural.sign(leaf.operand))
            };
            let odd = signs().filter(|&negative| negative).count() % 2 == 1;
            let all = !leaves.is_empty() && signs().all(|negative| negative);
            let none = !signs().any(|negative| negative);
            let by_leaf = leaves
                .iter()
                .filter_map(|leaf| leaf.operand.value())
                .any(|value| natural.flippable[value.index()]);
            let (negative, alone, flippable) = match node.operation {
                Operation::Add | Operation::Sub | Operation::Neg => {
                    let mixed = !all && !none;
                    (all, mixed, mixed || by_leaf)
                }
                Operation::Mul | Operation::Div | Operation::Sin | Operation::Copy => {
                    (odd, false, by_leaf)
                }
                Operation::Cos
                | Operation::Sqrt
                | Operation::Fma
                | Operation::Fms
                | Operation::Fnma => (false, false, false),
            };
            natural.negative[root.index()] = negative;
            natural.flippable_alone[root.index()] = alone;
            natural.flippable[root.index()] = flippable;
        }
        natural
    }

    fn sign(&self, operand: Operand) -> bool {
        operand
            .value()
            .is_some_and(|value| self.negative[value.index()])
    }
}

/// The leaves of a group, or the operands of any other operation.
fn leaves_of<'a>(
    function: &Function,
    groups: &'a OperandGroups,
    root: Value,
    operation: Operation,
    operands: &'a mut Vec<GroupLeaf>,
) -> &'a [GroupLeaf] {
    if GroupFamily::of(operation).is_some() {
        return groups.leaves(root);
    }
    operands.clear();
    operands.extend(
        function
            .node(root)
            .operands()
            .iter()
            .map(|&operand| GroupLeaf {
                operand,
                negative: false,
            }),
    );
    operands
}
