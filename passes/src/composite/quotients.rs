//! Equality of values that are quotients.
//!
//! The network has a stand-in for the inverse of a divisor, so that values with
//! other divisors are different ones: nothing is cancelled that may vanish. Two
//! factorisations of a mass matrix divide by other pivots, all of them positive
//! for a system with masses. Here quotients are those of the fields.

use crate::factor::network::{Edge, FactorKind, FactorNetwork};
use robovec_ir::Input;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::field::{Field, PrimeField};

/// Points at which values are compared, each in two fields.
const POINTS: u64 = 4;

/// Tests pairs of edges for equality at random points of prime fields.
pub(super) fn equal(network: &FactorNetwork, pairs: &[[Edge; 2]]) -> Vec<bool> {
    let order = order(network, pairs);
    let mut equal = vec![true; pairs.len()];
    for field in (0..POINTS).flat_map(|seed| PrimeField::pair(seed, true)) {
        let values = values(network, &order, &field);
        for (equal, [made, old]) in equal.iter_mut().zip(pairs) {
            let [made, old] = [made, old].map(|edge| signed(&field, &values, *edge));
            *equal &= made == old && !PrimeField::is_undefined(made);
        }
    }
    equal
}

/// The nodes that edges depend on, operands first.
fn order(network: &FactorNetwork, pairs: &[[Edge; 2]]) -> Vec<usize> {
    let mut is_seen = vec![false; network.nodes.len()];
    let mut open: Vec<usize> = pairs.iter().flatten().map(|edge| edge.node()).collect();
    let mut order = Vec::new();
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut is_seen[node], true) {
            order.push(node);
            open.extend(network.nodes[node].operands.iter().map(|edge| edge.node()));
        }
    }
    order.sort_unstable_by_key(|&node| network.nodes[node].position);
    order
}

/// The values of nodes, by node.
fn values(network: &FactorNetwork, order: &[usize], field: &PrimeField) -> Vec<u64> {
    let mut values = vec![PrimeField::UNDEFINED; network.nodes.len()];
    for &place in order {
        let node = &network.nodes[place];
        let operands = node.operands.iter();
        let mut operands = operands.map(|&edge| signed(field, &values, edge));
        values[place] = match node.kind {
            FactorKind::Input(operand) => match operand.input() {
                Some(Input(input)) => field.input(u64::from(input)),
                None => PrimeField::UNDEFINED,
            },
            FactorKind::Constant(number) => field.literal(number),
            FactorKind::Sum => operands.fold(field.literal(0.0), |sum, part| field.add(sum, part)),
            FactorKind::Product => {
                operands.fold(field.literal(1.0), |product, part| field.mul(product, part))
            }
            FactorKind::Other(operation) => {
                let first = operands.next().expect("an operation has an operand");
                let second = operands.next().unwrap_or(first);
                field.apply(operation, [first, second, second])
            }
            FactorKind::Part(_) => PrimeField::UNDEFINED,
        };
    }
    values
}

fn signed(field: &PrimeField, values: &[u64], edge: Edge) -> u64 {
    let value = values[edge.node()];
    if edge.negative() {
        field.neg(value)
    } else {
        value
    }
}
