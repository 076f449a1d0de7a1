//! Proofs by intervals.

use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, RangeBasis, USUAL, WindowLeaves, enclose, subdivide,
};
use robovec_framework::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, Operand, OperandKind, Tables, View};
use robovec_num::interval::Interval;

/// Bounds of errors in the ranges of a scene.
pub(super) struct Trial<'a> {
    tables: &'a Tables,
    states: States,
    format: Format,
    boxes: usize,
}

impl<'a> Trial<'a> {
    pub(super) fn new(
        tables: &'a Tables,
        scene: &Scene,
        (format, boxes): (Format, usize),
    ) -> Trial<'a> {
        Trial {
            tables,
            states: scene.states(super::SEED),
            format,
            boxes,
        }
    }

    /// Bound of the total error of the operations before an operand, for
    /// all states in the ranges; `None` where an input has no range, or there
    /// are too many operations, or no bound.
    pub(super) fn bound(&self, function: &Function, operand: Operand) -> Option<f64> {
        let tables = self.tables;
        let tape = Tape::new(function);
        let window = ConeWindow::new(&tape, slot(&tape, operand)?, USUAL);
        let known = Leaves::new(View { tables, function }, &tape, &self.states, 0);
        let leaves = WindowLeaves::new(&tape, &window, self.format, GivenData::Held, &known);
        if leaves.knowledge != RangeBasis::Given {
            return None;
        }
        let found = subdivide(&tape, &window, &leaves, self.boxes);
        found.error.is_finite().then_some(found.error)
    }
}

/// True when an operand is a positive number for all inputs.
pub(super) fn is_positive(function: &Function, operand: Operand) -> bool {
    let tape = Tape::new(function);
    let Some(slot) = slot(&tape, operand) else {
        return false;
    };
    let window = ConeWindow::new(&tape, slot, USUAL);
    let is_literal = |&leaf: &usize| leaf >= tape.nodes() + tape.inputs();
    let ranges = window.leaves.iter().map(|leaf| {
        if is_literal(leaf) {
            let constant = tape.constants().get(leaf - tape.nodes() - tape.inputs());
            Interval::point(constant.copied().unwrap_or(0.0))
        } else {
            Interval::WHOLE
        }
    });
    let ranges: Vec<Interval> = ranges.collect();
    let leaves = WindowLeaves::anything(&window, Format::BINARY64, ranges);
    let enclosure = enclose(&tape, &window, &leaves, &leaves.ranges);
    enclosure.exact.last().is_some_and(|range| range.low > 0.0)
}

fn slot(tape: &Tape, operand: Operand) -> Option<usize> {
    match operand.kind() {
        OperandKind::Value(value) => Some(value.index()),
        OperandKind::Input(input) => Some(tape.input_slot(input)),
        OperandKind::Constant(constant) => Some(tape.constant_slot(constant)),
        OperandKind::None => None,
    }
}
