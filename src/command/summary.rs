//! Summary of a run of `robovec-opt`: speed, error and cost beside the input's.
//!
//! As in compilers, it is for users and not programs: it is printed only where
//! the result goes to a file or to a terminal, and on the standard error. It
//! must take almost no time, so errors are measured at few states, and at none
//! where the functions are large: the work is counted in operations, so that
//! the same run prints the same on every computer.

use super::arguments::OptimiserArguments;
use robovec_analysis::critical_path::critical_path;
use robovec_error::yardstick::Yardstick;
use robovec_error::yardstick::account::{ErrorAccount, random_states};
use robovec_explore::device;
use robovec_explore::placing::scheduled_machine;
use robovec_fpga::hardware;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_ir::count::Counts;
use robovec_ir::diagnostic::counted;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, Level, Machine, Module, View};
use robovec_present::number::percent;
use std::borrow::Cow;
use std::io::{self, IsTerminal};
use std::path::Path;

/// Operations that are evaluated exactly, over all functions and states.
const EVALUATIONS: usize = 400_000;

/// Number of states evaluated at a time.
const LANES: usize = 4;

const MOST_STATES: usize = 64;

pub(super) struct RunSummary<'a> {
    machine: &'a Machine,
    /// Origin of the states, and a flag: true when a scene gives their ranges.
    states: (States, bool),
    /// The format in which the pipeline's program computes.
    format: Format,
    /// The functions as they came.
    before: Vec<FunctionBefore>,
}

struct FunctionBefore {
    name: String,
    operations: usize,
    path: u32,
    /// Its exact results; `None` where it is too large.
    yardstick: Option<Yardstick>,
}

impl<'a> RunSummary<'a> {
    /// Reads the functions before the run; `None` without a summary.
    pub(super) fn begin(
        arguments: &OptimiserArguments,
        pipeline: &Pipeline,
        module: &Module,
        machine: &'a Machine,
        states: (States, bool),
    ) -> Option<RunSummary<'a>> {
        if !is_told(arguments, pipeline) {
            return None;
        }
        let exact = measured_by(pipeline, module, machine);
        let nodes: usize = exact.functions.iter().map(|f| f.nodes().len()).sum();
        let count = (EVALUATIONS / nodes.max(1)).min(MOST_STATES) / LANES * LANES;
        let pairs = module.functions.iter().zip(&exact.functions);
        let before = pairs.map(|(function, exact_function)| {
            let view = exact.tables.view(exact_function);
            let exact = || Yardstick::new(view, &states.0, count as u32);
            FunctionBefore {
                name: function.name.clone(),
                operations: Counts::operations_of(function),
                path: critical_path(function, machine).asap_cycle,
                yardstick: (count > 0).then(exact),
            }
        });
        Some(RunSummary {
            machine,
            before: before.collect(),
            format: format(pipeline, machine),
            states,
        })
    }

    /// One line for every function.
    pub(super) fn text(&self, module: &Module) -> String {
        let lines = module.functions.iter().filter_map(|function| {
            let mut before = self.before.iter();
            let before = before.find(|before| before.name == function.name)?;
            let view = module.tables.view(function);
            Some(format!(
                "{}: {} -> {}, {}; {}\n",
                function.name,
                before.operations,
                counted(Counts::operations_of(function), "operation"),
                self.speed_and_cost(before, function),
                self.error(before, view)
            ))
        });
        lines.collect()
    }

    /// Longest path of a function, or its schedule and share of the device.
    fn speed_and_cost(&self, before: &FunctionBefore, function: &Function) -> String {
        let schedule = function.schedule.as_ref();
        let own = schedule.filter(|schedule| schedule.check_machine(self.machine).is_ok());
        let Some(schedule) = own else {
            let path = critical_path(function, self.machine).asap_cycle;
            let name = &self.machine.name;
            return format!(
                "longest path {} -> {} of {name}",
                before.path,
                counted(path, "cycle")
            );
        };
        let machine = scheduled_machine(self.machine, schedule);
        let clock = hardware::clock(&machine);
        let kinds = schedule.kinds.iter();
        let kinds: Vec<String> = kinds
            .map(|kind| format!("{} {}", kind.count, kind.name))
            .collect();
        let mut text = format!(
            "{}, {:.3} us at {} on {}",
            counted(schedule.cycles, "cycle"),
            clock.microseconds(schedule.cycles),
            clock.text(),
            kinds.join(" + ")
        );
        if let Some(share) = device::share_of_placed(function, &machine) {
            let device = &machine.device.device().name;
            text += &format!(", {} of {device} (estimated)", percent(share));
        }
        text
    }

    fn error(&self, before: &FunctionBefore, view: View<'_>) -> String {
        let Some(yardstick) = &before.yardstick else {
            return format!(
                "error not measured here beyond {} operations (--report)",
                EVALUATIONS / LANES
            );
        };
        let (states, has_scene) = &self.states;
        let words = random_states(yardstick.len(), states.seed(), *has_scene);
        let measured = ErrorAccount::measured(view, yardstick, self.format, words);
        match measured {
            Ok(account) => account.text(),
            Err(reason) => format!("error not measured: {reason}"),
        }
    }
}

/// The functions whose exact results are compared with: those that came, or,
/// where the pipeline differentiates, their derivatives and no other pass.
fn measured_by<'m>(pipeline: &Pipeline, module: &'m Module, machine: &Machine) -> Cow<'m, Module> {
    let differentiates = |step: &&PassStep| {
        let pass = (step.info.build)(&step.options);
        pass.is_ok_and(|pass| pass.differentiation().is_some())
    };
    let steps: Vec<PassStep> = pipeline.passes().filter(differentiates).cloned().collect();
    let is_at = |level: Level| {
        let mut functions = module.functions.iter();
        functions.all(|function| function.level == level)
    };
    let mut wanted = Pipeline {
        steps: Vec::new(),
        registry: pipeline.registry,
    };
    if is_at(Level::Equations) {
        let lowered = pipeline.registry.pipeline("atomise");
        wanted = lowered.expect("every registry can lower equations");
    }
    if steps.is_empty() || wanted.steps.is_empty() && !is_at(Level::Atomic) {
        return Cow::Borrowed(module);
    }
    let steps = steps.into_iter().map(PipelineStep::Pass);
    wanted.steps.extend(steps);
    let mut derivatives = module.clone();
    let mut silent = io::sink();
    // What cannot be differentiated is told by the run itself.
    match manager::run(&mut derivatives, &wanted, Config::new(machine, &mut silent)) {
        Ok(_) => Cow::Owned(derivatives),
        Err(_) => Cow::Borrowed(module),
    }
}

/// True when a result goes elsewhere and no other output has these figures.
fn is_told(arguments: &OptimiserArguments, pipeline: &Pipeline) -> bool {
    let is_file = |path: &Path| path != Path::new("-");
    let goes_to_people = match &arguments.output {
        Some(path) if is_file(path) => true,
        _ => io::stdout().is_terminal(),
    };
    let has_other = arguments.report.is_some() || arguments.explain.is_some();
    goes_to_people && !arguments.telling.quiet && !has_other && !pipeline.steps.is_empty()
}

/// The format that the result computes in: the machine's, or the last C's.
fn format(pipeline: &Pipeline, machine: &Machine) -> Format {
    let last = pipeline.passes().last();
    let Some(codegen) = last.filter(|pass| pass.info.name == "codegen") else {
        return machine.number;
    };
    let option = |name: &str| {
        let mut options = codegen.options.iter();
        let found = options.find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str())
    };
    match (option("target"), option("number")) {
        (None | Some("mif" | "rtl"), _) => machine.number,
        (Some(_), Some("float")) => Format::BINARY32,
        (Some(_), _) => Format::BINARY64,
    }
}
