//! Other programs a user could call: a written loop, Pinocchio, MuJoCo, CasADi.
//!
//! The programs are files of `benches/peers`; libraries are taken from the
//! user's Python packages (`pin`, `mujoco`, `casadi`), whose folders Python
//! reports. Missing tools are in the table with their packages.

use super::contestant::{Contestant, ContestantFamily, RESULTS};
use super::functions::inputs;
use super::own::BENCH_H;
use super::task::BenchTask;
use super::tools::{BuildStep, Compiler};
use super::{BenchQuestion, tree};
use robovec_io::process::ProgramCall;
use robovec_ir::{Input, View};
use robovec_model::Model;
use std::path::Path;

const PEER_H: &str = include_str!("../peers/peer.h");
const LOOP: [(&str, &str); 3] = [
    ("loop.cpp", include_str!("../peers/loop.cpp")),
    ("loop_direct.h", include_str!("../peers/loop_direct.h")),
    ("loop_bodies.h", include_str!("../peers/loop_bodies.h")),
];
const PINOCCHIO: &str = include_str!("../peers/pinocchio.cpp");
const MUJOCO: &str = include_str!("../peers/mujoco.c");
const CASADI: &str = include_str!("../peers/casadi_functions.py");
const CASADI_MAIN: &str = include_str!("../peers/casadi_main.c");

const FLAGS: &str = "-O3 -march=native";

/// Flags that Pinocchio's headers need for Boost.
const PINOCCHIO_FLAGS: &str = "-std=c++17 -DNDEBUG -DBOOST_MPL_LIMIT_LIST_SIZE=30 \
     -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
     -DBOOST_FUSION_INVOKE_MAX_ARITY=12";

/// The names of the peers.
pub const NAMES: [&str; 5] = ["loop", "batched-loop", "pinocchio", "mujoco", "casadi"];

/// States that the batched loop takes at once.
const LOOP_LANES: u32 = 8;

#[derive(Clone, Copy)]
struct PeerQuestion<'a> {
    question: &'a BenchQuestion<'a>,
    model: &'a Model,
    task: BenchTask,
}

/// The peers of some names, for a task of a model; `too_long` is the reason why
/// a peer that prints one function is not compiled.
pub fn peers(
    question: &BenchQuestion<'_>,
    model: &Model,
    task: BenchTask,
    names: &[String],
    too_long: Option<&str>,
) -> Vec<Contestant> {
    let wanted = |name: &str| names.iter().any(|known| known == name);
    let asked = PeerQuestion {
        question,
        model,
        task,
    };
    if let Some(why) = task.unknown_to_peers(model) {
        let names = NAMES.iter().zip(TITLES).filter(|(name, _)| wanted(name));
        return names.map(|(_, title)| asked.missing(title, why)).collect();
    }
    let mut list = Vec::new();
    for command in ["g++", "clang++"] {
        if Compiler::find(command).is_err() {
            continue;
        }
        let loops = [("loop", 1), ("batched-loop", LOOP_LANES)];
        for (_, lanes) in loops.into_iter().filter(|(name, _)| wanted(name)) {
            list.push(if task.is_derivative() {
                asked.missing(TITLES[usize::from(lanes > 1)], NO_DERIVATIVES)
            } else {
                asked.hand_written(command, lanes)
            });
        }
        if wanted("pinocchio") {
            list.extend(asked.pinocchio(command));
        }
    }
    if wanted("mujoco") {
        list.push(match (task.is_derivative(), question.has_loads) {
            (true, _) => asked.missing("MuJoCo", NO_DERIVATIVES),
            (_, true) => {
                asked.missing("MuJoCo", "its loads on bodies are in the frame of the base")
            }
            (false, false) => asked.mujoco(),
        });
    }
    if wanted("casadi") {
        list.push(match too_long {
            Some(why) => asked.missing("CasADi", why),
            None => asked.casadi(),
        });
    }
    list
}

/// Reason why some peers are missing. MuJoCo derives by difference quotients.
const NO_DERIVATIVES: &str = "it has no function for derivatives";

/// Titles of the peers in the table, in the order of their names.
const TITLES: [&str; 5] = [
    "hand-written loop",
    "hand-written loop, 8 at once",
    "Pinocchio",
    "MuJoCo",
    "CasADi",
];

impl PeerQuestion<'_> {
    /// A peer of these sources; with `shared`, in the folder of this name.
    fn peer(
        &self,
        name: &str,
        remark: String,
        sources: &[(&str, &str)],
        steps: Vec<BuildStep>,
        shared: Option<&str>,
    ) -> Contestant {
        let own = [("peer.h", PEER_H), ("bench.h", BENCH_H)];
        let files = sources.iter().chain(&own);
        let data = vec![
            ("model.txt".to_owned(), tree::text(self.model).into_bytes()),
            ("states.bin".to_owned(), self.state_bytes()),
        ];
        Contestant {
            remark,
            files: files
                .map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()))
                .collect(),
            data,
            steps,
            arguments: [self.task.name(), "model.txt", "states.bin", RESULTS]
                .map(str::to_owned)
                .into(),
            tolerance: self.task.tolerance(ContestantFamily::Peer),
            shared: shared.map(str::to_owned),
            ..Contestant::named(
                name,
                ContestantFamily::Peer,
                self.task.outputs(self.model.joints.len() as u32),
            )
        }
    }

    fn missing(&self, name: &str, why: &str) -> Contestant {
        Contestant {
            missing: Some(why.to_owned()),
            ..self.peer(name, String::new(), &[], Vec::new(), None)
        }
    }

    /// Number of states, a flag for loads, then each state's bytes (`peer.h`).
    fn state_bytes(&self) -> Vec<u8> {
        let (question, joints) = (self.question, self.model.joints.len());
        let head = [
            f64::from(question.count),
            f64::from(u8::from(question.has_loads)),
        ];
        let mut numbers = head.to_vec();
        for state in 0..question.count {
            let inputs = inputs(question, question.view, state);
            for array in ["q", "qd"].into_iter().chain(self.task.given()) {
                numbers.extend(elements(question.view, &inputs, array, 1, joints));
            }
            if question.has_loads {
                let [force, torque] =
                    ["frc", "trq"].map(|array| elements(question.view, &inputs, array, 3, joints));
                assert_eq!(
                    force.len(),
                    torque.len(),
                    "a joint has a force and a torque"
                );
                let loads = force.chunks(3).zip(torque.chunks(3));
                numbers.extend(loads.flat_map(|(force, torque)| [force, torque].concat()));
            }
        }
        numbers.into_iter().flat_map(f64::to_le_bytes).collect()
    }

    /// A loop that takes this number of states at once.
    fn hand_written(&self, command: &str, lanes: u32) -> Contestant {
        let flags = BuildStep::new(command, FLAGS);
        let step = flags
            .with("-std=c++17")
            .with(format!("-DBENCH_LANES={lanes}"))
            .with("-c")
            .with("loop.cpp");
        let steps = vec![
            step.function("loop.o"),
            BuildStep::new(command, "-o program loop.o -lm"),
        ];
        let (title, folder) = match lanes {
            1 => (TITLES[0], format!("loop-{command}")),
            _ => (TITLES[1], format!("batched-loop-{command}")),
        };
        let remark = format!("{command} {FLAGS}");
        Contestant {
            lanes,
            ..self.peer(title, remark, &LOOP, steps, Some(&folder))
        }
    }

    fn pinocchio(&self, command: &str) -> Vec<Contestant> {
        let name = "Pinocchio";
        let Some((folder, version)) = package("pinocchio") else {
            let why = "not installed: pip install pin, and Eigen's headers (libeigen3-dev)";
            return vec![self.missing(name, why)];
        };
        // The package is in <prefix>/lib/python3.x/site-packages/pinocchio.
        let prefix = Path::new(&folder).ancestors().nth(4);
        let include = prefix.map(|prefix| prefix.join("include").display().to_string());
        let include = include.unwrap_or_default();
        let convention = |convention: &str| {
            let said = match self.task {
                BenchTask::Dirdyna | BenchTask::Accelred => convention.to_lowercase() + ", ",
                BenchTask::Invdyna | BenchTask::InvdynaD | BenchTask::DirdynaD => String::new(),
            };
            let remark = format!("{version}, {said}{command} {FLAGS}");
            let step = BuildStep::new(command, &format!("{FLAGS} {PINOCCHIO_FLAGS}"))
                .with(format!("-DCONVENTION={convention}"))
                .with(format!("-I{include}"))
                .with("-I/usr/include/eigen3")
                .with("-o")
                .with("program")
                .with("pinocchio.cpp");
            let source = [("pinocchio.cpp", PINOCCHIO)];
            let shared = format!("pinocchio-{convention}-{command}");
            self.peer(name, remark, &source, vec![step], Some(&shared))
        };
        match self.task {
            BenchTask::Dirdyna | BenchTask::Accelred => ["WORLD", "LOCAL"].map(convention).into(),
            // Of the others there is one kind.
            BenchTask::Invdyna | BenchTask::InvdynaD | BenchTask::DirdynaD => {
                vec![convention("LOCAL")]
            }
        }
    }

    fn mujoco(&self) -> Contestant {
        let name = "MuJoCo";
        let Some((folder, version)) = package("mujoco") else {
            return self.missing(name, "not installed: pip install mujoco");
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
        self.peer(name, version, &source, vec![step], Some("mujoco"))
    }

    fn casadi(&self) -> Contestant {
        let name = "CasADi";
        let Some((_, version)) = package("casadi") else {
            return self.missing(name, "not installed: pip install casadi");
        };
        let sources = [("casadi_functions.py", CASADI), ("main.c", CASADI_MAIN)];
        let loads = if self.question.has_loads {
            "loads"
        } else {
            "free"
        };
        let print = format!(
            "casadi_functions.py {} {loads} model.txt function.c",
            self.task.name()
        );
        let step = BuildStep::new("cc", FLAGS).with("-c").with("function.c");
        let steps = vec![
            BuildStep::new("python3", &print),
            step.function("function.o"),
            BuildStep::new("cc", "-O2 -o program main.c function.o -lm"),
        ];
        let remark = format!("{version}, cc {FLAGS}");
        self.peer(name, remark, &sources, steps, None)
    }
}

/// An input array of a state, by components and joints; else zeros.
fn elements(
    view: View<'_>,
    inputs: &[f64],
    wanted: &str,
    components: usize,
    joints: usize,
) -> Vec<f64> {
    let mut values = vec![0.0; components * joints];
    for (index, &number) in inputs.iter().enumerate() {
        let (array, indices, rank) = view.function.input_element(Input(index as u32));
        if view.tables.symbols.text(array.name) != wanted {
            continue;
        }
        let (component, joint) = match rank {
            1 => (1, indices[0]),
            _ => (indices[0], indices[1]),
        };
        let place = (joint as usize - 1) * components + component as usize - 1;
        if let Some(value) = values.get_mut(place) {
            *value = number;
        }
    }
    values
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench;
    use robovec_dynamics::generate::{GenerationRequest, generate};
    use robovec_io::files::TemporaryFolder;
    use robovec_ir::Module;
    use robovec_ir::states::States;
    use robovec_model::{Axis, ConstantTurn, JointMounting, family};

    /// Question about a function of a model in 16 states.
    fn question<'a>(
        task: BenchTask,
        module: &'a Module,
        model: &'a Model,
        has_loads: bool,
        states: &'a States,
    ) -> BenchQuestion<'a> {
        BenchQuestion {
            name: task.name().to_owned(),
            view: module.tables.view(&module.functions[0]),
            model: Some(model),
            has_loads,
            states,
            count: 16,
            flags: None,
        }
    }

    /// A tree with constant turns before joints, and joints against their axes.
    fn placed_tree(seed: u64) -> Model {
        let mut model = family::random_tree(seed, 9);
        for (place, joint) in model.joints.iter_mut().enumerate() {
            let turn = |axis, angle| ConstantTurn { axis, angle };
            let all = [turn(Axis::Z, 0.4), turn(Axis::Y, -1.1), turn(Axis::X, 2.0)];
            joint.mounting = JointMounting {
                turns: all[..place % 4].to_vec(),
                reversed: place % 3 == 1,
            };
        }
        model
    }

    /// Loops of one and of eight states give the results of the generator's
    /// equations, for a tree whose joints turn and slide in general positions,
    /// when there is a compiler.
    #[test]
    fn hand_written_loops_agree_with_the_equations() {
        let model = placed_tree(5);
        let names = ["loop", "batched-loop"].map(str::to_owned);
        let folder = TemporaryFolder::new().expect("a folder");
        let tasks = BenchTask::ALL.into_iter();
        for task in tasks.filter(|task| !task.is_derivative()) {
            let module = generate(&model, &GenerationRequest::new(task.kind()));
            let module = module.expect("a tree has all functions");
            for has_loads in [false, true] {
                let states = States::new(3);
                let question = question(task, &module, &model, has_loads, &states);
                let peers = peers(&question, &model, task, &names, None);
                let outcomes = bench(&question, &peers, folder.path(), 0, 1, &mut |_| {});
                for outcome in outcomes.expect("the folder can be written") {
                    let context = format!("{}, {}, {has_loads}", task.name(), outcome.name);
                    assert_eq!(outcome.failure, None, "{context}");
                    assert!(outcome.difference.is_some(), "{context}");
                }
            }
        }
    }

    #[test]
    fn states_have_what_the_task_gives_and_loads() {
        let model = family::random_tree(1, 4);
        for (task, vectors) in [
            (BenchTask::Dirdyna, 2),
            (BenchTask::Invdyna, 3),
            (BenchTask::Accelred, 3),
            (BenchTask::InvdynaD, 3),
            (BenchTask::DirdynaD, 3),
        ] {
            let module = generate(&model, &GenerationRequest::new(task.kind()));
            let module = module.expect("a tree has all functions");
            for has_loads in [false, true] {
                let states = States::new(3);
                let question = question(task, &module, &model, has_loads, &states);
                let asked = PeerQuestion {
                    question: &question,
                    model: &model,
                    task,
                };
                let loads = if has_loads { 6 } else { 0 };
                let numbers = 2 + 16 * 4 * (vectors + loads);
                assert_eq!(asked.state_bytes().len(), 8 * numbers);
            }
        }
    }
}
