//! One placement, measured.

use super::occupation::{OccupationCurve, occupation};
use super::plan::{NamedMachine, PlacementRequest};
use super::program::StudyProgram;
use crate::placing::{verified, with_counts};
use robovec_ir::Operation;
use robovec_schedule::ElementSpread;
use serde::{Deserialize, Serialize};

/// Part of a placement that is kept. Names and numbers of its
/// [`PlacementRequest`] are not part of it: a point is found by its key.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedPoint {
    /// Reason why there is no placement; everything else is 0 then.
    pub failure: Option<String>,
    /// Length: the first cycle in which every result can be read.
    pub cycles: u32,
    /// No schedule on this machine is shorter (proved).
    pub lower_bound: u32,
    /// Operations per element and cycle.
    pub rate: f64,
    /// Adders, and multipliers.
    pub kinds: [KindPoint; 2],
    /// Writes in the cycle in which the result appears.
    pub direct_writes: u32,
    /// Writes through a buffer.
    pub indirect_writes: u32,
    /// Operations by their rank in Table 2.1.
    pub ranks: [u32; 9],
}

/// Work of the elements of one kind.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KindPoint {
    /// Operations they perform together.
    pub operations: u32,
    /// Operations per element and cycle.
    pub rate: f64,
    /// Words of memory per element: least, mean, most.
    pub memory: [f64; 3],
    /// Words of buffer per element: least, mean, most.
    pub buffer: [f64; 3],
    /// Occupation over normalised time.
    pub occupation: OccupationCurve,
}

/// Places a program and measures the placement, which the verifier has
/// accepted.
pub(super) fn measure(
    program: &StudyProgram,
    machine: &NamedMachine,
    request: &PlacementRequest,
) -> PlacedPoint {
    // Fused elements are as many as the machine has.
    let counts = [
        (Operation::Add, request.n_add),
        (Operation::Mul, request.n_multi),
    ];
    let machine = with_counts(&machine.machine, &counts);
    let placed = match verified(&program.module, &machine, request.options) {
        Ok(placed) => placed,
        Err(reason) => {
            return PlacedPoint {
                failure: Some(reason),
                ..PlacedPoint::default()
            };
        }
    };
    let statistics = placed.statistics(&machine);
    let schedule = placed.function.schedule.as_ref();
    let schedule = schedule.expect("what is placed has a schedule");
    let kind = |operation: Operation| {
        let Some(index) = machine.kind_of(operation) else {
            return KindPoint::default();
        };
        let statistics = &statistics.kinds[index];
        KindPoint {
            operations: statistics.operations,
            rate: statistics.occupancy,
            memory: words(statistics.memory),
            buffer: words(statistics.buffer),
            occupation: occupation(schedule, index),
        }
    };
    PlacedPoint {
        failure: None,
        cycles: schedule.cycles,
        lower_bound: schedule.lower_bound,
        rate: statistics.parallelisation_rate,
        kinds: [kind(Operation::Add), kind(Operation::Mul)],
        direct_writes: statistics.direct_writes,
        indirect_writes: statistics.indirect_writes,
        ranks: statistics.ranks,
    }
}

fn words(spread: ElementSpread) -> [f64; 3] {
    [f64::from(spread.min), spread.mean, f64::from(spread.max)]
}
