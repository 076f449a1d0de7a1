//! Files and commands for the documents: files in the place of a user's,
//! smaller commands in place of long ones, and those that are not run.

use crate::support::files::tree;
use crate::support::programs::{opt_in, robovec_in, said};
use std::fs;
use std::path::Path;

/// Commands that are not run, with the reason; `…` stands for the rest of one.
/// The programs must accept their arguments.
pub(crate) const NOT_RUN: &[(&str, &str)] = &[
    (
        "cargo test …",
        ".ci/run does it, and so does whoever reads this failure",
    ),
    (
        "cargo install …",
        "builds everything in release; docs/results-processors.md has the time it took",
    ),
    (
        "cargo run …",
        "tests/library.rs runs the examples as they were built",
    ),
    ("bash scripts/…", ".ci/run builds the package and tests it"),
    ("pip install …", ".ci/run builds the package and tests it"),
    (
        "scripts/on-hyperqueue …",
        "needs HyperQueue; tests/shares.rs runs shares",
    ),
    ("scripts/compare-with-form", "needs FORM"),
    ("scripts/compare-with-pinocchio …", "needs Pinocchio"),
    ("scripts/compare-with-mujoco …", "needs MuJoCo"),
    ("scripts/check-rtl.sh …", "takes minutes"),
    (
        "robovec project coman …",
        "needs a project of Robotran; tests/project.rs makes one",
    ),
    (
        "seq 8 | …",
        "shares side by side; tests/shares.rs runs shares",
    ),
    ("quartus_…", "needs Quartus"),
    (
        "make verilator…",
        "takes a minute; tests/rtl_host.rs does it where Verilator is",
    ),
    ("./try time…", "measures this computer"),
    ("robovec bench --robots…", "takes minutes"),
    (
        "robovec optimise examples/scenes/…",
        "searches long; tests/optimise.rs has smaller scenes",
    ),
    (
        "robovec fit examples/scenes/bogie-1e-4…",
        "takes a minute; tests/front.rs is smaller",
    ),
    (
        "robovec fit examples/scenes/car-ride…",
        "takes minutes; tests/neglect.rs is smaller",
    ),
    (
        "robovec rtl bogie …",
        "takes minutes; the double pendulum is run",
    ),
    ("robovec rtl bogie.rvir …", "needs yosys"),
    ("robovec rtl program.rvir …", "needs yosys and nextpnr"),
    ("robovec rtl --fits …", "tests/rtl_fits.rs does it"),
    (
        "robovec rules import …",
        "tests/rules.rs reads what Herbie writes",
    ),
    (
        "robovec rules find …",
        "takes a minute; tests/rules.rs is smaller",
    ),
    (
        "robovec rtl simulate images …",
        "needs images of a program of its own",
    ),
    ("robovec stress --class …", "takes long; one case is run"),
    (
        "robovec explore --plan thesis -o results --…",
        "takes minutes; tests/study.rs is smaller",
    ),
    (
        "robovec explore arm.mbs …",
        "takes minutes; a smaller space is run",
    ),
    ("robovec rtl synthesise…", "needs yosys"),
];

/// Beginnings of commands that take long, and the shorter commands run in their
/// place, once. Later commands do not read their files.
pub(crate) const SMALLER: &[(&str, &str)] = &[
    (
        "robovec bench",
        "robovec bench quarter-car --peers none --milliseconds 1 --rounds 1",
    ),
    (
        "robovec sim modal examples/models/bogie.mbs",
        "robovec sim modal examples/models/bogie.mbs --laws examples/laws/bogie.toml",
    ),
    (
        "robovec optimise examples/models/bogie.mbs --for cpu",
        "robovec optimise examples/models/quarter-car.mbs --for cpu --effort 1 --compiler none -o fast",
    ),
    (
        "robovec optimise examples/models/double-pendulum.mbs --for batch",
        "robovec optimise examples/models/double-pendulum.mbs --for batch --effort 1 --compiler none -o batch",
    ),
    (
        "robovec optimise examples/suspension/mbs_dirdyna_suspension.c --for cpu",
        "robovec optimise examples/suspension/mbs_dirdyna_suspension.c --for cpu --effort 1 -o fast",
    ),
    (
        "robovec optimise examples/suspension/mbs_dirdyna_suspension.m",
        "robovec optimise examples/suspension/mbs_dirdyna_suspension.m --effort 1 -o best",
    ),
    (
        "robovec rtl examples/models/double-pendulum.mbs",
        "robovec rtl examples/models/double-pendulum.mbs --passes '$shorten,place' --machine side-split -o board --check iverilog --runs 1",
    ),
    (
        "robovec-opt examples/models/bogie.mbs -passes=atomise",
        "robovec-opt examples/models/quarter-car.mbs -passes=atomise,zero-removal,balance,eqsat,cse,dce --rules mine.rules -stats",
    ),
    (
        "robovec explore --plan",
        "robovec explore bogie --plan thesis -o results --elements 1",
    ),
    (
        "robovec explore bogie --designs",
        "robovec explore bogie --adders 2 --multipliers 2 --couples 3-3 --memories unified --instances 1",
    ),
    (
        "robovec explore",
        "robovec explore double-pendulum --elements 1 --states 4",
    ),
    (
        "robovec rules bench",
        "robovec rules bench examples/models/bogie.mbs --rules mine.rules --only",
    ),
    (
        "robovec stress -o",
        "robovec stress --case tiny-1e-9 -o stress",
    ),
    (
        "robovec stress --verdicts",
        "robovec stress --verdicts --case tiny-1e-9",
    ),
    (
        "robovec stress",
        "robovec stress --case tiny-1e-9 -o stress",
    ),
];

/// Words that represent a user's file or choice.
pub(crate) const PLACEHOLDERS: &[(&str, &str)] = &[
    ("FILE", "mbs_dirdyna_mine.c"),
    ("FILE.c", "mbs_dirdyna_mine.c"),
    ("MODEL.mbs", "mine.mbs"),
    ("FOLDER", "folder"),
    ("DIR", "folder"),
    ("DIR/tb", "folder/tb"),
    ("STATES", "2"),
    // Icarus Verilog compiles in a moment what Verilator takes a minute for.
    ("verilator", "iverilog"),
];

/// Fills a folder with links to shipped files, and with a user's files: a model
/// and its equations.
pub(crate) fn fill(folder: &Path) {
    for part in ["examples", "machines", "scripts"] {
        std::os::unix::fs::symlink(tree(part), folder.join(part)).expect("a link");
    }
    let model = fs::read_to_string(tree("examples/models/bogie.mbs")).expect("it ships");
    for name in ["mine", "Car", "X", "model", "bogie", "robot"] {
        let own = model.replace("<mbsname>bogie", &format!("<mbsname>{name}"));
        fs::write(folder.join(format!("{name}.mbs")), own).expect("a folder of our own");
    }
    let run = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        said(&robovec_in(folder, &words));
    };
    run("gen bogie.mbs --function dirdyna -o bogie.rvir");
    run("gen bogie.mbs --function dirdyna,accelred --language c -o symbolicR");
    run("gen bogie.rvir --language matlab -o symbolicR");
    run("gen bogie.rvir --language python -o symbolicR");
    let model = "examples/models/double-pendulum.mbs";
    let place = [
        "-passes=$shorten,place",
        "--machine=side-split",
        "-o",
        "placed.rvir",
    ];
    said(&opt_in(folder, &[&[model], &place[..]].concat()));
    // What a smaller command leaves in another folder.
    fs::create_dir(folder.join("best")).expect("a folder of our own");
    let equations = "examples/suspension/mbs_dirdyna_suspension.m";
    let shorten = ["-passes=$shorten", "-o", "best/program.rvir"];
    said(&opt_in(folder, &[&[equations], &shorten[..]].concat()));
    let copy = |from: &str, to: &str| {
        fs::copy(folder.join("symbolicR").join(from), folder.join(to)).expect(from);
    };
    for name in ["mine", "car", "Car", "X"] {
        copy("mbs_dirdyna_bogie.c", &format!("mbs_dirdyna_{name}.c"));
    }
    copy("mbs_dirdyna_bogie.py", "mbs_dirdyna_X.py");
    copy("mbs_accelred_bogie.c", "mbs_accelred_bogie.c");
    copy("mbs_dirdyna_bogie.m", "symbolicR/mbs_dirdyna_Car.m");
    for (name, scene) in [("bogie", "bogie-straight"), ("flat", "bogie-1e-4")] {
        let scene = tree(&format!("examples/scenes/{scene}.scene.toml"));
        let scene = fs::read_to_string(scene).expect("it ships");
        let scene = scene.replace("../models", "examples/models");
        fs::write(folder.join(format!("{name}.scene.toml")), scene).expect("a folder of our own");
    }
}
