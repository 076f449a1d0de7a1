//! The growth of superwords from those of inputs.

use super::colours::ItemColours;
use super::graph::{DataGraph, OperationClass};
use super::seeds::gathered;
use super::{Superword, Superwords};
use robovec_ir::{Operand, Operation, Value};
use std::cmp::Reverse;

/// Maximum number of pairs of candidates that are compared; longer lists are
/// paired in order.
const PAIRS: usize = 4096;

/// Number of a slot without a superword.
const NO_WORD: u32 = u32::MAX;

/// An operation that can be a lane of a superword.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Candidate {
    class: OperationClass,
    /// The superwords of its operands.
    slots: [u32; 2],
    lane: usize,
    value: Value,
    /// The second operand of the operation is the first one here.
    is_swapped: bool,
}

impl Candidate {
    fn key(&self) -> (OperationClass, [u32; 2]) {
        (self.class, self.slots)
    }

    /// The operands in the order of the slots.
    fn operands(&self, graph: &DataGraph<'_>) -> [Operand; 2] {
        let operands = graph.function.node(self.value).operands();
        match (operands, self.is_swapped) {
            (&[only], _) => [only, only],
            (&[first, second, ..], false) => [first, second],
            (&[first, second, ..], true) => [second, first],
            (&[], _) => unreachable!("an operation has operands"),
        }
    }

    /// The operand, in the order of the slots, that is subtracted; 2 is none.
    fn subtracted(&self, graph: &DataGraph<'_>) -> usize {
        match (graph.function.node(self.value).operation, self.is_swapped) {
            (Operation::Sub, false) => 1,
            (Operation::Sub, true) => 0,
            _ => 2,
        }
    }
}

/// Adds superwords of operations, first those that read superwords lane by
/// lane, then those that superwords gather.
pub(super) fn grow(graph: &DataGraph<'_>, colours: &ItemColours, words: &mut Superwords) {
    let mut by_height: Vec<Value> = graph.function.values().map(|(value, _)| value).collect();
    by_height.retain(|&value| graph.class(value).is_some() || graph.is_circular(value));
    by_height.sort_by_key(|value| graph.heights[value.index()]);
    let height = |value: &Value| graph.heights[value.index()];
    for level in by_height.chunk_by(|a, b| height(a) == height(b)) {
        let (circular, computed): (Vec<Value>, Vec<Value>) = level
            .iter()
            .partition(|&&value| graph.class(value).is_none());
        let is_sign = |value: &Value| graph.class(*value) == Some(OperationClass::Sign);
        let (signs, others): (Vec<Value>, Vec<Value>) = computed.into_iter().partition(is_sign);
        load(graph, words, &circular);
        join(graph, colours, words, &others);
        // Changes of sign read values of their own height.
        join(graph, colours, words, &signs);
    }
    let mut next = 0;
    while next < words.words.len() {
        descend(graph, colours, words, next);
        next += 1;
    }
}

/// Joins sines and cosines whose angles are in one superword.
fn load(graph: &DataGraph<'_>, words: &mut Superwords, level: &[Value]) {
    let mut found: Vec<(usize, u8, usize, Value)> = Vec::new();
    for &value in level {
        let node = graph.function.node(value);
        if let Some((word, lane)) = words.place(node.operands[0]) {
            found.push((
                word,
                u8::from(node.operation == Operation::Cos),
                lane,
                value,
            ));
        }
    }
    found.sort_unstable();
    let lanes = words.lanes;
    for group in found.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if group.len() == lanes && (0..lanes).all(|lane| group[lane].2 == lane) {
            let items = group.iter().map(|&(.., value)| value.into()).collect();
            words.add(graph, gathered(items));
        }
    }
}

/// Joins values of one height whose operands are in the same superwords.
fn join(graph: &DataGraph<'_>, colours: &ItemColours, words: &mut Superwords, values: &[Value]) {
    let candidates = values
        .iter()
        .filter_map(|&value| candidate(graph, words, value));
    let mut candidates: Vec<Candidate> = candidates.collect();
    candidates.sort_unstable();
    for group in candidates.chunk_by(|a, b| a.key() == b.key()) {
        let sides: Vec<&[Candidate]> = group.chunk_by(|a, b| a.lane == b.lane).collect();
        if sides.len() == words.lanes {
            for members in matched(graph, colours, &sides) {
                add(graph, words, &members);
            }
        }
    }
}

/// A value as a candidate, if an operand is in a superword, and all those that
/// are in superwords lie in one lane.
fn candidate(graph: &DataGraph<'_>, words: &Superwords, value: Value) -> Option<Candidate> {
    let node = graph.function.node(value);
    let mut slots = [NO_WORD; 2];
    let mut own = None;
    for (slot, &operand) in slots.iter_mut().zip(node.operands()) {
        if let Some((word, lane)) = words.place(operand) {
            *slot = word as u32;
            if own.is_some_and(|own| own != lane) {
                return None;
            }
            own = Some(lane);
        }
    }
    let class = graph.class(value)?;
    let is_free = matches!(class, OperationClass::Sum | OperationClass::Product);
    let is_swapped = is_free && slots[1] < slots[0];
    if is_swapped {
        slots.reverse();
    }
    Some(Candidate {
        class,
        slots,
        lane: own?,
        value,
        is_swapped,
    })
}

/// Candidates of equal key of every lane, joined by how much they are alike.
fn matched(
    graph: &DataGraph<'_>,
    colours: &ItemColours,
    sides: &[&[Candidate]],
) -> Vec<Vec<Candidate>> {
    let first = sides[0];
    let mut members: Vec<Vec<Candidate>> = first.iter().map(|&member| vec![member]).collect();
    for side in &sides[1..] {
        let mut pairs = Vec::new();
        if first.len() * side.len() <= PAIRS {
            for (a, left) in first.iter().enumerate() {
                for (b, right) in side.iter().enumerate() {
                    pairs.push((Reverse(likeness(graph, colours, left, right)), a, b));
                }
            }
            pairs.sort_unstable();
        } else {
            let all = (0..first.len()).zip(0..side.len());
            pairs.extend(all.map(|(a, b)| (Reverse((0, 0)), a, b)));
        }
        let mut is_taken = [vec![false; first.len()], vec![false; side.len()]];
        for (_, a, b) in pairs {
            if !is_taken[0][a] && !is_taken[1][b] {
                is_taken[0][a] = true;
                is_taken[1][b] = true;
                members[a].push(side[b]);
            }
        }
    }
    members.retain(|members| members.len() == sides.len());
    members
}

/// The likeness of two candidates of equal key: equal signs, other operands
/// that are the same or equal in size, and then equal neighbourhoods.
fn likeness(
    graph: &DataGraph<'_>,
    colours: &ItemColours,
    a: &Candidate,
    b: &Candidate,
) -> (u32, usize) {
    let mut score = 2 * u32::from(a.subtracted(graph) == b.subtracted(graph));
    let operands = a.operands(graph).into_iter().zip(b.operands(graph));
    for ((left, right), slot) in operands.zip(a.slots) {
        if slot == NO_WORD {
            let size = |operand| graph.function.number(operand).map(f64::abs);
            score +=
                4 * u32::from(left == right || size(left).is_some() && size(left) == size(right));
        }
    }
    (score, colours.likeness(a.value.index(), b.value.index()))
}

/// Adds the superword of some members, unless their signs do not suit.
fn add(graph: &DataGraph<'_>, words: &mut Superwords, members: &[Candidate]) {
    let operations: Vec<Operation> = members
        .iter()
        .map(|member| graph.function.node(member.value).operation)
        .collect();
    let mut operands: Vec<Vec<Operand>> = vec![Vec::new(); 2];
    for member in members {
        let own = member.operands(graph);
        operands[0].push(own[0]);
        operands[1].push(own[1]);
    }
    let mut negative = 0;
    let mut operation = operations[0];
    match members[0].class {
        OperationClass::Sum => {
            let subtracted = members.iter().map(|member| member.subtracted(graph));
            let [mut first, mut second] = [0u8, 0];
            for (lane, subtracted) in subtracted.enumerate() {
                first |= u8::from(subtracted == 0) << lane;
                second |= u8::from(subtracted == 1) << lane;
            }
            if first != 0 && second != 0 {
                return;
            }
            if first != 0 {
                operands.reverse();
            }
            operation = Operation::Add;
            negative = first | second;
        }
        OperationClass::Sign | OperationClass::Product | OperationClass::Quotient => {
            if operations.iter().any(|&other| other != operation) {
                return;
            }
        }
    }
    if operation == Operation::Neg {
        operands.pop();
    }
    let items = members.iter().map(|member| member.value.into()).collect();
    words.add(
        graph,
        Superword {
            items,
            operation: Some(operation),
            negative,
            operands,
        },
    );
}

/// Makes superwords of the operands that a superword gathers, if they are
/// operations of one kind.
fn descend(graph: &DataGraph<'_>, colours: &ItemColours, words: &mut Superwords, number: usize) {
    for slot in 0..words.words[number].operands.len() {
        let operands = &words.words[number].operands[slot];
        let values: Option<Vec<Value>> = operands.iter().map(|operand| operand.value()).collect();
        let Some(values) = values else { continue };
        let is_new =
            |value: &Value| words.place((*value).into()).is_none() && graph.class(*value).is_some();
        let kind = |value: Value| (graph.heights[value.index()], graph.class(value));
        let is_alike = values.iter().all(|&value| kind(value) == kind(values[0]));
        let mut sorted = values.clone();
        sorted.sort_unstable();
        sorted.dedup();
        if !is_alike || !values.iter().all(is_new) || sorted.len() < words.lanes {
            continue;
        }
        let members = aligned(graph, colours, words, &values);
        add(graph, words, &members);
    }
}

/// Operations as members of one superword, their operands in the order in
/// which they are most alike those of the first.
fn aligned(
    graph: &DataGraph<'_>,
    colours: &ItemColours,
    words: &Superwords,
    values: &[Value],
) -> Vec<Candidate> {
    let class = graph.class(values[0]).expect("an operation of a superword");
    let is_free = matches!(class, OperationClass::Sum | OperationClass::Product);
    let member = |lane, value, is_swapped| Candidate {
        class,
        slots: [NO_WORD; 2],
        lane,
        value,
        is_swapped,
    };
    let first = member(0, values[0], false);
    let alike = |candidate: &Candidate| -> usize {
        let pairs = first
            .operands(graph)
            .into_iter()
            .zip(candidate.operands(graph));
        pairs
            .map(|(a, b)| match (graph.item(a), graph.item(b)) {
                _ if a == b => 100,
                (None, None) => 100,
                (Some(left), Some(right)) => {
                    let word = |operand| words.place(operand).map(|(word, _)| word);
                    let is_one = word(a).is_some() && word(a) == word(b);
                    colours.likeness(left, right) + 100 * usize::from(is_one)
                }
                _ => 0,
            })
            .sum()
    };
    let others = values.iter().enumerate().skip(1).map(|(lane, &value)| {
        let straight = member(lane, value, false);
        let swapped = member(lane, value, true);
        if is_free && alike(&swapped) > alike(&straight) {
            swapped
        } else {
            straight
        }
    });
    std::iter::once(first).chain(others).collect()
}
