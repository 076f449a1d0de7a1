//! Pipelines run over random programs under the semantic check.

use robovec_framework::manager::{self, Config, Executed, Limit, RunError};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::reduce::{TrialSetting, WORK, reduce};
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, print};
use robovec_passes::registry::REGISTRY;
use robovec_rules::RuleSet;

/// The passes of a pipeline that ran.
pub(crate) struct Ran {
    pub(crate) executed: Vec<Executed>,
    /// False when a pass had a reason to refuse the function.
    pub(crate) complete: bool,
}

/// Runs a pipeline for a machine that ships, up to a limit if there is one.
///
/// # Panics
///
/// Panics when a pass breaks an invariant or changes the function.
pub(crate) fn run(
    module: &mut Module,
    text: &str,
    machine: &str,
    seed: u64,
    limit: Option<Limit>,
) -> Ran {
    let pipeline = REGISTRY.pipeline(text).expect("made of known passes");
    let machine = Machine::built_in(machine).expect("it ships");
    let before = module.clone();
    let mut executed = Vec::new();
    let result = manager::run(
        module,
        &pipeline,
        Config {
            check_each: Some(2),
            states: States::new(seed),
            histories: seed.is_multiple_of(2),
            limit,
            executed: Some(&mut executed),
            ..Config::new(&machine, &mut std::io::sink())
        },
    );
    let complete = match result {
        Ok(_) => true,
        Err(RunError::Pass { .. }) => false,
        Err(error) => panic!(
            "{pipeline}, limit {limit:?}, seed {seed}: {error}\n{}",
            reduced(&before, &pipeline, &machine, &RuleSet::built_in(), seed)
        ),
    };
    Ran { executed, complete }
}

/// The smallest program that shows the failure; the whole program when the
/// failure is in the first rewrites of a pass.
pub(crate) fn reduced(
    module: &Module,
    pipeline: &Pipeline,
    machine: &Machine,
    rules: &RuleSet,
    seed: u64,
) -> String {
    let setting = TrialSetting {
        machine,
        rules,
        scene: None,
        target: None,
        points: 2,
        seed,
    };
    match reduce(module, pipeline, setting, WORK) {
        Some(found) => format!("{found}{}", print::print_module(&found.program)),
        None => format!("on {}", print::print_module(module)),
    }
}
