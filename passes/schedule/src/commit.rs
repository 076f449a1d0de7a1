//! The issue of an operation: the reservation of its transfers, and the update
//! of its readers.

use super::choice::{IssuePlan, OperandSource, OperandSources, Route, is_same, word};
use super::graph::Datum;
use super::locations::{Entry, Memory, Travel, WriteBack};
use super::state::{ScheduleDraft, Sweep};
use robovec_ir::Operand;
use robovec_ir::placement::Element;

impl Sweep<'_> {
    /// Issues a node as planned, its operands being these.
    pub(super) fn commit(
        &mut self,
        node: usize,
        cycle: u32,
        plan: IssuePlan,
        sources: &OperandSources,
    ) {
        assert_eq!(
            self.waiting[node].operands, 0,
            "an operation is issued after all its operands"
        );
        assert!(
            self.busy[plan.element.index()] <= cycle,
            "an element issues one operation in a cycle"
        );
        let mut reads = [None; Operand::MAX_COUNT];
        for operand in 0..Operand::MAX_COUNT {
            let (Some(route), Some(source)) = (plan.routes[operand], sources[operand]) else {
                continue;
            };
            let same_word = |&before: &usize| is_same(sources, &plan, before, operand);
            reads[operand] = match (0..operand).find(same_word) {
                Some(before) => reads[before],
                None => Some(self.transfer(source, route, plan.memories[operand], cycle)),
            };
        }
        for source in sources.iter().flatten() {
            self.has_read(source.datum);
        }
        let result = self.write_back(node, cycle, plan.element);
        self.draft.locations.data[node].result = Some(result);
        if plan.swapped {
            reads.swap(0, 1);
            self.draft.swapped[node] = true;
        }
        self.draft.reads[node] = reads;
        self.busy[plan.element.index()] = cycle + 1;
        self.last_issue = cycle;
        self.announce(node, cycle);
    }

    /// The place and the cycle in which the result of a node appears.
    pub(super) fn write_back(&self, node: usize, cycle: u32, element: Element) -> WriteBack {
        WriteBack {
            cycle: cycle + self.task.graph.weight(node) - 1,
            element,
        }
    }

    /// Reserves a transfer and returns the entry that is read.
    fn transfer(
        &mut self,
        source: OperandSource,
        route: Route,
        memory: Memory,
        cycle: u32,
    ) -> Entry {
        let draft = &mut self.draft;
        // Over a crossbar a word takes no link and arrives when it departs.
        let word = if draft.ports.has_network() {
            word(&draft.ports, source, memory, route)
        } else {
            None
        };
        let travel = |arrives| Travel {
            departs: word.map_or(arrives, |word| word.departs),
            arrives,
        };
        let travel = match route {
            Route::Held(entry) => {
                draft.locations.entries[entry.index()].set_last_read(Some(cycle));
                return entry;
            }
            Route::Load => None,
            Route::Direct(at) => {
                draft.ports.write(at, memory);
                if let Some(word) = word {
                    draft.ports.travel(&draft.locations, word);
                }
                Some(travel(at))
            }
            Route::Indirect(at) => {
                reserve_indirect(draft, source, memory, travel(at));
                Some(travel(at))
            }
        };
        draft.live[memory.index()] += 1;
        let datum = source.datum;
        draft.locations.add(datum, memory, travel, Some(cycle))
    }

    fn has_read(&mut self, datum: Datum) {
        let left = &mut self.draft.locations.data[datum.index()].readers_left;
        *left -= 1;
        if *left == 0 {
            for (_, entry) in self.draft.locations.of(datum) {
                self.draft.live[entry.memory.index()] -= 1;
            }
        }
    }

    /// Informs the readers of an issued node when its result can be read.
    fn announce(&mut self, node: usize, cycle: u32) {
        let ready = cycle + self.task.graph.weight(node);
        self.draft.cycles = self.draft.cycles.max(ready);
        for &user in self.task.graph.users_of(node) {
            let waiting = &mut self.waiting[user as usize];
            waiting.ready = waiting.ready.max(ready);
            waiting.operands -= 1;
            if waiting.operands == 0 {
                let ready = if self.draft.ports.has_network() {
                    self.first_arrival(user as usize)
                } else {
                    waiting.ready
                };
                self.ready.calendar.enter(ready.max(cycle + 1), user);
            }
        }
    }

    /// The first cycle in which some element can have all operands of a node
    /// whose operands are issued, counting only the network's latency.
    fn first_arrival(&self, node: usize) -> u32 {
        let draft = &self.draft;
        let sources = self.sources(node);
        let at = |element: u32| {
            let memory = Memory::new(element * self.banks as u32);
            let results = sources.iter().flatten().filter_map(|source| source.result);
            let arrivals =
                results.map(|back| back.cycle + draft.ports.latency(back.element, memory) + 1);
            arrivals.fold(0, u32::max)
        };
        let kind = self.task.graph.kinds[self.task.graph.kind[node] as usize];
        let elements = kind.first..kind.first + kind.count;
        let earliest = elements.map(at).min();
        earliest.expect("a kind that is used has an element")
    }
}

/// Reserves the ports, the links and the buffer words of an indirect write.
pub(super) fn reserve_indirect(
    draft: &mut ScheduleDraft,
    source: OperandSource,
    memory: Memory,
    travel: Travel,
) {
    let result = source.result.expect("only results are written");
    let producer = result.element;
    draft.ports.write(travel.arrives, memory);
    let departs = travel.departs;
    let word = (draft.ports).transfer(source.datum, producer, memory, departs);
    draft.ports.travel(&draft.locations, word);
    let mut sent = draft.locations.of(source.datum);
    if !sent.any(|(_, entry)| entry.departed() == Some(departs)) {
        draft.ports.read_buffer(departs, producer);
    }
    let from = draft
        .locations
        .buffered_until(source.datum)
        .map_or(result.cycle, |until| until + 1);
    draft.ports.occupy(from..=departs, producer);
}
