//! `robovec trig`: what series for sines and cosines do to the outputs.

use super::flags::{SEED, real, states, whole};
use super::output::result_files;
use super::{CommandFailure, input, output};
use clap::{Args, ValueEnum};
use robovec_explore::trigonometry::{self, TrigonometryEffect, TrigonometrySetting};
use robovec_io::sources;
use robovec_ir::Format;
use robovec_ir::diagnostic::counted;
use robovec_num::trigonometry::{LARGEST_RANGE, MAX_ORDER};
use robovec_passes::trigonometry::CircularMethod;
use robovec_present::json::json_text;
use std::path::PathBuf;

/// Choice of polynomials.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
enum SeriesChoice {
    /// The series of Taylor, cut off
    Taylor,
    /// Fitted to the range
    Minimax,
}

/// Arguments of `trig`.
#[derive(Args, Debug)]
pub(super) struct TrigArguments {
    /// Files of equations, or models (.mbs, .urdf)
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Orders of the polynomials: the largest power of the angle
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', default_value = "1,3,5,7",
          add = whole(1, MAX_ORDER as u64, "coefficients of higher powers are below the rounding of binary64"))]
    orders: Vec<u32>,
    /// Ranges of the joints: they move between minus and plus each, rad
    #[arg(long, value_name = "ANGLES", value_delimiter = ',',
          default_value = "0.01,0.1,0.5,1",
          add = real(1e-12, LARGEST_RANGE, "no series reaches larger angles"))]
    angles: Vec<f64>,
    /// Polynomials
    #[arg(long, value_enum, default_value_t = SeriesChoice::Taylor)]
    method: SeriesChoice,
    /// Number of times angles are halved before the polynomials
    #[arg(long, value_name = "N", default_value_t = 0,
          add = whole(0, 16, "every halving doubles the rounding error and adds operations"))]
    halvings: u32,
    /// Format the outputs are computed in: f32, f64, float(8,17) ...
    #[arg(long, value_name = "FORMAT", default_value = "f32")]
    number: Format,
    /// Machine whose cycles the longest path is counted in
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Only this function; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Random states of every range
    #[arg(long, default_value_t = 100,
          add = states(1, 100_000))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Folder for trig.csv, trig.json and trig.svg
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub(super) fn run(arguments: &TrigArguments) -> Result<String, CommandFailure> {
    let machine = input::machine(&arguments.machine)?;
    let setting = TrigonometrySetting {
        method: match arguments.method {
            SeriesChoice::Taylor => CircularMethod::Taylor,
            SeriesChoice::Minimax => CircularMethod::Minimax,
        },
        orders: arguments.orders.clone(),
        angles: arguments.angles.clone(),
        halvings: arguments.halvings,
        format: arguments.number,
        states: arguments.states,
        seed: arguments.seed,
    };
    let mut effects: Vec<TrigonometryEffect> = Vec::new();
    let mut text = format!(
        "Errors in {} over {}, seed {}: the largest of an array over its largest \
         element; those of sin and cos are proved bounds.\n",
        setting.format,
        counted(setting.states, "random state"),
        setting.seed
    );
    for path in &arguments.files {
        let function = arguments.function.as_deref();
        let read = input::equations_or_model(path, None, function)?;
        let mut module = read.without_ranges("trig")?;
        if let Some(wanted) = function {
            super::opt::select(&mut module, wanted)?;
        }
        let model = if sources::is_model_path(path) {
            Some(input::model(path)?.model)
        } else {
            None
        };
        let measured = trigonometry::measure(
            &input::stem(path),
            &module,
            model.as_ref(),
            &machine,
            &setting,
        )
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
        for effect in &measured {
            text.push('\n');
            text += &trigonometry::text(effect);
        }
        effects.extend(measured);
    }
    if let Some(folder) = &arguments.output {
        let table = trigonometry::table(&effects);
        let figure = trigonometry::figure(&effects);
        let files = result_files(&table, json_text(&table), &figure);
        output::write_files(folder, &files)?;
    }
    Ok(text)
}
