//! The robots that ship: their descriptions, their motions, and their limits in
//! scenes.

use crate::support::files::{compare_with_record, each, list, name, tree};
use crate::support::programs::{robovec, said, stderr};
use robovec::model::robot::{RobotBase, read_robot};
use robovec::model::summary::summarise;
use std::fs;

/// Their files, in order.
pub(super) const EXAMPLES: [&str; 4] =
    ["arm.urdf", "gripper.urdf", "oblique.urdf", "quadruped.urdf"];

const FOLDER: &str = "examples/robots";

#[test]
fn the_robots_that_ship_are_told_as_recorded() {
    let there: Vec<String> = list(FOLDER, &["urdf"])
        .iter()
        .map(|path| name(path))
        .collect();
    assert_eq!(there, EXAMPLES);
    each(FOLDER, &["urdf"], |path| {
        let bytes = fs::read(path).expect("it can be read");
        let name = name(path);
        let told = |base| {
            let read = read_robot(&name, &bytes, base).expect("a robot of our own");
            let warnings = read.warnings.render_plain();
            assert!(
                base == RobotBase::Floating || warnings.is_empty(),
                "{warnings}"
            );
            warnings + &summarise(&read.model)
        };
        let text = format!("{}\n{}", told(RobotBase::Fixed), told(RobotBase::Floating));
        compare_with_record(&tree("tests/robots/told"), &name, text.trim_end());
    });
}

/// The loss of energy of a motion, as a part of the largest kinetic energy,
/// from the figures that `sim` prints.
fn drift(name: &str, base: &str) -> f64 {
    let path = format!("{FOLDER}/{name}");
    let options = "--time 1 --tolerance 1e-10 --samples 4 --base";
    let options = options.split(' ').chain([base]);
    let output = robovec(
        &["sim", &path]
            .into_iter()
            .chain(options)
            .collect::<Vec<_>>(),
    );
    said(&output);
    let summary = stderr(&output);
    let after = |words: &str| -> f64 {
        let (_, rest) = summary
            .split_once(words)
            .unwrap_or_else(|| panic!("{summary}"));
        let number = rest.split_whitespace().next().expect("a number");
        number.parse().unwrap_or_else(|_| panic!("{summary}"))
    };
    let reached = after("kinetic energy reached ");
    assert!(reached > 1e-3, "{name} does not move:\n{summary}");
    after("energy less work kept within ") / reached
}

/// Energy is reckoned from the model by plain kinematics, so that a sign or a
/// turn that the equations see otherwise would show.
#[test]
fn robots_swing_without_loss() {
    let on_the_ground = EXAMPLES.map(|name| (name, "fixed"));
    // The base of the others has no mass, and a free one must have some.
    for (name, base) in on_the_ground
        .into_iter()
        .chain([("quadruped.urdf", "floating")])
    {
        let drift = drift(name, base);
        assert!(drift < 1e-8, "{name}, {base}: {drift:e}");
    }
}

#[test]
fn the_name_of_a_file_does_not_matter_where_its_text_tells() {
    let text = fs::read_to_string(tree("examples/robots/arm.urdf")).expect("it is there");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ARM.URDF");
    fs::write(&path, &text).expect("a folder of our own");
    let output = robovec(&["model", path.to_str().expect("a plain name")]);
    assert!(said(&output).starts_with("arm: 7 joints of 7 bodies"));
}

/// All results are compared before a time is shown, those in binary32 too; a
/// contestant that cannot take part is listed with the reason.
#[test]
fn robots_are_benched_after_a_comparison() {
    let options = "bench --robots examples/robots/gripper.urdf examples/robots/oblique.urdf \
                   --peers loop --rounds 1 --milliseconds 1";
    let output = robovec(&options.split_whitespace().collect::<Vec<_>>());
    let table = said(&output);
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| line.starts_with("gripper ") || line.starts_with("oblique "))
        .map(|line| {
            line.split("  ")
                .map(str::trim)
                .filter(|cell| !cell.is_empty())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 10, "{table}");
    for row in rows {
        assert_eq!(row.len(), 12, "{row:?}");
        let is_number = |cell: &&str| cell.parse::<f64>().is_ok_and(|number| number > 0.0);
        // Operations, three times, and cycles.
        let numbers = row[3..7].iter().chain(&row[11..]);
        assert!(numbers.copied().all(|cell| is_number(&cell)), "{row:?}");
        let functions = ["M and c", "inverse dynamics", "forward dynamics"];
        let named = row[2].trim_start_matches("derivatives of ");
        assert!(functions.contains(&named), "{row:?}");
    }
    assert!(
        table.contains("gripper-accelred, hand-written loop: the model has loops"),
        "{table}"
    );
    let output = robovec(&["bench"]);
    assert!(!output.status.success() && stderr(&output).contains("SUBJECTS"));
}
