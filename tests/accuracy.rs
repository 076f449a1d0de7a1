//! No pass of a default pipeline makes the rounding errors worse.
//!
//! The definition of worse is that of the measurement of errors
//! (`robovec_analysis::rounding`): the median over all outputs and states, of
//! the relative or of the normwise error in binary32, grows by more than 2 %
//! and by more than 3.5 times the noise of that comparison.

use robovec::accuracy::{FunctionAccuracy, Options, measure};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec_analysis::rounding::{MedianChange, Trend};
use robovec_framework::pass::Gives;
use robovec_framework::pipeline::{Pipeline, PipelineStep};
use robovec_ir::states::States;
use robovec_ir::{Level, Machine, Module};
use robovec_passes::registry::REGISTRY;
use std::fs;
use std::path::Path;

const MODELS: &[&str] = &[
    "bogie",
    "double-pendulum",
    "four-bar",
    "parallel-23",
    "quarter-car",
    "semi-serial-23",
    "serial-23",
    "slider-crank",
    "train",
];

fn example(name: &str) -> Vec<u8> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    fs::read(examples.join(name)).expect("it is in the repository")
}

/// The example of a Robotran file, and the direct dynamics of the models.
fn modules() -> Vec<(String, Module)> {
    let name = "mbs_dirdyna_suspension.m";
    let bytes = example(&format!("suspension/{name}"));
    let read = robovec::robotran::read(name, &bytes, None).expect("it is well formed");
    let mut modules = vec![(name.to_owned(), read.module)];
    for name in MODELS {
        let file = format!("{name}.mbs");
        let bytes = example(&format!("models/{file}"));
        let model = read_mbs(&file, &bytes).expect("it is well formed").model;
        let request = GenerationRequest::new(FunctionKind::Dirdyna);
        let module = generate(&model, &request).expect("it has equations");
        modules.push(((*name).to_owned(), module));
    }
    modules
}

/// The passes of a preset up to the schedule: later ones decide time and place,
/// not values.
fn arithmetic_part(preset: &str) -> Pipeline {
    let mut pipeline = REGISTRY.pipeline(preset).expect("presets are sound");
    let schedules = |step: &PipelineStep| match step {
        PipelineStep::Pass(step) => matches!(
            step.info.gives,
            Gives::Level(Level::Scheduled | Level::Placed)
        ),
        PipelineStep::Open { .. } | PipelineStep::Close => false,
    };
    if let Some(first) = pipeline.steps.iter().position(schedules) {
        pipeline.steps.truncate(first);
    }
    pipeline
}

/// Functions with more operations are searched too long for a test.
const SEARCHED_OPERATIONS: usize = 2_000;

/// True for presets that try other passes.
fn is_search(preset: &str) -> bool {
    let pipeline = REGISTRY.pipeline(preset).expect("it is known");
    pipeline.passes().any(|step| step.info.name == "optimise")
}

fn measured(preset: &str) -> Vec<FunctionAccuracy> {
    measured_on(preset, "thesis")
}

fn measured_on(preset: &str, machine: &str) -> Vec<FunctionAccuracy> {
    let machine = Machine::built_in(machine).expect("it ships");
    let pipeline = arithmetic_part(preset);
    let options = Options {
        states: 0,
        seed: 1,
        scene: None,
    };
    let mut subjects = Vec::new();
    for (name, mut module) in modules() {
        let module = &mut module;
        if is_search(preset) && module.functions[0].nodes().len() > SEARCHED_OPERATIONS {
            continue;
        }
        let found = measure(
            &name,
            module,
            &pipeline,
            &machine,
            options,
            &mut |_, _, _| {},
        );
        subjects.extend(found.expect("presets run on every model"));
    }
    subjects
}

/// Maximum growth of a median by a search: it looks for short schedules, and
/// reports the accuracy of each of its programs.
const SEARCHED: f64 = 1.25;

#[test]
fn no_pass_of_a_default_pipeline_worsens_the_median() {
    for preset in REGISTRY.presets {
        let mut compared = 0;
        let name = format!("${}", preset.name);
        let searches = is_search(&name);
        let subjects = measured(&name);
        let least = if searches {
            MODELS.len() / 2
        } else {
            2 * MODELS.len()
        };
        let is_worse = |change: &MedianChange, searches: bool| {
            change.trend == Trend::Worse && !(searches && change.ratio <= SEARCHED)
        };
        for subject in subjects {
            for step in &subject.steps {
                for change in step.changes.iter().flatten() {
                    compared += 1;
                    assert!(
                        !is_worse(change, step.pass.starts_with("optimise")),
                        "{}, {} of ${}: {change}",
                        subject.name,
                        step.pass,
                        preset.name
                    );
                }
            }
            for change in subject.overall().iter().flatten() {
                assert!(
                    !is_worse(change, searches),
                    "{}, the whole of ${}: {change}",
                    subject.name,
                    preset.name
                );
            }
        }
        assert!(compared > least, "passes were compared");
    }
}

#[test]
fn the_more_accurate_form_never_worsens_the_median_and_often_improves_it() {
    let before = "atomise,zero-removal,balance,cse,dce";
    for (options, machine, fewest) in [
        ("", "thesis", 0),
        ("", "fused", 7),
        ("{growth=50 slack=50}", "fused", 7),
    ] {
        let pipeline = format!("{before},accurate{options}");
        let mut better = 0;
        for subject in measured_on(&pipeline, machine) {
            let last = subject.steps.last().expect("there are passes");
            for change in last.changes.iter().flatten() {
                let name = &subject.name;
                let worse = change.trend == Trend::Worse;
                assert!(!worse, "{name}, accurate{options} on {machine}: {change}");
                better += u32::from(change.trend == Trend::Better);
            }
        }
        assert!(better >= fewest, "{options} on {machine}: {better} better");
    }
}

#[test]
fn what_does_worsen_it_is_seen() {
    // Taking all bodies into one frame costs digits: the same measure must
    // tell the formulations apart.
    use robovec::generate::Formulation;
    use robovec_analysis::rounding::{MedianChange, rounding};
    use robovec_ir::View;
    let bytes = example("models/serial-23.mbs");
    let model = read_mbs("serial-23.mbs", &bytes)
        .expect("it is well formed")
        .model;
    let of = |formulation: Formulation| {
        let request = GenerationRequest {
            formulation,
            ..GenerationRequest::new(FunctionKind::Dirdyna)
        };
        let module = generate(&model, &request).expect("it has equations");
        let view = View {
            tables: &module.tables,
            function: &module.functions[0],
        };
        rounding(view, &States::new(1), 64)
    };
    let bodies = of(Formulation::from_name("recursive").expect("it exists"));
    let one_frame = of(Formulation::from_name("prefix-serial").expect("it exists"));
    assert_eq!(
        MedianChange::relative(&bodies, &one_frame).trend,
        Trend::Worse
    );
    assert_eq!(
        MedianChange::relative(&one_frame, &bodies).trend,
        Trend::Better
    );
}
