//! Every command that README.md and docs/ show in a block of code: the
//! programs understand all of them, and those that need nothing but what
//! ships are run, in the order of the document.

use crate::support::files::{each, name, tree};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Commands that are not run, with the reason; `…` stands for the rest of one.
const NOT_RUN: &[(&str, &str)] = &[
    ("robovec bench …", "measures times on this computer"),
    ("robovec fit …", "takes a minute; tests/front.rs is smaller"),
    (
        "robovec front …",
        "takes minutes; tests/front.rs is smaller",
    ),
    (
        "robovec neglect …",
        "takes a minute; tests/neglect.rs is smaller",
    ),
    (
        "robovec optimise examples/scenes/…",
        "searches long; tests/optimise.rs has smaller scenes",
    ),
    (
        "robovec rtl examples/models/…",
        "needs verilator; tests/rtl.rs is smaller",
    ),
    ("robovec rules bench …", "takes a minute"),
    ("robovec rules why VALUE …", "VALUE stands for a name"),
    ("robovec simulate images …", "needs images of a program"),
    (
        "robovec stress",
        "takes minutes; tests/stress.rs is smaller",
    ),
    ("robovec stress --class …", "takes a minute"),
    ("robovec stress --verdicts", "takes a minute"),
    ("robovec stress -o …", "takes minutes"),
    (
        "robovec study …",
        "takes minutes; tests/study.rs is smaller",
    ),
    (
        "robovec sweep …",
        "takes minutes; tests/determinism.rs is smaller",
    ),
    (
        "robovec view examples/models/bogie.mbs --passes 'atomise,…",
        "saturates the bogie, as a command of README.md does",
    ),
    ("robovec synthesise", "needs yosys"),
    ("robovec synthesise …", "needs yosys"),
];

/// Options whose values are written.
const WRITTEN: &[&str] = &["-o", "--plot", "--report", "--events"];

/// The commands in the blocks of code of a document.
fn commands(document: &str) -> Vec<String> {
    let joined = document.replace("\\\n", " ");
    let mut is_fenced = false;
    let mut commands = Vec::new();
    for line in joined.lines() {
        if line.starts_with("```") {
            is_fenced = !is_fenced;
        }
        let Some(line) = line.strip_prefix("    ").or(is_fenced.then_some(line)) else {
            continue;
        };
        let line = line
            .strip_prefix("cargo run --release --bin ")
            .map_or_else(|| line.to_owned(), |rest| rest.replacen(" -- ", " ", 1));
        if !(line.starts_with("robovec ") || line.starts_with("robovec-opt ")) {
            continue;
        }
        // Behind a command stands what it does.
        let line = line.split(" # ").next().unwrap_or_default().trim_end();
        let columns: Vec<&str> = line.split("   ").filter(|part| !part.is_empty()).collect();
        let is_option = |part: &&&str| part.trim_start().starts_with('-');
        let options = columns[1..].iter().take_while(is_option);
        let parts: Vec<&str> = [&columns[0]].into_iter().chain(options).copied().collect();
        commands.push(parts.join(" "));
    }
    commands
}

/// The words of a command as a shell splits them, without the brackets around
/// what may be left out.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word = String::new();
    let mut quote = None;
    for letter in command.chars() {
        match (letter, quote) {
            ('\'' | '"', None) => quote = Some(letter),
            (_, Some(open)) if open == letter => quote = None,
            (' ', None) => words.push(std::mem::take(&mut word)),
            _ => word.push(letter),
        }
    }
    words.push(word);
    let is_whole = |word: &str| word.matches('[').count() == word.matches(']').count();
    words
        .into_iter()
        .filter(|word| !word.is_empty())
        .map(|word| match word.strip_prefix("[-") {
            Some(rest) => format!("-{}", rest.trim_end_matches(']')),
            None if is_whole(&word) => word,
            None => word.trim_end_matches(']').to_owned(),
        })
        .collect()
}

fn run(words: &[String], folder: &Path) -> Output {
    let program = match words[0].as_str() {
        "robovec" => env!("CARGO_BIN_EXE_robovec"),
        _ => env!("CARGO_BIN_EXE_robovec-opt"),
    };
    Command::new(program)
        .args(&words[1..])
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn succeed(command: &str, words: &[String], folder: &Path) {
    let output = run(words, folder);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command}\n{message}");
}

/// Calls a function for every document.
fn documents(mut attempt: impl FnMut(&str, &str)) {
    let mut read = |path: &Path| {
        let text = fs::read_to_string(path).expect("a document");
        attempt(&name(path), &text);
    };
    read(&tree("README.md"));
    each("docs", &["md"], read);
}

#[test]
fn programs_understand_every_command_of_the_documents() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut count = 0;
    documents(|_, text| {
        for command in commands(text) {
            count += 1;
            let mut words = words(&command);
            // Everything before it is read, nothing is run.
            words.push("--help".to_owned());
            succeed(&command, &words, folder.path());
        }
    });
    assert!(count > 80, "{count} commands");
}

/// Whether a word names a file by its extension.
fn is_file(word: &str) -> bool {
    [
        ".mbs", ".urdf", ".c", ".m", ".py", ".rvir", ".toml", ".rules", ".rkt",
    ]
    .iter()
    .any(|extension| word.ends_with(extension))
}

/// Whether a word stands for something of the user's: `MODEL.mbs`, `FILE…`.
fn is_placeholder(word: &str) -> bool {
    let stem = word.split('.').next().unwrap_or_default();
    let stem = stem.trim_end_matches('…');
    word.contains('…') || stem.len() > 1 && stem.bytes().all(|byte| byte.is_ascii_uppercase())
}

/// Whether everything is there that a command reads. What a document says of
/// the examples must be there.
fn is_complete(command: &str, words: &[String], folder: &Path) -> bool {
    let mut before = "";
    for word in &words[1..] {
        let is_read = !WRITTEN.contains(&before);
        before = word;
        if word.starts_with("examples/") {
            assert!(folder.join(word).exists(), "{command}: there is no {word}");
        }
        let is_there = !is_file(word) || folder.join(word).exists();
        if is_placeholder(word) || is_read && !is_there {
            return false;
        }
    }
    true
}

/// A folder with links to what ships, and the rules that documents begin with.
fn clone() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for part in ["examples", "machines"] {
        std::os::unix::fs::symlink(tree(part), folder.path().join(part)).expect("a link");
    }
    let readme = fs::read_to_string(tree("README.md")).expect("it is there");
    let (_, rules) = readme.split_once("    # mine.rules\n").expect("a rule");
    let (rules, _) = rules.split_once("\n\n").expect("an end");
    fs::write(folder.path().join("mine.rules"), rules).expect("a folder of our own");
    folder
}

#[test]
fn commands_on_what_ships_run() {
    let mut used = vec![false; NOT_RUN.len()];
    // What stands in two documents is run once.
    let mut done = BTreeSet::new();
    documents(|document, text| {
        let folder = clone();
        for command in commands(text) {
            let is_excused = |(line, _): &(&str, &str)| match line.strip_suffix('…') {
                Some(start) => command.starts_with(start),
                None => command == *line,
            };
            if let Some(index) = NOT_RUN.iter().position(is_excused) {
                used[index] = true;
                continue;
            }
            let words = words(&command);
            if is_complete(&command, &words, folder.path()) && done.insert(command.clone()) {
                let start = std::time::Instant::now();
                succeed(&command, &words, folder.path());
                println!("{document}: {:.1?} {command}", start.elapsed());
            }
        }
    });
    assert!(done.len() >= 12, "{} commands are run", done.len());
    let unused = NOT_RUN.iter().zip(used).filter(|(_, used)| !used);
    let unused: Vec<_> = unused.map(|(entry, _)| entry).collect();
    assert!(unused.is_empty(), "no document shows {unused:?}");
}
