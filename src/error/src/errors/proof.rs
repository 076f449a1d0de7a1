//! Ranges and errors of every output proved for all states, beside the
//! largest errors that a search finds.

use super::table::{ErrorSettings, ErrorTable, OutputRow, interval};
use super::view::{MAX_ROWS, small};
use crate::adversary::{SearchSubject, largest_errors};
use robovec_analysis::adjoint::{Tape, TapeSlot};
use robovec_analysis::interval::{
    Alarm, ConeWindow, Leaves, RangeBasis, input_ranges, integer_bits,
};
use robovec_analysis::norms::{NormBounds, norm_bounds};
use robovec_ir::diagnostic::{clip, counted};
use robovec_ir::print::print_operand;
use robovec_ir::{Operand, View};
use robovec_num::interval::Interval;
use robovec_present::text_lines;
use serde::Serialize;
use std::fmt::Write;

/// Bounds of one output that hold for all states in the ranges.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ProofRow {
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// The largest absolute error; infinite where nothing is proved.
    pub error: f64,
    /// The largest error that the search found.
    pub found: f64,
    /// Origin of the bound: `norms` of the function, or `boxes` of its ranges.
    pub method: &'static str,
    /// Basis of the ranges of inputs: `given`, or `drawn` from random states.
    pub ranges: &'static str,
    /// A harmful consequence of the range in the format, if any.
    pub alarm: Option<&'static str>,
    /// Bits before the point that a fixed-point number needs.
    pub integer_bits: Option<u32>,
    /// Reason why nothing is proved.
    pub reason: Option<String>,
}

/// Proves bounds of requested outputs; returns the number of states searched.
pub(super) fn prove(view: View<'_>, tape: &Tape, settings: &ErrorSettings) -> (Vec<ProofRow>, u64) {
    let ranges = input_ranges(view, &settings.states);
    let basis = ranges.iter().map(|range| range.knowledge).max();
    let basis = basis.unwrap_or(RangeBasis::Given).name();
    let inputs: Vec<Interval> = ranges.iter().map(|range| range.range).collect();
    let bounds = norm_bounds(tape, &inputs, settings.format, settings.data);
    let subject = SearchSubject {
        view,
        inputs: &inputs,
        format: settings.format,
        data: settings.data,
    };
    let found = largest_errors(subject, settings.states.seed(), settings.effort);
    let leaves = Leaves::new(view, tape, &settings.states, 0);
    let rows = settings.outputs.iter().map(|&output| {
        let slot = tape.output_slot(output);
        let window = ConeWindow::new(tape, slot, settings.window);
        let whole = window.leaves.iter().all(|&leaf| leaf >= tape.nodes());
        let boxes = whole.then(|| interval(tape, &window, settings, &leaves));
        let (mut range, mut error, mut method) = (bounds.exact[slot], bounds.error[slot], "norms");
        let mut largest = found.errors[output];
        if let Some(boxes) = boxes {
            range = range.clamped(Interval::new(boxes.low, boxes.high));
            largest = largest.max(boxes.seen);
            if boxes.error < error {
                (error, method) = (boxes.error, "boxes");
            }
        }
        let unproved = error.is_infinite();
        ProofRow {
            low: range.low,
            high: range.high,
            error,
            found: largest,
            method,
            ranges: basis,
            alarm: Alarm::of(range, settings.format).map(Alarm::name),
            integer_bits: integer_bits(range),
            reason: unproved.then(|| reason(view, tape, &bounds, slot)),
        }
    });
    (rows.collect(), found.tried)
}

/// The first operation before an output without a proved bound.
fn reason(view: View<'_>, tape: &Tape, bounds: &NormBounds, slot: usize) -> String {
    let window = ConeWindow::new(tape, slot, usize::MAX);
    let slots = window.leaves.iter().chain(&window.nodes);
    let first = slots
        .copied()
        .find(|&slot| bounds.error[slot].is_infinite());
    let about = match tape.slot(first.expect("the output itself is one")) {
        TapeSlot::Value(value) => print_operand(view, Operand::from(value)),
        TapeSlot::Input(input) => print_operand(view, Operand::from(input)),
        TapeSlot::Constant(_) | TapeSlot::Nothing => "a literal".to_owned(),
    };
    format!(
        "{}: it can be too large for the format, or a divisor or number under a root too near zero",
        clip(&about)
    )
}

/// The proofs of a table for a user, the largest errors first.
pub(super) fn proof_text(errors: &ErrorTable) -> String {
    let mut rows: Vec<(&OutputRow, &ProofRow)> = errors
        .outputs
        .iter()
        .filter_map(|row| Some((row, row.proof.as_ref()?)))
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    rows.sort_by(|a, b| b.1.error.total_cmp(&a.1.error));
    let mut text = format!(
        "{}: errors in {} proved for all states in the ranges\n",
        errors.function, errors.format
    );
    text += &headline(&rows);
    let shown = &rows[..rows.len().min(MAX_ROWS)];
    let alarm = shown.iter().any(|row| row.1.alarm.is_some());
    let head = "output | >least | >greatest | >proved | >found | >proved/found | by";
    let head = format!("{head}{}", if alarm { " | alarm" } else { "" });
    let cells = shown.iter().map(|(output, row)| {
        let numbers = [row.low, row.high, row.error, row.found].map(small);
        let mut cells = vec![output.name.clone()];
        cells.extend(numbers);
        cells.extend([times(row.error, row.found), row.method.to_owned()]);
        if alarm {
            cells.push(row.alarm.unwrap_or("").to_owned());
        }
        cells
    });
    text += &text_lines(&head, &cells.collect::<Vec<_>>());
    let rest = rows.len() - shown.len();
    if rest > 0 {
        let _ = writeln!(
            text,
            "and {} with smaller errors",
            counted(rest, "more output")
        );
    }
    let unproved: Vec<&str> = (rows.iter())
        .filter_map(|row| row.1.reason.as_deref())
        .collect();
    if let Some(reason) = unproved.first() {
        let _ = writeln!(
            text,
            "{} without a bound, the first by {reason}",
            counted(unproved.len(), "output")
        );
    }
    let ranges = match rows[0].1.ranges {
        "given" => "ranges: as given",
        _ => "ranges: those that random states are drawn from; --scene sets others",
    };
    let _ = writeln!(
        text,
        "{ranges}\nfound: at {}",
        counted(errors.searched, "directed state")
    );
    text
}

/// The largest errors, proved and found.
fn headline(rows: &[(&OutputRow, &ProofRow)]) -> String {
    let found = rows.iter().max_by(|a, b| a.1.found.total_cmp(&b.1.found));
    let (proved, found) = (rows[0], found.expect("there are rows"));
    let mut text = format!(
        "largest proved {} ({})",
        small(proved.1.error),
        proved.0.name
    );
    let _ = write!(
        text,
        ", largest found {} ({})",
        small(found.1.found),
        found.0.name
    );
    let ratio = times(proved.1.error, found.1.found);
    if ratio != "-" {
        let _ = write!(text, ": {ratio} times as much is proved");
    }
    text + "\n"
}

/// The quotient of two errors with two digits or more; `-` without an end.
fn times(proved: f64, found: f64) -> String {
    let ratio = proved / found;
    if !ratio.is_finite() {
        "-".to_owned()
    } else if ratio < 1e6 {
        format!("{ratio:.*}", usize::from(ratio < 10.0))
    } else {
        small(ratio)
    }
}
