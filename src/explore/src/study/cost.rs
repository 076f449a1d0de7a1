//! Share of its device that a placement takes, and error of its program: the
//! two figures beside every number of cycles of a study.

use super::program::ProgramFacts;
use super::results::{Results, StudyPlacement};
use crate::device;
use crate::placing::{with_counts, words_of_a_side};
use robovec_analysis::rounding::UNIT;
use robovec_error::yardstick::account::{ERROR_COLUMNS, random_states};
use robovec_fpga::hardware::MachineShape;
use robovec_ir::Operation;
use robovec_present::DataCell;
use robovec_present::number::exponential;

/// Heads of the cells of [`cells`].
pub(super) fn columns() -> String {
    format!("share of device (%) | {ERROR_COLUMNS}")
}

/// The hardware for a placement: memories and buffers as large as the program
/// needs, unless the machine says how large they are.
pub(super) fn shape(results: &Results, placed: StudyPlacement<'_>) -> MachineShape {
    let most = |words: [f64; 2]| words[0].max(words[1]) as u32;
    let of = |kind: usize| &placed.point.kinds[kind];
    let memory = most([of(0).memory[2], of(1).memory[2]]);
    let buffer = most([of(0).buffer[2], of(1).buffer[2]]).max(1);
    let request = placed.request;
    let machine = with_counts(
        &results.plan.machines[request.machine].machine,
        &[
            (Operation::Add, request.n_add),
            (Operation::Mul, request.n_multi),
        ],
    );
    let words = words_of_a_side(memory, &machine).max(1);
    let mut shape = MachineShape::of(&machine, placed.point.cycles, words);
    if let (Some(own), Some(declared)) = (&mut shape.buffer, &machine.buffer) {
        own.0 = declared.words.unwrap_or(buffer);
    }
    shape
}

/// The share of the device that the machine takes for a placement, by
/// formulas; above 1 it does not fit.
pub(super) fn share(results: &Results, placed: StudyPlacement<'_>) -> f64 {
    let shape = shape(results, placed);
    device::taken_by(&shape, shape.device).share(shape.device)
}

/// The median and the worst error of a program in binary32, in parts of the
/// largest element of an array.
pub(super) fn errors(facts: &ProgramFacts) -> [f64; 2] {
    let normwise = facts.rounding[1].normwise;
    [normwise.median * UNIT, normwise.worst * UNIT]
}

/// Source of the errors of a program, in words.
pub(super) fn states(facts: &ProgramFacts) -> String {
    let rounding = &facts.rounding[1];
    random_states(rounding.states as usize, rounding.seed, false)
}

/// Share and errors as cells; [`columns`] heads them.
pub(super) fn cells(share: Option<f64>, facts: Option<&ProgramFacts>) -> [DataCell; 3] {
    let error = |place: usize| match facts {
        Some(facts) => DataCell::text(exponential(errors(facts)[place])),
        None => DataCell::Empty,
    };
    let share = share.map_or(DataCell::Empty, |share| DataCell::number(100.0 * share, 2));
    [share, error(0), error(1)]
}
