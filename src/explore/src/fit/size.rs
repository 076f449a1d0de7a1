//! Number of elements: the fewest that meet the deadline, and more.

use super::{FitProgram, FitTask};
use crate::device::{MachineFigures, figures};
use crate::placing::{placed, with_fused};
use robovec_fpga::hardware;
use robovec_ir::count::Counts;
use robovec_ir::{Format, Machine};
use robovec_schedule::{PlaceError, PlaceOptions, schedule_bound};
use std::collections::HashMap;

/// The maximum number of elements of a kind.
const MOST: u32 = 64;

/// A machine with its schedule.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct SizedMachine {
    /// Elements that add, and that multiply.
    pub(super) elements: [u32; 2],
    pub(super) cycles: u32,
    /// The maximum number of words of memory in one element.
    pub(super) words: u32,
}

impl SizedMachine {
    /// The machine with these numbers of elements.
    pub(super) fn machine(&self, machine: &Machine) -> Machine {
        with_fused(machine, self.elements)
    }

    /// The time of its schedule: many elements slow the clock down.
    pub(super) fn microseconds(&self, machine: &Machine) -> f64 {
        hardware::clock(&self.machine(machine)).microseconds(self.cycles)
    }
}

/// Figures that were computed before. Whenever a choice fails, all candidates
/// are compared again, with other errors on the same machines.
#[derive(Default)]
pub(super) struct KnownFigures(HashMap<(SizedMachine, Format), MachineFigures>);

impl KnownFigures {
    /// The figures of a sized machine in a format.
    pub(super) fn of(
        &mut self,
        machine: &Machine,
        size: &SizedMachine,
        format: Format,
    ) -> MachineFigures {
        let compute = || figures(&size.machine(machine), format, size.cycles, size.words);
        let known = self.0.entry((size.clone(), format));
        *known.or_insert_with(compute)
    }
}

/// Small numbers of elements with more of the busier kind, fewer of it and more
/// of it: memories have powers of two of words, so that one element more may
/// take less of a device than the instructions that it saves.
const UNEVEN: [[u32; 2]; 2] = [[1, 2], [1, 3]];

/// The sizes a program is placed on: equal numbers by powers of two up to the
/// longest chain, small ones with more of the busier kind, and the fewest
/// adders and multipliers within the deadline.
///
/// # Errors
///
/// Fails when it cannot be placed with any number of elements.
pub(super) fn sizes(
    task: &FitTask<'_>,
    program: &FitProgram,
) -> Result<Vec<SizedMachine>, PlaceError> {
    let mut sizes: Vec<SizedMachine> = Vec::new();
    let mut refused: Option<PlaceError> = None;
    let mut count = 1;
    while count <= MOST {
        match attempt(task, program, [count, count]) {
            Ok(size) if sizes.last().is_none_or(|last| size.cycles < last.cycles) => {
                sizes.push(size);
            }
            Ok(_) => break,
            // More elements have more memory.
            Err(error) => refused = Some(error),
        }
        count *= 2;
    }
    match (sizes.is_empty(), refused) {
        (true, Some(error)) => Err(error),
        _ => {
            sizes.extend(uneven(task, program, &sizes));
            let fewest = fewest(task, program);
            let known = |size: &SizedMachine| sizes.iter().any(|one| one.elements == size.elements);
            let fewest = fewest.filter(|size| !known(size));
            sizes.extend(fewest);
            Ok(sizes)
        }
    }
}

/// Sizes with more elements of the busier kind, where that is shorter.
fn uneven(task: &FitTask<'_>, program: &FitProgram, even: &[SizedMachine]) -> Vec<SizedMachine> {
    let counts = Counts::of(&program.module.functions[0]);
    let adds = counts.add_sub > counts.mul;
    let mut sizes = Vec::new();
    for [few, many] in UNEVEN {
        let elements = if adds { [many, few] } else { [few, many] };
        let Ok(size) = attempt(task, program, elements) else {
            continue;
        };
        let shorter = |other: &SizedMachine| {
            let covers = (0..2).all(|kind| other.elements[kind] <= elements[kind]);
            !covers || size.cycles < other.cycles
        };
        if even.iter().chain(&sizes).all(shorter) {
            sizes.push(size);
        }
    }
    sizes
}

fn attempt(
    task: &FitTask<'_>,
    program: &FitProgram,
    elements: [u32; 2],
) -> Result<SizedMachine, PlaceError> {
    let machine = with_fused(task.machine, elements);
    let placed = placed(&program.module, &machine, PlaceOptions::default())?;
    Ok(SizedMachine {
        elements,
        cycles: placed.summary.cycles,
        words: placed.most_words(&machine),
    })
}

/// The fewest elements within the deadline: from the number that the work
/// needs, one more of the kind with the larger work bound until the schedule is
/// short enough; then fewer again, as long as it stays so.
fn fewest(task: &FitTask<'_>, program: &FitProgram) -> Option<SizedMachine> {
    let limit = task.scene.deadline?;
    let deadline = (limit * hardware::clock(task.machine).mhz).floor();
    if deadline < 1.0 {
        return None;
    }
    let deadline = deadline.min(f64::from(u32::MAX)) as u32;
    let function = &program.module.functions[0];
    let counts = Counts::of(function);
    let needed = |operations: usize| (operations as u32).div_ceil(deadline).max(1);
    let mut elements = [needed(counts.add_sub), needed(counts.mul)];
    // No number of elements beats the longest chain.
    let many = with_fused(task.machine, [MOST, MOST]);
    if schedule_bound(function, &many).ok()? > deadline {
        return None;
    }
    loop {
        if elements.iter().any(|&count| count > MOST) {
            return None;
        }
        let size = attempt(task, program, elements).ok()?;
        if size.microseconds(task.machine) <= limit {
            return Some(fewer(task, program, size, limit));
        }
        // The kind with more work per element comes first.
        let load = [counts.add_sub, counts.mul].map(|work| work as f64);
        let share = |kind: usize| load[kind] / f64::from(elements[kind]);
        let kind = usize::from(share(1) >= share(0));
        elements[kind] += 1;
    }
}

fn fewer(
    task: &FitTask<'_>,
    program: &FitProgram,
    mut size: SizedMachine,
    limit: f64,
) -> SizedMachine {
    for kind in [1, 0] {
        while size.elements[kind] > 1 {
            let mut elements = size.elements;
            elements[kind] -= 1;
            match attempt(task, program, elements) {
                Ok(less) if less.microseconds(task.machine) <= limit => size = less,
                Ok(_) | Err(_) => break,
            }
        }
    }
    size
}
