//! The table of the programs that were tried, as lines of equal columns.

use super::search::SearchOutcome;

/// The lines of the table: names to the left, numbers to the right.
pub(super) fn rows<P>(outcome: &SearchOutcome<P>) -> Vec<String> {
    let head = ["variant", "operations", "path", "bound", "cycles", ""].map(str::to_owned);
    let mut cells = vec![head];
    for (index, trial) in outcome.trials.iter().enumerate() {
        let or_dash = |number: Option<u32>| number.map_or("-".to_owned(), |n| n.to_string());
        cells.push([
            trial.name.clone(),
            trial.operations.to_string(),
            trial.path.to_string(),
            or_dash(trial.bound.as_ref().ok().copied()),
            or_dash(trial.cycles),
            match outcome.best == Some(index) {
                true => "taken".to_owned(),
                false => trial.remark.to_owned(),
            },
        ]);
    }
    for skipped in &outcome.skipped {
        let dash = || "-".to_owned();
        let reason = skipped.reason.clone();
        cells.push([skipped.name.clone(), dash(), dash(), dash(), dash(), reason]);
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
    cells.iter().map(line).collect()
}
