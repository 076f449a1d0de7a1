//! The whole step as a drop-in: a host that steps as MBsysC does, once with
//! Robotran-style files and dense matrices and once with the generated
//! `mbs_accelred`, over seconds of motion (tests/host).

use crate::compiled::has_gcc;
use crate::support::files::tree;
use crate::support::programs::{model, robovec, said};
use robovec::generate::{Options, cuts_of_rows, independent_joints};
use robovec::model::mbs::{read_mbs, write_mbs};
use robovec::model::{CutKind, Model, Nature};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Plan of a host.
#[derive(Default)]
struct HostPlan {
    /// Joints, from 0, that constraints of the user determine.
    bound: Vec<usize>,
    /// The C of `invdynared` is there, too.
    has_actuators: bool,
    /// Names are those of generator 6.6.
    is_old: bool,
    /// Accelerations are computed in binary32.
    is_single: bool,
    /// Both ways are timed, so both are optimised.
    is_timed: bool,
}

/// The numbers of a model, as read by the host.
fn data(model: &Model, plan: &HostPlan) -> String {
    let mut text = String::new();
    let n = model.joints.len();
    let options = Options {
        user_constraints: plan.bound.len(),
        ..Options::default()
    };
    let independent = independent_joints(model, &options).expect("the loops close");
    let with = |wanted: &dyn Fn(usize) -> bool| (0..n).filter(|&joint| wanted(joint)).collect();
    let is_driven = |joint: usize| model.joints[joint].nature == Nature::Driven;
    let driven: Vec<usize> = with(&is_driven);
    let dependent: Vec<usize> = with(&|joint| !is_driven(joint) && !independent.contains(&joint));
    let rows = cuts_of_rows(model).expect("the loops have rows").len();
    let _ = writeln!(text, "{n} {}", model.points.len());
    for list in [&independent, &driven, &dependent, &plan.bound] {
        let numbers: Vec<String> = list.iter().map(|joint| (joint + 1).to_string()).collect();
        let _ = writeln!(text, "{} {}", list.len(), numbers.join(" "));
    }
    let _ = writeln!(text, "{rows}");
    let mut line = |numbers: Vec<f64>| {
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number}")).collect();
        let _ = writeln!(text, "{}", numbers.join(" "));
    };
    for kind in 0..2 {
        line(
            model
                .joints
                .iter()
                .map(|joint| joint.initial[kind])
                .collect(),
        );
    }
    for axis in 0..3 {
        line(
            model
                .points
                .iter()
                .map(|point| point.coordinates[axis])
                .collect(),
        );
    }
    // What a body has belongs to its last joint.
    let of_bodies = |number: &dyn Fn(usize) -> f64| {
        let mut numbers = vec![0.0; n];
        for (index, body) in model.bodies.iter().enumerate() {
            numbers[body.joints.end - 1] = number(index);
        }
        numbers
    };
    for axis in 0..3 {
        line(of_bodies(&|body| model.bodies[body].center[axis]));
    }
    line(of_bodies(&|body| model.bodies[body].mass));
    for entry in [0, 1, 2, 1, 3, 4, 2, 4, 5] {
        line(of_bodies(&|body| model.bodies[body].inertia[entry]));
    }
    line(model.gravity.to_vec());
    let rods = model.cuts.iter().filter_map(|cut| match cut.kind {
        CutKind::Rod(length) => Some(length),
        CutKind::Ball | CutKind::Solid | CutKind::Coupling(_) => None,
    });
    let rods: Vec<f64> = rods.collect();
    line(vec![rods.len() as f64]);
    line(rods);
    let forces = model.forces.iter();
    let points: Vec<f64> = forces.map(|force| (force.point + 1) as f64).collect();
    line(vec![model.links.len() as f64, points.len() as f64]);
    line(points);
    text
}

/// Report of a host on 3 s of motion.
struct HostReport {
    /// Distance of the two ways, in parts of the largest position.
    apart: f64,
    /// That position.
    largest: f64,
    /// Distance of multipliers and forces of driven joints, in parts of the
    /// largest.
    forces: f64,
    /// Distance of accelerations from those that forces of actuators are for,
    /// in parts of the largest.
    actuators: f64,
    /// The most rounds of closing, by the dense way and by the step.
    rounds: [f64; 2],
    /// Time of the dense way in parts of that of the step.
    speedup: f64,
}

/// Writes the C of a model for a project into a folder.
fn generate(folder: &Path, plan: &HostPlan) {
    let path = folder.join("model.mbs");
    let (model, output) = (path.to_str(), folder.to_str());
    let (model, output) = model.zip(output).expect("plain paths");
    let generation = if plan.is_old { "6.6" } else { "8.1" };
    let rows = plan.bound.len().to_string();
    let steps = if plan.has_actuators {
        "accelred,invdynared"
    } else {
        "accelred"
    };
    let common = ["gen", model, "--generation", generation, "-o", output];
    let parts = "dirdyna,cons_hJ,cons_jdqd,link,extforces";
    for wanted in [
        &["--function", parts, "--language", "c"][..],
        &[
            "--whole-step",
            "--multipliers",
            "--user-constraints",
            &rows,
            "--function",
            steps,
            "--number",
            if plan.is_single { "f32" } else { "double" },
        ],
    ] {
        let made = robovec(&[&common, wanted].concat());
        assert!(made.status.success(), "{}", said(&made));
    }
}

/// Builds the host for a model, and runs it.
fn simulated(model: &Model, plan: &HostPlan) -> HostReport {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).expect("a writable folder");
    };
    write("model.mbs", write_mbs(model));
    write("data", data(model, plan));
    generate(folder.path(), plan);
    let host = tree("tests/host");
    let mut sources: Vec<_> = std::fs::read_dir(folder.path())
        .expect("a readable folder")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "c"))
        .collect();
    sources.sort();
    sources.extend(["host.c", "dense.c", "user.c"].map(|name| host.join(name)));
    if plan.is_old {
        sources.push(host.join("old/names.c"));
    }
    let actuators = if plan.has_actuators {
        "-DACTUATORS"
    } else {
        "-DNOTHING"
    };
    // Optimising takes longer than running without.
    let optimisation = if plan.is_timed { "-O1" } else { "-O0" };
    let compiled = Command::new("gcc")
        .current_dir(folder.path())
        // Robotran's style sets variables that a model does not need.
        .args(["-std=gnu99", optimisation, "-Wall", "-Werror", actuators])
        .args(["-Wno-unused-variable", "-Wno-unused-but-set-variable"])
        .arg("-Wno-unused-but-set-parameter")
        .arg("-I")
        .arg(&host)
        .arg("-I")
        .arg(host.join("old"))
        .args(["-o", "host"])
        .args(&sources)
        .arg("-lm")
        .output()
        .expect("gcc is there");
    assert!(compiled.status.success(), "{}", said(&compiled));
    let run = Command::new(folder.path().join("host"))
        .arg(folder.path().join("data"))
        .args(["3", "3000"])
        .output()
        .expect("it runs");
    let name = &model.name;
    assert!(run.status.success(), "{name}: {}", said(&run));
    let told = String::from_utf8_lossy(&run.stdout);
    println!("{name}: {}", told.trim());
    let numbers: Vec<f64> = told
        .split_whitespace()
        .map(|number| number.parse().expect("the host tells numbers"))
        .collect();
    HostReport {
        apart: numbers[0],
        largest: numbers[1],
        forces: numbers[6],
        actuators: numbers[7],
        rounds: [numbers[4], numbers[5]],
        speedup: numbers[2] / numbers[3],
    }
}

fn shipped(name: &str) -> Model {
    let bytes = std::fs::read(model(&format!("{name}.mbs"))).expect("the model is there");
    read_mbs(name, &bytes).expect("a good model").model
}

fn moves_the_same(model: &Model, plan: &HostPlan) -> HostReport {
    let told = simulated(model, plan);
    let (name, apart, largest) = (&model.name, told.apart, told.largest);
    assert!(largest > 1e-3, "{name} does not move: {largest:e}");
    assert!(apart < 1e-10, "{name}: {apart:e} apart after 3 s");
    let (forces, actuators) = (told.forces, told.actuators);
    assert!(forces < 1e-9, "{name}: forces are {forces:e} apart");
    assert!(actuators < 1e-9, "{name}: actuators miss by {actuators:e}");
    told
}

#[test]
fn a_host_moves_the_same_with_the_whole_step() {
    if !has_gcc() {
        return;
    }
    for name in [
        "double-pendulum",
        "four-bar",
        "slider-crank",
        "quarter-car",
        "bogie",
        "leg",
        "car",
        "wishbone-car",
    ] {
        moves_the_same(&shipped(name), &HostPlan::default());
    }
}

#[test]
fn projects_of_the_old_generator_are_served_too() {
    if !has_gcc() {
        return;
    }
    for name in ["quarter-car", "leg"] {
        let plan = HostPlan {
            is_old: true,
            ..HostPlan::default()
        };
        moves_the_same(&shipped(name), &plan);
    }
}

#[test]
fn rows_of_the_user_and_actuators_are_served() {
    if !has_gcc() {
        return;
    }
    for (name, rows) in [
        ("leg", 1),
        ("car", 2),
        ("quarter-car", 1),
        ("wishbone-car", 3),
    ] {
        let mut model = shipped(name);
        let joints = independent_joints(&model, &Options::default()).expect("the loops close");
        // The last ones: the first ones lead them.
        let bound = joints[joints.len() - rows..].to_vec();
        for (joint, of_model) in model.joints.iter_mut().enumerate() {
            of_model.actuated = false;
            if of_model.nature != Nature::Driven {
                of_model.nature = if joints.contains(&joint) && !bound.contains(&joint) {
                    Nature::Independent
                } else {
                    Nature::Dependent
                };
            }
        }
        let plan = HostPlan {
            bound,
            has_actuators: true,
            ..HostPlan::default()
        };
        moves_the_same(&model, &plan);
    }
}

/// Clients as real projects are: steering without mass that rows of the project
/// move, a joint that it drives, with loops and without.
#[test]
fn projects_with_massless_steering_move_the_same() {
    if !has_gcc() {
        return;
    }
    for (name, rows) in [("train", 2), ("wishbone-car", 3)] {
        let mut model = shipped(name);
        let free = independent_joints(&model, &Options::default()).expect("the loops close");
        let is_end = |joint: &usize| {
            let body = model.joints[*joint].body;
            let parents = model.bodies.iter().filter_map(|other| other.parent);
            let mut ends = model.cuts.iter().flat_map(|cut| cut.ends);
            model.bodies[body].joints.len() == 1
                && parents.into_iter().all(|parent| parent != body)
                && ends.all(|end| end.body != Some(body))
        };
        let mut ends: Vec<usize> = free.iter().copied().filter(is_end).collect();
        assert!(ends.len() > rows, "{name} has {} ends", ends.len());
        let driven = ends.pop().expect("there are ends");
        let bound = ends.split_off(ends.len() - rows);
        for (joint, of_model) in model.joints.iter_mut().enumerate() {
            let follows = bound.contains(&joint) || !free.contains(&joint);
            of_model.actuated = false;
            of_model.nature = match of_model.nature {
                _ if joint == driven => Nature::Driven,
                Nature::Driven => Nature::Driven,
                _ if follows => Nature::Dependent,
                _ => Nature::Independent,
            };
        }
        for &joint in &bound {
            let body = &mut model.bodies[model.joints[joint].body];
            (body.mass, body.center, body.inertia) = (0.0, [0.0; 3], [0.0; 6]);
        }
        let plan = HostPlan {
            bound,
            has_actuators: true,
            is_timed: true,
            ..HostPlan::default()
        };
        let report = moves_the_same(&model, &plan);
        assert!(report.speedup > 5.0, "{name}: {} times", report.speedup);
    }
}

/// Accelerations in binary32 move a model as those in binary64 do, within the
/// effect of errors of 1e-6 over 3 s of motion: loops stay closed, since they
/// are closed in binary64, with the same number of iterations.
#[test]
fn accelerations_in_binary32_move_models_nearly_the_same() {
    if !has_gcc() {
        return;
    }
    for name in ["four-bar", "slider-crank", "quarter-car", "wishbone-car"] {
        let plan = HostPlan {
            is_single: true,
            ..HostPlan::default()
        };
        let HostReport { apart, rounds, .. } = simulated(&shipped(name), &plan);
        assert!(apart < 1e-4, "{name}: {apart:e} apart after 3 s");
        // In binary64 they are within 1e-10.
        assert!(apart > 1e-10, "{name}: {apart:e}: is it binary32?");
        let [dense, step] = rounds;
        assert!(step <= dense, "{name}: {step} rounds instead of {dense}");
    }
}

/// The command reports the cost of binary32, and only that.
#[test]
fn the_error_of_binary32_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().to_str().expect("a plain path");
    let path = model("four-bar.mbs");
    let name = path.to_str().expect("a plain path");
    let common = ["gen", name, "--whole-step", "--force", "-o", output];
    let told = |extra: &[&str]| {
        let made = robovec(&[&common, extra].concat());
        assert!(made.status.success(), "{}", said(&made));
        String::from_utf8_lossy(&made.stdout).into_owned()
    };
    let [double, float] = [told(&[]), told(&["--number", "f32"])];
    assert!(!double.contains("error in"), "{double}");
    let line = float
        .lines()
        .find(|line| line.contains("error in f32: median"));
    let line = line.expect("a line of the error");
    assert!(
        line.contains("around the closed initial one, seed 1"),
        "{line}"
    );
    let source = folder.path().join("mbs_accelred_four_bar.c");
    let source = std::fs::read_to_string(source).expect("the command wrote it");
    let sines = |part: &str, number: &str| {
        source.contains(&format!("mbs_{part}_sines({number} *restrict work)"))
    };
    assert!(sines("accelerations", "float"));
    assert!(sines("loop_positions", "double"));
    assert!(sines("loop_velocities", "double"));
    assert_eq!(source.matches("float *restrict work").count(), 2);
}
