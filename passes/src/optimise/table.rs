//! The table of the best programs that were tried, as lines of equal columns.

use super::search::SearchOutcome;

/// Programs in the table.
const SHOWN: usize = 10;

/// The lines of the table, the program taken first: names to the left, numbers to the right.
pub(super) fn rows<P>(outcome: &SearchOutcome<P>) -> Vec<String> {
    let head = ["variant", "operations", "path", "bound", "cycles", ""].map(str::to_owned);
    let mut cells = vec![head];
    let mut order: Vec<usize> = (0..outcome.trials.len()).collect();
    order.sort_by_key(|&index| {
        let trial = &outcome.trials[index];
        (
            outcome.best != Some(index),
            trial.cycles.is_none(),
            trial.cycles,
            trial.operations,
            trial.path,
            index,
        )
    });
    for &index in order.iter().take(SHOWN) {
        let trial = &outcome.trials[index];
        let or_dash = |number: Option<u32>| number.map_or("-".to_owned(), |n| n.to_string());
        cells.push([
            trial.name.clone(),
            trial.operations.to_string(),
            trial.path.to_string(),
            or_dash(trial.bound.as_ref().ok().copied()),
            or_dash(trial.cycles),
            if outcome.best == Some(index) {
                "taken".to_owned()
            } else {
                trial.remark.to_owned()
            },
        ]);
    }
    let mut widths = [0; 6];
    for row in &cells {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = cell.chars().count().max(*width);
        }
    }
    let line = |row: &[String; 6]| {
        let mut line = format!("{:<1$}", row[0], widths[0]);
        for (cell, width) in row[1..5].iter().zip(&widths[1..5]) {
            line += &format!("  {cell:>width$}");
        }
        format!("{line}  {}", row[5]).trim_end().to_owned()
    };
    let mut lines: Vec<String> = cells.iter().map(line).collect();
    let more = outcome.trials.len().saturating_sub(SHOWN);
    if more > 0 || !outcome.skipped.is_empty() {
        let left = outcome.skipped.len();
        lines.push(format!("{more} more were made, {left} left out"));
    }
    for skipped in outcome
        .skipped
        .iter()
        .filter(|skipped| !skipped.is_beyond_effort())
    {
        lines.push(format!("left out: {}: {}", skipped.name, skipped.reason));
    }
    lines
}
