//! Errors of every output in any formats, and after every pass.

use super::{ErrorAnswer, ErrorArguments, ErrorSetting, ErrorSubject, chosen};
use crate::command::flags::whole;
use crate::command::output::result_files;
use crate::command::{CommandFailure, input, progress};
use clap::Args;
use indicatif::ProgressBar;
use robovec_analysis::accuracy::{Measurement, measure};
use robovec_analysis::reference::ReferenceEffort;
use robovec_analysis::rounding::usual_states;
use robovec_error::accuracy::outputs::{self, OutputLine};
use robovec_error::accuracy::{self, FunctionAccuracy, Options};
use robovec_ir::states::States;
use robovec_ir::{Format, Input, Module};
use robovec_num::hexadecimal;
use robovec_present::json::json_text;
use std::fmt::Write;

/// Options of the measurement of every output.
#[derive(Args, Debug)]
pub(super) struct MeasureArguments {
    /// Arithmetic of the exact results: double-double, certified (proved to the
    /// last bit of binary64), audit (all in arbitrary precision)
    #[arg(long, value_name = "EFFORT", conflicts_with_all = ["attribution", "series"],
          default_value_t = ReferenceEffort::Certified)]
    reference: ReferenceEffort,
    /// Print the inputs of one state, as `robovec eval --states` reads them
    #[arg(long, value_name = "N",
          conflicts_with_all = ["attribution", "series", "json", "csv", "output"],
          add = whole(0, 1_000_000_000, "states are drawn by their number"))]
    print_state: Option<u32>,
}

/// Maximum steps of reverse sweeps for condition numbers: a few seconds.
const CONDITION_WORK: u64 = 2_000_000_000;

/// Default number of outputs printed per format.
const USUAL_TOP: usize = 20;

pub(super) fn run(
    arguments: &ErrorArguments,
    setting: &ErrorSetting,
) -> Result<ErrorAnswer, CommandFailure> {
    let bar = progress::bar(arguments.files.len(), "{pos}/{len} files, {msg}");
    let mut after_passes: Vec<FunctionAccuracy> = Vec::new();
    let mut text = String::new();
    let mut lines = Vec::new();
    for path in &arguments.files {
        let mut subject = setting.subject(arguments, path)?;
        if arguments.passes.is_some() && arguments.measure.print_state.is_none() {
            let measured = each_pass(&mut subject, arguments, setting, &bar)?;
            for one in &measured {
                text += &accuracy::text(one);
                text.push('\n');
            }
            after_passes.extend(measured);
        } else {
            setting.transform(&mut subject)?;
        }
        let states = input::states(subject.scene.as_ref(), arguments.seed);
        match arguments.measure.print_state {
            Some(state) => text += &state_text(&subject.read.module, &states, state),
            None => every_output(&subject, arguments, &states, (&mut text, &mut lines))?,
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if after_passes.len() > 1 {
        text += &accuracy::summary(&after_passes);
    }
    let (csv, json) = (outputs::csv(&lines), json_text(&lines));
    let mut files = vec![
        ("outputs.csv".to_owned(), csv.clone()),
        ("outputs.json".to_owned(), json.clone()),
    ];
    if !after_passes.is_empty() {
        let table = accuracy::table(&after_passes);
        let figure = accuracy::figure(&after_passes);
        files.extend(result_files(&table, json_text(&table), &figure));
    }
    Ok(ErrorAnswer {
        text,
        csv,
        json,
        files,
    })
}

/// Runs the passes and measures errors after each of them.
fn each_pass(
    subject: &mut ErrorSubject,
    arguments: &ErrorArguments,
    setting: &ErrorSetting,
    bar: &ProgressBar,
) -> Result<Vec<FunctionAccuracy>, CommandFailure> {
    let options = Options {
        // 0 is the usual number for the size of the function.
        states: arguments.states.unwrap_or(0),
        seed: arguments.seed,
        scene: subject.scene.as_ref(),
    };
    let name = &subject.name;
    let mut progress = |done: usize, total: usize, pass: &str| {
        bar.set_message(format!("{name}: {pass} ({done}/{total})"));
    };
    let module = &mut subject.read.module;
    let (pipeline, machine) = (&setting.pipeline, &setting.machine);
    accuracy::measure(name, module, pipeline, machine, options, &mut progress)
        .map_err(|error| subject.failure(&error.to_string()))
}

fn every_output(
    subject: &ErrorSubject,
    arguments: &ErrorArguments,
    states: &States,
    (text, lines): (&mut String, &mut Vec<OutputLine>),
) -> Result<(), CommandFailure> {
    let usual = [Format::BINARY32, Format::BINARY64];
    let formats = arguments.formats(&usual);
    let measurement = Measurement {
        effort: arguments.measure.reference,
        sensitivities: true,
        condition_work: CONDITION_WORK,
    };
    for (name, view) in subject.functions() {
        let function = view.function;
        let count = arguments.states;
        let count = count.unwrap_or_else(|| usual_states(function.nodes().len()));
        let mut found = measure(view, states, count, formats, measurement);
        if let Some(list) = &arguments.outputs {
            let wanted: Vec<_> = chosen(view, list)?
                .iter()
                .map(|&place| function.assignments[place].output)
                .collect();
            for format in &mut found.formats {
                format.elements.retain(|one| wanted.contains(&one.output));
            }
        }
        *text += &outputs::text(&name, view, &found, arguments.top.unwrap_or(USUAL_TOP));
        lines.extend(outputs::lines(&name, view, &found));
    }
    Ok(())
}

/// The inputs of all functions in a state, with the same numbers in all.
fn state_text(module: &Module, states: &States, state: u32) -> String {
    let mut text = format!("# state {state} of seed {}\nstate\n", states.seed());
    let mut seen: Vec<String> = Vec::new();
    for function in &module.functions {
        let view = module.tables.view(function);
        let numbers = states.draw(view, state);
        let first = seen.len();
        for (place, number) in numbers.into_iter().enumerate() {
            let (array, indices, rank) = function.input_element(Input(place as u32));
            let mut name = module.tables.symbols.text(array.name).to_owned();
            if rank > 0 {
                let indices: Vec<String> =
                    indices[..rank].iter().map(ToString::to_string).collect();
                // Writing to a string cannot fail.
                let _ = write!(name, "[{}]", indices.join(","));
            }
            if seen[..first].binary_search(&name).is_err() {
                let _ = writeln!(text, "{name} {}", hexadecimal::format(number));
                seen.push(name);
            }
        }
        seen.sort_unstable();
    }
    text
}
