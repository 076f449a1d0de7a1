//! `robovec accuracy --outputs`: the errors of every output.

use super::accuracy::AccuracyArguments;
use super::flags::whole;
use super::{CommandFailure, input, output};
use clap::Args;
use robovec_analysis::accuracy::{Measurement, measure};
use robovec_analysis::reference::ReferenceEffort;
use robovec_analysis::rounding::usual_states;
use robovec_error::accuracy::outputs;
use robovec_framework::manager::{self, Config};
use robovec_ir::states::States;
use robovec_ir::{Format, Input, Module, View};
use robovec_num::hexadecimal;
use robovec_present::json::json_text;
use std::fmt::Write;
use std::io;
use std::path::PathBuf;

/// Measures of every output.
#[derive(Args, Debug)]
pub(super) struct OutputArguments {
    /// Measure every output, in all measures, instead of comparing passes
    #[arg(long)]
    pub(super) outputs: bool,
    /// Number formats to measure
    #[arg(long = "number", alias = "formats", value_name = "FORMATS", requires = "outputs",
          default_value = "f32,f64", value_parser = formats)]
    formats: FormatList,
    /// Reference of the outputs: double-double, certified (proved to the last
    /// bit of binary64), audit (all in arbitrary precision)
    #[arg(long, value_name = "EFFORT", requires = "outputs",
          default_value_t = ReferenceEffort::Certified)]
    reference: ReferenceEffort,
    /// Ranges of the inputs, from a scene
    #[arg(long, value_name = "FILE", requires = "outputs")]
    scene: Option<PathBuf>,
    /// Outputs shown for each format: those with the largest mixed errors
    #[arg(long, value_name = "N", requires = "outputs", default_value_t = 20,
          add = whole(0, 1_000_000, "every one is a line of the result"))]
    most: usize,
    /// Print the inputs of one state, as `robovec eval --states` reads them
    #[arg(long, value_name = "N", requires = "outputs",
          add = whole(0, 1_000_000_000, "states are drawn by their number"))]
    print_state: Option<u32>,
}

/// Formats in the order they were asked for.
#[derive(Clone, Debug)]
struct FormatList(Vec<Format>);

/// Reads formats separated by commas; those inside parentheses belong to a
/// format.
fn formats(text: &str) -> Result<FormatList, String> {
    let mut depth = 0u32;
    let separates = |character: char| {
        match character {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        character == ',' && depth == 0
    };
    let parsed = text.split(separates).map(|name| {
        let format = name.parse::<Format>();
        format.map_err(|error| format!("'{}': {error}", name.trim()))
    });
    parsed.collect::<Result<_, _>>().map(FormatList)
}

/// Steps of reverse sweeps for condition numbers: a few seconds.
const CONDITION_WORK: u64 = 2_000_000_000;

/// Runs the command.
pub(super) fn run(arguments: &AccuracyArguments) -> Result<String, CommandFailure> {
    let options = &arguments.of_outputs;
    let pipeline = input::passes_or_empty(arguments.passes.as_deref())?;
    let machine = input::machine(&arguments.machine)?;
    let given = options.scene.as_deref().map(input::scene).transpose()?;
    let given = given.map(|file| file.scene);
    let mut text = String::new();
    let mut lines = Vec::new();
    for path in &arguments.files {
        let function = arguments.function.as_deref();
        let mut read = input::equations_or_model(path, None, function)?;
        if let Some(wanted) = function {
            super::opt::select(&mut read.module, wanted)?;
        }
        let scene = read.scene(given.clone());
        let states = input::states(scene.as_ref(), arguments.seed);
        let module = &mut read.module;
        let mut log = io::sink();
        let config = Config {
            scene: scene.as_ref(),
            ..Config::new(&machine, &mut log)
        };
        manager::run(module, &pipeline, config)
            .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
        if let Some(state) = options.print_state {
            text += &state_text(module, &states, state);
            continue;
        }
        let stem = input::stem(path);
        let measurement = Measurement {
            effort: options.reference,
            sensitivities: true,
            condition_work: CONDITION_WORK,
        };
        for function in &module.functions {
            let name = match module.functions.len() {
                1 => stem.clone(),
                _ => format!("{} {}", stem, function.name),
            };
            let view = View {
                tables: &module.tables,
                function,
            };
            let count = match arguments.states {
                0 => usual_states(function.nodes().len()),
                count => count,
            };
            let accuracy = measure(view, &states, count, &options.formats.0, measurement);
            text += &outputs::text(&name, view, &accuracy, options.most);
            lines.extend(outputs::lines(&name, view, &accuracy));
        }
    }
    if let Some(folder) = &arguments.output {
        let files = [
            ("outputs.csv", outputs::csv(&lines)),
            ("outputs.json", json_text(&lines)),
        ];
        output::write_files(folder, &files)?;
    }
    Ok(text)
}

/// The inputs of all functions in a state. Elements that several functions
/// take are the same in all of them.
fn state_text(module: &Module, states: &States, state: u32) -> String {
    let mut text = format!("# state {state} of seed {}\nstate\n", states.seed());
    let mut seen: Vec<String> = Vec::new();
    for function in &module.functions {
        let view = View {
            tables: &module.tables,
            function,
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_with_commas_of_their_own_are_read() {
        let FormatList(found) =
            formats("f32, float(8,17) ,fixed(12,19)").expect("they are formats");
        let names: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["f32", "float(8,17)", "fixed(12,19)"]);
        for text in ["", "f32,,f64", "float(8", "f32)"] {
            assert!(formats(text).is_err(), "{text}");
        }
    }
}
