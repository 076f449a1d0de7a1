//! Planning one operation: for each element, the transfers of its operands;
//! then the best element.

use super::choice::{
    ADDEND_RANKS, Beside, ElementChoice, IssueDecision, IssuePlan, OperandSource, OperandSources,
    RANKS, Route, indirect_route, plain_route, shared,
};
use super::graph::Datum;
use super::locations::{Entry, Memory};
use super::state::Sweep;
use robovec_ir::Operand;
use robovec_ir::placement::Element;

/// An operation waits for a better element only while its longest chain ends
/// this many cycles before the target.
const MARGIN: u32 = 4;

/// Maximum number of plans compared for one operation: no machine that can be
/// built has as many elements of a kind; only imagined machines of thousands of
/// elements are searched in part.
const MAX_COMPARED: usize = 128;

/// The cost that [`ElementChoice::Preferential`] minimises: the rank, the
/// cycles results stay in buffers, the way through the network, new words of
/// initial data, live words.
type IssueCost = (u8, u32, u32, u8, u32);

/// The rank of an operation whose operands, as written, have these statuses.
#[inline]
fn rank(statuses: [usize; Operand::MAX_COUNT], swapped: bool) -> u8 {
    let [left, right, addend] = statuses;
    // Exchanged, the first operand is the one on the right.
    let factors = if swapped {
        RANKS[right][left]
    } else {
        RANKS[left][right]
    };
    factors + ADDEND_RANKS[addend]
}

impl Sweep<'_> {
    /// The operand as data flow.
    #[inline]
    pub(super) fn source(&self, datum: Datum) -> OperandSource {
        OperandSource {
            datum,
            result: self.draft.locations.result(datum),
        }
    }

    /// The data that a node reads.
    #[inline]
    pub(super) fn data(&self, node: usize) -> [Option<Datum>; Operand::MAX_COUNT] {
        self.task.graph.data_of(&self.task.function.nodes()[node])
    }

    /// The operands of a node as data flow.
    pub(super) fn sources(&self, node: usize) -> OperandSources {
        let [a, b, c] = self.data(node);
        let source = |datum: Option<Datum>| Some(self.source(datum?));
        [source(a), source(b), source(c)]
    }

    pub(super) fn mark(&mut self, sources: OperandSources) {
        self.stamp += 1;
        for (marks, source) in self.marks.iter_mut().zip(sources) {
            let Some(source) = source else { continue };
            for (entry, stored) in self.draft.locations.of(source.datum) {
                marks[stored.memory.index()] = (self.stamp, Some(entry));
            }
        }
    }

    #[inline]
    fn held(&self, operand: usize, memory: Memory) -> Option<Entry> {
        let (stamp, entry) = self.marks[operand][memory.index()];
        entry.filter(|_| stamp == self.stamp)
    }

    /// The best plan for a node whose operands have been computed.
    pub(super) fn consider(&mut self, node: usize, cycle: u32) -> IssueDecision {
        let sources = self.sources(node);
        self.mark(sources);
        let is_free = |at: &IssuePlan| self.busy[at.element.index()] != cycle + 1;
        let plan = match self.task.choice {
            ElementChoice::First => self.places(node).filter(is_free).find_map(|at| {
                self.plain(&sources, at, cycle)
                    .or_else(|| self.indirect(&sources, at, cycle))
            }),
            ElementChoice::Preferential => {
                let free = || self.places(node).filter(is_free);
                let best = self.cheapest_plain(&sources, node, free(), cycle);
                if best.is_none() && self.can_wait(node, cycle) {
                    let mut later = self.places(node).filter(|at| !is_free(at));
                    if later.any(|at| self.plain(&sources, at, cycle).is_some()) {
                        return IssueDecision::Wait;
                    }
                }
                best.or_else(|| {
                    self.cheapest(&sources, free(), |at| self.indirect(&sources, at, cycle))
                })
            }
        };
        match plan {
            Some(plan) => IssueDecision::Issue(plan, sources),
            None => IssueDecision::Fail,
        }
    }

    /// The plan of least cost among the first [`MAX_COMPARED`], the first of
    /// equals.
    pub(super) fn cheapest(
        &self,
        sources: &OperandSources,
        places: impl Iterator<Item = IssuePlan>,
        plan: impl Fn(IssuePlan) -> Option<IssuePlan>,
    ) -> Option<IssuePlan> {
        let mut best: Option<(IssueCost, IssuePlan)> = None;
        let mut compared = 0;
        for at in places {
            if let Some(plan) = plan(at) {
                compared += 1;
                let cost = self.cost(sources, &plan);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, plan));
                }
                if compared == MAX_COMPARED {
                    break;
                }
            }
        }
        best.map(|(_, plan)| plan)
    }

    /// As [`Sweep::cheapest`], of the plans without buffers for a node.
    ///
    /// The cost of such a plan follows from the places of the operands, so that
    /// ports are considered only for a plan that would be the best so far.
    pub(super) fn cheapest_plain(
        &self,
        sources: &OperandSources,
        node: usize,
        places: impl Iterator<Item = IssuePlan>,
        before: u32,
    ) -> Option<IssuePlan> {
        let elements = self.task.graph.kinds[self.task.graph.kind[node] as usize].count as usize;
        if elements * self.banks > MAX_COMPARED {
            return self.cheapest(sources, places, |at| self.plain(sources, at, before));
        }
        let mut best: Option<(IssueCost, IssuePlan)> = None;
        for at in places {
            let cost = self.plain_cost(sources, &at);
            if best.as_ref().is_some_and(|(least, _)| cost >= *least) {
                continue;
            }
            if let Some(plan) = self.plain(sources, at, before) {
                debug_assert_eq!(
                    cost,
                    self.cost(sources, &plan),
                    "a plan without buffers costs what was foreseen"
                );
                best = Some((cost, plan));
            }
        }
        best.map(|(_, plan)| plan)
    }

    /// True when issuing the node a cycle later need not lengthen the
    /// schedule.
    pub(super) fn can_wait(&self, node: usize, cycle: u32) -> bool {
        self.picky && cycle + self.task.graph.tail[node] + MARGIN < self.task.target
    }

    /// The elements that perform a node, and on each the ways to feed it its
    /// operands: as written and, where that is possible and makes a
    /// difference, with sides exchanged.
    pub(super) fn places(&self, node: usize) -> impl Iterator<Item = IssuePlan> + use<> {
        let kind = self.task.graph.kinds[self.task.graph.kind[node] as usize];
        let [left, right, _] = self.task.function.nodes()[node].operands;
        let exchanges = self.banks > 1
            && left != right
            && self.task.function.nodes()[node].operation.is_commutative();
        let sides = 1 + u32::from(exchanges);
        let banks = self.banks as u32;
        (kind.first * sides..(kind.first + kind.count) * sides).map(move |place| {
            let (element, swapped) = match sides {
                1 => (place, false),
                _ => (place >> 1, place & 1 == 1),
            };
            let [near, far] = [element * banks, (element + 1) * banks - 1].map(Memory::new);
            IssuePlan {
                element: Element::new(element),
                swapped,
                // Machines with a memory per side have no third operand.
                memories: if swapped {
                    [far, near, near]
                } else {
                    [near, far, near]
                },
                routes: [None; Operand::MAX_COUNT],
            }
        })
    }

    /// The plan without buffers that has everything written before a cycle.
    pub(super) fn plain(
        &self,
        sources: &OperandSources,
        at: IssuePlan,
        before: u32,
    ) -> Option<IssuePlan> {
        let mut plan = at;
        for operand in 0..Operand::MAX_COUNT {
            let Some(source) = sources[operand] else {
                break;
            };
            let route = match shared(sources, &plan, operand) {
                Some(route) => route,
                None => {
                    let memory = plan.memories[operand];
                    let held = self.held(operand, memory);
                    let beside = Beside {
                        sources,
                        plan: &plan,
                        operand,
                    };
                    // Nothing is planned before the first operand.
                    let beside = (operand > 0).then_some(beside);
                    plain_route(&self.draft, source, memory, held, before, beside)?
                }
            };
            plan.routes[operand] = Some(route);
        }
        Some(plan)
    }

    /// The plan with at least one operand through a buffer; called when there
    /// is none without. Operands that can be sent directly are.
    fn indirect(&self, sources: &OperandSources, at: IssuePlan, cycle: u32) -> Option<IssuePlan> {
        let draft = &self.draft;
        if !draft.ports.has_buffer() {
            return None;
        }
        let mut plan = at;
        for operand in 0..Operand::MAX_COUNT {
            if let Some(source) = sources[operand] {
                let memory = plan.memories[operand];
                let held = self.held(operand, memory);
                plan.routes[operand] = shared(sources, &plan, operand).or_else(|| {
                    let beside = Beside {
                        sources,
                        plan: &plan,
                        operand,
                    };
                    plain_route(draft, source, memory, held, cycle, Some(beside))
                });
            }
        }
        for operand in 0..Operand::MAX_COUNT {
            let Some(source) = sources[operand] else {
                continue;
            };
            if plan.routes[operand].is_some() {
                continue;
            }
            let route = match shared(sources, &plan, operand) {
                Some(route) => route,
                None => {
                    let memory = plan.memories[operand];
                    let beside = Beside {
                        sources,
                        plan: &plan,
                        operand,
                    };
                    let ports = &draft.ports;
                    let others = beside.others(ports);
                    indirect_route(ports, &draft.locations, source, memory, cycle, &others)?
                }
            };
            plan.routes[operand] = Some(route);
        }
        Some(plan)
    }

    /// The [`Sweep::cost`] of the plan without buffers at a place, if there is
    /// one.
    // Inlined, since most places only have their costs compared.
    #[inline(always)]
    fn plain_cost(&self, sources: &OperandSources, at: &IssuePlan) -> IssueCost {
        let held = |operand: usize| self.held(operand, at.memories[operand]).is_some();
        let status = |operand: usize| {
            let result = sources[operand].and_then(|source| source.result);
            usize::from(result.is_some() && !held(operand))
        };
        let loads = |operand: usize| {
            let initial = sources[operand].filter(|source| source.result.is_none());
            u8::from(initial.is_some() && !held(operand))
        };
        let rank = rank([status(0), status(1), status(2)], at.swapped);
        let travels = if self.draft.ports.has_network() {
            self.plain_travels(sources, at)
        } else {
            0
        };
        let loads = loads(0) + loads(1) + loads(2);
        (rank, 0, travels, loads, self.words(at))
    }

    /// The way through the network that operands take to a place. Transfers
    /// over networks, which need further resources.
    #[inline(never)]
    fn plain_travels(&self, sources: &OperandSources, at: &IssuePlan) -> u32 {
        let travel = |operand: usize| {
            let memory = at.memories[operand];
            let result = sources[operand].and_then(|source| source.result);
            let missing = result.filter(|_| self.held(operand, memory).is_none());
            missing.map_or(0, |from| self.draft.ports.latency(from.element, memory))
        };
        (0..Operand::MAX_COUNT).map(travel).sum()
    }

    /// The words that live in the memories of a plan.
    #[inline]
    fn words(&self, plan: &IssuePlan) -> u32 {
        let memories = plan.memories.iter();
        memories.map(|memory| self.draft.live[memory.index()]).sum()
    }

    fn cost(&self, sources: &OperandSources, plan: &IssuePlan) -> IssueCost {
        let statuses = plan.routes.map(|route| route.map_or(0, Route::status));
        let rank = rank(statuses, plan.swapped);
        let loads = plan
            .routes
            .iter()
            .filter(|&&route| route == Some(Route::Load))
            .count() as u8;
        let ports = &self.draft.ports;
        let travel = |operand: usize| {
            let moves = plan.routes[operand].is_some_and(Route::moves);
            let producer = sources[operand].and_then(|source| source.result);
            producer.filter(|_| moves).map_or(0, |from| {
                ports.latency(from.element, plan.memories[operand])
            })
        };
        let travels: u32 = if ports.has_network() {
            (0..Operand::MAX_COUNT).map(travel).sum()
        } else {
            0
        };
        let stay = plan.routes.iter().zip(sources).map(|(route, source)| {
            let back = source
                .and_then(|source| source.result)
                .map_or(0, |result| result.cycle);
            match route {
                Some(Route::Indirect(at)) => at - back,
                _ => 0,
            }
        });
        (rank, stay.sum(), travels, loads, self.words(plan))
    }

    /// False when no element, free now or not, can take the node in this or
    /// any later cycle.
    pub(super) fn can_ever(&mut self, node: usize, cycle: u32) -> bool {
        let sources = self.sources(node);
        self.mark(sources);
        self.places(node).any(|at| {
            self.plain(&sources, at, u32::MAX).is_some()
                || self.indirect(&sources, at, cycle).is_some()
                || self.may_wait(&sources, at, cycle)
        })
    }

    /// True when every operand is there, can go directly, or can stay in its
    /// buffer until now, so that a later cycle may find a port.
    fn may_wait(&self, sources: &OperandSources, at: IssuePlan, cycle: u32) -> bool {
        let draft = &self.draft;
        draft.ports.has_buffer()
            && (0..Operand::MAX_COUNT).all(|operand| {
                let Some(source) = sources[operand] else {
                    return true;
                };
                let memory = at.memories[operand];
                let held = self.held(operand, memory);
                let Some(result) = source.result else {
                    return true;
                };
                if plain_route(draft, source, memory, held, u32::MAX, None).is_some() {
                    return true;
                }
                let from = draft
                    .locations
                    .buffered_until(source.datum)
                    .map_or(result.cycle, |until| until + 1);
                (from..=cycle).all(|at| draft.ports.has_room(at, result.element, 1))
            })
    }
}
