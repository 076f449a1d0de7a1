//! Pages in a browser without a window: five clicks from a late output to the
//! equation and the rule behind it, every view opened, no error.

use super::{shown, suspension};
use crate::support::programs::model;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const DRIVE: &str = include_str!("drive.js");

fn chromium() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names.into_iter().find(|name| {
        let found = Command::new(name).arg("--version").output();
        found.is_ok_and(|output| output.status.success())
    })
}

/// What the drive through a page saw; `None` without a browser.
fn driven(page: &Path, width: u32) -> Option<BTreeMap<String, String>> {
    let Some(browser) = chromium() else {
        eprintln!("SKIPPED: no Chromium is installed, no page was opened");
        return None;
    };
    let folder = page.parent().expect("a page lies in a folder");
    let text = fs::read_to_string(page).expect("it was written");
    let end = text.rfind("</body>").expect("a page has a body");
    let text = format!("{}<script>{DRIVE}</script>{}", &text[..end], &text[end..]);
    let driven = folder.join("driven.html");
    fs::write(&driven, text).expect("a folder of our own");
    let profile = folder.join("profile");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .arg("--virtual-time-budget=20000")
        .arg(format!("--window-size={width},900"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", driven.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&output.stdout);
    let (_, told) = dom.split_once("<pre id=\"told\">").unwrap_or_else(|| {
        let said = String::from_utf8_lossy(&output.stderr);
        panic!("the drive did not end: {said}")
    });
    let (told, _) = told.split_once("</pre>").expect("the element ends");
    let pairs = told.lines().filter_map(|line| line.split_once('='));
    Some(
        pairs
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect(),
    )
}

/// Drives through the page of a pipeline; on the chain of the latest output
/// a rule must be found where `with_rule` says so, a pass always.
fn check(input: PathBuf, passes: &str, with_rule: bool, (width, most_kilobytes): (u32, u64)) {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let page = shown(&input, &["--passes", passes], folder.path());
    let size = fs::metadata(&page).expect("it was written").len() / 1000;
    assert!(size <= most_kilobytes, "the page has {size} kB");
    let Some(seen) = driven(&page, width) else {
        return;
    };
    let number = |key: &str| seen[key].parse::<u32>().expect("a number");
    assert_eq!(seen["errors"], "", "{seen:?}");
    assert!(number("outputs") > 0 && number("chain") > 3, "{seen:?}");
    assert!(number("reasons") > 0 && number("steps") > 1, "{seen:?}");
    assert!(number("rules") > 0 || !with_rule, "{seen:?}");
    assert!(seen["equation"].contains(':'), "{seen:?}");
    assert_ne!(seen["pass"], "as read");
    assert!((10..100).contains(&number("lines")), "{seen:?}");
    for view in [
        "graph", "nodes", "schedule", "ink", "source", "heat", "report", "late",
    ] {
        assert_eq!(seen[view], "true", "{view}: {seen:?}");
    }
}

#[test]
fn five_clicks_lead_from_a_late_output_to_equation_and_rule() {
    let passes = "atomise,zero-removal,balance,factor{path=free},eqsat,balance,cse,dce,place";
    check(suspension(), passes, true, (1400, 300));
}

#[test]
fn a_bogie_on_a_narrow_screen() {
    let passes = "$ahead,place";
    check(model("bogie.mbs"), passes, false, (500, 2500));
}
