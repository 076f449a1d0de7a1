//! The pass `differentiate` on everything that is generated: every function in
//! every formulation, against dual numbers in two prime fields and in numbers.

use super::closing::closed;
use super::{Case, PLAIN, each, requests};
use crate::reference::random::Recipe;
use robovec::generate::{Formulation, GenerationRequest, generate};
use robovec::robotran::FunctionKind;
use robovec_framework::manager::{self, Config};
use robovec_ir::{Machine, Module};
use robovec_passes::registry::REGISTRY;
use std::cell::Cell;

/// Trees of more joints are left to longer runs.
const MOST_JOINTS: usize = 9;

/// Points of each field at which derivatives are compared.
const POINTS: u32 = 8;

/// Differentiates all functions of a module by positions and velocities, where
/// they have these; returns their number.
fn differentiate(case: &Case, module: &Module, request: &GenerationRequest, result: &str) -> u32 {
    let mut count = 0;
    for function in &module.functions {
        let names = function.inputs().iter();
        let names = names.map(|array| module.tables.symbols.text(array.name));
        let by: Vec<&str> = names.filter(|name| ["q", "qd"].contains(name)).collect();
        if by.is_empty() {
            continue;
        }
        let mut alone = Module::new();
        alone.tables = module.tables.clone();
        alone.functions.push(function.clone());
        let by = by.join("+");
        let text = format!("atomise,differentiate{{by={by} result={result} values=false}}");
        let pipeline = REGISTRY.pipeline(&text).expect("made of known passes");
        let machine = Machine::built_in("ideal").expect("it ships");
        let mut silent = std::io::sink();
        let config = Config {
            check_each: Some(POINTS),
            ..Config::new(&machine, &mut silent)
        };
        if let Err(error) = manager::run(&mut alone, &pipeline, config) {
            panic!("seed {}, {request:?}, {text}: {error}", case.seed);
        }
        count += 1;
    }
    count
}

/// One of the three forms of a request, in turn.
fn results(number: usize) -> &'static str {
    ["jacobian", "direction", "gradient"][number % 3]
}

#[test]
fn every_function_in_every_formulation_has_derivatives() {
    let recipe = Recipe {
        devices: 2,
        massless: false,
        ..PLAIN
    };
    let count = Cell::new(0);
    each(recipe, |case| {
        if case.model.joints.len() > MOST_JOINTS {
            return;
        }
        for kind in FunctionKind::ALL {
            for (number, request) in requests(kind).iter().enumerate() {
                // Trees have no constraints, and what they leave out is said.
                if let Ok(module) = generate(&case.model, request) {
                    let done = differentiate(case, &module, request, results(number));
                    count.set(count.get() + done);
                }
            }
        }
    });
    assert!(count.get() > 200, "only {} functions", count.get());
}

#[test]
fn functions_of_closed_loops_have_derivatives() {
    let mut count = 0;
    for case in (1..=30).filter_map(closed) {
        if case.model.joints.len() > MOST_JOINTS {
            continue;
        }
        let kinds = FunctionKind::ALL.into_iter();
        for (number, kind) in kinds.filter(|kind| kind.is_special()).enumerate() {
            let request = GenerationRequest {
                formulation: Formulation::Composite,
                ..GenerationRequest::new(kind)
            };
            let module = generate(&case.model, &request);
            let module = module.unwrap_or_else(|error| panic!("seed {}: {error}", case.seed));
            count += differentiate(&case, &module, &request, results(number));
        }
    }
    assert!(count > 40, "only {count} functions");
}
