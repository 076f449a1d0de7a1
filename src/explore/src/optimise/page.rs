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
        method: include_str!("method.html"),
        data: json_script(&found.points),
    };
    page.to_html()
}
