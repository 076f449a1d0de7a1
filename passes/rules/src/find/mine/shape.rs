//! Shapes: windows without the names of their operands.
//!
//! Two windows have one shape when they differ only in the order of operands of
//! sums and products and in their leaves, where equal leaves of the one are
//! equal in the other. A window inside another is a window too, so the common
//! part of two places of a program (their least general term) is among the
//! shapes of both.

use super::super::super::pattern::{Pattern, PatternNode};
use robovec_ir::{Function, Operand, OperandKind, Operation, Value};

/// Maximum number of variables of a shape; the angle has the next number.
pub(super) const VARIABLES: u32 = 9;

/// Nodes of the tree of a window, at most; shared values are in it more
/// than once.
const LARGEST_TREE: usize = 40;

/// Numbers that are distinguished; any other one could be another one elsewhere
/// and counts as a value.
const NUMBERS: [f64; 4] = [-1.0, 0.0, 1.0, 2.0];

/// A leaf of a window.
#[derive(Clone, Copy, PartialEq, Debug)]
enum ShapeLeaf {
    Number(f64),
    Value(Operand),
    /// Sine or cosine of an angle: the operation, its angle, and its value.
    Turn(Operation, Operand, Operand),
}

#[derive(Clone, Copy)]
enum TreeNode {
    Leaf(ShapeLeaf),
    Operation(Operation, [usize; 2]),
}

/// A window as a term in normal form.
pub(super) struct WindowTerm {
    pub(super) pattern: Pattern,
    pub(super) variables: Vec<Operand>,
    pub(super) angle: Option<Operand>,
}

impl WindowTerm {
    /// The window as a term; `None` when it has too many leaves.
    pub(super) fn of(function: &Function, window: &[Value]) -> Option<WindowTerm> {
        let (nodes, hashes) = tree(function, window)?;
        let mut term = WindowTerm {
            pattern: Pattern::default(),
            variables: Vec::new(),
            angle: None,
        };
        term.write(&nodes, &hashes, 0)?;
        Some(term)
    }

    /// Writes a node and its subtree. As deep as the window is large.
    fn write(&mut self, nodes: &[TreeNode], hashes: &[u64], place: usize) -> Option<u32> {
        match nodes[place] {
            TreeNode::Leaf(ShapeLeaf::Number(number)) => {
                Some(self.pattern.push(PatternNode::Number(number)))
            }
            TreeNode::Leaf(ShapeLeaf::Value(operand)) => {
                let known = self.variables.iter().position(|&other| other == operand);
                let variable = known.unwrap_or(self.variables.len());
                if known.is_none() {
                    if variable == VARIABLES as usize {
                        return None;
                    }
                    self.variables.push(operand);
                }
                Some(self.pattern.push(PatternNode::Variable(variable as u32)))
            }
            TreeNode::Leaf(ShapeLeaf::Turn(operation, angle, _)) => {
                self.angle = Some(angle);
                let angle = self.pattern.push(PatternNode::Variable(VARIABLES));
                Some(self.pattern.operation(operation, &[angle]))
            }
            TreeNode::Operation(operation, [a, b]) => {
                if operation.arity() == 1 {
                    let operand = self.write(nodes, hashes, a)?;
                    return Some(self.pattern.operation(operation, &[operand]));
                }
                let swap = operation.is_commutative() && hashes[b] < hashes[a];
                let (a, b) = if swap { (b, a) } else { (a, b) };
                let first = self.write(nodes, hashes, a)?;
                let second = self.write(nodes, hashes, b)?;
                Some(self.pattern.operation(operation, &[first, second]))
            }
        }
    }
}

/// A hash of a few numbers, the same on every machine.
fn mixed(parts: &[u64]) -> u64 {
    parts.iter().fold(0x9e37_79b9_7f4a_7c15, |hash: u64, part| {
        let hash = (hash ^ part).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (hash ^ (hash >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb)
    })
}

/// The tree of a window, its root first, and for every node a hash that does
/// not depend on the order of operands: of the operations and, for each leaf,
/// of the paths from the root to it.
fn tree(function: &Function, window: &[Value]) -> Option<(Vec<TreeNode>, Vec<u64>)> {
    let mut nodes: Vec<TreeNode> = Vec::new();
    let mut ways: Vec<u64> = Vec::new();
    // What is to be written, the way to it, and where it is an operand.
    let mut open = vec![(Operand::from(window[0]), 0, None)];
    while let Some((operand, way, user)) = open.pop() {
        let place = nodes.len();
        if place == LARGEST_TREE {
            return None;
        }
        if let Some((user, side)) = user
            && let TreeNode::Operation(_, operands) = &mut nodes[user]
        {
            operands[side] = place;
        }
        ways.push(way);
        let inner = operand.value().filter(|value| window.contains(value));
        let Some(value) = inner else {
            nodes.push(TreeNode::Leaf(leaf(function, operand)));
            continue;
        };
        let node = function.node(value);
        nodes.push(TreeNode::Operation(node.operation, [place; 2]));
        for (side, &operand) in node.operands().iter().enumerate() {
            let turn = if node.operation.is_commutative() {
                0
            } else {
                side as u64
            };
            let way = mixed(&[way, node.operation as u64, turn]);
            open.push((operand, way, Some((place, side))));
        }
    }
    only_pairs(&mut nodes);
    let labels = labels(&nodes, &ways);
    let mut hashes = vec![0; nodes.len()];
    for (place, node) in nodes.iter().enumerate().rev() {
        hashes[place] = match *node {
            TreeNode::Leaf(_) => labels[place],
            TreeNode::Operation(operation, [a, b]) => {
                let mut below = [hashes[a], hashes[b]];
                if operation.is_commutative() {
                    below.sort_unstable();
                }
                mixed(&[operation as u64, below[0], below[1]])
            }
        };
    }
    Some((nodes, hashes))
}

/// For each leaf a hash of its kind and of all paths to it.
fn labels(nodes: &[TreeNode], ways: &[u64]) -> Vec<u64> {
    assert_eq!(nodes.len(), ways.len(), "every node has its ways");
    let label = |node: &TreeNode| {
        let TreeNode::Leaf(leaf) = node else {
            return 0;
        };
        let same = nodes
            .iter()
            .zip(ways)
            .filter(|(other, _)| matches!(other, TreeNode::Leaf(other) if other == leaf));
        let ways = same.fold(0u64, |sum, (_, way)| sum.wrapping_add(mixed(&[*way])));
        match leaf {
            ShapeLeaf::Number(number) => mixed(&[1, number.to_bits()]),
            ShapeLeaf::Value(_) => mixed(&[2, ways]),
            ShapeLeaf::Turn(operation, ..) => mixed(&[3, *operation as u64, ways]),
        }
    };
    nodes.iter().map(label).collect()
}

fn leaf(function: &Function, operand: Operand) -> ShapeLeaf {
    match operand.kind() {
        OperandKind::Constant(constant) => {
            let number = function.constant_number(constant);
            match NUMBERS.contains(&number) {
                // Zero has no sign here.
                true => ShapeLeaf::Number(number + 0.0),
                false => ShapeLeaf::Value(operand),
            }
        }
        OperandKind::Value(value) => {
            let node = function.node(value);
            if node.operation.is_trigonometric() {
                ShapeLeaf::Turn(node.operation, node.operands[0], operand)
            } else {
                ShapeLeaf::Value(operand)
            }
        }
        OperandKind::Input(_) | OperandKind::None => ShapeLeaf::Value(operand),
    }
}

/// Makes values of all sines and cosines but those of the first angle of which
/// both occur: no identity holds for one of them alone.
fn only_pairs(nodes: &mut [TreeNode]) {
    let turns: Vec<(Operation, Operand)> = nodes
        .iter()
        .filter_map(|node| match node {
            TreeNode::Leaf(ShapeLeaf::Turn(operation, angle, _)) => Some((*operation, *angle)),
            _ => None,
        })
        .collect();
    let pair = turns.iter().find(|(operation, angle)| {
        let other = |turn: &&(Operation, Operand)| turn.0 != *operation && turn.1 == *angle;
        turns.iter().any(|turn| other(&turn))
    });
    let pair = pair.map(|(_, angle)| *angle);
    for node in nodes {
        if let TreeNode::Leaf(leaf) = node
            && let ShapeLeaf::Turn(_, angle, itself) = *leaf
            && Some(angle) != pair
        {
            *leaf = ShapeLeaf::Value(itself);
        }
    }
}
