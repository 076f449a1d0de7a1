//! The pages of explorations in a browser, narrow and wide: tables sort, show
//! the rows that hold a text, give CSV, and keep all that in the address; no
//! script fails, and no page is wider than its window.

use crate::support::browser::driven;
use crate::support::files::tree;
use crate::support::programs::{model, robovec, said};
use std::fs;
use std::path::Path;

const DRIVE: &str = include_str!("pages/drive.js");

/// Makes a folder of results and drives through its page at two widths.
fn drive(arguments: &[&str], page: &str) {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let out = folder.path().display().to_string();
    said(&robovec(&[arguments, &["-o", &out]].concat()));
    let page = folder.path().join(page);
    refers_to_nothing(&page);
    for width in [500, 1400] {
        let Some(seen) = driven(&page, DRIVE, width) else {
            return;
        };
        let number = |key: &str| seen[key].parse::<usize>().expect("a number");
        assert_eq!(seen["errors"], "", "{seen:?}");
        assert_eq!(seen["wide"], "false", "at {width}: {seen:?}");
        assert!(number("tables") > 0 && number("figures") > 0, "{seen:?}");
        let (found, all) = (number("found"), number("all"));
        assert!((1..=all).contains(&found), "{seen:?}");
        for done in ["sorted", "csv", "address"] {
            assert_eq!(seen[done], "true", "{done} at {width}: {seen:?}");
        }
    }
}

fn refers_to_nothing(page: &Path) {
    let text = fs::read_to_string(page).expect("it was written");
    for outside in ["https:", " src=", "@import", "url(", "fetch("] {
        assert!(!text.contains(outside), "{}: {outside}", page.display());
    }
}

#[test]
fn a_sweep() {
    let space = ["--adders=1,2", "--multipliers=1,2", "--couples=3-3,6-4"];
    let model = model("double-pendulum.mbs").display().to_string();
    let program = ["explore", &model, "--passes=atomise,balance"];
    drive(&[&program[..], &space].concat(), "explore.html");
}

#[test]
fn a_study() {
    let plan = tree("tests/study/plans/suspension.toml");
    let plan = plan.display().to_string();
    drive(&["explore", "--plan", &plan], "explore.html");
}

#[test]
fn hard_cases() {
    drive(&["stress", "--case", "tiny-1e-9"], "stress.html");
}

#[test]
fn a_front() {
    let model = model("double-pendulum.mbs").display().to_string();
    let few = ["--states", "8", "--elements", "2"];
    drive(&[&["explore", &model][..], &few].concat(), "explore.html");
}

#[test]
fn the_best_program() {
    let model = model("double-pendulum.mbs").display().to_string();
    drive(&["optimise", &model, "--effort", "1"], "optimise.html");
}
