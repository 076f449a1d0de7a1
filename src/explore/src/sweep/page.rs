//! Sweeps as a page.

use super::FunctionSweep;
use super::text::{devices, figure, points_table};
use robovec_present::DataCell;
use robovec_present::json::json_script;
use robovec_present::page::{self, PointsPage};

/// The page of some sweeps.
pub fn page(sweeps: &[FunctionSweep]) -> String {
    let names: Vec<&str> = sweeps.iter().map(|sweep| sweep.name.as_str()).collect();
    let mut fronts = points_table(sweeps);
    let last = fronts.columns.len() - 1;
    let on_front = |row: &Vec<DataCell>| !row[last].plain().is_empty();
    fronts.rows.retain(on_front);
    fronts.title = "Designs that no other one beats".to_owned();
    let page = PointsPage {
        title: "Resources against time".to_owned(),
        subtitle: format!(
            "{}. {}. Computed by robovec {}.",
            names.join(", "),
            devices(sweeps),
            env!("CARGO_PKG_VERSION")
        ),
        figures: page::figure(&figure(sweeps)) + &page::table(&fronts, "explore.csv"),
        points: "All designs",
        tables: page::table(&points_table(sweeps), "explore.csv"),
        method: METHOD,
        data: json_script(sweeps),
    };
    page.to_html()
}

/// Explanation of the numbers.
const METHOD: &str = "<p>Every design is placed operation by operation, and the placement is \
checked against the machine. Time is cycles over the clock, divided by the instances that are \
evaluated at once. The clock is estimated by the model of the device that every command asks, and \
neither measured nor published. What a design takes is estimated by formulas. Sines and cosines, loading and reading cost no cycles.</p>\
<p>The time of the processor is that of the same function in binary64, written as C for processors \
(fewest operations, with loops or without, whichever is faster), its results compared with the \
evaluator's, and run on one core, the least of many repetitions. Energy is told where the power of the device is given: \
that of the idle device and a share of the rest, times the time.</p>";
