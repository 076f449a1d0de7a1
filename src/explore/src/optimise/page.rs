//! Result of a search as a page.

use super::Optimised;
use super::text::{figure, points_table};
use robovec_present::json::json_script;
use robovec_present::page::{self, PointsPage};

/// The page: `facts` says what was taken and why, `commands` how it is made
/// again.
pub fn page(name: &str, found: &Optimised, facts: &str, commands: &str) -> String {
    let page = PointsPage {
        title: format!("The best program of {name}"),
        subtitle: format!("Computed by robovec {}.", env!("CARGO_PKG_VERSION")),
        figures: page::lines(facts) + &page::figure(&figure(found)),
        points: "All that was tried",
        tables: page::table(&points_table(found), "optimise.csv")
            + "<h2>How to make it again</h2>"
            + &page::lines(commands),
        method: METHOD,
        data: json_script(&found.points),
    };
    page.to_html()
}

/// Explanation of the numbers.
const METHOD: &str = "<p>Programs start from the equations as they came and, where a model was \
given, from other formulations that were proved to be the same function. Passes make others of \
them; the most promising ones are taken further. <b>Bound</b>: no schedule of the same \
operations on the same machine is shorter; other operations for the same function may be.</p>\
<p><b>Errors</b> are those of the results in the number format of the target, at random states, \
against the equations as they came in double-double arithmetic: the largest error of an array \
over its largest element, the median and the worst over all arrays and states. The <b>share of \
the device</b> is that of the machine with memories for the program, estimated by formulas.</p>\
<p>Cycles are exact. Times of C are measured here, and differ from run to run; programs within \
two percent of the fastest count as equally fast.</p>";
