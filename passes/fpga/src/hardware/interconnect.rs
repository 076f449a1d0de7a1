//! The resources of an interconnect (thesis 1.1.3): multiplexers, bit by bit,
//! and registers after links.
//!
//! A look-up table of six inputs chooses among four (thesis 1.3.1). Every write
//! port has a multiplexer, and in a network every link. Routers are counted
//! whole, those at the edge of a mesh without the links they lack. The
//! selecting bits come from instruction memories, which are counted separately.

use super::ResourceUse;
use robovec_ir::machine::{Interconnect, LinkNetwork, Topology};

/// The terminals that a machine has to connect.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Terminals {
    /// Elements.
    pub elements: u32,
    /// Words an element sends in a cycle: its result, and those its buffer
    /// shows.
    pub sources: u32,
    /// Write ports of an element.
    pub ports: u32,
    /// Bits of a word.
    pub width: u32,
}

/// Look-up tables per bit of a multiplexer of words.
fn choice(words: u32) -> u32 {
    words.saturating_sub(1).div_ceil(3)
}

pub(super) fn interconnect(interconnect: Interconnect, terminals: Terminals) -> ResourceUse {
    let Terminals {
        elements,
        sources,
        ports,
        width,
    } = terminals;
    let (tables, registers) = match interconnect {
        Interconnect::Crossbar => (elements * ports * choice(elements * sources), 0),
        Interconnect::Network(network) => {
            let links = links(&network, terminals);
            // A memory is written from the element itself or from the links
            // that end at it.
            let arrivals = elements * ports * choice(links.arriving * network.words + sources);
            let tables = links.count * network.words * choice(links.words);
            let registers = links.count * network.words * network.hop;
            (arrivals + tables, registers)
        }
    };
    ResourceUse {
        aluts: f64::from(tables) * f64::from(width),
        registers: f64::from(registers) * f64::from(width),
        ..ResourceUse::default()
    }
}

/// The links of a network.
struct Links {
    count: u32,
    /// Words each chooses among.
    words: u32,
    /// Links that end at an element.
    arriving: u32,
}

fn links(network: &LinkNetwork, terminals: Terminals) -> Links {
    let Terminals {
        elements, sources, ..
    } = terminals;
    let columns = network.columns(elements).min(elements.max(1));
    let rows = elements.div_ceil(columns);
    let dimensions = elements.max(1).next_power_of_two().ilog2();
    match network.topology {
        Topology::Bus => Links {
            count: 1,
            words: elements * sources,
            arriving: 1,
        },
        // A word goes on straight, turns, or starts.
        Topology::Mesh => Links {
            count: 2 * (rows * (columns - 1) + columns * (rows - 1)),
            words: 3 + sources,
            arriving: 4,
        },
        Topology::Torus => Links {
            count: 4 * rows * columns,
            words: 3 + sources,
            arriving: 4,
        },
        Topology::Hypercube => Links {
            count: dimensions << dimensions,
            words: dimensions.saturating_sub(1) + sources,
            arriving: dimensions,
        },
        Topology::Omega => Links {
            count: dimensions << dimensions,
            // The switches, and before them the multiplexer of the word that
            // enters, counted with each stage.
            words: 1 + sources,
            arriving: 1,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THESIS: Terminals = Terminals {
        elements: 8,
        sources: 2,
        ports: 2,
        width: 32,
    };

    fn of(topology: Topology, terminals: Terminals) -> ResourceUse {
        interconnect(Interconnect::Network(LinkNetwork::of(topology)), terminals)
    }

    #[test]
    fn the_crossbar_is_that_of_table_1_4() {
        let taken = interconnect(Interconnect::Crossbar, THESIS);
        // 16 choices of 160 tables each (thesis 1.3.1).
        assert_eq!(taken.aluts, 2560.0);
        assert_eq!(taken.registers, 0.0);
        let bufferless = Terminals {
            sources: 1,
            ..THESIS
        };
        // Half the sources, as the thesis' perspective has it.
        assert_eq!(
            interconnect(Interconnect::Crossbar, bufferless).aluts,
            16.0 * 32.0 * 3.0
        );
    }

    #[test]
    fn networks_grow_slower_than_the_crossbar() {
        let large = Terminals {
            elements: 64,
            ..THESIS
        };
        let crossbar = |terminals| interconnect(Interconnect::Crossbar, terminals).aluts;
        let growth = crossbar(large) / crossbar(THESIS);
        for topology in Topology::ALL {
            let (small, large) = (of(topology, THESIS), of(topology, large));
            assert!(large.aluts / small.aluts < growth / 3.0, "{topology:?}");
            assert!(large.registers > 0.0);
        }
        // Three rows of three: twelve neighbours, two links for each pair.
        assert_eq!(of(Topology::Mesh, THESIS).registers, 24.0 * 32.0);
    }
}
