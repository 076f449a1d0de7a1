//! Windows: a value with the operations closest before it.

use super::super::adjoint::Tape;
use robovec_ir::Operation;
use std::collections::{BinaryHeap, HashMap};

/// The definition cone of a value, cut off after a number of operations.
///
/// Operations are added from the last to the first, so that everything outside
/// comes before everything inside: a leaf never depends on an operation of the
/// window.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ConeWindow {
    /// The slots that are read and not computed inside, in order.
    pub leaves: Vec<usize>,
    /// The nodes inside, in program order, without those that compute what an
    /// earlier one does (their errors are one and the same); the last one is the
    /// value. None for a value that is an input or a literal.
    pub nodes: Vec<usize>,
    /// For every node the places of its operands: leaves first, then nodes.
    pub(super) operands: Vec<[usize; 3]>,
}

impl ConeWindow {
    /// The window of a slot with at most this number of operations.
    pub fn new(tape: &Tape, root: usize, most: usize) -> ConeWindow {
        // Inputs and literals have the largest slots, though they come before
        // everything: only nodes are taken in order.
        let (mut open, mut nodes, mut leaves) = (BinaryHeap::new(), Vec::new(), Vec::new());
        let mut read = vec![root];
        loop {
            let is_node = |slot: &usize| *slot < tape.nodes();
            leaves.extend(read.iter().copied().filter(|slot| !is_node(slot)));
            open.extend(read.iter().copied().filter(is_node));
            read.clear();
            let Some(slot) = open.pop() else {
                break;
            };
            // Equal slots come out one after the other.
            while open.peek() == Some(&slot) {
                open.pop();
            }
            if nodes.len() < most {
                let arity = tape.operation(slot).arity();
                read.extend(&tape.operands(slot)[..arity]);
                nodes.push(slot);
            } else {
                leaves.push(slot);
            }
        }
        nodes.reverse();
        debug_assert!(
            nodes.is_sorted_by(|one, next| one < next),
            "the nodes of a window are in program order, each once"
        );
        leaves.sort_unstable();
        leaves.dedup();
        let mut computed: HashMap<(Operation, [usize; 3]), usize> = HashMap::new();
        let mut places_of_nodes = Vec::with_capacity(nodes.len());
        let (mut kept, mut operands) = (Vec::new(), Vec::new());
        for &node in &nodes {
            let operation = tape.operation(node);
            let mut places = [0; 3];
            let read = &tape.operands(node)[..operation.arity()];
            for (place, slot) in places.iter_mut().zip(read) {
                *place = match leaves.binary_search(slot) {
                    Ok(leaf) => leaf,
                    Err(_) => {
                        let inside = nodes.binary_search(slot);
                        let inside = inside.expect("what is read is a leaf or computed inside");
                        places_of_nodes[inside]
                    }
                };
            }
            let own = leaves.len() + kept.len();
            let place = match computed.get(&(operation, places)) {
                Some(&earlier) if node != root => earlier,
                _ => {
                    computed.insert((operation, places), own);
                    kept.push(node);
                    operands.push(places);
                    own
                }
            };
            places_of_nodes.push(place);
        }
        ConeWindow {
            leaves,
            nodes: kept,
            operands,
        }
    }
}
