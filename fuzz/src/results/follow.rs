//! One pass after the other, each judged.

use super::pairing::Pairing;
use super::promise::Promise;
use super::{Finding, Tally};
use robovec_framework::manager::{self, Config, RunError};
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, print};
use robovec_passes::registry::REGISTRY;

/// Points at which versions are compared.
const POINTS: u32 = 3;

/// Programs that passes made larger are not followed any further.
const LARGEST: usize = 2000;

/// Runs one pass and judges it; false when the pipeline ends with it.
pub(super) fn follow(
    module: &mut Module,
    step: &str,
    machine: &Machine,
    seed: u64,
    tally: &mut Tally,
) -> std::result::Result<bool, Box<Finding>> {
    let before = module.clone();
    let accused = match execute(module, step, machine, Some(2), seed) {
        Ok(()) => None,
        Err(RunError::Pass { .. }) => {
            tally.refused += 1;
            return Ok(false);
        }
        // What the pass made is left in the module.
        Err(RunError::Check { reason, .. }) => {
            *module = before.clone();
            match execute(module, step, machine, None, seed) {
                Ok(()) => Some(reason),
                Err(error) => {
                    return Err(finding(
                        step,
                        format!("without the check: {error}"),
                        &before,
                        module,
                    ));
                }
            }
        }
        Err(error) => return Err(finding(step, error.to_string(), &before, module)),
    };
    tally.passes += 1;
    let judged = judge(&before, module, step, seed, tally);
    match (judged, accused) {
        (Ok(()), None) => {}
        (Ok(()), Some(reason)) => {
            let what = format!("the check refuses what the referee finds right: {reason}");
            return Err(finding(step, what, &before, module));
        }
        (Err(what), None) => {
            let what = format!("{what}\nand the check saw nothing");
            return Err(finding(step, what, &before, module));
        }
        (Err(what), Some(reason)) => {
            let what = format!("{what}\nthe check: {reason}");
            return Err(finding(step, what, &before, module));
        }
    }
    Ok(module
        .functions
        .iter()
        .all(|function| function.nodes().len() <= LARGEST))
}

pub(super) fn finding(step: &str, what: String, before: &Module, after: &Module) -> Box<Finding> {
    Box::new(Finding {
        pass: step.to_owned(),
        what,
        program: print::print_module(before),
        result: print::print_module(after),
    })
}

fn execute(
    module: &mut Module,
    step: &str,
    machine: &Machine,
    check_each: Option<u32>,
    seed: u64,
) -> std::result::Result<(), RunError> {
    let pipeline = REGISTRY.pipeline(step).expect("made of known passes");
    let mut log = std::io::sink();
    let config = Config {
        check_each,
        states: States::new(seed),
        ..Config::new(machine, &mut log)
    };
    manager::run(module, &pipeline, config).map(|_| ())
}

/// Compares all functions with their originals; the first difference.
fn judge(
    before: &Module,
    after: &Module,
    step: &str,
    seed: u64,
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    let pipeline = REGISTRY.pipeline(step).expect("made of known passes");
    let promise = Promise::of(pipeline.passes().next().expect("it is a pass"));
    for (old, new) in before.functions.iter().zip(&after.functions) {
        let old = before.tables.view(old);
        let new = after.tables.view(new);
        let count = promise
            .instances
            .as_ref()
            .map_or(1, |instances| instances.count);
        for instance in 1..=count {
            let pairing = Pairing {
                promise: &promise,
                instance,
                seed,
            };
            for point in 0..POINTS {
                pairing.compare(old, new, point, tally)?;
            }
        }
    }
    Ok(())
}
