//! The interconnect by which results travel from element to element (thesis
//! 1.1.3).
//!
//! # Conventions
//!
//! A word *departs* in the cycle in which it is on its element's result bus, or
//! is shown by the element's buffer. Over the crossbar it arrives in the same
//! cycle. Over a network it passes *links*, each in its own cycle: the `k`-th
//! of them, from 0, `k * hop` cycles after the departure, and it arrives `hop`
//! cycles after the last. A word of an element's own memory passes no link and
//! arrives immediately.
//!
//! Routes are static: the way from one element to another is always the same,
//! and the ways of one word form a tree. A link carries `words` words in a
//! cycle; one word from one departure counts once, for any number of target
//! elements, because switches copy it where its paths separate.
//!
//! The elements are in the network in the order of their numbers, the kinds
//! taking turns (`add0`, `multi0`, `add1`, `multi1`, …), so that elements that
//! work together are neighbours.

use super::fields;
use crate::diagnostic::counted;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// The interconnect by which results travel from element to element.
///
/// In a machine file either a name (`"crossbar"`, `"bus"`, `"mesh"`,
/// `"torus"`, `"omega"`, `"hypercube"`) or a table with the name as `kind`
/// and the fields of [`LinkNetwork`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Interconnect {
    /// Every result and every buffer output reaches every write port, any
    /// number of them in the same cycle.
    #[default]
    Crossbar,
    /// Words pass links that are shared.
    Network(LinkNetwork),
}

/// A network of links.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LinkNetwork {
    /// Its shape.
    pub topology: Topology,
    /// Cycles from one link to the next, and from the last to the memory: 1
    /// for links that end in registers, 0 for wires.
    pub hop: u32,
    /// Words a link carries in a cycle.
    pub words: u32,
    /// Routers in a row of a mesh or torus; absent, the smallest number whose
    /// square takes all elements.
    pub columns: Option<u32>,
}

robovec_num::named! {
    /// The shape of a network (thesis, figures 1.4 and 1.5).
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Topology {
        /// One link, heard by all.
        Bus = "bus",
        /// A rectangle of routers with a link in each direction between
        /// neighbours; words go along the row first, then along the column.
        Mesh = "mesh",
        /// A mesh whose rows and columns are rings; words take the shorter
        /// direction, upwards where both are equal.
        Torus = "torus",
        /// Stages of two-by-two switches after perfect shuffles, one stage per bit
        /// of the number of a place; a word enters on the line of its element.
        Omega = "omega",
        /// Routers whose numbers differ in one bit are neighbours; words correct
        /// the bits from the lowest up.
        Hypercube = "hypercube",
    }
}

impl LinkNetwork {
    /// The network of a shape with one word per link and cycle and a register
    /// after every link.
    pub fn of(topology: Topology) -> LinkNetwork {
        LinkNetwork {
            topology,
            hop: 1,
            words: 1,
            columns: None,
        }
    }

    /// Routers in a row of a mesh or torus of this number of elements.
    pub fn columns(&self, elements: u32) -> u32 {
        let square = || {
            let root = elements.isqrt();
            root + u32::from(root * root < elements)
        };
        self.columns.unwrap_or_else(square).max(1)
    }

    /// The fault that makes the network of this number of elements impossible,
    /// or `None`.
    pub(super) fn fault(&self, elements: u32) -> Option<String> {
        let name = self.topology.name();
        let columns = self.columns?;
        if !matches!(self.topology, Topology::Mesh | Topology::Torus) {
            return Some(format!("the interconnect '{name}' has no columns"));
        }
        (columns > elements).then(|| {
            format!(
                "the interconnect '{name}' has {} for {}; at most one for each is allowed",
                counted(columns, "column"),
                counted(elements, "element")
            )
        })
    }
}

impl Interconnect {
    /// The name of its shape.
    pub fn name(&self) -> &'static str {
        match self {
            Interconnect::Crossbar => CROSSBAR,
            Interconnect::Network(network) => network.topology.name(),
        }
    }

    /// The interconnect of a name, with usual parameters.
    pub fn named(name: &str) -> Option<Interconnect> {
        if name == CROSSBAR {
            return Some(Interconnect::Crossbar);
        }
        let mut all = Topology::ALL.into_iter();
        let topology = all.find(|topology| topology.name() == name)?;
        Some(Interconnect::Network(LinkNetwork::of(topology)))
    }
}

/// The place of every element in the network, for this number of elements of
/// each kind: by number, kinds taking turns.
pub fn places(counts: &[u32]) -> Vec<u32> {
    let mut elements: Vec<(u32, usize)> = Vec::new();
    for (kind, &count) in counts.iter().enumerate() {
        elements.extend((0..count).map(|number| (number, kind)));
    }
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by_key(|&element| elements[element]);
    let mut places = vec![0; order.len()];
    for (place, &element) in (0..).zip(&order) {
        places[element] = place;
    }
    places
}

const CROSSBAR: &str = "crossbar";

/// The table form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    kind: String,
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "fields::hop::deserialize"
    )]
    hop: Option<u32>,
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "fields::link_words::deserialize"
    )]
    words: Option<u32>,
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "fields::columns::deserialize"
    )]
    columns: Option<u32>,
}

impl Serialize for Interconnect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Interconnect::Network(network) if *network != LinkNetwork::of(network.topology) => {
                Table {
                    kind: self.name().to_owned(),
                    hop: Some(network.hop),
                    words: Some(network.words),
                    columns: network.columns,
                }
                .serialize(serializer)
            }
            _ => serializer.serialize_str(self.name()),
        }
    }
}

impl<'de> Deserialize<'de> for Interconnect {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Interconnect, D::Error> {
        deserializer.deserialize_any(InterconnectVisitor)
    }
}

struct InterconnectVisitor;

impl<'de> Visitor<'de> for InterconnectVisitor {
    type Value = Interconnect;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the name of an interconnect, or a table with its 'kind'")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Interconnect, E> {
        Interconnect::named(name).ok_or_else(|| {
            E::custom(format!(
                "unknown interconnect '{name}': there are crossbar, bus, mesh, torus, omega and \
                 hypercube"
            ))
        })
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Interconnect, M::Error> {
        let table = Table::deserialize(MapAccessDeserializer::new(map))?;
        let mut interconnect = self.visit_str(&table.kind)?;
        match &mut interconnect {
            Interconnect::Network(network) => {
                network.hop = table.hop.unwrap_or(network.hop);
                network.words = table.words.unwrap_or(network.words);
                network.columns = table.columns;
            }
            Interconnect::Crossbar => {
                let given = [table.hop, table.words, table.columns];
                if given.iter().any(Option::is_some) {
                    let message = "the crossbar has neither hops nor words nor columns";
                    return Err(serde::de::Error::custom(message));
                }
            }
        }
        Ok(interconnect)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Machine;

    fn machine(interconnect: &str) -> Result<Machine, crate::machine::MachineError> {
        let text = include_str!("../../machines/thesis.toml");
        Machine::parse(&format!("interconnect = {interconnect}\n{text}"))
    }

    #[test]
    fn interconnects_are_names_or_tables() {
        for name in ["crossbar", "bus", "mesh", "torus", "omega", "hypercube"] {
            let machine = machine(&format!("\"{name}\"")).expect("it is one");
            assert_eq!(machine.interconnect.name(), name);
            let written = toml::to_string(&machine).expect("it can be written");
            assert_eq!(Machine::parse(&written), Ok(machine));
        }
        let machine = machine("{kind = \"mesh\", columns = 2, hop = 0}").expect("it is one");
        let expected = LinkNetwork {
            hop: 0,
            columns: Some(2),
            ..LinkNetwork::of(Topology::Mesh)
        };
        assert_eq!(machine.interconnect, Interconnect::Network(expected));
        let written = toml::to_string(&machine).expect("it can be written");
        assert_eq!(Machine::parse(&written), Ok(machine));
    }

    #[test]
    fn impossible_interconnects_are_refused() {
        for wrong in [
            "\"rings\"",
            "7",
            "{kind = \"crossbar\", hop = 1}",
            "{kind = \"bus\", columns = 2}",
            "{kind = \"mesh\", columns = 0}",
            "{kind = \"mesh\", columns = 9}",
            "{kind = \"torus\", columns = 4096}",
            "{kind = \"bus\", words = 0}",
            "{kind = \"bus\", width = 2}",
            "{words = 2}",
        ] {
            assert!(machine(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn kinds_take_turns_in_the_network() {
        assert_eq!(places(&[3, 2]), [0, 2, 4, 1, 3]);
        assert_eq!(places(&[1, 3, 1]), [0, 1, 3, 4, 2]);
    }
}
