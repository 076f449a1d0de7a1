//! Words in a network, checked link by link.
//!
//! The verifier walks every word from switch to switch by the conventions of
//! [`crate::machine::interconnect`] and writes down which wire it is on in
//! which cycle. Nothing is shared with the placer.

use super::placement::PlacementCheck;
use super::{ViolationCollector, ViolationSubject};
use crate::entity::Value;
use crate::machine::interconnect::{Interconnect, LinkNetwork, Topology, places};
use crate::placement::Element;

/// A point of a network: a place and, behind the switches of an omega
/// network, how many of them lie before it.
type NetworkPoint = (u32, u32);

/// The network a placement is for.
pub(super) struct Routes {
    network: LinkNetwork,
    places: Vec<u32>,
}

impl Routes {
    /// `None` for a crossbar.
    pub(super) fn new(interconnect: Interconnect, counts: &[u32]) -> Option<Routes> {
        match interconnect {
            Interconnect::Crossbar => None,
            Interconnect::Network(network) => Some(Routes {
                network,
                places: places(counts),
            }),
        }
    }

    /// The wires between two elements, as pairs of points.
    fn wires(&self, from: Element, to: Element) -> Vec<(NetworkPoint, NetworkPoint)> {
        let (mut at, end) = (self.places[from.index()], self.places[to.index()]);
        let mut wires = Vec::new();
        if from == to {
            return wires;
        }
        let elements = self.places.len() as u32;
        let columns = self.network.columns(elements).min(elements);
        let rows = elements.div_ceil(columns);
        match self.network.topology {
            // One wire for all.
            Topology::Bus => wires.push(((0, 0), (0, 0))),
            Topology::Mesh | Topology::Torus => {
                let ring = self.network.topology == Topology::Torus;
                while at % columns != end % columns {
                    let next = step(at % columns, end % columns, columns, ring);
                    let next = at - at % columns + next;
                    wires.push(((at, 0), (next, 0)));
                    at = next;
                }
                while at != end {
                    let next = step(at / columns, end / columns, rows, ring);
                    let next = next * columns + at % columns;
                    wires.push(((at, 0), (next, 0)));
                    at = next;
                }
            }
            Topology::Hypercube => {
                let mut bit = 1;
                while at != end {
                    let next = at & !bit | end & bit;
                    if next != at {
                        wires.push(((at, 0), (next, 0)));
                    }
                    at = next;
                    bit <<= 1;
                }
            }
            Topology::Omega => {
                let stages = elements.next_power_of_two().ilog2();
                for stage in 1..=stages {
                    // The bits of the destination come in from the right,
                    // highest first, and push out those of the start.
                    let next = ((u64::from(at) << stages | u64::from(end)) >> (stages - stage))
                        & ((1 << stages) - 1);
                    wires.push(((next as u32, stage), (next as u32, stage)));
                }
            }
        }
        wires
    }

    /// Cycles from the departure of a word to its arrival.
    pub(super) fn latency(&self, from: Element, to: Element) -> u64 {
        self.wires(from, to).len() as u64 * u64::from(self.network.hop)
    }

    /// The wires a word is on, and how long after its departure.
    fn uses(&self, from: Element, to: Element) -> Vec<((NetworkPoint, NetworkPoint), u64)> {
        let hop = u64::from(self.network.hop);
        let wires = self.wires(from, to).into_iter();
        let mut uses: Vec<_> = (0..).zip(wires).map(|(k, wire)| (wire, k * hop)).collect();
        if self.network.topology == Topology::Omega && from != to {
            let line = (self.places[from.index()], 0);
            uses.push(((line, line), 0));
        }
        uses
    }
}

/// The next place along a row or column.
fn step(at: u32, end: u32, length: u32, ring: bool) -> u32 {
    let ahead = (end + length - at) % length;
    let up = if ring { 2 * ahead <= length } else { end > at };
    if up {
        (at + 1) % length
    } else {
        (at + length - 1) % length
    }
}

/// A word on a wire in a cycle: wire, cycle, value, departure.
type Use = ((NetworkPoint, NetworkPoint), u64, u32, u64);

/// Reports every wire that carries more words than it can, and every buffer
/// that hands out more.
pub(super) fn check(
    check: &PlacementCheck<'_>,
    routes: &Routes,
    collector: &mut ViolationCollector<'_>,
) {
    let mut uses: Vec<Use> = Vec::new();
    let mut sent: Vec<(Element, u64, u32)> = Vec::new();
    for value in check.placed_values() {
        let from = check.slot(value).element;
        let back = check.write_back(value);
        for write in check.placement.writes_of(value) {
            let to = write.word.element;
            let departs = u64::from(write.cycle).saturating_sub(routes.latency(from, to));
            let used = routes.uses(from, to).into_iter();
            uses.extend(used.map(|(wire, after)| (wire, departs + after, value.0, departs)));
            if departs > back && check.placement.buffers[value.index()].is_some() {
                sent.push((from, departs, value.0));
            }
        }
    }
    uses.sort_unstable();
    uses.dedup();
    let words = routes.network.words as usize;
    for group in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if group.len() > words {
            let (count, cycle) = (group.len(), group[0].1);
            let name = routes.network.topology.name();
            collector.value(Value(group[words].2), || {
                format!(
                    "is one of {count} words on one link of the {name} at cycle {cycle}, which \
                     carries {words}"
                )
            });
        }
    }
    let Some(limit) = check.machine.buffer.and_then(|buffer| buffer.reads) else {
        return;
    };
    sent.sort_unstable();
    sent.dedup();
    for group in sent.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if group.len() > limit as usize {
            let (kind, number) = check.schedule.element_name(group[0].0);
            let cycle = group[0].1;
            collector.add(ViolationSubject::Schedule, || {
                format!(
                    "more words of the buffer of {kind}{number} are read at cycle {cycle} than the \
                     {limit} it hands out"
                )
            });
        }
    }
}
