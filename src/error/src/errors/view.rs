//! Errors as text, JSON and CSV.

use super::heat::{Heat, HotEquation};
use super::proof::{ProofRow, proof_text};
use super::table::{ErrorTable, IntervalRow, OutputRow};
use robovec_ir::diagnostic::counted;
use robovec_present::json::json_text;
use robovec_present::number::or_dash;
use robovec_present::number::percent;
use robovec_present::{columns, text_lines};
use std::fmt::Write;

/// The rows of a table for a user; the others are counted.
pub(super) const MAX_ROWS: usize = 40;

/// Relative error of a divisor above which first-order bounds are unreliable.
const WEAK: f64 = 0.01;

/// Reliability of the bounds of a run.
fn first_order(weakest_divisor: f64) -> String {
    if weakest_divisor <= WEAK {
        return "bound: at this state, to first order\n".to_owned();
    }
    format!(
        "bound: not reliable, a divisor or root has a relative error of {} at this state, and \
         bounds are of first order\n",
        percent(weakest_divisor.min(1.0))
    )
}

/// Meaning of the columns of windows.
const ESTABLISHED: &str = "window loses: proved for all states in the ranges, unless the ranges \
     are assumed; seen: the largest error at random states in them\n";

/// The meaning of a mark before an exact value.
const ESTIMATE: &str = "~: an estimate, not certified\n";

/// Characters of a full bar.
const BAR: f64 = 24.0;

/// The table for a user: the outputs with the largest errors relative to their
/// exact values, in their order, and the heat.
pub fn text(errors: &ErrorTable) -> String {
    let proofs = proof_text(errors);
    let first = errors.outputs.first();
    let has = |pick: fn(&OutputRow) -> bool| first.is_some_and(pick);
    let of_state = |row: &OutputRow| {
        row.predicted.is_some()
            || row.bound.is_some()
            || row.sigma.is_some()
            || row.interval.is_some()
    };
    if !proofs.is_empty() && !first.is_some_and(of_state) {
        return proofs;
    }
    let mut text = proofs;
    if !text.is_empty() {
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "{}: errors in {} at state {} of seed {}",
        errors.function, errors.format, errors.state, errors.seed
    );
    let shown = worst(&errors.outputs);
    let mut head = "output | >exact | >error".to_owned();
    let columns = [
        has(|row| row.predicted.is_some()),
        has(|row| row.bound.is_some()),
        has(|row| row.sigma.is_some()),
        has(|row| row.interval.is_some()),
    ];
    let names = [
        " | >predicted",
        " | >bound",
        " | >sigma",
        " | >least | >greatest | >window loses | >seen | >boxes | >ranges",
    ];
    for (names, _) in names.iter().zip(columns).filter(|(_, has)| *has) {
        head.push_str(names);
    }
    let rows: Vec<Vec<String>> = shown
        .iter()
        .map(|&index| row(&errors.outputs[index]))
        .collect();
    text += &text_lines(&head, &rows);
    if shown.iter().any(|&index| !errors.outputs[index].certified) {
        text += ESTIMATE;
    }
    if columns[1] {
        text += &first_order(errors.weakest_divisor);
    }
    if columns[3] {
        text.push_str(ESTABLISHED);
    }
    let rest = errors.outputs.len() - shown.len();
    if rest > 0 {
        let _ = writeln!(
            text,
            "and {} with smaller relative errors",
            counted(rest, "more output")
        );
    }
    text.push('\n');
    text.push_str(&heat_title(&errors.heat));
    text.push('\n');
    text += &heat_text(&errors.heat);
    text
}

/// The places of the rows to show, in order.
fn worst(outputs: &[OutputRow]) -> Vec<usize> {
    let relative = |row: &OutputRow| match row.error {
        0.0 => 0.0,
        error => (error / row.exact).abs(),
    };
    let mut places: Vec<usize> = (0..outputs.len()).collect();
    places.sort_by(|&a, &b| relative(&outputs[b]).total_cmp(&relative(&outputs[a])));
    places.truncate(MAX_ROWS);
    places.sort_unstable();
    places
}

fn row(output: &OutputRow) -> Vec<String> {
    let mut cells = vec![
        output.name.clone(),
        format!(
            "{}{:.6e}",
            if output.certified { "" } else { "~" },
            output.exact
        ),
        small(output.error),
    ];
    let numbers = [output.predicted, output.bound, output.sigma];
    cells.extend(numbers.into_iter().flatten().map(small));
    if let Some(interval) = &output.interval {
        let mut ranges = interval.ranges.to_owned();
        if let Some(alarm) = interval.alarm {
            let _ = write!(ranges, ", {alarm}");
        }
        let mut loses = interval.error;
        if loses.is_infinite() && interval.share > 0.0 {
            // An error without an end somewhere says nothing of the rest.
            loses = interval.finite;
            let _ = write!(ranges, ", only {} of them", percent(interval.share));
        }
        let numbers = [interval.low, interval.high, loses, interval.seen];
        cells.extend(numbers.map(small));
        cells.push(interval.boxes.to_string());
        cells.push(ranges);
    }
    cells
}

/// Three digits and an exponent; a plain 0.
pub(super) fn small(number: f64) -> String {
    if number == 0.0 {
        "0".to_owned()
    } else {
        format!("{number:.2e}")
    }
}

/// Title of the heat.
pub fn heat_title(heat: &Heat) -> String {
    format!(
        "Heat: where the errors of {} in {} come from, {}, seed {}",
        counted(heat.outputs, "output"),
        heat.format,
        counted(heat.states, "state"),
        heat.seed
    )
}

/// The hottest equations, with bars, and the shares of inputs and literals.
pub fn heat_text(heat: &Heat) -> String {
    let mut text = String::new();
    if heat.equations.is_empty() && heat.inputs.is_empty() && heat.literals == 0.0 {
        text.push_str(match heat.refused {
            0 => "nothing is rounded\n",
            _ => "results are not finite, so no operation has a share\n",
        });
        return text;
    }
    // Bars tell equations apart even where none stands out.
    let hottest = heat
        .equations
        .first()
        .map_or(1.0, |equation| equation.share);
    let rows = heat
        .equations
        .iter()
        .map(|equation| equation_row(equation, hottest));
    let rows: Vec<Vec<String>> = rows.collect();
    let head = ">share |  | equation | >operations | where";
    text += &text_lines(head, &rows);
    if heat.literals > 0.0 {
        let _ = writeln!(
            text,
            "{} literals that the format cannot hold",
            percent(heat.literals)
        );
    }
    for input in &heat.inputs {
        let _ = writeln!(
            text,
            "{} input {}, which it cannot hold",
            percent(input.share),
            input.name
        );
    }
    if heat.refused > 0 {
        let _ = writeln!(
            text,
            "{} had results that are not finite",
            counted(heat.refused, "state")
        );
    }
    text
}

fn equation_row(equation: &HotEquation, hottest: f64) -> Vec<String> {
    vec![
        percent(equation.share),
        bar(equation.share / hottest),
        or_dash(equation.name.clone(), |name| name),
        equation.operations.to_string(),
        place(equation),
    ]
}

pub(super) fn place(equation: &HotEquation) -> String {
    match (&equation.file, equation.line, equation.column) {
        (Some(file), Some(line), Some(column)) => format!("{file}:{line}:{column}"),
        _ => "-".to_owned(),
    }
}

/// A bar from left to right, to eighths of a character.
fn bar(share: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (share.clamp(0.0, 1.0) * BAR * 8.0).round() as usize;
    let eighths = if share > 0.0 { eighths.max(1) } else { 0 };
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

/// The tables as JSON: a list with one object per function.
pub fn json(tables: &[ErrorTable]) -> String {
    json_text(tables)
}

/// The rows of all tables as CSV, without the methods not requested.
pub fn csv(tables: &[ErrorTable]) -> String {
    type Row<'a> = (&'a ErrorTable, &'a OutputRow);
    let rows: Vec<Row<'_>> = tables
        .iter()
        .flat_map(|table| table.outputs.iter().map(move |row| (table, row)))
        .collect();
    fn of<'a>(row: &Row<'a>) -> Option<&'a IntervalRow> {
        row.1.interval.as_ref()
    }
    fn proof<'a>(row: &Row<'a>) -> Option<&'a ProofRow> {
        row.1.proof.as_ref()
    }
    let columns = columns! { Row<'_>;
        "function", [Hidden, All], |row| row.0.function.as_str();
        "output", [Hidden, All], |row| row.1.name.as_str();
        "exact", [Hidden, All], |row| row.1.exact;
        "computed", [Hidden, All], |row| row.1.computed;
        "error", [Hidden, All], |row| row.1.error;
        "predicted", [Hidden, All], |row| row.1.predicted;
        "bound", [Hidden, All], |row| row.1.bound;
        "sigma", [Hidden, All], |row| row.1.sigma;
        "low", [Hidden, All], move |row| of(row).map(|found| found.low);
        "high", [Hidden, All], move |row| of(row).map(|found| found.high);
        "window_error", [Hidden, All], move |row| of(row).map(|found| found.error);
        "window_operations", [Hidden, All], move |row| of(row).map(|found| found.operations);
        "ranges", [Hidden, All], move |row| of(row).map(|found| found.ranges);
        "alarm", [Hidden, All], move |row| of(row).and_then(|found| found.alarm);
        "share", [Hidden, All], move |row| of(row).map(|found| found.share);
        "finite", [Hidden, All], move |row| of(row).map(|found| found.finite);
        "at_a_state", [Hidden, All], move |row| of(row).map(|found| found.at_a_state);
        "seen", [Hidden, All], move |row| of(row).map(|found| found.seen);
        "states", [Hidden, All], move |row| of(row).map(|found| found.states);
        "boxes", [Hidden, All], move |row| of(row).map(|found| found.boxes);
        "proved_low", [Hidden, All], move |row| proof(row).map(|found| found.low);
        "proved_high", [Hidden, All], move |row| proof(row).map(|found| found.high);
        "proved_error", [Hidden, All], move |row| proof(row).map(|found| found.error);
        "found_error", [Hidden, All], move |row| proof(row).map(|found| found.found);
        "certified", [Hidden, All], |row| row.1.certified.to_string();
    };
    columns.table("", "", "", &rows).to_csv()
}
