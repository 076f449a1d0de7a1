//! The signs with which values should be stored.
//!
//! A sum with terms of both signs can be given either sign at no cost; all
//! other groups inherit their sign from their leaves. Backwards from the
//! outputs, which need true signs, each group that would have the wrong sign
//! requests the other sign of one leaf that can choose. A sign that cannot be
//! absorbed costs a `0 - x` at the output later; the signs themselves are
//! tracked exactly while building, so a bad choice here is never wrong.

use crate::sums::groups::{GroupFamily, GroupLeaf, OperandGroups};
use robovec_ir::{Function, Operation, Value};

/// For each group root the requested sign: true for negated, `None` without a
/// request.
#[derive(Clone)]
pub(super) struct Wishes(Vec<Option<bool>>);

impl Wishes {
    pub(super) fn of(&self, value: Value) -> Option<bool> {
        self.0[value.index()]
    }

    pub(super) fn ask(&mut self, value: Value, negative: bool) {
        self.0[value.index()] = Some(negative);
    }

    pub(super) fn find(
        function: &Function,
        groups: &OperandGroups,
        natural: &NaturalSigns,
    ) -> Wishes {
        let count = function.nodes().len();
        let mut wishes = Wishes(vec![None; count]);
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
            let own = natural.of(root);
            if groups.is_absorbed(root) || own.flippable_alone {
                continue;
            }
            if own.negative == wish || !own.flippable {
                continue;
            }
            let leaves = leaves_of(function, groups, root, node.operation, &mut operands);
            wishes.ask_one(natural, leaves);
        }
        wishes
    }

    /// Requests a change of sign from the first leaf that can change and has no
    /// request yet.
    fn ask_one(&mut self, natural: &NaturalSigns, leaves: &[GroupLeaf]) {
        let asked = leaves
            .iter()
            .filter_map(|leaf| leaf.operand.value())
            .find(|value| natural.of(*value).flippable && self.of(*value).is_none());
        if let Some(value) = asked {
            self.0[value.index()] = Some(!natural.of(value).negative);
        }
    }
}

/// The sign without any request.
#[derive(Clone, Copy, Default)]
pub(super) struct NaturalSign {
    pub(super) negative: bool,
    /// The sign can be chosen, perhaps by a request to a leaf.
    pub(super) flippable: bool,
    /// The sign can be chosen without a request to a leaf.
    pub(super) flippable_alone: bool,
}

/// The natural sign of every value.
pub(super) struct NaturalSigns(Vec<NaturalSign>);

impl NaturalSigns {
    #[inline]
    pub(super) fn of(&self, value: Value) -> NaturalSign {
        self.0[value.index()]
    }

    pub(super) fn find(function: &Function, groups: &OperandGroups) -> NaturalSigns {
        let mut natural = NaturalSigns(vec![NaturalSign::default(); function.nodes().len()]);
        let mut operands = Vec::new();
        for (root, node) in function.values() {
            if groups.is_absorbed(root) {
                continue;
            }
            let leaves = leaves_of(function, groups, root, node.operation, &mut operands);
            let (mut negatives, mut by_leaf) = (0, false);
            for leaf in leaves {
                let of_leaf = leaf.operand.value().map(|value| natural.of(value));
                let of_leaf = of_leaf.unwrap_or_default();
                negatives += usize::from(leaf.negative ^ of_leaf.negative);
                by_leaf |= of_leaf.flippable;
            }
            let all = negatives > 0 && negatives == leaves.len();
            let mixed = negatives > 0 && negatives < leaves.len();
            let (negative, alone, flippable) = match node.operation {
                Operation::Add | Operation::Sub | Operation::Neg => (all, mixed, mixed || by_leaf),
                Operation::Mul | Operation::Div | Operation::Sin | Operation::Copy => {
                    (negatives % 2 == 1, false, by_leaf)
                }
                Operation::Cos
                | Operation::Sqrt
                | Operation::Fma
                | Operation::Fms
                | Operation::Fnma => (false, false, false),
            };
            natural.0[root.index()] = NaturalSign {
                negative,
                flippable,
                flippable_alone: alone,
            };
        }
        natural
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
