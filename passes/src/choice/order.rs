//! One order for the values of several functions.

use crate::sums::values::ValueTable;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::DfsPostOrder;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_ir::Function;

/// For each function and each of its values the maximum number of operations
/// after it, for any function that computes its operands: the same number
/// wherever the value occurs, up to its sign.
///
/// Functions can contradict one another (`x = y - z` here, `y = x + z` there).
/// Then one of the two is not counted.
pub(super) fn common_levels(
    functions: &[&Function],
    values: &[Vec<Fingerprint>],
    images: &Images,
) -> Vec<Vec<u32>> {
    let mut table = ValueTable::new(*images);
    let mut graph: DiGraph<(), (), u32> = DiGraph::new();
    let mut places: Vec<Vec<u32>> = Vec::with_capacity(functions.len());
    for values in values {
        let places_of = values.iter().map(|&value| table.place(value).0).collect();
        places.push(places_of);
    }
    let count = places.iter().flatten().map(|&place| place + 1);
    let count = count.fold(0, u32::max);
    for _ in 0..count {
        graph.add_node(());
    }
    for (function, places) in functions.iter().zip(&places) {
        for (value, node) in function.values() {
            let user = NodeIndex::new(places[value.index()] as usize);
            for operand in node.values() {
                let operand = NodeIndex::new(places[operand.index()] as usize);
                graph.add_edge(user, operand, ());
            }
        }
    }
    let mut levels = vec![0_u32; count as usize];
    let mut is_done = vec![false; count as usize];
    let mut search = DfsPostOrder::empty(&graph);
    for root in graph.node_indices() {
        search.move_to(root);
        while let Some(node) = search.next(&graph) {
            let operands = graph.neighbors(node);
            let counted = operands.filter(|operand| is_done[operand.index()]);
            let highest = counted.map(|operand| levels[operand.index()]);
            levels[node.index()] = 1 + highest.fold(0, u32::max);
            is_done[node.index()] = true;
        }
    }
    for place in places.iter_mut().flatten() {
        *place = levels[*place as usize];
    }
    places
}
