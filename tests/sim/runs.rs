//! Summaries of runs of `sim`: in `runs/*.txt` the arguments, and below them
//! the summary.
//!
//! Drifts are results of rounding and of the method, and differ a little
//! between libraries of sines: numbers with an exponent may be four times
//! larger or smaller, counts of steps and evaluations a tenth. Times of events
//! and all other figures must be equal. The speed of a run is printed on
//! terminals alone.

use crate::support::programs::robovec_in;
use std::fs;
use std::path::{Path, PathBuf};

/// Maximum distance of drifts.
const APART: f64 = 4.0;

/// Drifts below this are rounding of a few last digits.
const ROUNDING: f64 = 1e-11;

/// True when the lines are equal.
fn same(expected: &str, found: &str) -> bool {
    let (expected, found): (Vec<&str>, Vec<&str>) = (
        expected.split_whitespace().collect(),
        found.split_whitespace().collect(),
    );
    let word = |(expected, found): (&&str, &&str)| {
        let drift = |word: &str| word.trim_end_matches(';').parse::<f64>().ok();
        let both = drift(expected).zip(drift(found));
        let drifts = both.filter(|_| expected.contains('e') && found.contains('e'));
        let count = |word: &str| word.trim_end_matches(';').parse::<u64>().ok();
        let counts = count(expected).zip(count(found));
        expected == found
            || counts.is_some_and(|(a, b)| 10 * a.abs_diff(b) <= a)
            || drifts
                .is_some_and(|(a, b)| a.max(b) < ROUNDING || (a <= APART * b && b <= APART * a))
    };
    expected.len() == found.len() && expected.iter().zip(&found).all(word)
}

#[test]
fn summaries_tell_drifts_and_events() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let runs = fs::read_dir(folder.join("tests/sim/runs")).expect("the runs");
    let mut paths: Vec<PathBuf> = runs.map(|run| run.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "txt"));
    paths.sort();
    assert!(paths.len() >= 9, "the runs that ship");
    for path in paths {
        let text = fs::read_to_string(&path).expect("readable");
        let (line, expected) = text.split_once('\n').expect("a line of arguments");
        let (model, rest) = line.split_once(' ').expect("a model and arguments");
        let model = format!("examples/models/{model}.mbs");
        let arguments: Vec<&str> = ["sim", &model].into_iter().chain(rest.split(' ')).collect();
        let output = robovec_in(folder, &arguments);
        let found = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{line}: {found}");
        assert!(!found.contains("per second"), "{found}");
        if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
            fs::write(&path, format!("{line}\n{found}")).expect("a writable folder");
            continue;
        }
        let lines = expected.lines().zip(found.lines());
        let agree = expected.lines().count() == found.lines().count()
            && lines
                .into_iter()
                .all(|(expected, found)| same(expected, found));
        assert!(
            agree,
            "{line} gives\n{found}instead of\n{expected}\
             INSTA_UPDATE=always cargo test --test all sim::runs writes it"
        );
    }
}
