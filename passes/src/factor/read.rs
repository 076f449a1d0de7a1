//! From a function to a network.

use super::network::{Edge, FactorKind, FactorNetwork, NodeOrigin};
use crate::sums::fused::apart;
use robovec_framework::fingerprint::Images;
use robovec_framework::rewrite::owners;
use robovec_ir::{Function, Name, Node, Operand, OperandKind, Operation, Tables};
use std::collections::HashMap;

/// The network of a function; on the `circle`, values are also equal that
/// need sin² + cos² = 1 for it.
pub(crate) fn read(function: &Function, tables: &mut Tables, circle: bool) -> FactorNetwork {
    let owners = owners(tables, function);
    let mut reader = FactorReader {
        network: FactorNetwork::new(Images::of(function, circle)),
        map: Vec::with_capacity(function.nodes().len()),
        inputs: HashMap::new(),
        function,
    };
    for (value, node) in function.values() {
        let origin = NodeOrigin {
            name: node.name,
            owner: owners[value.index()],
            sources: node.sources,
        };
        let before = reader.network.nodes.len();
        let edge = reader.operation(node, origin);
        if edge.node() < before {
            let merged = (edge.node() as u32, origin);
            reader.network.merged.push(merged);
        }
        reader.map.push(edge);
    }
    let outputs: Vec<Edge> = function
        .assignments
        .iter()
        .map(|assignment| reader.edge(assignment.operand))
        .collect();
    let mut network = reader.network;
    for &edge in &outputs {
        network.acquire(edge);
    }
    network.outputs = outputs;
    network
}

struct FactorReader<'a> {
    network: FactorNetwork,
    /// The edges that the values read so far have become.
    map: Vec<Edge>,
    inputs: HashMap<u32, Edge>,
    function: &'a Function,
}

impl FactorReader<'_> {
    fn edge(&mut self, operand: Operand) -> Edge {
        match operand.kind() {
            OperandKind::Value(value) => self.map[value.index()],
            OperandKind::Constant(constant) => {
                let number = self.function.constant_number(constant);
                self.network.constant(number)
            }
            OperandKind::Input(input) => {
                if let Some(&edge) = self.inputs.get(&input.0) {
                    return edge;
                }
                let value = self.network.values.images.input(input);
                let kind = FactorKind::Input(operand);
                let edge = self.network.push(kind, Vec::new(), value, NodeOrigin::NONE);
                self.inputs.insert(input.0, edge);
                edge
            }
            OperandKind::None => self.network.constant(0.0),
        }
    }

    fn operation(&mut self, node: &Node, origin: NodeOrigin) -> Edge {
        let operands: Vec<Edge> = node
            .operands()
            .iter()
            .map(|&operand| self.edge(operand))
            .collect();
        if node.operation.is_fused() {
            return self.fused(node.operation, &operands, origin);
        }
        self.single(node.operation, operands, origin)
    }

    /// A fused operation is taken apart, so that its parts can be shared.
    fn fused(&mut self, operation: Operation, operands: &[Edge], origin: NodeOrigin) -> Edge {
        let unnamed = NodeOrigin {
            name: Name::NONE,
            ..origin
        };
        let product = self.single(Operation::Mul, operands[..2].to_vec(), unnamed);
        let (operation, pair) = apart(operation, product, operands[2]);
        self.single(operation, pair.to_vec(), origin)
    }

    fn single(&mut self, operation: Operation, operands: Vec<Edge>, origin: NodeOrigin) -> Edge {
        let a = operands[0];
        let b = operands.get(1).copied().unwrap_or(a);
        let network = &mut self.network;
        if !operands
            .iter()
            .all(|edge| network.nodes[edge.node()].defined)
        {
            return Self::unknown(network, operation, operands, origin);
        }
        let value = match operation {
            Operation::Copy => return a,
            Operation::Neg => return a.flip(true),
            Operation::Add => return network.sum(&[a, b], origin),
            Operation::Sub => return network.sum(&[a, b.flip(true)], origin),
            Operation::Mul => return network.product(&[a, b], origin),
            _ => {
                let literal = matches!(network.nodes[b.node()].kind, FactorKind::Constant(_));
                let [x, y] = [a, b].map(|edge| network.value(edge));
                network.values.images.operate(operation, [x, y, y], literal)
            }
        };
        if value.is_undefined() {
            return Self::unknown(network, operation, operands, origin);
        }
        let kind = FactorKind::Other(operation);
        network.find_or_push(kind, operands, value, origin)
    }

    /// A value without a meaning: its operands may be rewritten, but not the
    /// operation.
    fn unknown(
        network: &mut FactorNetwork,
        operation: Operation,
        operands: Vec<Edge>,
        origin: NodeOrigin,
    ) -> Edge {
        let value = network.values.images.random(!(network.nodes.len() as u64));
        network.push_unknown(FactorKind::Other(operation), operands, value, origin)
    }
}
