//! Pages in a browser without a window: five clicks from a late output to its
//! equation and rule, every view opened, no error.

use super::{shown, suspension};
use crate::support::browser::driven;
use crate::support::programs::model;
use std::fs;
use std::path::PathBuf;

/// Passes that write down their rules.
const RULED: &str = "atomise,zero-removal,balance,factor{path=free},eqsat,balance,cse,dce,place";
const DRIVE: &str = include_str!("drive.js");

/// Operates the page of a pipeline; on the chain of the latest output a rule
/// must be found if `with_rule` is set, a pass always.
fn check(input: PathBuf, passes: &str, with_rule: bool, (width, most_kilobytes): (u32, u64)) {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let page = shown(&input, &["--passes", passes], folder.path());
    let size = fs::metadata(&page).expect("it was written").len() / 1000;
    assert!(size <= most_kilobytes, "the page has {size} kB");
    let Some(seen) = driven(&page, DRIVE, width) else {
        return;
    };
    let number = |key: &str| seen[key].parse::<u32>().expect("a number");
    assert_eq!(seen["errors"], "", "{seen:?}");
    assert_eq!(seen["requests"], "0", "{seen:?}");
    assert!(number("clicks") <= 5, "{seen:?}");
    assert!(number("outputs") > 0 && number("chain") > 3, "{seen:?}");
    assert!(number("reasons") > 0 && number("steps") > 1, "{seen:?}");
    assert!(number("rules") > 0 || !with_rule, "{seen:?}");
    assert!(seen["equation"].contains(':'), "{seen:?}");
    assert_ne!(seen["pass"], "as read");
    assert!((10..100).contains(&number("lines")), "{seen:?}");
    for view in [
        "opens", "graph", "nodes", "schedule", "ink", "source", "heat", "report", "late",
    ] {
        assert_eq!(seen[view], "true", "{view}: {seen:?}");
    }
}

#[test]
fn five_clicks_lead_from_a_late_output_to_equation_and_rule() {
    check(suspension(), RULED, true, (1400, 300));
    check(model("bogie.mbs"), RULED, true, (1400, 2000));
}

/// As large as the Jeep of Robotran's examples through the same pipeline.
#[test]
fn five_clicks_lead_through_a_car() {
    check(model("wishbone-car.mbs"), RULED, true, (1400, 4500));
}

#[test]
fn a_bogie_on_a_narrow_screen() {
    let passes = "$ahead,place";
    check(model("bogie.mbs"), passes, false, (500, 2500));
}
