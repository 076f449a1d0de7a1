//! The table of a bench.

use super::BenchOutcome;
use super::contestant::ContestantFamily;
use robovec_error::yardstick::account::measure_text;
use robovec_present::number::{exponential, or_dash};
use std::fmt::Write;

/// The outcomes as a table, the fastest of a group last; errors at `states`.
///
/// The ratio is against Robotran's file, or the first contestant that ran.
pub fn text(title: &str, states: &str, outcomes: &[BenchOutcome]) -> String {
    let base = outcomes.iter().find_map(|outcome| outcome.nanoseconds);
    let width = outcomes.iter().map(|outcome| outcome.name.chars().count());
    let width = width.fold(12, usize::max);
    let remark = outcomes
        .iter()
        .map(|outcome| outcome.remark.chars().count());
    let remark = remark.fold(0, usize::max);
    let mut text = format!("{title}\n");
    let _ = writeln!(
        text,
        "  {:width$}  {:>10}  {:>7}  {:>9}  {:>10}  {:>9}  {:>9}  {:>12}  {:>11}",
        "",
        "ns/state",
        "faster",
        "jitter ns",
        "operations",
        "compile s",
        "code kB",
        "median error",
        "worst error"
    );
    let line = "─".repeat(2 + width + 93 + 2 + remark);
    let _ = writeln!(text, "  {}", &line[..line.len() - 3 * 2]);
    let mut family = None;
    for outcome in outcomes {
        if family != Some(outcome.family) {
            family = Some(outcome.family);
            let _ = writeln!(text, "  {}", heading(outcome.family));
        }
        let name = &outcome.name;
        if let Some(failure) = &outcome.failure {
            let _ = writeln!(text, "    {name:width$}  {failure}");
            continue;
        }
        let number = |number: Option<f64>, decimals: usize| {
            or_dash(number, |number| format!("{number:.decimals$}"))
        };
        let ratio = base.zip(outcome.nanoseconds).map(|(base, own)| base / own);
        let _ = writeln!(
            text,
            "    {name:width$}{:>10}  {:>7}  {:>9}  {:>10}  {:>9}  {:>9}  {:>12}  {:>11}  {}",
            number(outcome.nanoseconds, 1),
            number(ratio, 2),
            number(outcome.jitter, 0),
            or_dash(outcome.operations, |count| count.to_string()),
            number(outcome.compile_seconds, 2),
            number(outcome.code_bytes.map(|bytes| bytes as f64 * 1e-3), 1),
            or_dash(outcome.errors, |errors| exponential(errors.median)),
            or_dash(outcome.errors, |errors| exponential(errors.worst)),
            outcome.remark
        );
    }
    let _ = writeln!(
        text,
        "  errors in f64, in parts {}; jitter: one call in a thousand takes so much longer than \
         the median one",
        measure_text(states)
    );
    text
}

fn heading(family: ContestantFamily) -> &'static str {
    match family {
        ContestantFamily::Robotran => "Robotran",
        ContestantFamily::Equations => "robovec, from the equations",
        ContestantFamily::Model => "robovec, from the model",
        ContestantFamily::Peer => "others, from the model",
    }
}
