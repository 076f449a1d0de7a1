//! What else a user could call: a hand-written loop, Pinocchio, MuJoCo,
//! CasADi.
//!
//! The programs are files of `benches/peers`; libraries are taken from the
//! user's Python packages (`pin`, `mujoco`, `casadi`), found by asking Python.
//! What is not installed is named in the table with what to install.

use super::contestant::{Contestant, ContestantFamily, RESULTS};
use super::functions::{OutputKey, inputs};
use super::own::BENCH_H;
use super::tools::{BuildStep, Compiler};
use super::{BenchQuestion, tree};
use crate::model::Model;
use crate::process::ProgramCall;
use robovec_ir::{Input, View};
use std::path::Path;

const PEER_H: &str = include_str!("../../benches/peers/peer.h");
const LOOP: &str = include_str!("../../benches/peers/loop.cpp");
const PINOCCHIO: &str = include_str!("../../benches/peers/pinocchio.cpp");
const MUJOCO: &str = include_str!("../../benches/peers/mujoco.c");
const CASADI: &str = include_str!("../../benches/peers/casadi_functions.py");
const CASADI_MAIN: &str = include_str!("../../benches/peers/casadi_main.c");

/// Flags for all of them.
const FLAGS: &str = "-O3 -march=native";

/// What Pinocchio's headers need to know of Boost.
const PINOCCHIO_FLAGS: &str = "-std=c++17 -DNDEBUG -DBOOST_MPL_LIMIT_LIST_SIZE=30 \
     -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
     -DBOOST_FUSION_INVOKE_MAX_ARITY=12";

/// The names of the peers.
pub const NAMES: [&str; 4] = ["loop", "pinocchio", "mujoco", "casadi"];

/// The peers of some names, for a model; `too_long` says why a peer that prints
/// one function is not compiled.
pub fn peers(
    question: &BenchQuestion<'_>,
    model: &Model,
    names: &[String],
    too_long: Option<&str>,
) -> Vec<Contestant> {
    let wanted = |name: &str| names.iter().any(|known| known == name);
    let mut list = Vec::new();
    for command in ["g++", "clang++"] {
        let Ok(compiler) = Compiler::find(command) else {
            continue;
        };
        if wanted("loop") {
            let remark = format!("{command} {FLAGS}");
            let source = [("loop.cpp", LOOP)];
            let step = BuildStep::new(command, FLAGS)
                .with("-std=c++17")
                .with("-c")
                .with("loop.cpp");
            let steps = vec![
                step.function("loop.o"),
                BuildStep::new(&compiler.command, "-o program loop.o -lm"),
            ];
            list.push(peer(
                question,
                model,
                "hand-written loop",
                remark,
                &source,
                steps,
                Some(&format!("loop-{command}")),
            ));
        }
        if wanted("pinocchio") {
            list.extend(pinocchio(question, model, command));
        }
    }
    if wanted("mujoco") {
        list.push(mujoco(question, model));
    }
    if wanted("casadi") {
        list.push(match too_long {
            Some(why) => missing(question, model, "CasADi", why),
            None => casadi(question, model),
        });
    }
    list
}

fn peer(
    question: &BenchQuestion<'_>,
    model: &Model,
    name: &str,
    remark: String,
    sources: &[(&str, &str)],
    steps: Vec<BuildStep>,
    shared: Option<&str>,
) -> Contestant {
    let mut files: Vec<(String, Vec<u8>)> = sources
        .iter()
        .map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()))
        .collect();
    files.push(("peer.h".to_owned(), PEER_H.as_bytes().to_vec()));
    files.push(("bench.h".to_owned(), BENCH_H.as_bytes().to_vec()));
    files.push(("model.txt".to_owned(), tree::text(model).into_bytes()));
    files.push(("states.bin".to_owned(), state_bytes(question, model)));
    Contestant {
        remark,
        files,
        steps,
        arguments: ["model.txt", "states.bin", RESULTS]
            .map(str::to_owned)
            .into(),
        // Other formulas, other roundings; a wrong one is off by far more.
        tolerance: 1e-9,
        shared: shared.map(|name| name.to_owned()),
        ..Contestant::named(
            name,
            ContestantFamily::Peer,
            outputs(model.joints.len() as u32),
        )
    }
}

fn missing(question: &BenchQuestion<'_>, model: &Model, name: &str, why: &str) -> Contestant {
    let mut peer = peer(question, model, name, String::new(), &[], Vec::new(), None);
    peer.missing = Some(why.to_owned());
    peer
}

/// Mass matrix in full, then the forces.
fn outputs(joints: u32) -> Vec<OutputKey> {
    let key = |array: &str, indices| OutputKey {
        array: array.to_owned(),
        indices,
    };
    let pairs = (1..=joints).flat_map(|row| (1..=joints).map(move |column| [row, column]));
    let matrix = pairs.map(|indices| key("M", indices));
    matrix
        .chain((1..=joints).map(|row| key("c", [row, 0])))
        .collect()
}

/// The number of states, then q and qd of each.
fn state_bytes(question: &BenchQuestion<'_>, model: &Model) -> Vec<u8> {
    let mut numbers = vec![f64::from(question.count)];
    for state in 0..question.count {
        let inputs = inputs(question.view, question.model, question.states, state);
        for wanted in ["q", "qd"] {
            let mut values = vec![0.0; model.joints.len()];
            for (index, &number) in inputs.iter().enumerate() {
                if let Some(joint) = element(question.view, index, wanted)
                    && let Some(value) = values.get_mut(joint)
                {
                    *value = number;
                }
            }
            numbers.extend(values);
        }
    }
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// Which joint an input element belongs to, from 0, if it is of this array.
fn element(view: View<'_>, index: usize, wanted: &str) -> Option<usize> {
    let (array, indices, _) = view.function.input_element(Input(index as u32));
    (view.tables.symbols.text(array.name) == wanted).then(|| indices[0] as usize - 1)
}

/// The folder and version of a Python package.
fn package(name: &str) -> Option<(String, String)> {
    let script = format!(
        "import {name}, os\nprint(os.path.dirname({name}.__file__))\nprint({name}.__version__)"
    );
    let run = ProgramCall::version("python3", "-c")
        .arguments([script])
        .run();
    let run = run.ok().filter(|run| run.status.success())?;
    let text = run.text();
    let mut lines = text.lines().rev();
    let version = lines.next()?.to_owned();
    Some((lines.next()?.to_owned(), version))
}

fn pinocchio(question: &BenchQuestion<'_>, model: &Model, command: &str) -> Vec<Contestant> {
    let name = "Pinocchio";
    let Some((folder, version)) = package("pinocchio") else {
        let why = "not installed: pip install pin, and Eigen's headers (libeigen3-dev)";
        return vec![missing(question, model, name, why)];
    };
    // The package is in <prefix>/lib/python3.x/site-packages/pinocchio.
    let prefix = Path::new(&folder).ancestors().nth(4);
    let include = prefix.map(|prefix| prefix.join("include").display().to_string());
    let include = include.unwrap_or_default();
    let convention = |convention: &str| {
        let remark = format!(
            "{version}, {}, {command} {FLAGS}",
            convention.to_lowercase()
        );
        let step = BuildStep::new(command, FLAGS);
        let mut step = BuildStep {
            arguments: [
                step.arguments,
                BuildStep::new("", PINOCCHIO_FLAGS).arguments,
            ]
            .concat(),
            ..step
        };
        step = step
            .with(format!("-DCONVENTION={convention}"))
            .with(format!("-I{include}"))
            .with("-I/usr/include/eigen3")
            .with("-o")
            .with("program")
            .with("pinocchio.cpp");
        let source = [("pinocchio.cpp", PINOCCHIO)];
        let shared = format!("pinocchio-{convention}-{command}");
        peer(
            question,
            model,
            name,
            remark,
            &source,
            vec![step],
            Some(&shared),
        )
    };
    ["WORLD", "LOCAL"].map(convention).into()
}

fn mujoco(question: &BenchQuestion<'_>, model: &Model) -> Contestant {
    let name = "MuJoCo";
    let Some((folder, version)) = package("mujoco") else {
        return missing(question, model, name, "not installed: pip install mujoco");
    };
    let library = format!("{folder}/libmujoco.so.{version}");
    let step = BuildStep::new("cc", FLAGS)
        .with(format!("-I{folder}/include"))
        .with("-o")
        .with("program")
        .with("mujoco.c")
        .with(library)
        .with(format!("-Wl,-rpath,{folder}"))
        .with("-lm");
    let source = [("mujoco.c", MUJOCO)];
    peer(
        question,
        model,
        name,
        version,
        &source,
        vec![step],
        Some("mujoco"),
    )
}

fn casadi(question: &BenchQuestion<'_>, model: &Model) -> Contestant {
    let name = "CasADi";
    let Some((_, version)) = package("casadi") else {
        return missing(question, model, name, "not installed: pip install casadi");
    };
    let sources = [("casadi_functions.py", CASADI), ("main.c", CASADI_MAIN)];
    let step = BuildStep::new("cc", FLAGS).with("-c").with("function.c");
    let steps = vec![
        BuildStep::new("python3", "casadi_functions.py model.txt function.c"),
        step.function("function.o"),
        BuildStep::new("cc", "-O2 -o program main.c function.o -lm"),
    ];
    let remark = format!("{version}, cc {FLAGS}");
    peer(question, model, name, remark, &sources, steps, None)
}
