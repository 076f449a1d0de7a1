//! Patterns: terms with variables, the two sides of a rule.
//!
//! Invariant: nodes are in post-order (operands before the operation, the
//! root last), so that everything that walks a pattern is a counting loop.

use robovec_ir::Operation;
use robovec_num::arithmetic::Arithmetic;

/// A node of a pattern.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum PatternNode {
    /// The variable of this number, counted from 0 in
    /// [`Rule::variables`](super::Rule::variables); it represents any value.
    Variable(u32),
    /// This number. Finite; minus zero is not distinguished from zero.
    Number(f64),
    /// An operation on earlier nodes of the pattern. Of an operation on one
    /// operand the second place repeats the first.
    Operation(Operation, [u32; 2]),
}

impl PatternNode {
    /// An operation on one or two earlier nodes.
    pub(super) fn of(operation: Operation, operands: &[u32]) -> PatternNode {
        let [first, .., last] = *operands else {
            return PatternNode::Operation(operation, [operands[0]; 2]);
        };
        PatternNode::Operation(operation, [first, last])
    }
}

/// A term with variables.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Pattern {
    /// The nodes in post-order, root last; never empty once read.
    pub nodes: Vec<PatternNode>,
}

impl Pattern {
    /// Most nodes a side of a rule may have; a larger one is a mistake.
    pub const LARGEST: usize = 200;

    /// Adds a node and returns its number.
    pub fn push(&mut self, node: PatternNode) -> u32 {
        if let PatternNode::Operation(_, operands) = node {
            let count = self.nodes.len();
            assert!(
                operands.iter().all(|&operand| (operand as usize) < count),
                "operands come before their operation"
            );
        }
        self.nodes.push(node);
        self.nodes.len() as u32 - 1
    }

    /// Adds an operation on one or two earlier nodes.
    pub fn operation(&mut self, operation: Operation, operands: &[u32]) -> u32 {
        self.push(PatternNode::of(operation, operands))
    }

    /// The number of the root.
    pub fn root(&self) -> usize {
        self.nodes
            .len()
            .checked_sub(1)
            .expect("a pattern has a root")
    }

    /// True for a pattern that is one variable, and so matches every value.
    pub fn is_variable(&self) -> bool {
        matches!(self.nodes[..], [PatternNode::Variable(_)])
    }

    /// The variables that occur, by rising number, each once.
    pub fn variables(&self) -> Vec<u32> {
        let mut variables: Vec<u32> = self
            .nodes
            .iter()
            .filter_map(|node| match node {
                PatternNode::Variable(variable) => Some(*variable),
                PatternNode::Number(_) | PatternNode::Operation(..) => None,
            })
            .collect();
        variables.sort_unstable();
        variables.dedup();
        variables
    }

    /// The operations that occur, in post-order.
    pub fn operations(&self) -> impl Iterator<Item = Operation> + '_ {
        self.nodes.iter().filter_map(|node| match node {
            PatternNode::Operation(operation, _) => Some(*operation),
            PatternNode::Variable(_) | PatternNode::Number(_) => None,
        })
    }

    /// For each node up to a given one whether that is computed from it, with
    /// itself.
    pub(super) fn needed(&self, node: usize) -> Vec<bool> {
        let nodes = &self.nodes;
        let mut needed = vec![false; node + 1];
        needed[node] = true;
        for index in (0..=node).rev() {
            if let (true, PatternNode::Operation(_, operands)) = (needed[index], nodes[index]) {
                for operand in operands {
                    needed[operand as usize] = true;
                }
            }
        }
        needed
    }

    /// A node with its operands.
    pub(super) fn part(&self, node: usize) -> Pattern {
        let nodes = &self.nodes;
        let needed = self.needed(node);
        let mut part = Pattern::default();
        let mut places = vec![0; node + 1];
        for index in (0..=node).filter(|&index| needed[index]) {
            places[index] = part.push(match nodes[index] {
                PatternNode::Operation(operation, operands) => {
                    PatternNode::Operation(operation, operands.map(|old| places[old as usize]))
                }
                leaf => leaf,
            });
        }
        part
    }

    /// The terms of which sines and cosines are taken.
    pub fn angles(&self) -> Vec<Pattern> {
        let angles = self.nodes.iter().filter_map(|node| match *node {
            PatternNode::Operation(Operation::Sin | Operation::Cos, [angle, _]) => Some(angle),
            _ => None,
        });
        angles.map(|angle| self.part(angle as usize)).collect()
    }

    /// True when an operation occurs.
    pub fn uses(&self, wanted: impl Fn(Operation) -> bool) -> bool {
        self.operations().any(wanted)
    }

    /// The values of all nodes when variable `i` has the value `values[i]`.
    pub fn evaluate_all<A: Arithmetic>(
        &self,
        arithmetic: &A,
        values: &[A::Number],
    ) -> Vec<A::Number> {
        let mut results: Vec<A::Number> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let value = match *node {
                PatternNode::Variable(variable) => values[variable as usize],
                PatternNode::Number(number) => arithmetic.literal(number),
                PatternNode::Operation(operation, [a, b]) => apply(
                    arithmetic,
                    operation,
                    results[a as usize],
                    results[b as usize],
                ),
            };
            results.push(value);
        }
        results
    }

    /// The value of the pattern when variable `i` has the value `values[i]`.
    ///
    /// # Panics
    ///
    /// Panics when the pattern is empty or has variables without values;
    /// patterns of a [`RuleSet`](super::RuleSet) are never empty.
    pub fn evaluate<A: Arithmetic>(&self, arithmetic: &A, values: &[A::Number]) -> A::Number {
        let all = self.evaluate_all(arithmetic, values);
        all[self.root()]
    }

    /// The pattern with its variables renumbered.
    #[must_use]
    pub fn renamed(&self, number: impl Fn(u32) -> u32) -> Pattern {
        let nodes = self.nodes.iter().map(|node| match *node {
            PatternNode::Variable(variable) => PatternNode::Variable(number(variable)),
            other => other,
        });
        Pattern {
            nodes: nodes.collect(),
        }
    }
}

/// An operation carried out.
pub(super) fn apply<A: Arithmetic>(
    arithmetic: &A,
    operation: Operation,
    a: A::Number,
    b: A::Number,
) -> A::Number {
    match operation {
        Operation::Copy => a,
        Operation::Neg => arithmetic.neg(a),
        Operation::Add => arithmetic.add(a, b),
        Operation::Sub => arithmetic.sub(a, b),
        Operation::Mul => arithmetic.mul(a, b),
        Operation::Div => arithmetic.div(a, b),
        Operation::Sin => arithmetic.sin(a),
        Operation::Cos => arithmetic.cos(a),
        Operation::Sqrt => arithmetic.sqrt(a),
        // No pattern has three operands; without its addend it is a product.
        Operation::Fma | Operation::Fms => arithmetic.mul(a, b),
        Operation::Fnma => arithmetic.neg(arithmetic.mul(a, b)),
    }
}
