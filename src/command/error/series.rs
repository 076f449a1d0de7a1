//! Errors of series for sines and cosines.

use super::{ErrorAnswer, ErrorArguments, ErrorSetting};
use crate::command::flags::{FlagChoice, choice, real, whole};
use crate::command::output::result_files;
use crate::command::{CommandFailure, input};
use clap::Args;
use robovec_explore::trigonometry::{self, TrigonometryEffect, TrigonometrySetting};
use robovec_io::sources;
use robovec_ir::Format;
use robovec_ir::diagnostic::counted;
use robovec_num::trigonometry::{LARGEST_RANGE, MAX_ORDER};
use robovec_passes::trigonometry::CircularMethod;
use robovec_present::json::json_text;

/// Polynomials, by the method that makes them.
const POLYNOMIALS: [FlagChoice<CircularMethod>; 2] = [
    (&["taylor"], "Taylor series", CircularMethod::Taylor),
    (&["minimax"], "Fitted to the range", CircularMethod::Minimax),
];

/// Options of `--series`.
#[derive(Args, Debug)]
#[command(next_help_heading = "With --series")]
pub(super) struct SeriesArguments {
    /// Orders of the polynomials: the largest power of the angle
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', default_value = "1,3,5,7",
          requires = "series",
          add = whole(1, MAX_ORDER as u64, "coefficients of higher powers are below the rounding of binary64"))]
    orders: Vec<u32>,
    /// Ranges of the joints: they move between minus and plus each of these
    /// angles, rad
    #[arg(long, value_name = "ANGLES", value_delimiter = ',', requires = "series",
          default_value = "0.01,0.1,0.5,1",
          add = real(1e-12, LARGEST_RANGE, "no series is accurate for larger angles"))]
    angles: Vec<f64>,
    /// Polynomials
    #[arg(long, value_parser = choice(&POLYNOMIALS), requires = "series",
        default_value = "taylor")]
    polynomials: CircularMethod,
    /// Number of times angles are halved before the polynomials
    #[arg(long, value_name = "N", requires = "series", default_value_t = 0,
          add = whole(0, 16, "every halving doubles the rounding error and adds operations"))]
    halvings: u32,
}

/// Random states of every range.
const USUAL_STATES: u32 = 100;

pub(super) fn run(
    arguments: &ErrorArguments,
    setting: &ErrorSetting,
) -> Result<ErrorAnswer, CommandFailure> {
    let series = &arguments.of_series;
    let [format] = arguments.formats(&[Format::BINARY32])[..] else {
        return Err(CommandFailure::plain(
            "--series measures one format at a time, and --number gives several",
        ));
    };
    let question = TrigonometrySetting {
        method: series.polynomials,
        orders: series.orders.clone(),
        angles: series.angles.clone(),
        halvings: series.halvings,
        format,
        states: arguments.states.unwrap_or(USUAL_STATES),
        seed: arguments.seed,
    };
    let mut effects: Vec<TrigonometryEffect> = Vec::new();
    let mut text = format!(
        "Errors in {} over {}, seed {}: the largest of an array over its largest \
         element; those of sin and cos are proved bounds.\n",
        question.format,
        counted(question.states, "random state"),
        question.seed
    );
    for path in &arguments.files {
        let mut subject = setting.subject(arguments, path)?;
        setting.transform(&mut subject)?;
        let failure = |error: String| CommandFailure::plain(format!("{}: {error}", path.display()));
        let module = input::without_ranges(subject.read, "error --series")?;
        let model = if sources::is_model_path(path) {
            Some(input::model(path)?.model)
        } else {
            None
        };
        let (name, machine) = (&subject.name, &setting.machine);
        let measured = trigonometry::measure(name, &module, model.as_ref(), machine, &question)
            .map_err(|error| failure(error.to_string()))?;
        for effect in &measured {
            text.push('\n');
            text += &trigonometry::text(effect);
        }
        effects.extend(measured);
    }
    let table = trigonometry::table(&effects);
    let json = json_text(&table);
    Ok(ErrorAnswer {
        text,
        csv: table.to_csv(),
        files: result_files(&table, json.clone(), &trigonometry::figure(&effects)),
        json,
    })
}
