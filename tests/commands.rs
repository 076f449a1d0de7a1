//! Every block of code in README.md and docs/ matches the word after its fence:
//! commands run, in the order of the document, with the output shown, rules are
//! proved, functions and machines read, C compiled.
//!
//! Blocks of Python run where the package is built (`scripts/test-wheel.sh`),
//! those of Rust as tests of documentation. A document has its own folder, with
//! shipped files and those of a user; all documents are tested in parallel.

mod blocks;
mod given;

use crate::support::files::{list, name, tree};
use blocks::{CodeBlock, blocks, commands};
use given::{NOT_RUN, PLACEHOLDERS, SMALLER};
use robovec::model::mbs::read_mbs;
use robovec::motion::Laws;
use robovec_ir::Machine;
use robovec_ir::parse::parse_module;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;

/// The documents, the longest first.
fn documents() -> Vec<PathBuf> {
    let mut documents = list("docs", &["md"]);
    documents.insert(0, tree("README.md"));
    documents
}

fn read(path: &Path) -> (String, Vec<CodeBlock>) {
    let text = fs::read_to_string(path).expect("a document");
    let blocks = blocks(&text).unwrap_or_else(|error| panic!("{}: {error}", name(path)));
    (name(path), blocks)
}

/// A command as one types it whose programs are installed.
fn installed(command: &str) -> String {
    let run = command.strip_prefix("cargo run --release --bin ");
    run.map_or_else(|| command.to_owned(), |rest| rest.replacen(" -- ", " ", 1))
}

/// True for one of robovec's own programs.
fn is_ours(command: &str) -> bool {
    command.starts_with("robovec ") || command.starts_with("robovec-opt ")
}

/// True for a synopsis of the words that a command takes: `FILE… [-o FOLDER]`.
fn is_synopsis(command: &str) -> bool {
    command.contains(" [-")
        || command.contains('…')
        || command.contains("...")
        || command.contains("PIPELINE")
}

/// A line for the shell, run in a folder by the programs of this build.
fn shell(line: &str, folder: &Path) -> Output {
    let programs = Path::new(env!("CARGO_BIN_EXE_robovec")).parent();
    let mut paths = vec![programs.expect("a folder").to_owned()];
    paths.extend(std::env::split_paths(
        &std::env::var_os("PATH").unwrap_or_default(),
    ));
    Command::new("sh")
        .args(["-c", line])
        .env("PATH", std::env::join_paths(paths).expect("paths"))
        .current_dir(folder)
        .output()
        .expect("a shell")
}

/// Output of a command; it must succeed.
fn printed(line: &str, folder: &Path) -> Result<String, String> {
    let output = shell(line, folder);
    let [told, warned] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    if output.status.success() {
        Ok(told + &warned)
    } else {
        Err(format!("{line}\n{warned}"))
    }
}

#[test]
fn programs_understand_every_command_of_the_documents() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut count = 0;
    for document in documents() {
        let (name, blocks) = read(&document);
        for block in blocks.iter().filter(|block| block.kind == "sh") {
            for command in commands(&block.text) {
                let command = installed(&command);
                if !is_ours(&command) {
                    continue;
                }
                count += 1;
                // What may be left out is read as well; then everything before
                // --help is read, and nothing is run.
                let mut asked = command.clone();
                if is_synopsis(&command) {
                    let plain = command.replace(" [", " ").replace("] ", " ");
                    let plain = plain.trim_end_matches(']').replace('|', "/");
                    asked = plain.replace('(', "\\(").replace(')', "\\)");
                }
                let asked = format!("{asked} --help");
                let line = block.line;
                if let Err(error) = printed(&asked, folder.path()) {
                    panic!("{name}:{line}: {error}");
                }
            }
        }
    }
    assert!(count > 80, "{count} commands");
}

/// Findings of a run of the documents.
#[derive(Default)]
struct Tried {
    /// Entries of [`NOT_RUN`] that a document shows.
    used: BTreeSet<usize>,
    /// Smaller commands that were run.
    smaller: BTreeSet<String>,
    /// Number of commands that were run.
    count: usize,
    wrong: Vec<String>,
}

/// A document being tried.
struct TriedDocument<'a> {
    name: String,
    folder: PathBuf,
    /// Output of the last command that was run.
    printed: Option<String>,
    tried: &'a Mutex<Tried>,
}

impl TriedDocument<'_> {
    fn attempt(&mut self, block: &CodeBlock) -> Result<(), String> {
        match block.kind.as_str() {
            "sh" => self.commands(&block.text),
            "console" => self.excerpt(&block.text),
            "rules" => self.rules(&block.text),
            "rvir" => function(&block.text),
            "c" => self.compile(block),
            "toml" => self.toml(block),
            "python" => {
                let tests = fs::read_to_string(tree("python/tests/test_robovec.py"));
                let known = tests.is_ok_and(|tests| tests.contains(&self.name));
                let message = "python/tests/test_robovec.py does not run this document";
                known.then_some(()).ok_or_else(|| message.to_owned())
            }
            "rust" => {
                let library = fs::read_to_string(tree("src/lib.rs")).expect("it is there");
                let known = library.contains(&format!("docs/{}", self.name));
                let message = "src/lib.rs does not compile this document";
                known.then_some(()).ok_or_else(|| message.to_owned())
            }
            "text" => match block.text.lines().find(|line| is_ours(line)) {
                Some(line) => Err(format!("'{line}' is a command, and text is not run")),
                None => Ok(()),
            },
            kind => Err(format!("'{kind}' is no kind of code that is tried")),
        }
    }

    fn commands(&mut self, text: &str) -> Result<(), String> {
        let mut folder = self.folder.clone();
        for command in commands(text) {
            let command = installed(&command);
            if let Some(place) = command.strip_prefix("cd ") {
                folder = folder.join(given(place));
                let message = || format!("there is no folder {}", folder.display());
                folder.is_dir().then_some(()).ok_or_else(message)?;
                continue;
            }
            self.command(&command, &folder)?;
        }
        Ok(())
    }

    fn command(&mut self, command: &str, folder: &Path) -> Result<(), String> {
        let is_excused = |(line, _): &(&str, &str)| match line.strip_suffix('…') {
            Some(start) => command.starts_with(start),
            None => command == *line,
        };
        let smaller = SMALLER.iter().find(|(start, _)| command.starts_with(start));
        if let Some(index) = NOT_RUN.iter().position(is_excused) {
            self.tried
                .lock()
                .expect("no test panics")
                .used
                .insert(index);
            return Ok(());
        }
        if is_synopsis(command) {
            return Ok(());
        }
        let mut command = given(command);
        if let Some((_, smaller)) = smaller {
            command = (*smaller).to_owned();
            let mut tried = self.tried.lock().expect("no test panics");
            if !tried.smaller.insert(command.clone()) {
                return Ok(());
            }
        }
        if command.contains("iverilog") && Command::new("iverilog").arg("-V").output().is_err() {
            println!("SKIPPED: without Icarus Verilog: {command}");
            return Ok(());
        }
        let start = std::time::Instant::now();
        self.printed = Some(printed(&command, folder)?);
        println!("{}: {:.1?} {command}", self.name, start.elapsed());
        self.tried.lock().expect("no test panics").count += 1;
        Ok(())
    }

    /// Tests for lines of the last command's output, in this order.
    fn excerpt(&self, text: &str) -> Result<(), String> {
        let printed = self.printed.as_ref().ok_or("no command printed it")?;
        let mut lines = printed.lines().map(str::trim);
        for line in text.lines().map(str::trim) {
            let is_gap = line.is_empty() || line == "…";
            if !is_gap && !lines.any(|printed| printed == line) {
                return Err(format!("the last command does not print\n{line}"));
            }
        }
        Ok(())
    }

    /// A file of rules, under the name of its first line.
    fn rules(&self, text: &str) -> Result<(), String> {
        let first = text.lines().next().unwrap_or_default();
        let name = first
            .strip_prefix("# ")
            .ok_or("the first line names the file")?;
        fs::write(self.folder.join(name), text).expect("a folder of our own");
        printed(&format!("robovec rules check {name}"), &self.folder).map(drop)
    }

    /// C, with the headers of the folder that the fence names.
    fn compile(&self, block: &CodeBlock) -> Result<(), String> {
        fs::write(self.folder.join("block.c"), &block.text).expect("a folder of our own");
        let headers = given(&block.note);
        let compile = format!("cc -Wall -Werror -fsyntax-only -I '{headers}' block.c");
        printed(&compile, &self.folder).map(drop)
    }

    /// A file that robovec reads, or a part of the file that the fence names.
    fn toml(&self, block: &CodeBlock) -> Result<(), String> {
        let text = &block.text;
        if let Some(model) = block.note.strip_prefix("laws of ") {
            let bytes = fs::read(tree(model)).map_err(|error| error.to_string())?;
            let read = read_mbs(model, &bytes).expect("what ships is read");
            let laws = Laws::parse(&read.model, text);
            return laws.map(drop).map_err(|errors| format!("{errors:?}"));
        }
        if block.note == "plan" {
            fs::write(self.folder.join("plan.toml"), text).expect("a folder of our own");
            // A share of nothing: the plan is read and resolved.
            let study = "robovec explore --plan plan.toml -o plan --shard 1000/1000";
            return printed(study, &self.folder).map(drop);
        }
        let whole = fs::read_to_string(tree(&block.note)).map_err(|error| error.to_string())?;
        let mut whole: toml::Table = whole.parse().expect("what ships is read");
        let part: toml::Table = text
            .parse()
            .map_err(|error: toml::de::Error| error.to_string())?;
        whole.extend(part);
        let whole = toml::to_string(&whole).expect("it was TOML");
        if block.note.starts_with("machines/") {
            return Machine::parse(&whole)
                .map(drop)
                .map_err(|error| error.to_string());
        }
        let folder = self.folder.join("part");
        fs::create_dir_all(folder.join("scenes")).expect("a folder of our own");
        for part in ["models", "laws"] {
            let link = std::os::unix::fs::symlink(tree("examples").join(part), folder.join(part));
            // The first scene of the document made it.
            link.unwrap_or_default();
        }
        fs::write(folder.join("scenes/part.scene.toml"), whole).expect("a folder of our own");
        printed(
            "robovec fit --explain part/scenes/part.scene.toml",
            &self.folder,
        )
        .map(drop)
    }
}

/// A command with its placeholders replaced.
fn given(command: &str) -> String {
    let words = command.split(' ').map(|word| {
        let known = PLACEHOLDERS
            .iter()
            .find(|(placeholder, _)| *placeholder == word);
        known.map_or(word, |(_, stands_for)| *stands_for)
    });
    let words: Vec<&str> = words.collect();
    words.join(" ").replace("FOLDER/", "folder/")
}

/// A function in robovec's own text; sources may be left out.
fn function(text: &str) -> Result<(), String> {
    let text = if text.contains("source 0") {
        text.to_owned()
    } else {
        format!("source 0 \"a.m\"\n{text}")
    };
    parse_module("block", &text)
        .map(drop)
        .map_err(|errors| format!("{errors:?}"))
}

/// A copy of a folder of files; links stay links.
fn copy(from: &Path, to: &Path) {
    let status = Command::new("cp")
        .arg("-R")
        .arg(from.join("."))
        .arg(to)
        .status();
    assert!(status.expect("cp").success());
}

#[test]
fn every_block_of_the_documents_is_what_its_fence_says() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let filled = folder.path().join("filled");
    fs::create_dir(&filled).expect("a folder of our own");
    given::fill(&filled);
    let readme = read(&tree("README.md")).1;
    let rules = readme
        .iter()
        .find(|block| block.kind == "rules")
        .expect("a rule");
    fs::write(filled.join("mine.rules"), &rules.text).expect("a folder of our own");
    let (tried, waiting) = (Mutex::new(Tried::default()), Mutex::new(documents()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(2, usize::from) {
            scope.spawn(|| {
                while let Some(path) = { waiting.lock().expect("no test panics").pop() } {
                    let (name, blocks) = read(&path);
                    let own = folder.path().join(&name);
                    fs::create_dir(&own).expect("a folder of our own");
                    copy(&filled, &own);
                    let printed = None;
                    let (name, folder, tried) = (name.clone(), own, &tried);
                    let mut document = TriedDocument {
                        name,
                        folder,
                        printed,
                        tried,
                    };
                    for block in blocks {
                        if let Err(error) = document.attempt(&block) {
                            let wrong = format!("{}:{}: {error}", document.name, block.line);
                            tried.lock().expect("no test panics").wrong.push(wrong);
                        }
                    }
                }
            });
        }
    });
    let tried = tried.into_inner().expect("no test panics");
    assert!(tried.wrong.is_empty(), "{}", tried.wrong.join("\n"));
    assert!(tried.count > 80, "{} commands are run", tried.count);
    let unused = NOT_RUN
        .iter()
        .enumerate()
        .filter(|(index, _)| !tried.used.contains(index));
    let unused: Vec<_> = unused.map(|(_, entry)| entry).collect();
    assert!(unused.is_empty(), "no document shows {unused:?}");
    let unused = SMALLER
        .iter()
        .filter(|(_, smaller)| !tried.smaller.contains(*smaller));
    assert_eq!(unused.count(), 0, "no document shows what is run smaller");
}
