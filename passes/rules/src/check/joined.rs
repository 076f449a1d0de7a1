//! A rule of one direction as one list of nodes, evaluated in prime fields.

use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::{Requirement, Rule};
use super::field::{RuleField, RuleResidue};
use robovec_ir::Operation;

/// Both sides of a rule, one after the other, with the fields for its
/// judgement.
#[derive(Clone, Debug)]
pub(super) struct Joined<'a> {
    pub(super) rule: &'a Rule,
    /// The nodes of the left side, then those of the right side.
    pub(super) pattern: Pattern,
    /// The number of nodes of the left side.
    pub(super) left: usize,
    /// For each variable whether it must be positive.
    pub(super) positive: Vec<bool>,
    pub(super) fields: [RuleField; 2],
}

impl<'a> Joined<'a> {
    /// The rule, without its way back. The fields are drawn from the rule
    /// itself, so that no rule can be written to suit them.
    pub(super) fn new(rule: &'a Rule) -> Joined<'a> {
        let mut pattern = rule.left.clone();
        let left = pattern.nodes.len();
        let shift = left as u32;
        pattern
            .nodes
            .extend(rule.right.nodes.iter().map(|node| match *node {
                PatternNode::Operation(operation, [a, b]) => {
                    PatternNode::Operation(operation, [a + shift, b + shift])
                }
                other => other,
            }));
        let positive = (0..rule.variables.len() as u32)
            .map(|variable| {
                let mut needed = rule.requirements(variable);
                needed.any(|requirement| requirement == Requirement::Positive)
            })
            .collect();
        Joined {
            fields: RuleField::pair(digest(&pattern)),
            rule,
            pattern,
            left,
            positive,
        }
    }

    /// The root of the left side and of the right side.
    pub(super) fn roots(&self) -> [usize; 2] {
        [self.left - 1, self.pattern.nodes.len() - 1]
    }

    /// The operands of the nodes of one operation, in a part of the nodes.
    pub(super) fn operands(
        &self,
        wanted: Operation,
        nodes: std::ops::Range<usize>,
    ) -> impl Iterator<Item = [usize; 2]> + '_ {
        let nodes = &self.pattern.nodes[nodes];
        nodes.iter().filter_map(move |node| match *node {
            PatternNode::Operation(operation, [a, b]) if operation == wanted => {
                Some([a as usize, b as usize])
            }
            _ => None,
        })
    }

    /// True when the operation occurs in a part of the nodes.
    pub(super) fn uses(&self, wanted: Operation, nodes: std::ops::Range<usize>) -> bool {
        self.operands(wanted, nodes).next().is_some()
    }

    /// A node with its operands.
    pub(super) fn part(&self, node: usize) -> Pattern {
        self.pattern.part(node)
    }

    /// The field of a point: the two take turns.
    pub(super) fn field(&self, point: u64) -> RuleField {
        self.fields[(point % 2) as usize].at(point)
    }

    /// All nodes at a point of a field.
    pub(super) fn values(&self, field: &RuleField) -> Vec<RuleResidue> {
        let inputs = field.inputs(&self.positive);
        self.pattern.evaluate_all(field, &inputs)
    }
}

/// A number that depends on every node.
fn digest(pattern: &Pattern) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |number: u64| {
        hash = (hash ^ number).wrapping_mul(0x0000_0100_0000_01b3);
        hash ^= hash >> 29;
    };
    for node in &pattern.nodes {
        match *node {
            PatternNode::Variable(variable) => add(u64::from(variable) << 2),
            PatternNode::Number(number) => add(number.to_bits() ^ 1),
            PatternNode::Operation(operation, [a, b]) => {
                add((operation as u64) << 2 | 2);
                add(u64::from(a) << 32 | u64::from(b));
            }
        }
    }
    hash
}
