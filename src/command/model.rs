//! `robovec model`: models to look at and to start from.

use super::flags::{FlagLimit, SEED};
use super::{CommandFailure, base_parameters, input, output};
use crate::command::emit;
use clap::Args;
use robovec_dynamics::generate::Options;
use robovec_dynamics::stale;
use robovec_io::files::Replace;
use robovec_ir::diagnostic::{Diagnostic, Label, Report, Severity, suggestion};
use robovec_model::Model;
use robovec_model::family::{self, ModelFamily};
use robovec_model::mbs::{unsayable, write_mbs};
use robovec_model::summary::summarise;
use robovec_present::json::json_text;
use std::path::PathBuf;

/// The joints of a family that is given no number.
const DEFAULT_JOINTS: usize = 23;

/// Arguments of `model`.
#[derive(Args, Debug)]
pub(super) struct ModelArguments {
    /// A .mbs, .urdf or .xml file to summarise, or a family to write a model of: serial,
    /// semi-serial, parallel, thesis-70, random, bogie, train,
    /// double-pendulum, four-bar, slider-crank, quarter-car
    #[arg(value_name = "FILE|FAMILY")]
    subject: PathBuf,
    /// Number of joints of a serial, semi-serial, parallel or random model
    #[arg(long, add = FlagLimit(family::JOINTS))]
    joints: Option<usize>,
    /// Seed of the parameters
    #[arg(long, add = SEED)]
    seed: Option<u64>,
    /// File for the model as compact .mbs text; a model of a family is written
    /// to the standard output by default
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Check whether these files of equations still belong to the model; exit
    /// code 1 when one must be generated again
    #[arg(long, value_name = "FILES", num_args = 1.., conflicts_with = "output")]
    equations: Vec<PathBuf>,
    /// Print the base parameters: the fewest combinations of masses, first
    /// moments and moments of inertia that determine the forces of joints
    #[arg(long, conflicts_with_all = ["output", "equations"])]
    base_parameters: bool,
    /// Write the map from all parameters to the base parameters as JSON
    #[arg(long, requires = "base_parameters", conflicts_with = "csv")]
    json: bool,
    /// Write the map as a CSV table
    #[arg(long, requires = "base_parameters")]
    csv: bool,
}

pub(super) fn run(arguments: &ModelArguments) -> Result<String, CommandFailure> {
    let name = arguments.subject.to_string_lossy();
    if let Some(family) = ModelFamily::from_name(&name) {
        let model = member(family, arguments)?;
        if arguments.base_parameters {
            return of_base(&model, arguments);
        }
        return write(&model, arguments);
    }
    if arguments.subject.extension().is_none() && !arguments.subject.exists() {
        return Err(unknown(&name));
    }
    if arguments.joints.is_some() || arguments.seed.is_some() {
        return Err(CommandFailure::plain(
            "--joints and --seed are for families; this is a file",
        ));
    }
    let read = input::model(&arguments.subject)?;
    match &arguments.output {
        Some(_) => write(&read.model, arguments),
        None if arguments.base_parameters => of_base(&read.model, arguments),
        None if !arguments.equations.is_empty() => freshness(&read.model, &arguments.equations),
        None => Ok(summarise(&read.model)),
    }
}

fn of_base(model: &Model, arguments: &ModelArguments) -> Result<String, CommandFailure> {
    let found = base_parameters::find(model, &Options::default())?;
    let table = || base_parameters::table(model, &found);
    Ok(if arguments.json {
        json_text(&table())
    } else if arguments.csv {
        table().to_csv()
    } else {
        base_parameters::text(model, &found)
    })
}

/// One line for each file of equations; a failure when one is stale.
fn freshness(model: &Model, files: &[PathBuf]) -> Result<String, CommandFailure> {
    let mut lines = String::new();
    let mut report = Report::new();
    let mut unreadable = 0;
    for path in files {
        let input = match input::equations_or_stubs(path, None) {
            Ok(input) => input,
            Err(failure) if files.len() == 1 => return Err(failure),
            Err(failure) => {
                failure.emit();
                unreadable += 1;
                continue;
            }
        };
        let comparison = stale::compare(model, &input.module);
        let verdict = if comparison.is_stale() {
            "stale".to_owned()
        } else if comparison.equal.is_empty() {
            "nothing to compare".to_owned()
        } else {
            format!("belongs to the model: {}", comparison.equal.join(", "))
        };
        lines += &format!("{}: {verdict}\n", input.name);
        let text = input.text().unwrap_or_default();
        let file = report.add_file(&input.name, text);
        for finding in comparison.findings {
            let severity = if finding.stale {
                Severity::Error
            } else {
                Severity::Warning
            };
            let mut diagnostic = Diagnostic::new(severity)
                .with_message(format!("{}: {}", input.name, finding.message))
                .with_note(format!("help: {}", finding.help));
            if let Some(place) = finding.place {
                let range = report.range_of(file, place);
                diagnostic = diagnostic.with_label(Label::primary(file, range));
            }
            report.push(diagnostic);
        }
    }
    if unreadable > 0 {
        report.push(Diagnostic::error().with_message(format!(
            "{unreadable} of {} files cannot be compared, because they are not equations",
            files.len()
        )));
    }
    if !report.has_errors() {
        emit(&report);
        return Ok(lines);
    }
    output::write_stdout(|stdout| stdout.write_all(lines.as_bytes()))?;
    Err(CommandFailure(report))
}

fn unknown(name: &str) -> CommandFailure {
    let names: Vec<&str> = ModelFamily::ALL
        .iter()
        .map(|family| family.name())
        .collect();
    let mut notes = Vec::new();
    notes.extend(suggestion(name, names.iter().copied()));
    notes.push(format!(
        "families: {}; or a .mbs, .urdf or .xml file",
        names.join(", ")
    ));
    CommandFailure::advised(format!("there is no file or family '{name}'"), notes)
}

fn member(family: ModelFamily, arguments: &ModelArguments) -> Result<Model, CommandFailure> {
    let joints = match (family.joints(), arguments.joints) {
        (Some(only), Some(asked)) if asked != only => {
            return Err(CommandFailure::plain(format!(
                "a {} always has {only} joints, not {asked}",
                family.name()
            )));
        }
        (Some(only), _) => only,
        (None, asked) => asked.unwrap_or(DEFAULT_JOINTS),
    };
    if arguments.seed.is_some() && !family.is_seeded() {
        return Err(CommandFailure::plain(format!(
            "the parameters of a {} are fixed: --seed has no effect",
            family.name()
        )));
    }
    Ok(family.build(joints, arguments.seed.unwrap_or(1)))
}

fn write(model: &Model, arguments: &ModelArguments) -> Result<String, CommandFailure> {
    if let Some(reason) = unsayable(model) {
        return Err(CommandFailure::advised(
            format!("a .mbs file cannot hold '{}': {reason}", model.name),
            vec!["every command takes the file it comes from as a model".to_owned()],
        ));
    }
    let text = write_mbs(model);
    let Some(path) = &arguments.output else {
        return Ok(text);
    };
    // Models are edited by hand, so none is known to be robovec's still.
    output::write_over(path, Replace::Nothing, |writer| {
        writer.write_all(text.as_bytes())
    })?;
    warn_of_limits(model);
    Ok(String::new())
}

/// Warns of limits, losses and rotors of joints, which `.mbs` files cannot express.
fn warn_of_limits(model: &Model) {
    let limited = model.joints.iter().filter(|joint| joint.limits.is_some());
    let losing = model.joints.iter().filter(|joint| joint.law.are_there());
    let turning = model.joints.iter().filter(|joint| joint.armature != 0.0);
    let counts = [
        ("limits", limited.count()),
        ("damping, friction and springs", losing.count()),
        ("armature", turning.count()),
    ];
    let mut report = Report::new();
    for (what, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
        report.push(Diagnostic::warning().with_message(format!(
            "the {what} of {count} joints are left out: a .mbs file has no words for them"
        )));
    }
    emit(&report);
}
