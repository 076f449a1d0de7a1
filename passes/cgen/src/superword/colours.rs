//! Colours of values by their neighbourhoods (colour refinement).
//!
//! Before the first round the colour of a value is its kind of operation, that
//! of an input its array. Every round adds the colours of operands and readers.
//! Constants have no colour, and sums none for the sign or place of an operand:
//! the sides of a mechanism are mirrored, and differ in their numbers.

use super::Superwords;
use super::graph::{DataGraph, OperationClass};
use robovec_ir::Value;

/// Radius of the largest neighbourhood.
pub(super) const ROUNDS: usize = 14;

/// The colours of all items after every round.
pub(super) struct ItemColours {
    rounds: Vec<Vec<u64>>,
}

impl ItemColours {
    /// The colours of a graph in which all lanes of a superword look alike, and
    /// different from everything else.
    pub(super) fn new(graph: &DataGraph<'_>, words: &Superwords) -> ItemColours {
        let first = (0..graph.len()).map(|item| initial(graph, words, item));
        let mut rounds: Vec<Vec<u64>> = vec![first.collect()];
        for _ in 0..ROUNDS {
            let next = refined(graph, &rounds[rounds.len() - 1]);
            rounds.push(next);
        }
        ItemColours { rounds }
    }

    /// The colour of an item after a round.
    pub(super) fn of(&self, item: usize, round: usize) -> u64 {
        self.rounds[round][item]
    }

    /// Number of rounds after which two items still look alike; 0 also for
    /// items that never did.
    pub(super) fn likeness(&self, a: usize, b: usize) -> usize {
        let alike = self
            .rounds
            .iter()
            .rposition(|colours| colours[a] == colours[b]);
        alike.unwrap_or(0)
    }
}

fn initial(graph: &DataGraph<'_>, words: &Superwords, item: usize) -> u64 {
    let operand = graph.operand(item);
    if let Some((word, _)) = words.place(operand) {
        return mixed(1, word as u64);
    }
    match (operand.value(), operand.input()) {
        (Some(value), _) => mixed(2, kind(graph, value)),
        (None, input) => {
            let input = input.expect("an item is a value or an input");
            mixed(3, graph.function.input_array(input) as u64)
        }
    }
}

/// The kind of operation of a value as a number.
fn kind(graph: &DataGraph<'_>, value: Value) -> u64 {
    match graph.class(value) {
        Some(class) => class as u64,
        None => 16 + graph.function.node(value).operation as u64,
    }
}

/// The colours after one more round. What is read by several has the sum of
/// their contributions, so that their order plays no part.
fn refined(graph: &DataGraph<'_>, before: &[u64]) -> Vec<u64> {
    let mut below = vec![0u64; before.len()];
    let mut above = vec![0u64; before.len()];
    for (value, node) in graph.function.values() {
        let index = value.index();
        let is_ordered = !matches!(
            graph.class(value),
            Some(OperationClass::Sum | OperationClass::Product)
        );
        let own = before[index];
        let reads = if graph.is_loaded(value) {
            node.operands()
        } else {
            graph.reads(value)
        };
        for (place, &operand) in (1u64..).zip(reads) {
            let place = if is_ordered { place } else { 0 };
            match graph.item(operand) {
                Some(item) => {
                    below[index] = below[index].wrapping_add(mixed(place, before[item]));
                    above[item] = above[item].wrapping_add(mixed(place + 8, own));
                }
                None => below[index] = below[index].wrapping_add(mixed(place, 5)),
            }
        }
    }
    for assignment in &graph.function.assignments {
        if let Some(item) = graph.item(assignment.operand) {
            above[item] = above[item].wrapping_add(mixed(4, 4));
        }
    }
    let sides = below.iter().zip(&above);
    let all = before.iter().zip(sides);
    all.map(|(own, (below, above))| mixed(mixed(*own, *below), *above))
        .collect()
}

/// Two numbers as one without order or pattern (the finaliser of SplitMix64).
fn mixed(a: u64, b: u64) -> u64 {
    let mut bits = a
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(b)
        .wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}
