//! From a network back to a function of single operations.
//!
//! Sums and products become trees, the earliest operands first. Signs travel
//! as they do in [`crate::reassociate`]: a value may be stored with the wrong
//! sign, and only an output (or a root, or a value without a meaning) forces a
//! `0 - x`.

use super::network::{Edge, FactorKind, FactorNetwork, NodeOrigin};
use crate::sums::earliest::{TieOrder, join_earliest};
use robovec_analysis::critical_path::Weights;
use robovec_framework::rewrite::output_symbol;
use robovec_framework::trail::Notes;
use robovec_ir::{
    FreshNames, Function, Level, Name, Node, Operand, Operation, SourceSet, Symbol, Tables,
};
use std::cmp::Reverse;
use std::collections::HashMap;

/// Writes the live part of a network in the place of a function's body.
pub(crate) fn write(
    function: &Function,
    mut network: FactorNetwork,
    weights: &Weights,
    tables: &mut Tables,
    notes: &mut Notes,
) -> Function {
    let order = network.order();
    let merged = std::mem::take(&mut network.merged);
    let mut writer = FactorWriter {
        out: function.skeleton(Level::Atomic),
        names: function.fresh_names(),
        stored: vec![(Operand::NONE, false); network.nodes.len()],
        arrivals: Vec::new(),
        negated: HashMap::new(),
        weights: *weights,
        network: &network,
    };
    let wishes = writer.wishes(&order);
    let mut parts = MergedParts::new(&network, merged);
    for &node in &order {
        let mut naming = parts.naming(&network, node, tables);
        let made = writer.node(node as usize, wishes[node as usize], &mut naming);
        if let (Some(rule), Some(value)) = (network.nodes[node as usize].rule, made.0.value()) {
            notes.note(writer.out.node(value).name, rule);
        }
        writer.stored[node as usize] = made;
    }
    writer.outputs(function, tables);
    writer.out
}

/// The names and sources of the values that became part of others.
struct MergedParts {
    merged: Vec<(u32, NodeOrigin)>,
}

impl MergedParts {
    fn new(network: &FactorNetwork, mut merged: Vec<(u32, NodeOrigin)>) -> MergedParts {
        let mut heirs: Vec<u32> = (0..network.nodes.len() as u32).collect();
        for node in 0..heirs.len() {
            let mut chain = Vec::new();
            let mut heir = node as u32;
            while let FactorKind::Part(user) = network.nodes[heir as usize].kind {
                if heirs[heir as usize] != heir {
                    heir = heirs[heir as usize];
                    break;
                }
                chain.push(heir);
                heir = user;
            }
            for part in chain {
                heirs[part as usize] = heir;
            }
        }
        for (user, _) in &mut merged {
            *user = heirs[*user as usize];
        }
        merged.retain(|(user, _)| network.nodes[*user as usize].uses > 0);
        merged.sort_by_key(|(user, _)| *user);
        MergedParts { merged }
    }

    fn naming(&mut self, network: &FactorNetwork, node: u32, tables: &mut Tables) -> NodeNaming {
        let own = &network.nodes[node as usize];
        let start = self.merged.partition_point(|(user, _)| *user < node);
        let end = self.merged.partition_point(|(user, _)| *user <= node);
        let mut sets = vec![own.sources];
        let mut spare = Vec::new();
        let mut root = own.name;
        for (_, origin) in &self.merged[start..end] {
            if !sets.contains(&origin.sources) || sets.len() > 8 {
                sets.push(origin.sources);
            }
            if !origin.name.is_none() {
                spare.push(origin.name);
            }
        }
        spare.sort_unstable_by_key(|&name| Reverse(name));
        spare.dedup();
        if root.is_none()
            && let Some(name) = spare.pop()
        {
            root = name;
        }
        spare.retain(|name| name.suffix > 0);
        NodeNaming {
            root,
            spare,
            owner: own.owner,
            sources: tables.sources.union(&sets),
        }
    }
}

/// Names and sources for the operations of one node.
struct NodeNaming {
    root: Name,
    /// Of values that were merged into it, last first.
    spare: Vec<Name>,
    owner: Symbol,
    sources: SourceSet,
}

struct FactorWriter<'n> {
    out: Function,
    names: FreshNames,
    /// For each node the operand it is stored in, and whether negated.
    stored: Vec<(Operand, bool)>,
    arrivals: Vec<u32>,
    negated: HashMap<Operand, Operand>,
    weights: Weights,
    network: &'n FactorNetwork,
}

/// An operand of a sum or product while the tree is built.
#[derive(Clone, Copy)]
struct TreeOperand {
    operand: Operand,
    negative: bool,
    arrival: u32,
}

impl FactorWriter<'_> {
    /// The sign each node had better be stored with: true for negated. Only
    /// outputs ask, and what cannot choose hands the wish to an operand.
    fn wishes(&self, order: &[u32]) -> Vec<Option<bool>> {
        let mut wishes: Vec<Option<bool>> = vec![None; self.network.nodes.len()];
        for edge in &self.network.outputs {
            wishes[edge.node()] = Some(edge.negative());
        }
        for &node in order.iter().rev() {
            let Some(wish) = wishes[node as usize] else {
                continue;
            };
            let node = &self.network.nodes[node as usize];
            let mixed = node.operands.iter().any(|edge| edge.negative())
                && !node.operands.iter().all(|edge| edge.negative());
            let natural = match node.kind {
                FactorKind::Sum if mixed => continue,
                FactorKind::Sum => node.operands.iter().all(|edge| edge.negative()),
                FactorKind::Product => false,
                _ => continue,
            };
            if natural == wish {
                continue;
            }
            let able = |edge: &&Edge| {
                let operand = &self.network.nodes[edge.node()];
                let signs = || operand.operands.iter().map(|edge| edge.negative());
                operand.kind == FactorKind::Sum
                    && wishes[edge.node()].is_none()
                    && signs().any(|negative| negative)
                    && !signs().all(|negative| negative)
            };
            if let Some(edge) = node.operands.iter().find(able) {
                wishes[edge.node()] = Some(true);
            }
        }
        wishes
    }

    fn node(
        &mut self,
        node: usize,
        wish: Option<bool>,
        naming: &mut NodeNaming,
    ) -> (Operand, bool) {
        let node = &self.network.nodes[node];
        match node.kind {
            FactorKind::Input(operand) => (operand, false),
            FactorKind::Constant(number) => (self.out.constant(number).into(), false),
            FactorKind::Sum | FactorKind::Product => {
                let sum = node.kind == FactorKind::Sum;
                self.tree(sum, &node.operands, wish == Some(true), naming)
            }
            FactorKind::Other(operation) => self.other(operation, &node.operands, naming),
            // Parts have no uses, so they are not in the order.
            FactorKind::Part(_) => (Operand::NONE, false),
        }
    }

    fn term(&self, edge: Edge) -> TreeOperand {
        let (operand, negative) = self.stored[edge.node()];
        TreeOperand {
            operand,
            negative: negative ^ edge.negative(),
            arrival: self.arrival(operand),
        }
    }

    fn arrival(&self, operand: Operand) -> u32 {
        operand
            .value()
            .map_or(0, |value| self.arrivals[value.index()])
    }

    fn push(
        &mut self,
        operation: Operation,
        operands: [Operand; 2],
        last: bool,
        naming: &mut NodeNaming,
    ) -> Operand {
        let name = match (last, naming.root.is_none(), naming.spare.pop()) {
            (true, false, spare) => {
                naming.spare.extend(spare);
                naming.root
            }
            (_, _, Some(spare)) => spare,
            (_, _, None) => self.names.fresh(naming.owner),
        };
        let ready = self.arrival(operands[0]).max(self.arrival(operands[1]));
        self.arrivals
            .push(ready.saturating_add(self.weights.of(operation)));
        let value = self.out.push(Node {
            name,
            sources: naming.sources,
            operands: Operand::list(operands),
            operation,
        });
        value.into()
    }

    fn tree(
        &mut self,
        sum: bool,
        operands: &[Edge],
        flip: bool,
        naming: &mut NodeNaming,
    ) -> (Operand, bool) {
        let terms = operands.iter().map(|&edge| self.term(edge)).collect();
        let arrival = |term: &TreeOperand| term.arrival;
        let tree = join_earliest(terms, TieOrder::Made, arrival, |[a, b], last| {
            let (operation, operands, negative) = if sum {
                join(a, b, flip && last)
            } else {
                let negative = a.negative ^ b.negative;
                (Operation::Mul, [a.operand, b.operand], negative)
            };
            let operand = self.push(operation, operands, last, naming);
            TreeOperand {
                operand,
                negative,
                arrival: self.arrival(operand),
            }
        });
        let root = tree.expect("a sum or product has operands");
        (root.operand, root.negative)
    }

    fn other(
        &mut self,
        operation: Operation,
        operands: &[Edge],
        naming: &mut NodeNaming,
    ) -> (Operand, bool) {
        let a = self.term(operands[0]);
        let b = operands.get(1).map_or(
            TreeOperand {
                operand: Operand::NONE,
                negative: false,
                arrival: 0,
            },
            |&edge| self.term(edge),
        );
        let negative = match operation {
            Operation::Mul | Operation::Div => a.negative ^ b.negative,
            Operation::Sin => a.negative,
            Operation::Cos => false,
            _ => {
                let operands = [a, b].map(|term| self.true_sign(term, naming));
                return (self.push(operation, operands, true, naming), false);
            }
        };
        let operands = [a.operand, b.operand];
        (self.push(operation, operands, true, naming), negative)
    }

    fn true_sign(&mut self, term: TreeOperand, naming: &mut NodeNaming) -> Operand {
        if !term.negative {
            return term.operand;
        }
        if let Some(number) = self.out.number(term.operand) {
            return self.out.constant(-number).into();
        }
        if let Some(&known) = self.negated.get(&term.operand) {
            return known;
        }
        let zero = self.out.constant(0.0).into();
        let negated = self.push(Operation::Sub, [zero, term.operand], false, naming);
        self.negated.insert(term.operand, negated);
        negated
    }

    fn outputs(&mut self, function: &Function, tables: &mut Tables) {
        let mut assignments = function.assignments.clone();
        for (assignment, &edge) in assignments.iter_mut().zip(&self.network.outputs) {
            let mut naming = NodeNaming {
                root: Name::NONE,
                spare: Vec::new(),
                owner: output_symbol(tables, function, assignment.output),
                sources: assignment.sources,
            };
            let term = match self.network.nodes[edge.node()].kind {
                FactorKind::Input(operand) => TreeOperand {
                    operand,
                    negative: edge.negative(),
                    arrival: 0,
                },
                _ => self.term(edge),
            };
            assignment.operand = self.true_sign(term, &mut naming);
        }
        self.out.assignments = assignments;
    }
}

/// The operation that joins two terms, and the sign of its result; `flip`
/// chooses the negated form where both cost the same.
fn join(a: TreeOperand, b: TreeOperand, flip: bool) -> (Operation, [Operand; 2], bool) {
    match (a.negative, b.negative) {
        (false, false) => (Operation::Add, [a.operand, b.operand], false),
        (true, true) => (Operation::Add, [a.operand, b.operand], true),
        (false, true) if flip => (Operation::Sub, [b.operand, a.operand], true),
        (false, true) => (Operation::Sub, [a.operand, b.operand], false),
        (true, false) if flip => (Operation::Sub, [a.operand, b.operand], true),
        (true, false) => (Operation::Sub, [b.operand, a.operand], false),
    }
}
