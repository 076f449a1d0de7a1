//! The whole step as a drop-in: a host that steps as MBsysC does, once with
//! Robotran-style files and dense matrices and once with the generated
//! `mbs_accelred`, over seconds of motion (tests/host).

use crate::compiled::has_gcc;
use crate::support::files::tree;
use crate::support::programs::{model, robovec, said};
use robovec::generate::{cuts_of_rows, independent_joints};
use robovec::model::mbs::read_mbs;
use robovec::model::{CutKind, Model, Nature};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// The numbers of a model as the host reads them.
fn data(model: &Model) -> String {
    let mut text = String::new();
    let n = model.joints.len();
    let independent = independent_joints(model).expect("the loops close");
    let with = |wanted: &dyn Fn(usize) -> bool| (0..n).filter(|&joint| wanted(joint)).collect();
    let is_driven = |joint: usize| model.joints[joint].nature == Nature::Driven;
    let driven: Vec<usize> = with(&is_driven);
    let dependent: Vec<usize> = with(&|joint| !is_driven(joint) && !independent.contains(&joint));
    let rows = cuts_of_rows(model).expect("the loops have rows").len();
    let _ = writeln!(text, "{n} {}", model.points.len());
    for list in [&independent, &driven, &dependent] {
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
        CutKind::Ball | CutKind::Solid => None,
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

/// Builds the host for a model with C of a generation of generators, and runs
/// it for 3 s: how far the two ways are apart in parts of the largest position,
/// that position, seconds of a step each way, and the most rounds of closing
/// each way.
fn simulated(path: &Path, generation: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = std::fs::read(path).expect("the model is there");
    let model = read_mbs("model", &bytes).expect("a good model").model;
    let name = path.to_str().expect("a plain path");
    let output = folder.path().to_str().expect("a plain path");
    let common = ["gen", name, "--generation", generation, "-o", output];
    let parts = "dirdyna,cons_hJ,cons_jdqd,link,extforces";
    for wanted in [
        &["--function", parts, "--language", "c"][..],
        &["--whole-step"],
    ] {
        let made = robovec(&[&common, wanted].concat());
        assert!(made.status.success(), "{}", said(&made));
    }
    std::fs::write(folder.path().join("data"), data(&model)).expect("a writable folder");
    let host = tree("tests/host");
    let mut sources: Vec<_> = std::fs::read_dir(folder.path())
        .expect("a readable folder")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "c"))
        .collect();
    sources.sort();
    sources.extend(["host.c", "dense.c", "user.c"].map(|name| host.join(name)));
    if generation == "6.6" {
        sources.push(host.join("old/names.c"));
    }
    let compiled = Command::new("gcc")
        .current_dir(folder.path())
        // Robotran's style sets variables that a model does not need.
        .args(["-std=gnu99", "-O1", "-Wall", "-Werror"])
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
    assert!(run.status.success(), "{name}: {}", said(&run));
    let told = String::from_utf8_lossy(&run.stdout);
    told.split_whitespace()
        .map(|number| number.parse().expect("the host tells numbers"))
        .collect()
}

fn moves_the_same(name: &str, generation: &str) {
    let told = simulated(&model(&format!("{name}.mbs")), generation);
    println!("{name}: {told:?}");
    let (apart, largest) = (told[0], told[1]);
    assert!(largest > 1e-3, "{name} does not move: {largest:e}");
    assert!(apart < 1e-10, "{name}: {apart:e} apart after 3 s");
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
        moves_the_same(name, "8.1");
    }
}

#[test]
fn projects_of_the_old_generator_are_served_too() {
    if !has_gcc() {
        return;
    }
    for name in ["quarter-car", "leg"] {
        moves_the_same(name, "6.6");
    }
}
