//! The crates of the workspace as packages: files outside the folder of a crate
//! are not in its package, and a test that no test program includes never runs.

use crate::support::files::tree;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The folders of all crates, the root's last.
pub(crate) fn crates() -> Vec<PathBuf> {
    let manifest = fs::read_to_string(tree("Cargo.toml")).expect("the root has a manifest");
    let manifest: toml::Table = manifest.parse().expect("a well-formed manifest");
    let members = manifest["workspace"]["members"]
        .as_array()
        .expect("a list of members");
    let members = members
        .iter()
        .map(|member| tree(member.as_str().expect("a path")));
    members.chain([tree("")]).collect()
}

/// All Rust files of a folder and its subfolders.
pub(crate) fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(folder) else {
            continue;
        };
        for entry in entries {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                // Crates lie below `src` and are counted on their own.
                if !path.join("Cargo.toml").is_file() {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The paths that a source includes as text or bytes, as written.
fn included(source: &str) -> impl Iterator<Item = &str> {
    ["include_str!(", "include_bytes!("]
        .into_iter()
        .flat_map(|call| source.split(call).skip(1))
        .filter_map(|rest| {
            let rest = rest.trim_start();
            let rest = rest.strip_prefix("concat!(").unwrap_or(rest).trim_start();
            rest.strip_prefix('"')?.split('"').next()
        })
}

/// A path without `..`, links not followed.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        if component == Component::ParentDir {
            plain.pop();
        } else {
            plain.push(component);
        }
    }
    plain
}

/// The crates of the workspace by name, those without dependencies first, each
/// with the crates it depends on that no other of its dependencies brings, as
/// ARCHITECTURE.md draws them.
fn drawing() -> String {
    let short = |name: &str| name.trim_start_matches("robovec-").to_owned();
    let mut left: Vec<(String, BTreeSet<String>)> = crates()
        .iter()
        .map(|folder| {
            let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
            let manifest: toml::Table = manifest.parse().expect("a well-formed manifest");
            let name = manifest["package"]["name"].as_str().expect("a name");
            let needs = manifest["dependencies"].as_table().expect("a table").keys();
            let needs = needs.filter(|name| name.starts_with("robovec"));
            (short(name), needs.map(|name| short(name)).collect())
        })
        .collect();
    let (mut all, mut text) = (BTreeMap::<String, BTreeSet<String>>::new(), String::new());
    while !left.is_empty() {
        let ready = |(_, needs): &(String, BTreeSet<String>)| {
            needs.iter().all(|name| all.contains_key(name))
        };
        let place = left.iter().position(ready).expect("crates form no circle");
        let (name, needs) = left.remove(place);
        let brought: BTreeSet<String> = needs.iter().flat_map(|name| all[name].clone()).collect();
        let direct: Vec<&str> = needs.difference(&brought).map(String::as_str).collect();
        let line = format!("    {name:9} <- {}", direct.join(", "));
        text += line.trim_end().trim_end_matches(" <-").trim_end();
        text.push('\n');
        all.insert(name, needs.union(&brought).cloned().collect());
    }
    text
}

#[test]
fn architecture_draws_the_crates_as_they_are() {
    let drawing = drawing();
    let text = fs::read_to_string(tree("ARCHITECTURE.md")).expect("it is there");
    assert!(
        text.contains(&drawing),
        "ARCHITECTURE.md should draw\n\n{drawing}"
    );
}

#[test]
fn crates_include_only_what_is_in_their_packages() {
    let mut outside = Vec::new();
    let mut count = 0;
    for folder in crates() {
        for path in sources(&folder.join("src")) {
            // Tests are run in the tree, never from a package.
            if path.ends_with("tests.rs") {
                continue;
            }
            let source = fs::read_to_string(&path).expect("a readable source");
            let beside = path.parent().expect("a file lies in a folder");
            for included in included(&source) {
                count += 1;
                if !plain(&beside.join(included)).starts_with(&folder) {
                    outside.push(format!("{}: {included}", path.display()));
                }
            }
        }
    }
    assert!(count > 60, "{count} files are included");
    assert!(outside.is_empty(), "not in the package: {outside:#?}");
}

#[test]
fn every_file_of_tests_is_a_module() {
    let mut forgotten = Vec::new();
    for folder in crates() {
        let Ok(main) = fs::read_to_string(folder.join("tests/main.rs")) else {
            continue;
        };
        let entries = fs::read_dir(folder.join("tests")).expect("it holds main.rs");
        for entry in entries {
            let path = entry.expect("a readable folder").path();
            let is_module = path.extension().is_some_and(|extension| extension == "rs")
                || path.join("mod.rs").is_file();
            let stem = path.file_stem().expect("a name").to_string_lossy();
            if is_module && stem != "main" && !main.contains(&format!("\nmod {stem};\n")) {
                forgotten.push(path.display().to_string());
            }
        }
    }
    assert!(forgotten.is_empty(), "in no test program: {forgotten:?}");
}

#[test]
fn examples_in_comments_run_as_tests() {
    for folder in crates() {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
        if !manifest.contains("doctest = false") {
            continue;
        }
        for path in sources(&folder.join("src")) {
            let source = fs::read_to_string(&path).expect("a readable source");
            let lines = source.lines().map(str::trim_start);
            let comments = lines.filter(|line| line.starts_with("//"));
            let fences = comments
                .filter_map(|line| line.trim_start_matches(['/', '!']).strip_prefix(" ```"));
            // Fences open and close in turn.
            for opened in fences.step_by(2) {
                let is_text = ["text", "toml"].contains(&opened);
                assert!(is_text, "{}: no test runs {opened}", path.display());
            }
        }
    }
}
