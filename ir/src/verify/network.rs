//! Words in a network, checked link by link.
//!
//! The verifier walks every word from switch to switch by the conventions of
//! [`crate::machine::interconnect`] and records which wire it is on in which
//! cycle. No code is shared with the placer.

use crate::machine::interconnect::{Interconnect, LinkNetwork, Topology, places};
use crate::placement::Element;

/// A point of a network: a place, and in an omega network the number of
/// switches before it.
type NetworkPoint = (u32, u32);

/// A wire, by the points at its ends; both are the same for the output of a
/// switch of an omega network.
pub(super) type NetworkWire = (NetworkPoint, NetworkPoint);

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

    /// Number of words that a link carries in a cycle.
    pub(super) fn words(&self) -> usize {
        self.network.words as usize
    }

    /// The name of the topology.
    pub(super) fn topology(&self) -> &'static str {
        self.network.topology.name()
    }

    /// The wires between two elements, in the order of a word's path.
    fn wires(&self, from: Element, to: Element) -> Vec<NetworkWire> {
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

    /// The wires that a word takes, each with its cycle after the departure.
    pub(super) fn uses(&self, from: Element, to: Element) -> Vec<(NetworkWire, u64)> {
        let hop = u64::from(self.network.hop);
        let wires = self.wires(from, to).into_iter();
        let mut uses: Vec<_> = (0..).zip(wires).map(|(k, wire)| (wire, k * hop)).collect();
        if self.network.topology == Topology::Omega && from != to {
            // The line from the element into the first switch adds no latency.
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
