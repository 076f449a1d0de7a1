//! The text of the functions that MBsysC calls: calls in the order of MBsysC,
//! and Newton's method. The C is in separate files beside this one, with names
//! between `@` for the parts that depend on the model.

use super::{StepFunction, StepPlan};
use robovec_cgen::kind::{Generation, ProjectStructure, file_stem};
use robovec_framework::template::fill;
use robovec_model::Nature;

/// Text of both functions.
const STEP: &str = include_str!("step.c");

/// The C source, with the generated functions in it.
pub(super) fn source(step: &StepPlan<'_>, function: StepFunction, generated: &str) -> String {
    let ProjectStructure {
        name,
        prefix,
        header,
        functions,
        ..
    } = step.generation.structure();
    let (own, title) = match function {
        StepFunction::Accelerations => (include_str!("accelred.c"), "the accelerations"),
        StepFunction::ActuatorForces => (include_str!("invdynared.c"), "the forces of actuators"),
    };
    let (filled, qddu) = match step.generation {
        Generation::Current => ("", ""),
        // That of generator 6.6 also fills the accelerations of independent joints.
        Generation::Old => (
            "double *qddu, ",
            "    for (int i = 1; i <= s->nqu; i++)\n        qddu[i] = s->qdd[s->qu[i]];\n",
        ),
    };
    let mut joints = step.model.joints.iter();
    let driven = if joints.any(|joint| joint.nature == Nature::Driven) {
        "    user_DrivenJoints(s, tsim);\n"
    } else {
        ""
    };
    fill(
        &(STEP.to_owned() + own),
        &[
            ("NAME", &function.name()),
            ("TITLE", &title),
            ("STEM", &file_stem(&step.model.name)),
            ("HEADER", &header),
            ("FUNCTIONS", &functions),
            ("JOINTS", &step.model.joints.len()),
            ("LOOP_ROWS", &step.rows.len()),
            ("MASSLESS", &step.massless.len()),
            ("MASSLESS_JOINTS", &numbers(&step.massless)),
            ("MOST_GROWTH", &if step.is_double { "1e12" } else { "1e5" }),
            (
                "CUTS",
                &texts(step.rows.iter().map(|&cut| &step.model.cuts[cut].name)),
            ),
            ("USER_ROWS", &step.user_rows),
            ("MULTIPLIERS", &u8::from(step.multipliers)),
            ("ROLES", &roles(step)),
            (
                "NAMES",
                &texts(step.model.joints.iter().map(|joint| &joint.name)),
            ),
            ("LOADS", &loads(step)),
            ("DRIVEN", &driven),
            ("FILLED", &filled),
            ("QDDU", &qddu),
            ("DATA", &name),
            ("PREFIX", &prefix),
            ("GENERATED", &generated),
        ],
    )
}

/// A letter for each joint: u, v or c.
fn roles(step: &StepPlan<'_>) -> String {
    let joints = step.model.joints.iter().enumerate();
    let letters = joints.map(|(place, joint)| match joint.nature {
        Nature::Driven => 'c',
        _ if step.independent.binary_search(&place).is_ok() => 'u',
        _ => 'v',
    });
    letters.collect()
}

/// Numbers from 1 of joints, as elements of an array of C, one at least.
fn numbers(joints: &[usize]) -> String {
    let numbers = joints.iter().map(|joint| (joint + 1).to_string());
    let numbers: Vec<String> = numbers.chain(["0".to_owned()]).collect();
    numbers.join(", ")
}

/// Names as texts of C, elements of an array, which has one at least.
fn texts<'n>(names: impl Iterator<Item = &'n String>) -> String {
    let texts = names.map(|name| {
        let plain = name.chars().filter(|letter| !letter.is_control());
        let escaped = plain.flat_map(|letter| {
            let escape = matches!(letter, '"' | '\\' | '?').then_some('\\');
            escape.into_iter().chain([letter])
        });
        format!("\"{}\"", escaped.collect::<String>())
    });
    let texts: Vec<String> = texts.chain(["\"\"".to_owned()]).collect();
    texts.join(", ")
}

/// Calls of the functions that add loads, if the model has them.
fn loads(step: &StepPlan<'_>) -> String {
    let ProjectStructure { prefix, .. } = step.generation.structure();
    let model = step.model;
    let calls = [
        (!model.links.is_empty(), "link", ", s->Fl, s->Z, s->Zd"),
        (!model.links3d.is_empty(), "link3D", ""),
        (!model.forces.is_empty(), "extforces", ""),
    ];
    let there = calls.into_iter().filter(|(is_there, ..)| *is_there);
    let lines = there.map(|(_, function, arrays)| {
        format!("    {prefix}{function}(s->frc, s->trq{arrays}, s, tsim);\n")
    });
    lines.collect()
}
