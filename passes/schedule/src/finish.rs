//! From a draft to the explicit schedule and placement of the function.

use super::addresses::{Addresses, allocate};
use super::error::PlaceError;
use super::graph::{Datum, DependenceGraph, HOST};
use super::locations::Entry;
use super::ports::{Ports, banks};
use super::search::PlacementCandidate;
use super::state::ScheduleDraft;
use robovec_ir::placement::{
    Bank, BufferWord, Element, ElementKind, Placement, Preload, Schedule, Slot, Word, Write,
};
use robovec_ir::{Function, Level, Machine, Operand, Value};

/// Writes schedule and placement into the function.
///
/// # Errors
///
/// Fails when a memory has fewer words than are alive at once.
pub(super) fn finish(
    function: &mut Function,
    mut graph: DependenceGraph,
    machine: &Machine,
    found: PlacementCandidate,
    lower_bound: u32,
) -> Result<(), PlaceError> {
    let PlacementCandidate {
        mut draft,
        homes,
        buffers,
        ..
    } = found;
    graph.release_links();
    let addresses = allocate(&graph, &draft);
    draft.ports = Ports::default();
    let reads = std::mem::take(&mut draft.reads);
    let words = WordNames {
        banks: banks(machine) as u32,
        addresses: &addresses,
        draft: &draft,
    };
    let schedule = Schedule {
        machine: machine.name.clone(),
        machine_hash: Some(machine.content_hash()),
        kinds: machine
            .elements
            .iter()
            .map(|element| ElementKind {
                name: element.kind.clone(),
                count: element.count,
            })
            .collect(),
        slots: slots(&graph, &draft),
        cycles: draft.cycles,
        lower_bound,
    };
    check_sizes(machine, &schedule, &addresses)?;
    let placement = words.placement(&graph, &homes, reads, buffers);
    for (index, _) in draft.swapped.iter().enumerate().filter(|(_, swap)| **swap) {
        function.node_mut(Value(index as u32)).operands.swap(0, 1);
    }
    function.schedule = Some(schedule);
    function.placement = Some(placement);
    function.level = Level::Placed;
    Ok(())
}

fn slots(graph: &DependenceGraph, draft: &ScheduleDraft) -> Vec<Option<Slot>> {
    let data = draft.locations.data.iter().enumerate();
    data.take(graph.kind.len())
        .map(|(node, datum)| match graph.kind[node] {
            HOST => None,
            _ => {
                let result = datum.result.expect("every operation was issued");
                Some(Slot {
                    cycle: result.cycle + 1 - graph.weight(node),
                    element: result.element,
                })
            }
        })
        .collect()
}

fn check_sizes(
    machine: &Machine,
    schedule: &Schedule,
    addresses: &Addresses,
) -> Result<(), PlaceError> {
    let Some(available) = machine.memory.words else {
        return Ok(());
    };
    let banks = banks(machine);
    // The fullest memory, the first of them.
    let fullest = addresses
        .used
        .iter()
        .enumerate()
        .max_by_key(|&(memory, &used)| (used, std::cmp::Reverse(memory)));
    match fullest {
        Some((memory, &needed)) if needed > available => {
            let (kind, number) = schedule.element_name(Element::new((memory / banks) as u32));
            let side = match (banks, memory % banks) {
                (1, _) => "",
                (_, 0) => ".left",
                (_, _) => ".right",
            };
            Err(PlaceError::MemoryTooSmall {
                element: format!("{kind}{number}{side}"),
                needed,
                available,
            })
        }
        _ => Ok(()),
    }
}

struct WordNames<'a> {
    banks: u32,
    addresses: &'a Addresses,
    draft: &'a ScheduleDraft,
}

impl WordNames<'_> {
    fn word(&self, entry: Entry) -> Word {
        let memory = self.draft.locations.entries[entry.index()].memory.number();
        let bank = match (self.banks, memory % self.banks) {
            (1, _) => Bank::Unified,
            (_, 0) => Bank::Left,
            (_, _) => Bank::Right,
        };
        Word {
            element: Element::new(memory / self.banks),
            bank,
            address: self.addresses.of_entry[entry.index()]
                .expect("an entry that is used has an address"),
        }
    }

    fn placement(
        &self,
        graph: &DependenceGraph,
        homes: &[Option<Entry>],
        reads: Vec<[Option<Entry>; Operand::MAX_COUNT]>,
        buffers: Vec<Option<BufferWord>>,
    ) -> Placement {
        let preloads = self
            .addresses
            .preloads
            .iter()
            .map(|&(entry, datum)| Preload {
                word: self.word(entry),
                operand: graph.initial_operand(datum),
            });
        let mut write_starts = Vec::with_capacity(graph.kind.len() + 1);
        let transfers = self.draft.locations.entries.len() - self.addresses.preloads.len();
        let mut writes: Vec<Write> = Vec::with_capacity(transfers);
        for node in (0..graph.kind.len() as u32).map(Datum::new) {
            let start = writes.len();
            write_starts.push(start as u32);
            if graph.is_computed(node) {
                // Not `extend`, which asks every list of entries how long it is.
                for (entry, stored) in self.draft.locations.of(node) {
                    writes.push(Write {
                        word: self.word(entry),
                        cycle: stored.written().expect("a result is written"),
                    });
                }
                writes[start..].sort_unstable_by_key(|write| (write.cycle, write.word));
            }
        }
        write_starts.push(writes.len() as u32);
        Placement {
            preloads: preloads.collect(),
            // In the memory of the entries, which are as long.
            reads: reads
                .into_iter()
                .map(|read| read.map(|entry| self.addresses.of_entry[entry?.index()]))
                .collect(),
            buffers,
            write_starts,
            writes,
            homes: homes
                .iter()
                .map(|entry| entry.map(|entry| self.word(entry)))
                .collect(),
        }
    }
}
