//! The worth of superwords in instructions.

use super::Superwords;
use super::graph::DataGraph;
use robovec_ir::Operand;

/// Maximum number of rounds in which superwords are taken apart.
const ROUNDS: usize = 8;

/// Takes superwords apart that need more instructions than their operations
/// one by one, until none does.
pub(super) fn prune(graph: &DataGraph<'_>, words: &mut Superwords) {
    for _ in 0..ROUNDS {
        let mut is_done = true;
        for number in 0..words.words.len() {
            if is_whole(words, number) && cost(graph, words, number) > words.lanes {
                is_done = false;
                for &item in &words.words[number].items {
                    words.places[graph.item(item).expect("a value")] = None;
                }
            }
        }
        if is_done {
            break;
        }
    }
}

/// True if a superword computes.
pub(super) fn is_useful(words: &Superwords) -> bool {
    (0..words.words.len()).any(|number| is_whole(words, number))
}

/// True for superwords that compute and were not taken apart.
fn is_whole(words: &Superwords, number: usize) -> bool {
    let word = &words.words[number];
    word.operation.is_some() && words.place(word.items[0]).is_some()
}

/// Instructions of a superword: its operation, those that gather operands and
/// those that take lanes out.
fn cost(graph: &DataGraph<'_>, words: &Superwords, number: usize) -> usize {
    let word = &words.words[number];
    let gathered = word
        .operands
        .iter()
        .map(|operands| gathers(words, operands));
    let taken = (word.items.iter().enumerate()).filter(|&(lane, &item)| {
        // The first lane is a number as it is.
        lane > 0 && !is_read_in_lane(graph, words, item, lane)
    });
    1 + gathered.sum::<usize>() + taken.count()
}

/// Instructions that put the operands of lanes into one vector. Constants are
/// in memory as vectors, and a number in all lanes is read as such.
fn gathers(words: &Superwords, operands: &[Operand]) -> usize {
    let is_constant = |operand: &Operand| operand.constant().is_some();
    let is_same = operands.iter().all(|operand| *operand == operands[0]);
    if is_same || operands.iter().all(is_constant) || words.word_of(operands).is_some() {
        return 0;
    }
    operands.len() - 1
}

/// True if every reader of an item is in a superword, in the lane of the item.
fn is_read_in_lane(graph: &DataGraph<'_>, words: &Superwords, item: Operand, lane: usize) -> bool {
    let item = graph.item(item).expect("a value");
    let mut users = graph.users(item).iter();
    users.all(|&user| words.computing(user).is_some_and(|(_, own)| own == lane))
}

/// Approximate number of instructions of the function with these superwords.
pub(super) fn instructions(graph: &DataGraph<'_>, words: &Superwords) -> usize {
    let whole = (0..words.words.len()).filter(|&number| is_whole(words, number));
    let (count, costs) = whole.fold((0, 0), |(count, costs), number| {
        (count + 1, costs + cost(graph, words, number))
    });
    graph.operations() - count * words.lanes + costs
}
