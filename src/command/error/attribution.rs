//! Errors of one state attributed to equations, and bounds.

use super::{ErrorAnswer, ErrorArguments, ErrorSetting, chosen};
use crate::command::CommandFailure;
use crate::command::flags::{FlagChoice, choice, whole};
use crate::command::input;
use clap::Args;
use robovec_analysis::interval::GivenData;
use robovec_analysis::stochastic;
use robovec_error::errors::{self, ErrorMethod, ErrorSettings, ErrorTable};
use robovec_ir::{Format, View};

/// Options of `--blame` and `--prove`.
#[derive(Args, Debug)]
#[command(next_help_heading = "With --blame and --prove")]
pub(super) struct AttributionArguments {
    /// Methods to estimate the error of every output; by default bound, predict
    /// and, where the format is narrow enough, stochastic; with --prove proof
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        value_enum,
        requires = "attribution"
    )]
    method: Option<Vec<ErrorMethod>>,
    /// State of the table, counted from 0
    #[arg(long, default_value_t = 0, requires = "attribution",
          add = whole(0, 1_000_000_000, "states are drawn by their number"))]
    state: u32,
    /// Number of operations in a window, for the method interval
    #[arg(long, default_value_t = 1000, requires = "attribution",
          add = whole(1, 100_000, "intervals over more operations are useless"))]
    window: u32,
    /// Number of states from which the ranges of intermediate values are
    /// estimated, for the method interval
    #[arg(long, default_value_t = 32, requires = "attribution",
          add = whole(1, 10_000, "the function is evaluated at every state, and all values are kept"))]
    samples: u32,
    /// Maximum number of boxes into which the ranges of a window are cut, for
    /// the method interval
    #[arg(long, default_value_t = 20000, requires = "attribution",
          add = whole(1, 1_000_000, "all operations of the window are enclosed in every box"))]
    boxes: u32,
    /// Number of times the usual number of states of the search, for the method
    /// proof
    #[arg(long, default_value_t = 1, requires = "attribution",
          add = whole(1, 1_000, "the usual search takes some seconds"))]
    effort: u32,
    /// Kind of inputs and literals for the methods proof and interval: real numbers
    /// that are rounded first, or numbers of the format
    #[arg(long, value_name = "WHAT", value_parser = choice(&DATA), default_value = "real",
        requires = "attribution")]
    data: GivenData,
}

/// Kinds of inputs and literals before the run.
const DATA: [FlagChoice<GivenData>; 2] = [
    (
        &["held"],
        "Inputs are numbers of the format, literals of binary64",
        GivenData::Held,
    ),
    (
        &["real"],
        "Inputs are real numbers, literals are the decimals as written",
        GivenData::Real,
    ),
];

/// Methods of `--blame`; the last one has formats it cannot sample.
const BLAME: [ErrorMethod; 3] = [
    ErrorMethod::Bound,
    ErrorMethod::Predict,
    ErrorMethod::Stochastic,
];

const PROVE: [ErrorMethod; 1] = [ErrorMethod::Proof];

/// Maximum cost of differentiating all outputs, in values times outputs; where
/// it would be more, matrices are left out unless they are requested.
const WORK: usize = 1 << 31;

/// Equations named as the hottest.
const USUAL_TOP: usize = 12;

/// Attributes the errors of all files.
pub(super) fn run(
    arguments: &ErrorArguments,
    setting: &ErrorSetting,
) -> Result<ErrorAnswer, CommandFailure> {
    let mut tables = Vec::new();
    let mut remarks = String::new();
    for path in &arguments.files {
        let mut subject = setting.subject(arguments, path)?;
        setting.transform(&mut subject)?;
        let usual = [subject.read.format.unwrap_or(Format::BINARY32)];
        for &format in arguments.formats(&usual) {
            let (methods, remark) = methods(arguments, format);
            remarks += &remark;
            for (_, view) in subject.functions() {
                let options = &arguments.attribution;
                let settings = ErrorSettings {
                    format,
                    states: input::states(subject.scene.as_ref(), arguments.seed),
                    state: options.state,
                    blamed: arguments.states.unwrap_or(1),
                    methods: methods.clone(),
                    outputs: outputs(view, arguments.outputs.as_deref())?,
                    most_equations: arguments.top.unwrap_or(USUAL_TOP),
                    window: options.window as usize,
                    samples: options.samples,
                    boxes: options.boxes as usize,
                    effort: options.effort,
                    data: options.data,
                };
                let table = ErrorTable::measure(view, &settings).map_err(|error| {
                    let help = "leave it out: --method bound,predict".to_owned();
                    CommandFailure::advised(format!("method stochastic: {error}"), vec![help])
                })?;
                tables.push(table);
            }
        }
    }
    let texts: Vec<String> = tables.iter().map(errors::text).collect();
    let (csv, json) = (errors::csv(&tables), errors::json(&tables));
    Ok(ErrorAnswer {
        text: texts.join("\n") + &remarks,
        files: vec![
            ("errors.csv".to_owned(), csv.clone()),
            ("errors.json".to_owned(), json.clone()),
        ],
        csv,
        json,
    })
}

/// Methods for a format, and a remark on one that was left out.
fn methods(arguments: &ErrorArguments, format: Format) -> (Vec<ErrorMethod>, String) {
    if let Some(methods) = &arguments.attribution.method {
        return (methods.clone(), String::new());
    }
    let mut methods = Vec::new();
    if arguments.blame {
        methods.extend(BLAME);
    }
    if arguments.prove {
        methods.extend(PROVE);
    }
    methods.sort_unstable();
    methods.dedup();
    let mut remark = String::new();
    if let (true, Err(reason)) = (arguments.blame, stochastic::supports(format)) {
        methods.retain(|method| *method != ErrorMethod::Stochastic);
        remark = format!("\nno sigma: {reason}\n");
    }
    (methods, remark)
}

/// The assignments whose errors are attributed: listed ones, else usual ones.
fn outputs(view: View<'_>, list: Option<&str>) -> Result<Vec<usize>, CommandFailure> {
    if let Some(list) = list {
        return chosen(view, list);
    }
    let function = view.function;
    let all = 0..function.assignments.len();
    if all.len().saturating_mul(function.nodes().len()) > WORK {
        let is_vector = |&place: &usize| {
            let output = function.assignments[place].output;
            function.output_element(output).2 <= 1
        };
        let vectors: Vec<usize> = all.clone().filter(is_vector).collect();
        if !vectors.is_empty() {
            return Ok(vectors);
        }
    }
    Ok(all.collect())
}
