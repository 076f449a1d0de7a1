//! Pages in a browser without a window.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

fn chromium() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    names.into_iter().find(|name| {
        let found = Command::new(name).arg("--version").output();
        found.is_ok_and(|output| output.status.success())
    })
}

/// Report of a script that operated a page, by its keys; it writes them into an
/// element `told`. `None` without a browser.
pub(crate) fn driven(page: &Path, script: &str, width: u32) -> Option<BTreeMap<String, String>> {
    let Some(browser) = chromium() else {
        eprintln!("SKIPPED: no Chromium is installed, no page was opened");
        return None;
    };
    let folder = page.parent().expect("a page lies in a folder");
    let text = fs::read_to_string(page).expect("it was written");
    let end = text.rfind("</body>").expect("a page has a body");
    let text = format!("{}<script>{script}</script>{}", &text[..end], &text[end..]);
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
