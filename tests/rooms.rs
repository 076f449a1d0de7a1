//! The rooms of every crate: they lie in layers, and every type has a name
//! that a search finds.

use crate::packages::{self, crates};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The folders of the sources of all crates but that of the fuzz targets.
fn folders() -> impl Iterator<Item = PathBuf> {
    let crates = crates().into_iter();
    let crates = crates.filter(|folder| !folder.ends_with("fuzz"));
    crates.map(|folder| folder.join("src"))
}

/// Names that several types may have: in every room they mean the same.
const SHARED: [&str; 3] = ["Error", "Iter", "Options"];

/// Paths and contents of the sources below a folder, without tests and
/// comments.
fn sources(folder: &Path) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).expect("the sources are there") {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                // Crates lie below `src` and are counted on their own.
                if !path.join("Cargo.toml").is_file() && !path.ends_with("tests") {
                    folders.push(path);
                }
                continue;
            }
            let is_source = path.extension().is_some_and(|extension| extension == "rs");
            if !is_source || path.ends_with("tests.rs") || path.ends_with("testing.rs") {
                continue;
            }
            let text = fs::read_to_string(&path).expect("a readable source");
            let text = text.split("#[cfg(test)]\nmod tests {").next();
            let lines = text.expect("a first part").lines();
            let code: Vec<&str> = lines
                .filter(|line| !line.trim_start().starts_with("//"))
                .collect();
            let inside = path.strip_prefix(folder).expect("it lies in the folder");
            found.push((inside.to_string_lossy().into_owned(), code.join("\n")));
        }
    }
    found.sort();
    found
}

/// The room a source lies in: the folder or file directly in the crate.
fn room(path: &str) -> &str {
    path.split('/')
        .next()
        .expect("a first part")
        .trim_end_matches(".rs")
}

/// The rooms that a source names by `crate::`, alone or in braces.
fn named(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let Some(list) = rest.strip_prefix('{') else {
            found.insert(word(rest));
            continue;
        };
        let mut depth = 0;
        let mut start = true;
        for (place, character) in list.char_indices() {
            match character {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                _ if start && !character.is_whitespace() => {
                    found.insert(word(&list[place..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found
}

fn word(text: &str) -> String {
    let is_part = |character: &char| character.is_alphanumeric() || *character == '_';
    text.chars().take_while(is_part).collect()
}

#[test]
fn rooms_of_a_crate_lie_in_layers() {
    for folder in folders() {
        let sources = sources(&folder);
        let rooms: BTreeSet<&str> = sources.iter().map(|(path, _)| room(path)).collect();
        let mut arrows: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for (path, code) in &sources {
            // What names all rooms to make one crate of them is no room.
            if matches!(room(path), "lib" | "bin") {
                continue;
            }
            let mut named = named(code);
            named.retain(|name| name != room(path) && rooms.contains(name.as_str()));
            arrows.entry(room(path)).or_default().extend(named);
        }
        while !arrows.is_empty() {
            let is_free = |room: &&str| {
                arrows[room]
                    .iter()
                    .all(|name| !arrows.contains_key(name.as_str()))
            };
            let free: Vec<&str> = arrows.keys().copied().filter(is_free).collect();
            assert!(
                !free.is_empty(),
                "circles among the rooms of {folder:?}: {arrows:#?}"
            );
            for room in free {
                arrows.remove(room);
            }
        }
    }
}

/// The type that a line defines, when it defines one.
fn defined(line: &str) -> Option<String> {
    let line = match line.strip_prefix("pub") {
        Some(rest) => match rest.strip_prefix('(') {
            Some(scope) => scope.split_once(") ")?.1,
            None => rest.strip_prefix(' ')?,
        },
        None => line,
    };
    let (kind, rest) = line.split_once(' ')?;
    matches!(kind, "struct" | "enum" | "trait" | "union" | "type").then(|| word(rest))
}

#[test]
fn every_type_has_a_name_of_its_own() {
    let mut places: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for folder in folders() {
        for (path, code) in sources(&folder) {
            for name in code.lines().filter_map(defined) {
                places.entry(name).or_default().push(folder.join(&path));
            }
        }
    }
    assert!(places.len() > 1000, "{} types", places.len());
    places.retain(|name, places| places.len() > 1 && !SHARED.contains(&name.as_str()));
    assert!(
        places.is_empty(),
        "several types have one name: {places:#?}"
    );
}

/// Words that open no comment of documentation: it names its subject first.
const OPENINGS: [&str; 8] = [
    "What", "How", "Which", "Where", "Whether", "When", "Why", "So",
];

#[test]
fn comments_open_with_their_subject() {
    let (mut count, mut found) = (0, Vec::new());
    for folder in crates() {
        for path in packages::sources(&folder) {
            let text = fs::read_to_string(&path).expect("a readable source");
            let mut last = "";
            for line in text.lines().map(str::trim_start) {
                let is_comment = |line: &str| line.starts_with("///") || line.starts_with("//!");
                if is_comment(line) && !is_comment(last) {
                    count += 1;
                    if OPENINGS.contains(&word(line[3..].trim_start()).as_str()) {
                        found.push(format!("{}: {line}", path.display()));
                    }
                }
                last = line;
            }
        }
    }
    assert!(count > 10_000, "{count} comments");
    // One in a hundred may be better that way.
    assert!(100 * found.len() <= count, "of {count}: {found:#?}");
}
