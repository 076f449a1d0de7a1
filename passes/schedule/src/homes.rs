//! Words for the outputs: every result that is an output stays readable.

use super::choice::OperandSource;
use super::graph::DependenceGraph;
use super::locations::{FOREVER, NO_ENTRY, Travel};
use super::ports::{PLANNED, WordTransfer};
use super::sweep::{ScheduleDraft, Stuck, reserve_indirect};
use robovec_ir::Function;

/// Gives each assignment the entry that keeps its result to the end, or
/// [`NO_ENTRY`] where the machine does not compute it.
///
/// A word that was written for a reader serves; a result without readers gets
/// a write of its own, directly if a port is free, else through the buffer as
/// soon as possible.
///
/// # Errors
///
/// [`Stuck`] when there is neither a free port nor room in the buffer.
pub(super) fn settle_homes(
    function: &Function,
    graph: &DependenceGraph,
    draft: &mut ScheduleDraft,
) -> Result<Vec<u32>, Stuck> {
    let mut kept = vec![0_u32; draft.live.len()];
    let mut homes = Vec::with_capacity(function.assignments.len());
    for assignment in &function.assignments {
        let home = match assignment.operand.value() {
            Some(value) if graph.is_computed(value.0) => {
                let known = draft
                    .locations
                    .of(value.0)
                    .min_by_key(|(_, entry)| {
                        // The word another assignment of the value keeps is free.
                        let memory = entry.memory;
                        let price = kept[memory as usize] + 1;
                        (if entry.last_read == FOREVER { 0 } else { price }, memory)
                    })
                    .map(|(index, _)| index);
                let home = match known {
                    Some(entry) => entry,
                    None => new_home(draft, value.0, &kept)?,
                };
                let entry = &mut draft.locations.entries[home as usize];
                draft.cycles = draft.cycles.max(entry.written + 1);
                if entry.last_read != FOREVER {
                    entry.last_read = FOREVER;
                    kept[entry.memory as usize] += 1;
                }
                home
            }
            _ => NO_ENTRY,
        };
        homes.push(home);
    }
    Ok(homes)
}

/// Reserves a write for a result that nothing reads.
fn new_home(draft: &mut ScheduleDraft, datum: u32, kept: &[u32]) -> Result<u32, Stuck> {
    let known = draft.locations.data[datum as usize];
    let (producer, back) = (known.element as usize, known.back);
    draft.ports.reach(back);
    // The emptiest memory a word that departs in a cycle gets into, and when.
    let emptiest = |draft: &ScheduleDraft, departs: u32| {
        let reach = |memory: usize| {
            let ports = &draft.ports;
            let arrives = departs + ports.latency(producer, memory);
            let word = WordTransfer {
                datum,
                from: producer,
                to: ports.element_of(memory),
                departs,
            };
            let free = ports.can_write(arrives, memory, 1)
                && ports.can_travel(&draft.locations, word, || [None; PLANNED]);
            free.then_some((memory, Travel { departs, arrives }, word))
        };
        (0..kept.len())
            .filter_map(reach)
            .min_by_key(|&(memory, travel, _)| (travel.arrives, kept[memory] + draft.live[memory]))
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
                result: Some((back, producer)),
            };
            reserve_indirect(draft, source, memory, travel);
            return Ok(add(draft, datum, memory, travel));
        }
    }
}

fn add(draft: &mut ScheduleDraft, datum: u32, memory: usize, travel: Travel) -> u32 {
    draft.live[memory] += 1;
    draft.cycles = draft.cycles.max(travel.arrives + 1);
    draft.locations.add(datum, memory, travel, FOREVER)
}
