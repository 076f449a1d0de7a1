//! Bounds, predictions and sampled deviations against the errors of all
//! models that ship; and bounds for all states by norms of vectors.

use robovec::generate::{Formulation, GenerationRequest, Options, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec_analysis::adjoint::{AdjointRun, OutputError, Tape};
use robovec_analysis::interval::{GivenData, input_ranges};
use robovec_analysis::norms::norm_bounds;
use robovec_analysis::stochastic::stochastic;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, View};
use std::path::{Path, PathBuf};

/// Errors found over functions and states.
#[derive(Default)]
struct ErrorsFound {
    /// Bound divided by actual error, where known.
    overestimates: Vec<f64>,
    /// Errors of the prediction, relative to the bound.
    misses: Vec<f64>,
    /// Bound of all states over the largest error of a function's outputs.
    proofs: Vec<f64>,
    /// Outputs beyond three sigma, and all.
    beyond: usize,
    sampled: usize,
}

fn models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let entries = std::fs::read_dir(folder).expect("the folder ships");
    let paths = entries.map(|entry| entry.expect("it can be listed").path());
    let is_model = |path: &PathBuf| path.extension().is_some_and(|kind| kind == "mbs");
    let mut paths: Vec<PathBuf> = paths.filter(is_model).collect();
    paths.sort();
    assert!(paths.len() > 20);
    paths
}

/// Measures a model's functions up to the requested size; `most` outputs of a
/// state are differentiated.
fn measure(path: &Path, largest: usize, states: u32, most: usize, found: &mut ErrorsFound) {
    let bytes = std::fs::read(path).expect("it can be read");
    let name = path.to_string_lossy();
    let model = read_mbs(&name, &bytes).expect("it is a model").model;
    for kind in [FunctionKind::Dirdyna, FunctionKind::Invdyna] {
        for formulation in [Formulation::Recursive, Formulation::Composite] {
            let request = GenerationRequest {
                formulation,
                options: Options::default(),
                ..GenerationRequest::new(kind)
            };
            let Ok(module) = generate(&model, &request) else {
                continue;
            };
            for function in &module.functions {
                let view = View {
                    tables: &module.tables,
                    function,
                };
                if function.nodes().len() <= largest {
                    measure_function(view, states, most, found);
                }
            }
        }
    }
}

fn measure_function(view: View<'_>, states: u32, most: usize, found: &mut ErrorsFound) {
    let tape = Tape::new(view.function);
    let source = States::new(11);
    let ranges = input_ranges(view, &source);
    let ranges: Vec<_> = ranges.iter().map(|range| range.range).collect();
    let proved = norm_bounds(&tape, &ranges, Format::BINARY32, GivenData::Held);
    let mut largest: f64 = 0.0;
    for state in 0..states {
        let inputs = source.draw(view, state);
        let run = AdjointRun::of(view.function, &tape, Format::BINARY32, &inputs);
        let step = tape.outputs().div_ceil(most).max(1);
        let outputs: Vec<usize> = (0..tape.outputs()).step_by(step).collect();
        for (error, &output) in run.outputs(&outputs).iter().zip(&outputs) {
            judge(view.function, error, output, found);
        }
        for slot in 0..tape.slots() {
            let error = run.errors()[slot].abs();
            assert!(
                error <= proved.error[slot],
                "{}, slot {slot}",
                view.function.name
            );
        }
        let slots: Vec<usize> = (0..tape.outputs()).map(|i| tape.output_slot(i)).collect();
        largest = slots
            .iter()
            .map(|&slot| run.errors()[slot].abs())
            .fold(largest, f64::max);
        let sampled =
            stochastic(&tape, Format::BINARY32, &inputs, 5, &slots).expect("f32 is narrow");
        for (output, sampled) in sampled.iter().enumerate() {
            let error = run.errors()[tape.output_slot(output)].abs();
            found.beyond += usize::from(error > 3.0 * sampled.sigma);
            found.sampled += 1;
        }
    }
    let slots = (0..tape.outputs()).map(|output| tape.output_slot(output));
    let bound = slots.map(|slot| proved.error[slot]).fold(0.0, f64::max);
    if largest > 0.0 {
        found.proofs.push(bound / largest);
    }
}

fn judge(function: &Function, error: &OutputError, output: usize, found: &mut ErrorsFound) {
    let actual = error.actual.abs();
    assert!(
        actual <= error.bound,
        "{}, output {output}: {error:?}",
        function.name
    );
    if actual > 0.0 {
        found.overestimates.push(error.bound / actual);
        found
            .misses
            .push((error.predicted - error.actual).abs() / error.bound);
    }
}

fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Conditions of the acceptance.
fn accept(mut found: ErrorsFound) {
    let overestimate = median(&mut found.overestimates);
    let proof = median(&mut found.proofs);
    let worst_miss = found.misses.iter().copied().fold(0.0, f64::max);
    let share = found.beyond as f64 / found.sampled as f64;
    eprintln!(
        "{} errors: overestimate {overestimate:.1} in the median, of all states {proof:.0}, worst miss {worst_miss:.1e} of \
         the bound; {} of {} outputs beyond three sigma, {:.3} %",
        found.overestimates.len(),
        found.beyond,
        found.sampled,
        100.0 * share,
    );
    assert!(overestimate <= 200.0);
    assert!(proof <= 1e5);
    assert!(worst_miss <= 1e-6);
    assert!(share <= 0.001);
}

#[test]
fn small_models_stay_within_bounds_and_three_sigma() {
    let mut found = ErrorsFound::default();
    let is_small = |path: &PathBuf| {
        let bytes = std::fs::metadata(path).expect("it is a file").len();
        bytes < 16_000
    };
    for path in models().into_iter().filter(is_small) {
        measure(&path, 3_000, 4, 100, &mut found);
    }
    assert!(found.sampled > 1_000, "{}", found.sampled);
    accept(found);
}

/// All models up to 130 joints; of large functions a part of the outputs is
/// differentiated, and all are sampled.
#[test]
#[ignore = "takes half a minute"]
fn all_models_stay_within_bounds_and_three_sigma() {
    let mut found = ErrorsFound::default();
    for path in models() {
        measure(&path, usize::MAX, 3, 64, &mut found);
    }
    accept(found);
}
