//! Every command on files of the wrong kind, and without the tools that it
//! needs: one message, exit code 1, and no output.
//!
//! The commands are those that the programs list; one without a row in
//! [`PLACES`] or [`WITHOUT_FILES`] fails. `tests/mistaken/files.snap` holds
//! every message, with the commands that give it.

use crate::support::files::{compare_with_record, tree};
use crate::support::programs::{opt_in, robovec_in, said, stderr};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Kinds of files.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Sample {
    Equations,
    Model,
    Pipeline,
    Machine,
    Scene,
    Laws,
    Plan,
    Rules,
    ForeignRules,
    States,
    Images,
    /// TOML of no kind in particular, which readers of TOML refuse line by line.
    Toml,
    /// No kind that any command takes.
    Foreign,
}

use Sample::{
    Equations, Foreign, ForeignRules, Images, Laws, Machine, Model, Pipeline, Plan, Rules, Scene,
    States, Toml,
};

/// The places of command lines that name a file (`@`): the extension it has
/// there, and the kinds that are taken.
const PLACES: [(&str, &str, &[Sample]); 63] = [
    (
        "robovec-opt @ --passes=atomise",
        "rvir",
        &[Equations, Model, Scene],
    ),
    ("robovec-opt @ --run-reproducer", "rvir", &[Equations]),
    ("robovec-opt good.rvir --passes=@@", "txt", &[Pipeline]),
    (
        "robovec-opt good.rvir --passes=atomise --machine=@",
        "toml",
        &[Machine],
    ),
    (
        "robovec-opt good.rvir --passes=atomise --scene=@",
        "toml",
        &[Scene],
    ),
    (
        "robovec-opt good.rvir --passes=atomise --rules=@",
        "rules",
        &[Rules],
    ),
    (
        "robovec-opt good.rvir --passes=codegen{target=template} --target=@",
        "",
        &[],
    ),
    ("bench @ --peers=none", "c", &[Equations, Model]),
    ("bench good.c --peers=none --model=@", "mbs", &[Model]),
    ("check @ good.rvir", "rvir", &[Equations]),
    ("check good.rvir @", "c", &[Equations]),
    ("check good.rvir good.rvir --zeros=@", "mbs", &[Model]),
    ("check good.rvir good.rvir --model=@", "mbs", &[Model]),
    ("error @ --states=8", "rvir", &[Equations, Model]),
    ("error @ --blame", "c", &[Equations, Model]),
    ("error @ --series", "rvir", &[Equations, Model]),
    ("error good.rvir --scene=@", "toml", &[Scene]),
    ("eval @ --states=1", "m", &[Equations, Model]),
    ("eval good.rvir --states=@", "txt", &[States]),
    ("eval good.rvir --states=1 --model=@", "mbs", &[Model]),
    ("explore @", "py", &[Equations, Model]),
    ("explore --plan=@ -o out", "toml", &[Plan]),
    (
        "explore @ --plan=good.toml -o out",
        "c",
        &[Equations, Model],
    ),
    ("explore @ --designs", "c", &[Equations, Model]),
    ("explore good.rvir --machine=@", "toml", &[Machine]),
    ("fit @", "toml", &[Scene]),
    ("fit @ --reduce", "toml", &[Scene]),
    ("gen @", "mbs", &[Equations, Model]),
    ("gen @ --language=c", "m", &[Equations, Model]),
    ("model @", "mbs", &[Model]),
    ("model good.mbs --equations=@", "c", &[Equations]),
    ("optimise @", "c", &[Equations, Model, Scene]),
    ("optimise good.rvir --model=@", "mbs", &[Model]),
    ("optimise good.rvir --scene=@", "toml", &[Scene]),
    (
        "rtl @ --passes=atomise,place -o out",
        "rvir",
        &[Equations, Model],
    ),
    (
        "rtl good.rvir --passes=atomise,place --fits=@",
        "json",
        &[Images],
    ),
    ("rules bench @", "rvir", &[Equations, Model]),
    ("rules bench good.rvir --rules=@", "rules", &[Rules]),
    ("rules check @", "rules", &[Rules]),
    ("rules export @ --syntax=egglog", "rules", &[Rules]),
    ("rules find @", "rvir", &[Equations, Model]),
    ("rules find good.rvir --from=@", "rvir", &[Equations, Model]),
    ("rules find good.rvir --rules=@", "rules", &[Rules]),
    ("rules import @ --syntax=egglog", "egg", &[ForeignRules]),
    ("rules list @", "rules", &[Rules]),
    ("rules profile @", "rules", &[Rules]),
    ("rules why y @", "rvir", &[Equations, Model]),
    ("rules why y good.rvir --rules=@", "rules", &[Rules]),
    ("rules why-not a+b b+a --rules=@", "rules", &[Rules]),
    ("fit @ --explain", "toml", &[Scene]),
    ("sim @", "mbs", &[Model]),
    ("sim good.mbs --laws=@", "toml", &[Laws]),
    ("sim equilibrium @", "mbs", &[Model]),
    ("sim equilibrium good.mbs --laws=@", "toml", &[Laws]),
    ("sim fmu @ -o x.fmu", "mbs", &[Model]),
    ("sim fmu good.mbs -o x.fmu --laws=@", "toml", &[Laws]),
    ("sim modal @", "urdf", &[Model]),
    ("sim modal good.mbs --laws=@", "toml", &[Laws]),
    ("rtl simulate @", "", &[Images]),
    ("view @", "c", &[Equations, Model]),
    ("view good.rvir --model=@", "mbs", &[Model]),
    ("view good.rvir --scene=@", "toml", &[Scene]),
    ("view good.rvir --rules=@", "rules", &[Rules]),
];

/// Commands that read no file.
const WITHOUT_FILES: [&str; 6] = [
    // Its subject is a folder; tests/project.rs has its mistakes.
    "project",
    "rtl help",
    "rtl synthesise",
    "rules help",
    "sim help",
    "stress",
];

/// Files of every kind, the same for all places.
const SAMPLES: [(&str, Sample, &[u8]); 16] = [
    ("picture.png", Foreign, b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"),
    ("a.out", Foreign, b"\x7fELF\x02\x01\x01\0\0\0\0\0"),
    ("archive.zip", Foreign, b"PK\x03\x04\x14\0\0\0"),
    ("numbers.bin", Foreign, b"\x01\x02\0\x03"),
    ("page.html", Foreign, b"<!DOCTYPE html>\n<html></html>\n"),
    ("data.json", Foreign, b"{\n  \"a\": 1\n}\n"),
    ("other.toml", Toml, b"[package]\nname = \"x\"\n"),
    (
        "notes.md",
        Foreign,
        b"# Notes\n\nA text for people, not for programs.\n",
    ),
    (
        "of-robotran.mbs",
        Model,
        b"<?xml version=\"1.0\"?>\n<mbsDescR7>\n</mbsDescR7>\n",
    ),
    ("robot.xml", Model, b"<robot name=\"arm\">\n</robot>\n"),
    (
        "by-robotran.c",
        Equations,
        b"void mbs_invdyna(double *Qq, MbsData *s, double tsim)\n{\nQq[1] = s->q[1];\n}\n",
    ),
    (
        "own.rvir",
        Equations,
        b"// robovec 1\nfunction f equations {\n  in q\n  out y\n  y = q\n}\n",
    ),
    (
        "machine.toml",
        Machine,
        b"name = \"x\"\nclock_mhz = 100.0\n",
    ),
    (
        "laws.toml",
        Laws,
        b"[[joint]]\nname = \"hinge\"\nstiffness = 1.0\n",
    ),
    ("mine.rules", Rules, b"rule some: a*b + a*c => a*(b + c);\n"),
    (
        "others.egg",
        ForeignRules,
        b"(rewrite (Add a b) (Add b a))\n",
    ),
];

/// More of them, whose texts are of the tree.
const MORE: [(&str, Sample, &str); 2] = [
    (
        "ride.scene.toml",
        Scene,
        "examples/scenes/bogie-1e-4.scene.toml",
    ),
    ("plan.toml", Plan, "tests/study/errors/unknown_names.toml"),
];

/// The commands of a help text, after its program's words.
fn commands(words: &[&str]) -> BTreeSet<String> {
    let mut arguments = words.to_vec();
    arguments.push("--help");
    let help = said(&robovec_in(&tree(""), &arguments));
    let is_name = |word: &&str| {
        word.bytes()
            .all(|byte| byte == b'-' || byte.is_ascii_lowercase())
    };
    let lines = help.lines().filter_map(|line| line.strip_prefix("  "));
    let lines = lines.filter(|line| line.starts_with(|first: char| first.is_ascii_lowercase()));
    lines
        .filter(|line| line.contains("  "))
        .filter_map(|line| line.split_whitespace().next().filter(is_name))
        .map(|name| [words, &[name]].concat().join(" "))
        .collect()
}

#[test]
fn every_command_is_tried() {
    let mut known = commands(&[]);
    assert!(known.remove("rules"), "{known:?}");
    for group in ["rtl", "rules", "sim"] {
        known.extend(commands(&[group]));
    }
    let of = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let both = words[..2].join(" ");
        if known.contains(&both) {
            both
        } else {
            words[0].to_owned()
        }
    };
    let tried = PLACES
        .iter()
        .map(|(line, ..)| of(line))
        .filter(|name| name != "robovec-opt");
    let tried: BTreeSet<String> = tried.chain(WITHOUT_FILES.map(str::to_owned)).collect();
    assert_eq!(
        known, tried,
        "a row in PLACES or WITHOUT_FILES is missing, or one too many"
    );
}

/// Files that are right.
fn prepare(folder: &Path) {
    let copy = |from: &str, to: &str| {
        fs::copy(tree(from), folder.join(to)).expect("it ships");
    };
    copy("examples/models/double-pendulum.mbs", "good.mbs");
    for (name, _, text) in SAMPLES
        .iter()
        .filter(|(name, ..)| name.contains(['v', 'y']))
    {
        match *name {
            "own.rvir" => fs::write(folder.join("good.rvir"), text).expect("written"),
            "by-robotran.c" => fs::write(folder.join("good.c"), text).expect("written"),
            _ => {}
        }
    }
    let plan = "name = \"p\"\n[[model]]\nname = \"f\"\nsource = \"good.rvir\"\n[[pipeline]]\n\
                name = \"x\"\npasses = \"atomise\"\n[[sweep]]\nelements = [1]\n";
    fs::write(folder.join("good.toml"), plan).expect("written");
    fs::create_dir(folder.join("heap")).expect("made");
    for (name, _, text) in SAMPLES {
        fs::write(folder.join(name), text).expect("written");
    }
    for (name, _, from) in MORE {
        copy(from, name);
    }
}

fn run(folder: &Path, line: &str) -> Output {
    let words: Vec<&str> = line.split(' ').collect();
    match words[0] {
        "robovec-opt" => opt_in(folder, &words[1..]),
        _ => robovec_in(folder, &words),
    }
}

/// The message of a run that must fail, with one error; else the fault of the
/// run.
fn refusal(folder: &Path, line: &str) -> Result<String, String> {
    let output = run(folder, line);
    let message = stderr(&output);
    let errors = message.lines().filter(|line| line.starts_with("error"));
    let is_right = output.status.code() == Some(1)
        && output.stdout.is_empty()
        && !message.contains("panicked")
        && errors.count() == 1;
    if is_right {
        Ok(message)
    } else {
        Err(format!("$ {line}\n{:?}\n{message}", output.status.code()))
    }
}

#[test]
fn files_that_a_command_cannot_take_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    prepare(folder);
    let mut trials: Vec<(String, String)> = Vec::new();
    for (line, extension, taken) in PLACES {
        let mut names = vec!["missing".to_owned(), "heap".to_owned()];
        for (what, text) in [("empty", &b""[..]), ("disguised", SAMPLES[0].2)] {
            let name = format!("{what}.{extension}");
            fs::write(folder.join(&name), text).expect("written");
            names.push(name);
        }
        let samples = SAMPLES.iter().map(|(name, kind, _)| (name, kind));
        let samples = samples.chain(MORE.iter().map(|(name, kind, _)| (name, kind)));
        let reads_toml = extension == "toml";
        let is_taken = |kind: &Sample| taken.contains(kind) || reads_toml && *kind == Toml;
        let others = samples.filter(|(_, kind)| !is_taken(kind));
        names.extend(others.map(|(name, _)| (*name).to_owned()));
        trials.extend(names.into_iter().map(|name| (line.to_owned(), name)));
    }
    let messages: Vec<Result<String, String>> = trials
        .par_iter()
        .map(|(line, name)| {
            // `@@` is a pipeline's mark and the file.
            let line = match line.split_once("@@") {
                Some((before, after)) => format!("{before}@{name}{after}"),
                None => line.replace('@', name),
            };
            let message = refusal(folder, &line)?;
            if message.contains(name.as_str()) {
                Ok(message)
            } else {
                Err(format!("$ {line}\nno name of the file\n{message}"))
            }
        })
        .collect();
    let wrong = messages.iter().filter_map(|message| message.as_ref().err());
    let wrong: Vec<&str> = wrong.map(String::as_str).collect();
    assert!(
        wrong.is_empty(),
        "{} runs:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    let mut record = MessageRecord::default();
    for ((line, name), message) in trials.iter().zip(messages.into_iter().flatten()) {
        record.add(line, &message.trim_end().replace(name.as_str(), "FILE"));
    }
    compare_with_record(&tree("tests/mistaken"), "files", &record.text());
}

/// Messages with the commands that give them; those that name an expected kind
/// and the recognised kind of a file are separate, since all pairs occur.
#[derive(Default)]
struct MessageRecord<'a>(BTreeMap<String, BTreeSet<&'a str>>);

impl<'a> MessageRecord<'a> {
    fn add(&mut self, line: &'a str, message: &str) {
        let parts = message.split_once(": it looks like ");
        let texts = match (parts, message.split_once(" is empty\n = expected ")) {
            (Some((wanted, looks)), _) => vec![
                (format!("{wanted}: it looks like …"), Some(line)),
                (format!("error: …: it looks like {looks}"), None),
            ],
            (None, Some((_, wanted))) => vec![
                (
                    format!("error: FILE is not {wanted}: it looks like …"),
                    Some(line),
                ),
                ("error: FILE is empty\n = expected …".to_owned(), None),
            ],
            // Every command gives these.
            (None, None) if message.contains("cannot read") => vec![(message.to_owned(), None)],
            (None, None) => vec![(message.to_owned(), Some(line))],
        };
        for (text, line) in texts {
            self.0.entry(text).or_default().extend(line);
        }
    }

    fn text(&self) -> String {
        let lines = |lines: &BTreeSet<&str>| -> String {
            lines.iter().map(|line| format!("$ {line}\n")).collect()
        };
        let records = self.0.iter();
        records
            .map(|(message, commands)| format!("{}{message}\n\n", lines(commands)))
            .collect()
    }
}

/// Commands that need a tool, and the tool.
const WITHOUT_TOOLS: [(&str, &str); 12] = [
    ("optimise good.rvir --for=cpu", "'cc'"),
    ("optimise good.rvir --for=batch --compiler=nocc", "'nocc'"),
    ("bench good.c --peers=none", "'gcc'"),
    ("bench good.c --peers=none --compilers=nocc", "'nocc'"),
    ("explore good.rvir --cpu -o out", "'cc'"),
    ("explore good.rvir --designs --cpu -o out", "'cc'"),
    ("explore --plan=good.toml --cpu -o out", "'cc'"),
    ("rtl synthesise", "yosys"),
    (
        "rtl good.rvir --passes=atomise,place --check=iverilog -o out",
        "'iverilog'",
    ),
    (
        "rtl good.rvir --passes=atomise,place --check=verilator -o out",
        "'verilator'",
    ),
    (
        "rtl good.rvir --passes=atomise,place --synthesise -o out",
        "yosys",
    ),
    (
        "rtl good.rvir --passes=atomise,place --place-and-route=1 -o out",
        "yosys",
    ),
];

/// No work is done before a missing tool is reported.
#[test]
fn tools_that_are_not_there_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    prepare(folder);
    let mut text = String::new();
    for (line, tool) in WITHOUT_TOOLS {
        let output = Command::new(env!("CARGO_BIN_EXE_robovec"))
            .current_dir(folder)
            .env("PATH", folder.join("heap"))
            .args(line.split(' '))
            .output()
            .expect("the program starts");
        let message = stderr(&output);
        let errors = message.lines().filter(|line| line.starts_with("error"));
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert_eq!(errors.count(), 1, "{line}: {message}");
        assert!(
            message.contains(tool) && output.stdout.is_empty(),
            "{line}: {message}"
        );
        assert!(!folder.join("out").exists(), "{line} left something");
        text += &format!("$ {line}\n{}\n\n", message.trim_end());
    }
    compare_with_record(&tree("tests/mistaken"), "tools", &text);
}
