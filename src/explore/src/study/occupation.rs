//! Occupation of the elements over a run (thesis 3.6): the share of issue slots
//! used, averaged over a window of cycles that rolls along, against the share
//! of the run that has passed.

use robovec_ir::placement::Schedule;
use serde::{Deserialize, Serialize};

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
