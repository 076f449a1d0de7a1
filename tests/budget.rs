//! The size of every crate: `budget.toml` holds the maximum number of lines of
//! Rust without tests, so that growth is part of its own commit.
//!
//! `INSTA_UPDATE=always cargo test --workspace --test all budget::` records the
//! present numbers of lines.

use crate::packages::crates;
use crate::support::files::tree;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Maximum excess of a budget over the number of lines, in lines.
const SLACK: usize = 100;

/// Lines of Rust of one crate, or their maximum.
#[derive(Clone, Copy, Default)]
struct Lines {
    /// Lines that are neither tests nor shared by tests.
    product: usize,
    tests: usize,
}

/// Adds the lines of all sources below a folder, without other crates.
fn count(folder: &Path, is_test: bool, lines: &mut Lines) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        let name = path.file_name().expect("an entry has a name");
        let name = name.to_string_lossy();
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            let is_other = name.starts_with('.') || name == "target";
            if !is_other && !path.join("Cargo.toml").is_file() {
                count(&path, is_test || name == "tests", lines);
            }
        } else if name.ends_with(".rs") {
            let text = fs::read_to_string(&path).expect("a readable source");
            let is_test = is_test || name.ends_with("tests.rs") || name == "testing.rs";
            let product = match text.split_once("#[cfg(test)]\nmod tests {") {
                _ if is_test => 0,
                Some((product, _)) => product.lines().count(),
                None => text.lines().count(),
            };
            lines.product += product;
            lines.tests += text.lines().count() - product;
        }
    }
}

/// The lines of all crates by name.
fn counted() -> BTreeMap<String, Lines> {
    let mut counted = BTreeMap::new();
    for folder in crates() {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        let manifest: toml::Table = manifest.parse().expect("a well-formed manifest");
        let name = manifest["package"]["name"].as_str().expect("a name");
        let mut lines = Lines::default();
        count(&folder, false, &mut lines);
        counted.insert(name.to_owned(), lines);
    }
    counted
}

/// The maximum of all crates by name, from `budget.toml`.
fn budgets(text: &str) -> BTreeMap<String, Lines> {
    let table: toml::Table = text.parse().expect("budget.toml is well formed");
    let number = |value: &toml::Value, key: &str| {
        let number = value[key].as_integer().expect("a number of lines");
        usize::try_from(number).expect("at least none")
    };
    let crates = table["crates"].as_table().expect("a table of crates");
    let budget = |value| Lines {
        product: number(value, "product"),
        tests: number(value, "tests"),
    };
    crates
        .iter()
        .map(|(name, value)| (name.clone(), budget(value)))
        .collect()
}

/// The text of `budget.toml`, its comment kept.
fn recorded(comment: &str, counted: &BTreeMap<String, Lines>) -> String {
    let mut text = format!("{comment}[crates]\n");
    for (name, Lines { product, tests }) in counted {
        writeln!(
            text,
            "{name:18} = {{ product = {product}, tests = {tests} }}"
        )
        .expect("text takes all that is written");
    }
    text
}

#[test]
fn crates_grow_with_their_budgets_only() {
    let path = tree("budget.toml");
    let written = fs::read_to_string(&path).expect("it is in the repository");
    let counted = counted();
    let (comment, _) = written.split_once("[crates]").expect("a table of crates");
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        fs::write(&path, recorded(comment, &counted)).expect("a writable folder");
        return;
    }
    let budgets = budgets(&written);
    let mut table = format!(
        "{:20}{:>9}{:>9}{:>9}{:>9}\n",
        "crate", "product", "budget", "tests", "budget"
    );
    let within = |lines: usize, budget: usize| lines <= budget && budget <= lines + SLACK;
    let mut is_within = budgets.keys().eq(counted.keys());
    let (mut sum, mut allowed) = (Lines::default(), Lines::default());
    for (name, lines) in &counted {
        let budget = budgets.get(name).copied().unwrap_or_default();
        let holds = within(lines.product, budget.product) && within(lines.tests, budget.tests);
        is_within &= holds;
        for (total, one) in [(&mut sum, lines), (&mut allowed, &budget)] {
            total.product += one.product;
            total.tests += one.tests;
        }
        let mark = if holds { "" } else { "  <" };
        write_row(&mut table, name, lines, &budget, mark);
    }
    write_row(&mut table, "all", &sum, &allowed, "");
    assert!(
        is_within,
        "lines of Rust and budget.toml differ by more than {SLACK}: make it lighter, or record \
         the lines with INSTA_UPDATE=always and give the reason in the commit\n\n{table}"
    );
}

fn write_row(table: &mut String, name: &str, lines: &Lines, budget: &Lines, mark: &str) {
    let columns = [lines.product, budget.product, lines.tests, budget.tests];
    let columns = columns.map(|count| format!("{count:>9}")).concat();
    writeln!(table, "{name:20}{columns}{mark}").expect("text takes all that is written");
}
