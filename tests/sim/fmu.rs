//! FMUs of models with laws, in FMPy where it is installed.

use crate::reference::random::{self, Recipe};
use crate::support::programs::{robovec, said, stderr};
use robovec::model::Model;
use robovec::model::mbs::write_mbs;
use robovec_num::random::Random;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Makes the FMU of a model and compares it with `sim` for a time: the largest
/// differences of co-simulation, of model exchange, and of directional
/// derivatives; `None` if `sim` gives up.
fn compared(folder: &Path, subject: &[&str], seconds: &str) -> Option<[f64; 3]> {
    let [fmu, table] = ["x.fmu", "x.csv"].map(|name| folder.join(name).display().to_string());
    let run = [
        &["sim"],
        subject,
        &["--whole-step", "--time", seconds, "--samples", "20"],
    ]
    .concat();
    let run = [&run[..], &["--tolerance", "1e-10", "-q", "-o", &table]].concat();
    if !robovec(&run).status.success() {
        return None;
    }
    said(&robovec(
        &[&["sim", "fmu"], subject, &["-q", "-o", &fmu]].concat(),
    ));
    let main = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/sim/fmu_main.py");
    let output = Command::new("python3").args([main, &fmu, &table]).output();
    let text = said(&output.expect("python3 starts"));
    let numbers = text.lines().next_back().expect("a line").split(' ');
    let numbers: Vec<f64> = numbers
        .map(|word| word.parse().expect("a number"))
        .collect();
    Some(numbers.try_into().expect("three numbers"))
}

/// True if FMPy is installed; a message if not.
fn has_fmpy() -> bool {
    let import = Command::new("python3").args(["-c", "import fmpy"]).output();
    let is_there = import.is_ok_and(|output| output.status.success());
    if !is_there {
        eprintln!("SKIPPED: FMPy is not installed (pip install fmpy), no FMU was run");
    }
    is_there
}

fn assert_near([together, exchange, derivative]: [f64; 3], subject: &str) {
    assert!(together < 1e-7, "{subject}: co-simulation {together:e}");
    assert!(exchange < 1e-4, "{subject}: model exchange {exchange:e}");
    assert!(derivative < 1e-6, "{subject}: derivatives {derivative:e}");
}

#[test]
fn examples_move_in_fmpy_as_in_sim() {
    if !has_fmpy() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (model, laws, seconds) in [
        ("models/quarter-car.mbs", "laws/quarter-car-tyre.toml", "1"),
        ("models/leg.mbs", "laws/leg.toml", "0.3"),
        ("models/four-bar.mbs", "", "1"),
        ("robots/leg.xml", "", "0.2"),
    ] {
        let [path, laws] = [model, laws].map(|name| format!("examples/{name}"));
        let mut subject = vec![path.as_str()];
        if laws.ends_with(".toml") {
            subject.extend(["--laws", &laws]);
        }
        let found = compared(folder.path(), &subject, seconds).expect("examples move");
        assert_near(found, model);
    }
}

/// Laws for everything that a model has.
fn laws(model: &Model) -> String {
    let mut text =
        String::from("[[joint]]\nname = \"*\"\nstiffness = 3\ndamping = 0.5\nfriction = 0.1\n");
    if !model.links.is_empty() {
        text +=
            "[[link]]\nname = \"*\"\nstiffness = 5\ndamping = 0.2\nforce = 0.3\nfriction = 0.1\n";
    }
    if !model.forces.is_empty() {
        text += "[[force]]\nname = \"*\"\nforce = [1, 2, 3]\ntorque = [0.1, 0, 0]\n\
                 stiffness = [2, 3, 4]\ndamping = [0.1, 0.2, 0.3]\namplitude = [0, 0, 0.1]\nfrequency = 3\n";
    }
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "[[event]]\nname = \"{}\"\nvalue = 7",
        model.joints[0].name
    );
    text
}

#[test]
fn random_models_move_in_fmpy_as_in_sim() {
    if !has_fmpy() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [model_path, laws_path] = ["x.mbs", "x.toml"].map(|name| folder.path().join(name));
    let mut compared_models = 0;
    for seed in 0..8 {
        let mut random = Random::new(seed);
        let recipe = Recipe {
            bodies: 2 + seed as usize % 4,
            zeros: 0.3,
            massless: false,
            driven: seed % 3 == 0,
            placed: false,
            cuts: usize::from(seed % 4 == 1),
            devices: usize::from(seed % 2 == 0),
        };
        let model = random::model(&mut random, &recipe);
        fs::write(&model_path, write_mbs(&model)).expect("a temporary file");
        fs::write(&laws_path, laws(&model)).expect("a temporary file");
        let [path, laws] = [&model_path, &laws_path].map(|path| path.display().to_string());
        if let Some(found) = compared(folder.path(), &[&path, "--laws", &laws], "0.02") {
            assert_near(found, &format!("seed {seed}"));
            compared_models += 1;
        }
    }
    assert!(compared_models >= 4, "{compared_models}");
}

/// Runs an FMU in both ways up to 2 s: the time of the last step of
/// co-simulation, and that of model exchange.
const LAST_TIMES: &str = "
import sys
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
description = read_model_description(sys.argv[1])
fmu = instantiate_fmu(extract(sys.argv[1]), description, 'CoSimulation')
fmu.enterInitializationMode(tolerance=1e-10)
fmu.exitInitializationMode()
_, ends, _, last = fmu.doStep(0.0, 2.0)
assert ends
run = simulate_fmu(sys.argv[1], fmi_type='ModelExchange', stop_time=2, relative_tolerance=1e-10)
print(last, run['time'][-1])
";

#[test]
fn an_event_that_stops_ends_both_kinds_of_run() {
    if !has_fmpy() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [laws, fmu] = ["x.toml", "x.fmu"].map(|name| folder.path().join(name));
    let event = "[[event]]\nname = \"R2_Crank\"\nvalue = -0.9\nstop = true\n";
    fs::write(&laws, event).expect("a temporary file");
    let [laws, fmu] = [laws, fmu].map(|path| path.display().to_string());
    let subject = ["examples/models/four-bar.mbs", "--laws", &laws];
    let precise = ["--time", "2", "--tolerance", "1e-10", "--samples", "1"];
    let table = said(&robovec(&[&["sim"], &subject[..], &precise].concat()));
    let last = table.lines().next_back().expect("a row");
    let (time, _) = last.split_once(',').expect("a time");
    let expected: f64 = time.parse().expect("a number");
    said(&robovec(
        &[&["sim", "fmu"], &subject[..], &["-o", &fmu]].concat(),
    ));
    let run = Command::new("python3")
        .args(["-c", LAST_TIMES, &fmu])
        .output();
    let times = said(&run.expect("python3 starts"));
    for time in times.split_whitespace() {
        let found: f64 = time.parse().expect("a number");
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
    assert_eq!(times.split_whitespace().count(), 2);
}

#[test]
fn models_that_do_not_move_have_no_fmu() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("x.fmu").display().to_string();
    let held = [
        "sim",
        "fmu",
        "examples/models/four-bar.mbs",
        "--hold",
        "R2_Crank",
        "-o",
        &path,
    ];
    let output = robovec(&held);
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(
        message.contains("no joint of the model 'four_bar' moves freely"),
        "{message}"
    );
    assert!(!Path::new(&path).exists());
}

#[test]
fn links_of_robots_are_outputs_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("x.fmu").display().to_string();
    let arm = [
        "sim",
        "fmu",
        "examples/robots/arm.urdf",
        "--compiler",
        "no-such-compiler",
        "-o",
        &path,
    ];
    let text = said(&robovec(&[&arm[..], &["--frames", "tool,base"]].concat()));
    // 21 of joints, 18 of each frame.
    assert!(text.contains("57 outputs"), "{text}");
    let output = robovec(&[&arm[..], &["--frames", "tol"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(
        message.contains("no link 'tol'") && message.contains("did you mean 'tool'?"),
        "{message}"
    );
}

#[test]
fn without_a_compiler_an_fmu_has_its_sources() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("x.fmu").display().to_string();
    let model = "examples/models/double-pendulum.mbs";
    let output = robovec(&[
        "sim",
        "fmu",
        model,
        "--compiler",
        "no-such-compiler",
        "-o",
        &path,
    ]);
    let text = said(&output);
    assert!(
        text.contains("4 states, 2 inputs, 9 parameters, 24 outputs"),
        "{text}"
    );
    assert!(stderr(&output).contains("has its C (sources) and no binary"));
    let bytes = fs::read(&path).expect("it is written");
    let holds = |name: &str| {
        bytes
            .windows(name.len())
            .any(|window| window == name.as_bytes())
    };
    assert!(holds("modelDescription.xml") && holds("sources/double_pendulum.c"));
    assert!(holds("sources/buildDescription.xml") && !holds("binaries/"));
}
