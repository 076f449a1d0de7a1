//! The table of the variants that were tried, as lines of equal columns.

use super::trial::VariantTrial;

/// The lines of the table: names to the left, numbers to the right.
pub(super) fn rows(trials: &[VariantTrial], taken: Option<usize>) -> Vec<String> {
    let head = ["variant", "operations", "path", "bound", "cycles", ""].map(str::to_owned);
    let mut cells = vec![head];
    for (index, trial) in trials.iter().enumerate() {
        let made = |number: String| match trial.is_made() {
            true => number,
            false => "-".to_owned(),
        };
        let bound = match &trial.bound {
            Ok(bound) => bound.to_string(),
            Err(_) => "-".to_owned(),
        };
        let cycles = trial.cycles.map(|cycles| cycles.to_string());
        cells.push([
            trial.name.clone(),
            made(trial.operations.to_string()),
            made(trial.path.to_string()),
            made(bound),
            cycles.unwrap_or_else(|| "-".to_owned()),
            match taken == Some(index) {
                true => "taken".to_owned(),
                false => trial.remark.to_owned(),
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
    cells.iter().map(line).collect()
}
