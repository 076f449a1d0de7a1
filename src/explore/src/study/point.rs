//! One placement, measured; the occupation of its elements over the run (thesis 3.6).

use super::plan::{NamedMachine, PlacementRequest};
use super::program::StudyProgram;
use crate::placing::{verified, with_elements};
use robovec_ir::Operation;
use robovec_ir::placement::Schedule;
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

/// Places a program and measures the placement, which is verified.
pub(super) fn measure(
    program: &StudyProgram,
    machine: &NamedMachine,
    request: &PlacementRequest,
) -> PlacedPoint {
    let machine = with_elements(&machine.machine, [request.n_add, request.n_multi]);
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

/// Cycles of the rolling window (thesis 3.6).
pub(super) const WINDOW: u32 = 50;

/// Samples of a run, equally spaced from its first to its last cycle.
pub(super) const SAMPLES: u32 = 201;

/// Occupation at [`SAMPLES`] moments, in thousandths.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct OccupationCurve(pub Vec<u16>);

impl OccupationCurve {
    /// Share of the run that has passed, and occupation, both from 0 to 1.
    pub fn curve(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let last = f64::from(SAMPLES - 1);
        let shares = self.0.iter().map(|&share| f64::from(share) / 1000.0);
        (0u32..)
            .zip(shares)
            .map(move |(index, share)| [f64::from(index) / last, share])
    }
}

/// The occupation of the elements of one kind, by its index in the schedule.
///
/// The window is centred, and cut off at the ends of the run.
pub(super) fn occupation(schedule: &Schedule, kind: usize) -> OccupationCurve {
    let before: u32 = schedule.kinds[..kind].iter().map(|kind| kind.count).sum();
    let count = schedule.kinds[kind].count;
    // issued[c] counts the operations issued before cycle c.
    let mut issued = vec![0u32; schedule.cycles as usize + 1];
    for slot in schedule.slots.iter().flatten() {
        if (before..before + count).contains(&slot.element.number()) {
            issued[slot.cycle as usize + 1] += 1;
        }
    }
    for cycle in 1..issued.len() {
        issued[cycle] += issued[cycle - 1];
    }
    let share = |sample: u32| {
        let last = u64::from(schedule.cycles.saturating_sub(1));
        let centre = (u64::from(sample) * last / u64::from(SAMPLES - 1)) as u32;
        let start = centre.saturating_sub(WINDOW / 2);
        let end = (centre + WINDOW / 2).min(schedule.cycles);
        let slots = u64::from(end - start) * u64::from(count);
        let used = u64::from(issued[end as usize] - issued[start as usize]);
        // Rounded to the nearest thousandth.
        ((2000 * used + slots) / (2 * slots).max(1)) as u16
    };
    OccupationCurve((0..SAMPLES).map(share).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::placement::{Element, ElementKind, Slot};

    /// One adder busy for the first half of 400 cycles, two multipliers of
    /// which one is busy all the time.
    fn schedule() -> Schedule {
        let kind = |name: &str, count| ElementKind {
            name: name.to_owned(),
            count,
        };
        let slot = |cycle, element| {
            let element = Element::new(element);
            Some(Slot { cycle, element })
        };
        let adds = (0..200).map(|cycle| slot(cycle, 0));
        let muls = (0..400).map(|cycle| slot(cycle, 2));
        Schedule {
            machine: "test".to_owned(),
            machine_hash: None,
            kinds: vec![kind("add", 1), kind("multi", 2)],
            slots: adds.chain(muls).chain([None]).collect(),
            cycles: 400,
            lower_bound: 400,
        }
    }

    #[test]
    fn the_window_rolls_over_the_edge_of_a_busy_half() {
        let adders = occupation(&schedule(), 0);
        assert_eq!(adders.0.len(), SAMPLES as usize);
        assert_eq!((adders.0[0], adders.0[80], adders.0[120]), (1000, 1000, 0));
        // Sample 100 is cycle 199: 24 idle cycles out of 50.
        assert_eq!(adders.0[100], 520);
    }

    #[test]
    fn one_of_two_elements_is_half() {
        assert!(
            occupation(&schedule(), 1)
                .0
                .iter()
                .all(|&share| share == 500)
        );
    }

    #[test]
    fn an_empty_run_is_idle() {
        let mut schedule = schedule();
        schedule.slots.clear();
        schedule.cycles = 0;
        assert!(occupation(&schedule, 0).0.iter().all(|&share| share == 0));
    }
}
