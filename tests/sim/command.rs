//! The commands `sim` and `eval`, from the command line.

use crate::support::programs::{model, robovec};
use std::fs;
use std::path::Path;

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Demands exit code 1, the words in the message, and nothing written.
fn refused(arguments: &[&str], words: &[&str]) {
    let output = robovec(arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(
            message.contains(word),
            "{arguments:?}: no '{word}' in\n{message}"
        );
    }
    assert!(!message.contains("panicked"), "{message}");
}

#[test]
fn sim_writes_a_table_and_a_drawing_and_sums_up() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (table, drawing) = (folder.path().join("t.csv"), folder.path().join("p.svg"));
    let path = model("four-bar.mbs");
    let arguments = [
        "sim",
        path.to_str().expect("a path"),
        "--time",
        "0.5",
        "--samples",
        "10",
        "--passes=atomise,balance,cse,dce",
    ];
    let files = [
        "-o",
        table.to_str().expect("a path"),
        "--plot",
        drawing.to_str().expect("a path"),
    ];
    let output = robovec(&[&arguments[..], &files].concat());
    let summary = text(&output.stderr);
    assert!(output.status.success(), "{summary}");
    assert!(output.stdout.is_empty());
    assert!(
        summary.contains("1 independent, 2 dependent, 0 driven"),
        "{summary}"
    );
    assert!(summary.contains("constraints kept within"), "{summary}");
    let rows = fs::read_to_string(&table).expect("the table");
    let lines: Vec<&str> = rows.lines().collect();
    assert_eq!(lines.len(), 12);
    assert!(lines[0].starts_with("time,q.R2_Crank,"), "{}", lines[0]);
    assert!(lines[11].starts_with("0.5,"), "{}", lines[11]);
    let columns = lines[0].split(',').count();
    assert!(lines.iter().all(|line| line.split(',').count() == columns));
    let svg = fs::read_to_string(&drawing).expect("the drawing");
    assert!(svg.starts_with("<svg") && svg.contains("R2_Rocker"));
    // The same bytes again, this time on the standard output.
    let again = robovec(&arguments);
    assert_eq!(text(&again.stdout), rows);
}

#[test]
fn sim_says_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let laws = folder.path().join("laws.toml");
    fs::write(&laws, "[[link]]\nname = 'Sprung'\n").expect("room");
    let laws = laws.to_str().expect("a path");
    let car = model("quarter-car.mbs");
    let car = car.to_str().expect("a path");
    let never = folder.path().join("never.csv");
    let output = never.to_str().expect("a path");
    refused(
        &["sim", car, "--laws", laws, "-o", output],
        &["no link 'Sprung'", "did you mean 'Spring'?", "laws.toml:2"],
    );
    refused(
        &["sim", car, "--hold", "R2_Weel", "-o", output],
        &["no joint 'R2_Weel'", "did you mean 'R2_Wheel'?"],
    );
    refused(
        &["sim", car, "--max-steps", "3", "-o", output],
        &["3 steps did not"],
    );
    refused(
        &["sim", car, "--passes=atomise,place", "-o", output],
        &["the passes failed", "sqrt"],
    );
    assert!(!never.exists());
    let wrong = robovec(&["sim", car, "--step", "-1"]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn sim_warns_of_forces_that_are_zero_and_of_locked_wheels() {
    let car = model("car.mbs");
    let car = car.to_str().expect("a path");
    let short = ["sim", car, "--time", "1e-4", "--samples", "1"];
    let plain = robovec(&short);
    let warned = text(&plain.stderr);
    for part in ["zero, since no law", "Spring_Front_left", "Tyre_Rear_left"] {
        assert_eq!(warned.matches(part).count(), 1, "{part}: {warned}");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let laws = folder.path().join("laws.toml");
    let tyres = "[[link]]\nname = '*'\nforce = 1.0\n\
                 [[tyre]]\nname = '*'\nradius = 0.3\nstiffness = 1e5\nlaw = 'linear'\n\
                 longitudinal = 1e3\nlateral = 1e3\nfriction = 1.0\n";
    fs::write(&laws, tyres).expect("room");
    let laws = laws.to_str().expect("a path");
    let warned = robovec(&[&short[..], &["--laws", laws]].concat());
    let warned = text(&warned.stderr);
    // Its forces are those of knuckles.
    assert!(warned.contains("about the axes of these wheels: tyres Tyre_Front_left"));
    assert!(!warned.contains("no law"), "{warned}");
    let quarter = model("quarter-car.mbs");
    let quarter = quarter.to_str().expect("a path");
    let wheel = robovec(&["sim", quarter, "--time", "1e-4", "--laws", laws]);
    assert!(!text(&wheel.stderr).contains("warning"));
}

#[test]
fn sim_holds_joints() {
    let car = model("quarter-car.mbs");
    let car = car.to_str().expect("a path");
    let output = robovec(&[
        "sim",
        car,
        "--samples",
        "2",
        "--hold",
        "R2_Wheel,T3_Chassis",
    ]);
    let summary = text(&output.stderr);
    assert!(
        summary.contains("1 independent, 2 dependent, 2 driven"),
        "{summary}"
    );
    let table = text(&output.stdout);
    let last = table.lines().last().expect("rows");
    assert!(last.starts_with("1.0,0.45,"), "{last}");
}

#[test]
fn eval_takes_models_and_equations() {
    let path = model("four-bar.mbs");
    let path = path.to_str().expect("a path");
    let output = robovec(&[
        "eval",
        path,
        "--random",
        "2",
        "--function",
        "dirdyna,cons_hJ",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines = text(&output.stdout);
    assert!(lines.contains("\nstate 2 cons_hJ Jac[2,3] "), "{lines}");
    let again = robovec(&[
        "eval",
        path,
        "--random",
        "2",
        "--function",
        "dirdyna,cons_hJ",
    ]);
    assert_eq!(again.stdout, output.stdout);
    refused(
        &["eval", path, "--random", "1", "--function", "cons_h"],
        &["no function 'cons_h'", "cons_hJ"],
    );
    let equations =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.py");
    let equations = equations.to_str().expect("a path");
    let output = robovec(&[
        "eval", equations, "--random", "1", "--number", "192", "--format", "csv",
    ]);
    let table = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let value = table
        .lines()
        .nth(1)
        .and_then(|line| line.rsplit(',').next());
    assert!(value.is_some_and(|value| value.len() > 20), "{table}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let states = folder.path().join("states.txt");
    fs::write(&states, "q[1] 1\n").expect("room");
    let states = states.to_str().expect("a path");
    refused(
        &["eval", equations, "--states", states],
        &["before the first `state`", "states.txt:1:1"],
    );
    refused(
        &["eval", equations, "--random", "1", "--function", "invdyna"],
        &["no function 'invdyna'", "dirdyna"],
    );
}
