//! From a network back to a function of single operations.
//!
//! Sums and products become trees, the earliest operands first; only an output
//! (or a root, or a value without a meaning) forces a `0 - x`.

use super::network::{Edge, FactorKind, FactorNetwork, NodeOrigin};
use crate::sums::earliest::TieOrder;
use crate::sums::groups::GroupFamily;
use crate::sums::writer::{SignedOperand, SumWriter, ValueNaming};
use robovec_analysis::critical_path::Weights;
use robovec_framework::trail::Notes;
use robovec_ir::{Function, Level, Name, Operation, Tables};

/// Writes the live part of a network instead of a function's body.
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
        writer: SumWriter::new(function, Level::Atomic, *weights),
        stored: vec![SignedOperand::NONE; network.nodes.len()],
        network: &network,
    };
    let wishes = writer.wishes(&order);
    let parts = MergedParts::new(&network, merged);
    for &node in &order {
        let mut naming = parts.naming(&network, node, tables);
        let made = writer.node(node as usize, wishes[node as usize], &mut naming);
        if let (Some(rule), Some(value)) = (network.nodes[node as usize].rule, made.operand.value())
        {
            notes.note(writer.writer.out.node(value).name, rule);
        }
        writer.stored[node as usize] = made;
    }
    writer.finish(function, tables)
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

    fn naming(&self, network: &FactorNetwork, node: u32, tables: &mut Tables) -> ValueNaming {
        let own = &network.nodes[node as usize];
        let start = self.merged.partition_point(|(user, _)| *user < node);
        let end = self.merged.partition_point(|(user, _)| *user <= node);
        let parts = self.merged[start..end].iter();
        let parts = parts.map(|(_, origin)| (origin.name, origin.sources));
        let mut root = own.name;
        if root.is_none() {
            // By their texts, as in `with_parts`.
            let symbols = &tables.symbols;
            let text = |name: &Name| (symbols.text(name.base), name.suffix);
            let names = parts.clone().map(|(name, _)| name);
            let names = names.filter(|name| !name.is_none());
            root = names.min_by(|a, b| text(a).cmp(&text(b))).unwrap_or(root);
        }
        ValueNaming::new(root, own.owner, own.sources).with_parts(parts, tables)
    }
}

struct FactorWriter<'n> {
    writer: SumWriter,
    /// For each node the operand that stores it.
    stored: Vec<SignedOperand>,
    network: &'n FactorNetwork,
}

impl FactorWriter<'_> {
    /// The sign each node had better be stored with: true for negated. Only
    /// outputs have a wish, and an operation without a choice passes it to an
    /// operand.
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

    fn node(&mut self, node: usize, wish: Option<bool>, naming: &mut ValueNaming) -> SignedOperand {
        let node = &self.network.nodes[node];
        let family = match node.kind {
            FactorKind::Input(operand) => return self.writer.signed(operand, false),
            FactorKind::Constant(number) => return self.writer.number(number),
            FactorKind::Other(operation) => return self.other(operation, &node.operands, naming),
            // Parts have no uses, so they are not in the order.
            FactorKind::Part(_) => return SignedOperand::NONE,
            FactorKind::Sum => GroupFamily::Sum,
            FactorKind::Product => GroupFamily::Product,
        };
        let terms = node.operands.iter().map(|&edge| self.term(edge)).collect();
        let order = (TieOrder::Made, wish == Some(true));
        self.writer.tree(family, terms, order, naming)
    }

    fn term(&self, edge: Edge) -> SignedOperand {
        self.stored[edge.node()].flip(edge.negative())
    }

    fn other(
        &mut self,
        operation: Operation,
        operands: &[Edge],
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        let a = self.term(operands[0]);
        let b = operands.get(1).map(|&edge| self.term(edge));
        let b = b.unwrap_or(SignedOperand::NONE);
        let mut pair = [a.operand, b.operand];
        let negative = match operation {
            Operation::Mul | Operation::Div => a.negative ^ b.negative,
            Operation::Sin => a.negative,
            Operation::Cos => false,
            _ => {
                pair = [a, b].map(|term| self.writer.true_sign(term, naming));
                false
            }
        };
        let operand = self.writer.push(operation, pair, true, naming);
        self.writer.signed(operand, negative)
    }

    fn finish(mut self, function: &Function, tables: &mut Tables) -> Function {
        let (network, stored) = (self.network, &self.stored);
        self.writer.outputs(function, tables, |writer, place| {
            let edge = network.outputs[place];
            let stored = match network.nodes[edge.node()].kind {
                FactorKind::Input(operand) => writer.signed(operand, false),
                _ => stored[edge.node()],
            };
            stored.flip(edge.negative())
        });
        self.writer.finish(tables).0
    }
}
