//! Words for the outputs: every result that is an output stays readable.

use super::choice::OperandSource;
use super::commit::reserve_indirect;
use super::graph::{Datum, DependenceGraph};
use super::locations::{Entry, Memory, Travel};
use super::ports::PLANNED;
use super::state::{ScheduleDraft, Stuck};
use robovec_ir::Function;

/// Gives each assignment whose operand the machine computes the entry that
/// keeps it to the end.
///
/// A word that was written for a reader serves; a result without readers gets
/// its own write, directly if a port is free, else through the buffer as
/// soon as possible.
///
/// # Errors
///
/// [`Stuck`] when there is neither a free port nor room in the buffer.
pub(super) fn settle_homes(
    function: &Function,
    graph: &DependenceGraph,
    draft: &mut ScheduleDraft,
) -> Result<Vec<Option<Entry>>, Stuck> {
    let mut kept = vec![0_u32; draft.live.len()];
    let mut homes = Vec::with_capacity(function.assignments.len());
    for assignment in &function.assignments {
        let datum = assignment.operand.value().map(Datum::from);
        let Some(datum) = datum.filter(|&datum| graph.is_computed(datum)) else {
            homes.push(None);
            continue;
        };
        let known = draft.locations.of(datum).min_by_key(|(_, stored)| {
            // The word another assignment of the value keeps is free.
            let memory = stored.memory;
            let price = kept[memory.index()] + 1;
            (stored.last_read().map_or(0, |_| price), memory)
        });
        let home = match known {
            Some((entry, _)) => entry,
            None => new_home(draft, datum, &kept)?,
        };
        let stored = &mut draft.locations.entries[home.index()];
        let written = stored.written().expect("a result is written");
        draft.cycles = draft.cycles.max(written + 1);
        if stored.last_read().is_some() {
            stored.set_last_read(None);
            kept[stored.memory.index()] += 1;
        }
        homes.push(Some(home));
    }
    Ok(homes)
}

/// Reserves a write for an unread result.
fn new_home(draft: &mut ScheduleDraft, datum: Datum, kept: &[u32]) -> Result<Entry, Stuck> {
    let result = draft.locations.computed(datum);
    let (producer, back) = (result.element, result.cycle);
    draft.ports.reach(back);
    // The emptiest memory a word that departs in a cycle gets into, and when.
    let emptiest = |draft: &ScheduleDraft, departs: u32| {
        let reach = |memory: Memory| {
            let ports = &draft.ports;
            let arrives = departs + ports.latency(producer, memory);
            let word = ports.transfer(datum, producer, memory, departs);
            let free = ports.can_write(arrives, memory, 1)
                && ports.can_travel(&draft.locations, word, || [None; PLANNED]);
            free.then_some((memory, Travel { departs, arrives }, word))
        };
        let reached = draft.ports.memories().filter_map(reach);
        reached.min_by_key(|&(memory, travel, _)| {
            let words = kept[memory.index()] + draft.live[memory.index()];
            (travel.arrives, words)
        })
    };
    if let Some((memory, travel, word)) = emptiest(draft, back) {
        draft.ports.write(travel.arrives, memory);
        draft.ports.travel(&draft.locations, word);
        return Ok(add(draft, datum, memory, travel));
    }
    if !draft.ports.has_buffer() {
        return Err(Stuck);
    }
    let mut cycle = back;
    loop {
        if !draft.ports.has_room(cycle, producer, 1) {
            return Err(Stuck);
        }
        cycle += 1;
        draft.ports.reach(cycle);
        if !draft.ports.can_read_buffer(cycle, producer, 1)
            || !draft.ports.has_room(cycle, producer, 1)
        {
            continue;
        }
        if let Some((memory, travel, _)) = emptiest(draft, cycle) {
            let source = OperandSource {
                datum,
                result: Some(result),
            };
            reserve_indirect(draft, source, memory, travel);
            return Ok(add(draft, datum, memory, travel));
        }
    }
}

fn add(draft: &mut ScheduleDraft, datum: Datum, memory: Memory, travel: Travel) -> Entry {
    draft.live[memory.index()] += 1;
    draft.cycles = draft.cycles.max(travel.arrives + 1);
    draft.locations.add(datum, memory, Some(travel), None)
}
