//! Runs steps on a function and describes the failure.

use crate::manager::{self, Config, Executed, Limit, RunError};
use crate::pass::{Registry, TargetFolder};
use crate::pipeline::{PassStep, Pipeline, PipelineStep};
use crate::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, Tables};
use robovec_rules::RuleSet;
use std::io;

/// The setting in which passes are judged.
#[derive(Clone, Copy)]
pub struct TrialSetting<'a> {
    /// The machine compiled for.
    pub machine: &'a Machine,
    /// The rules that rewriting may use.
    pub rules: &'a RuleSet,
    /// The scene that the functions are needed for.
    pub scene: Option<&'a Scene>,
    /// Target of code generation that the user described.
    pub target: Option<&'a TargetFolder>,
    /// Random points each pass is checked at.
    pub points: u32,
    /// Seed of the points.
    pub seed: u64,
}

/// The kind of failure of a pipeline.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ProblemKind {
    /// A pass gave up with an error.
    Refused,
    /// A pass panicked.
    Panicked,
    /// The verifier refuses the result of a pass.
    Malformed,
    /// The semantic check refuses the result of a pass.
    Changed,
}

/// The problem, and the pass in which it occurred.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PassProblem {
    /// The kind of failure.
    pub kind: ProblemKind,
    /// The message of the manager.
    pub message: String,
    /// Name of the pass.
    pub pass: &'static str,
}

impl PassProblem {
    /// True when another program shows the same: the same pass fails in the
    /// same way, and where it shows why, for the same reason. Names and
    /// numbers in the reason may differ, as they belong to the program.
    pub(super) fn is_like(&self, other: &PassProblem) -> bool {
        let reasoned = matches!(self.kind, ProblemKind::Refused | ProblemKind::Panicked);
        (self.kind, self.pass) == (other.kind, other.pass)
            && (!reasoned || gist(&self.message) == gist(&other.message))
    }
}

/// The words of a message, without those that hold digits, signs or quoted
/// names.
fn gist(message: &str) -> Vec<&str> {
    message
        .split_whitespace()
        .filter(|word| word.bytes().all(|byte| byte.is_ascii_lowercase()))
        .collect()
}

/// The outcome of a run.
pub(super) struct ReductionTrial {
    /// The functions as far as they came.
    pub(super) module: Module,
    /// The passes that were started.
    pub(super) executed: Vec<Executed>,
    pub(super) problem: Option<PassProblem>,
}

/// Runs a pipeline on a copy of a module under the verifier and the check.
///
/// A pipeline that cannot run on the module is no problem of a pass.
pub(super) fn run(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
    limit: Option<Limit>,
    judged: bool,
) -> ReductionTrial {
    let mut module = module.clone();
    let mut executed = Vec::new();
    let result = manager::run(
        &mut module,
        pipeline,
        Config {
            check_each: judged.then_some(setting.points),
            verify_each: judged,
            states: match setting.scene {
                Some(scene) => scene.states(setting.seed),
                None => States::new(setting.seed),
            },
            scene: setting.scene,
            target: setting.target,
            rules: Some(setting.rules),
            limit,
            executed: Some(&mut executed),
            ..Config::new(setting.machine, &mut io::sink())
        },
    );
    let kind = match &result {
        Ok(_) | Err(RunError::Plan(_) | RunError::Io(_) | RunError::Given { .. }) => None,
        Err(RunError::Pass { .. }) => Some(ProblemKind::Refused),
        Err(RunError::Panic { .. }) => Some(ProblemKind::Panicked),
        Err(RunError::Verify { .. }) => Some(ProblemKind::Malformed),
        Err(RunError::Check { .. }) => Some(ProblemKind::Changed),
    };
    let message = match &result {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let pass = executed
        .last()
        .map_or("", |last: &Executed| last.step.info.name);
    ReductionTrial {
        module,
        executed,
        problem: kind.map(|kind| PassProblem {
            kind,
            message,
            pass,
        }),
    }
}

/// One function with the passes to run on it, of which the last fails.
#[derive(Clone)]
pub(super) struct Case {
    pub(super) tables: Tables,
    pub(super) function: Function,
    pub(super) steps: Vec<PassStep>,
    pub(super) registry: &'static Registry,
}

impl Case {
    pub(super) fn pipeline(&self) -> Pipeline {
        Pipeline {
            steps: self.steps.iter().cloned().map(PipelineStep::Pass).collect(),
            registry: self.registry,
        }
    }

    pub(super) fn module(&self) -> Module {
        Module {
            tables: self.tables.clone(),
            functions: vec![self.function.clone()],
        }
    }

    /// Runs the steps; of the last one only some rewrites, if limited.
    pub(super) fn run(
        &self,
        setting: TrialSetting<'_>,
        rewrites: Option<u64>,
        judged: bool,
    ) -> ReductionTrial {
        let limit = rewrites.map(|rewrites| Limit {
            passes: self.steps.len() as u64,
            rewrites: Some(rewrites),
        });
        run(&self.module(), &self.pipeline(), setting, limit, judged)
    }

    /// True when the steps fail with the given kind of failure.
    pub(super) fn shows(
        &self,
        wanted: &PassProblem,
        setting: TrialSetting<'_>,
        rewrites: Option<u64>,
    ) -> bool {
        let trial = self.run(setting, rewrites, true);
        trial.problem.is_some_and(|found| found.is_like(wanted))
            && trial.executed.len() == self.steps.len()
    }
}
