//! Ways of words through a network (the conventions are those of
//! [`robovec_ir::machine::interconnect`]).
//!
//! Paths are followed link by link on request, never stored: a table of all
//! pairs would grow with the square of the elements.

use robovec_ir::machine::interconnect::{self, Interconnect, LinkNetwork, Topology};
use robovec_ir::placement::Element;

/// The links of a machine's network.
#[derive(Clone, Debug)]
pub(super) struct Wires {
    network: LinkNetwork,
    /// The place of each element.
    places: Vec<u32>,
    columns: u32,
    rows: u32,
    /// Bits of a place's number.
    bits: u32,
}

impl Wires {
    /// The network of a machine with this number of elements of each kind;
    /// `None` for a crossbar, which has no links to share.
    pub(super) fn new(interconnect: Interconnect, counts: &[u32]) -> Option<Wires> {
        let Interconnect::Network(network) = interconnect else {
            return None;
        };
        let places = interconnect::places(counts);
        let elements = places.len() as u32;
        let columns = network.columns(elements).min(elements.max(1));
        Some(Wires {
            network,
            columns,
            rows: elements.div_ceil(columns),
            bits: elements.max(1).next_power_of_two().ilog2(),
            places,
        })
    }

    /// The number of links.
    pub(super) fn links(&self) -> usize {
        let rectangle = (self.columns * self.rows) as usize;
        let square = 1_usize << self.bits;
        match self.network.topology {
            Topology::Bus => 1,
            Topology::Mesh | Topology::Torus => 4 * rectangle,
            Topology::Hypercube => square * self.bits.max(1) as usize,
            Topology::Omega => square * (self.bits as usize + 1),
        }
    }

    /// Words a link carries in a cycle.
    pub(super) fn words(&self) -> u8 {
        self.network.words.min(u32::from(u8::MAX)) as u8
    }

    /// The longest time a word travels, in cycles.
    pub(super) fn longest(&self) -> u32 {
        let hops = match self.network.topology {
            Topology::Bus => 1,
            Topology::Mesh => self.columns + self.rows,
            Topology::Torus => self.columns / 2 + self.rows / 2,
            Topology::Omega | Topology::Hypercube => self.bits,
        };
        hops * self.network.hop
    }

    /// Cycles from the departure of a word to its arrival.
    pub(super) fn latency(&self, from: Element, to: Element) -> u32 {
        if from == to {
            return 0;
        }
        let (from, to) = (self.places[from.index()], self.places[to.index()]);
        let along = |difference: u32, length: u32| match self.network.topology {
            Topology::Torus => difference.min(length - difference),
            _ => difference,
        };
        let hops = match self.network.topology {
            Topology::Bus => 1,
            Topology::Mesh | Topology::Torus => {
                let columns = (from % self.columns).abs_diff(to % self.columns);
                let rows = (from / self.columns).abs_diff(to / self.columns);
                along(columns, self.columns) + along(rows, self.rows)
            }
            Topology::Hypercube => (from ^ to).count_ones(),
            Topology::Omega => self.bits,
        };
        hops * self.network.hop
    }

    /// The links on the way, each with the cycles from the departure to its
    /// use.
    pub(super) fn way(
        &self,
        from: Element,
        to: Element,
    ) -> impl Iterator<Item = (usize, u32)> + '_ {
        let (start, end) = (self.places[from.index()], self.places[to.index()]);
        let mut at = start;
        let mut step = 0;
        let mut entered = self.network.topology != Topology::Omega;
        let mut arrived = from == to;
        std::iter::from_fn(move || {
            if arrived {
                return None;
            }
            if !entered {
                // The line of the element itself, in the cycle of departure.
                entered = true;
                return Some((start as usize, 0));
            }
            let (link, next) = self.step(at, end, step);
            let delay = step * self.network.hop;
            step += 1;
            at = next;
            arrived = match self.network.topology {
                Topology::Bus => true,
                Topology::Omega => step == self.bits,
                _ => at == end,
            };
            Some((link, delay))
        })
    }

    /// The next link from a place towards another, and where it leads.
    fn step(&self, at: u32, end: u32, step: u32) -> (usize, u32) {
        match self.network.topology {
            Topology::Bus => (0, end),
            Topology::Mesh | Topology::Torus => {
                let (column, row) = (at % self.columns, at / self.columns);
                let (to_column, to_row) = (end % self.columns, end / self.columns);
                let (direction, next) = if column == to_column {
                    let (up, row) = self.along(row, to_row, self.rows);
                    (2 + usize::from(!up), row * self.columns + column)
                } else {
                    let (up, column) = self.along(column, to_column, self.columns);
                    (usize::from(!up), row * self.columns + column)
                };
                (4 * at as usize + direction, next)
            }
            Topology::Hypercube => {
                let bit = (at ^ end).trailing_zeros();
                ((at * self.bits + bit) as usize, at ^ 1 << bit)
            }
            Topology::Omega => {
                // A shuffle moves the highest bit to the lowest place, where
                // the switch puts the next bit of the destination.
                let mask = (1 << self.bits) - 1;
                let bit = end >> (self.bits - 1 - step) & 1;
                let line = (at << 1 & mask) | bit;
                (((step + 1) << self.bits | line) as usize, line)
            }
        }
    }

    /// One step along a row or column: whether it goes up, and to where.
    fn along(&self, at: u32, to: u32, length: u32) -> (bool, u32) {
        let up = match self.network.topology {
            Topology::Torus => (to + length - at) % length <= length / 2,
            _ => to > at,
        };
        let next = if up { at + 1 } else { at + length - 1 };
        (up, next % length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wires(topology: Topology, elements: u32) -> Wires {
        let interconnect = Interconnect::Network(LinkNetwork::of(topology));
        Wires::new(interconnect, &[elements]).expect("it is a network")
    }

    #[test]
    fn ways_take_as_long_as_they_have_links() {
        for topology in Topology::ALL {
            for elements in [2, 5, 8, 9, 13] {
                let wires = wires(topology, elements);
                for (from, to) in (0..elements * elements)
                    .map(|pair| [pair / elements, pair % elements].map(Element::new).into())
                {
                    let way: Vec<(usize, u32)> = wires.way(from, to).collect();
                    let latency = wires.latency(from, to);
                    let last = way.last().map_or(0, |(_, delay)| delay + 1);
                    assert_eq!(latency, last, "{topology:?} {from} {to}");
                    assert!(latency <= wires.longest());
                    assert!(way.iter().all(|(link, _)| *link < wires.links()));
                }
            }
        }
    }

    #[test]
    fn ways_to_one_element_meet_and_those_from_one_part() {
        for topology in Topology::ALL {
            let wires = wires(topology, 8);
            for start in 0..8 {
                // A link is entered from one side only: equal links of two
                // ways from one element are used at the same time.
                let mut used = std::collections::BTreeMap::new();
                for end in (0..8).filter(|&end| end != start) {
                    for (link, delay) in wires.way(Element::new(start), Element::new(end)) {
                        assert_eq!(*used.entry(link).or_insert(delay), delay, "{topology:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn distances_are_those_of_the_figures() {
        // Eight elements: three columns and three rows; three dimensions.
        let far = |topology| {
            let wires = wires(topology, 8);
            (1..8)
                .map(|to| wires.latency(Element::new(0), Element::new(to)))
                .max()
        };
        assert_eq!(far(Topology::Bus), Some(1));
        assert_eq!(far(Topology::Mesh), Some(3));
        assert_eq!(far(Topology::Torus), Some(2));
        assert_eq!(far(Topology::Omega), Some(3));
        assert_eq!(far(Topology::Hypercube), Some(3));
    }
}
