//! Scheduling and placement (thesis 2.3): every operation gets a cycle and a
//! processing element, every word an address, every transfer a cycle.
//!
//! The parts, in the order in which they run:
//!
//! - `graph`: dependences, kinds, longest chains before and after each node;
//! - `bound`: a length no schedule can beat;
//! - `order`, `list`: priorities, and how short a schedule they give without
//!   memories;
//! - `sweep`, with `state`, `ready`, `plan`, `choice`, `commit`, `ports` and
//!   `locations`: the placement itself, cycle by cycle; `ahead`, with `seats`,
//!   does without buffers;
//! - `search`: which orders are tried, and what is kept;
//! - `homes`: words that keep the outputs to the end;
//! - `addresses`, `finish`: addresses by lifetime, and the result.
//!
//! The time is linear in the number of operations, up to the sorting of
//! priorities and the number of elements that an operation can choose from.
//! Node order, names and sources stay; operands of commutative operations may
//! change sides on machines with a memory per side.

mod addresses;
mod ahead;
mod bound;
mod choice;
mod commit;
mod error;
mod finish;
mod graph;
mod homes;
mod list;
mod locations;
mod network;
mod order;
mod pass;
mod plan;
mod ports;
mod ready;
#[cfg(test)]
mod rules;
mod search;
mod seats;
mod state;
mod statistics;
mod sweep;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use choice::ElementChoice;
pub use error::PlaceError;
pub use order::Priority;
pub use pass::{ElementCounts, Place, element_counts, explain, with_counts};
pub use statistics::{
    ElementSpread, KindStatistics, PlacementStatistics, most_memory_words, placement_statistics,
};

use graph::DependenceGraph;
use order::SchedulingOrder;
use robovec_ir::{Function, Machine};
use search::PlacementSearch;
use state::Task;

/// The maximum number of entries the table of write ports may have: one per
/// memory and cycle, in bytes.
const LARGEST_TABLE: u64 = 1 << 30;

/// The choices with which a function is placed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct PlaceOptions {
    /// The rule for the order of operations.
    pub priority: Priority,
    /// The rule that chooses an element for an operation.
    pub choice: ElementChoice,
}

/// The result of a placement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PlaceSummary {
    /// Length of the schedule, in cycles.
    pub cycles: u32,
    /// No schedule on this machine is shorter.
    pub lower_bound: u32,
    /// The order that gave the schedule.
    pub order: &'static str,
    /// Orders tried, with or without memories.
    pub tries: u32,
}

/// A lower bound of the length of every schedule of a function on a machine,
/// without a placement.
///
/// # Errors
///
/// As [`place`], except for memories.
pub fn schedule_bound(function: &Function, machine: &Machine) -> Result<u32, PlaceError> {
    let graph = DependenceGraph::new(function, machine)?;
    Ok(bound::lower_bound(
        &graph,
        &SchedulingOrder::fan_out(&graph),
    ))
}

/// Places a function on a machine.
///
/// # Errors
///
/// Fails when the machine cannot perform the function (an operation it lacks,
/// an angle it would have to compute, a memory too small); the function is then
/// unchanged.
pub fn place(
    function: &mut Function,
    machine: &Machine,
    options: PlaceOptions,
) -> Result<PlaceSummary, PlaceError> {
    let graph = DependenceGraph::new(function, machine)?;
    let memories = ports::Ports::new(machine).width() as u64;
    if u64::from(graph.path) * memories > LARGEST_TABLE {
        return Err(PlaceError::TooLong {
            path: graph.path.into(),
            limit: LARGEST_TABLE / memories,
        });
    }
    let fan_out = SchedulingOrder::fan_out(&graph);
    let lower_bound = bound::lower_bound(&graph, &fan_out);
    let mut search = PlacementSearch {
        task: Task {
            function,
            graph: &graph,
            machine,
            choice: options.choice,
            target: lower_bound,
        },
        best: None,
        tries: 0,
    };
    match options.priority {
        Priority::Alap => search.sweep("alap", &SchedulingOrder::alap(&graph)),
        Priority::Mobility => search.sweep("mobility", &SchedulingOrder::mobility(&graph)),
        Priority::FanOut => search.sweep("fan-out", &fan_out),
        Priority::Best => search.best(&fan_out),
    }
    let tries = search.tries;
    let Some(best) = search.best else {
        // Binding ahead works wherever a memory can be written at all.
        return Err(PlaceError::NoWritePorts {
            machine: machine.name.clone(),
        });
    };
    let summary = PlaceSummary {
        cycles: best.draft.cycles,
        lower_bound,
        order: best.order,
        tries,
    };
    finish::finish(function, graph, machine, best, lower_bound)?;
    Ok(summary)
}
