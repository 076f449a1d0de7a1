//! `robovec stress`: hard cases, verdicts and cures.

use super::output::result_files;
use super::{CommandFailure, input, opt, output, progress};
use clap::Args;
use rayon::prelude::*;
use robovec_io::sources;
use robovec_ir::diagnostic::{clip, suggestion};
use robovec_present::json::json_text;
use robovec_present::text::{cut, headed, labelled};
use robovec_robotran::FunctionKind;
use robovec_stress::{CaseClass, Findings, StressCase, StressError};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Measure cases that are hard for floating point, find the cause of each
/// error, and try cures
#[derive(Args, Debug)]
pub(super) struct StressArguments {
    /// Model (.mbs, .urdf, .xml) or function in any language to drive to its hard
    /// states, in place of the cases that ship
    #[arg(value_name = "INPUT")]
    input: Option<PathBuf>,
    /// Only this function of the input
    #[arg(long, value_name = "NAME", requires = "input")]
    function: Option<String>,
    /// Scene (.scene.toml) with the ranges of a function's inputs
    #[arg(long, value_name = "FILE", requires = "input")]
    scene: Option<PathBuf>,
    /// Case to measure; repeat the option for several
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// Class whose cases are measured
    #[arg(long, value_name = "NAME", value_parser = classes())]
    class: Option<String>,
    /// List the cases, without measuring
    #[arg(long)]
    list: bool,
    /// Print only verdicts, without cures
    #[arg(long)]
    verdicts: bool,
    /// Folder for stress.csv, stress.json and stress.html
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

fn classes() -> clap::builder::PossibleValuesParser {
    CaseClass::ALL.map(|class| class.name).into()
}

pub(super) fn run(arguments: &StressArguments) -> Result<String, CommandFailure> {
    let cases = chosen(arguments)?;
    if arguments.list {
        return Ok(list(&cases));
    }
    let bar = progress::bar(cases.len(), "{pos}/{len} cases, {msg}");
    // The largest cases stand last in their classes: begun first, they leave
    // no core idle at the end.
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by_key(|&index| !cases[index].long);
    let mut found: Vec<(usize, Result<Findings, StressError>)> = order
        .into_par_iter()
        .with_max_len(1)
        .map(|index| {
            let case = &cases[index];
            let result = if arguments.verdicts {
                robovec_stress::judge(case)
            } else {
                robovec_stress::examine(case)
            };
            bar.set_message(case.name.clone());
            bar.inc(1);
            (index, result)
        })
        .collect();
    bar.finish_and_clear();
    found.sort_by_key(|(index, _)| *index);
    let mut findings = Vec::new();
    for (index, result) in found {
        let case = &cases[index];
        let result = result
            .map_err(|error| CommandFailure::plain(format!("case '{}': {error}", case.name)))?;
        findings.push((case, result));
    }
    if let Some(folder) = &arguments.output {
        write_files(folder, &findings)?;
    }
    let text = text(arguments, &findings);
    let complaints = complaints(arguments, &findings);
    if complaints.is_empty() {
        return Ok(text);
    }
    output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))?;
    Err(CommandFailure::advised(
        "some hard cases have changed".to_owned(),
        complaints,
    ))
}

/// The answer, the cases of the largest errors or all, and energies and gaps.
fn text(arguments: &StressArguments, findings: &[(&StressCase, Findings)]) -> String {
    let name = arguments.input.as_deref().and_then(Path::file_name);
    let title = name.map_or("hard cases".into(), |name| name.to_string_lossy());
    let mut text = headed(&title, &robovec_stress::headline(findings))
        + &labelled(&robovec_stress::lines(findings));
    if arguments.input.is_some() {
        text += "\n";
        for (case, _) in findings {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{:10} {}", case.name, cut(&case.construction, 69));
        }
    }
    let all = if progress::is_verbose() {
        robovec_stress::text(findings)
    } else {
        robovec_stress::worst(findings)
    };
    let more = [
        all,
        robovec_stress::steps(findings),
        robovec_stress::gaps(findings),
    ];
    for more in more.iter().filter(|more| !more.is_empty()) {
        text += &format!("\n{more}");
    }
    text
}

fn chosen(arguments: &StressArguments) -> Result<Vec<StressCase>, CommandFailure> {
    let mut cases = match &arguments.input {
        Some(path) => given(arguments, path)?,
        None => robovec_stress::cases(),
    };
    for name in &arguments.case {
        if !cases.iter().any(|case| case.name == *name) {
            let known = cases.iter().map(|case| case.name.as_str());
            let near = suggestion(name, known);
            let mut notes: Vec<String> = near.into_iter().collect();
            notes.push("'robovec stress --list' prints all cases".to_owned());
            let message = format!("there is no case '{}'", clip(name));
            return Err(CommandFailure::advised(message, notes));
        }
    }
    if !arguments.case.is_empty() {
        cases.retain(|case| arguments.case.contains(&case.name));
    }
    if let Some(class) = &arguments.class {
        cases.retain(|case| case.class.name == class);
    }
    if cases.is_empty() {
        let message = "no case of this class has one of these names".to_owned();
        return Err(CommandFailure::plain(message));
    }
    Ok(cases)
}

/// The cases of a model or a function.
fn given(arguments: &StressArguments, path: &Path) -> Result<Vec<StressCase>, CommandFailure> {
    if sources::is_model_path(path) && arguments.function.is_none() {
        let read = input::model_for(path, Some(FunctionKind::Dirdyna))?;
        let cases = robovec_stress::of_model(&read.model);
        return cases
            .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())));
    }
    let mut read = input::equations_or_model(path, None, arguments.function.as_deref())?;
    let scene = arguments.scene.as_deref().map(input::scene).transpose()?;
    let scene = input::scene_of(&read, scene.map(|file| file.scene));
    let name = path.to_string_lossy();
    opt::select_one(&mut read.module, &name, arguments.function.as_deref())?;
    Ok(robovec_stress::of_function(
        &read.module,
        &input::states(scene.as_ref(), 1),
    ))
}

fn list(cases: &[StressCase]) -> String {
    let mut text = String::new();
    for class in CaseClass::ALL {
        let of_class = || cases.iter().filter(|case| case.class == class);
        if of_class().next().is_none() {
            continue;
        }
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}: {}", class.name, class.description);
        let width = of_class().map(|case| case.name.len()).fold(0, usize::max);
        for case in of_class() {
            let breaks = match case.breaks.as_str() {
                "" => String::new(),
                breaks => format!("; breaks {breaks}"),
            };
            let _ = writeln!(
                text,
                "  {:width$}  {}{breaks}",
                case.name, case.construction
            );
        }
    }
    text
}

fn write_files(
    folder: &std::path::Path,
    findings: &[(&StressCase, Findings)],
) -> Result<(), CommandFailure> {
    let table = robovec_stress::table(findings);
    let mut files = result_files(&table, json_text(&table), &robovec_stress::figure(findings));
    files.push(("stress.html".to_owned(), robovec_stress::page(findings)));
    output::write_files(folder, &files)
}

/// Faults: verdicts, and classes without a cure.
fn complaints(arguments: &StressArguments, findings: &[(&StressCase, Findings)]) -> Vec<String> {
    let mut complaints = Vec::new();
    for (case, found) in findings {
        if let Some(expected) = case.expected.filter(|expected| found.verdict != *expected) {
            complaints.push(format!(
                "the verdict on '{}' is '{}', expected was '{expected}'",
                case.name, found.verdict
            ));
        }
    }
    if arguments.verdicts || arguments.input.is_some() {
        return complaints;
    }
    for class in CaseClass::ALL {
        let mut of_class = findings.iter().filter(|(case, _)| case.class == class);
        let cured = of_class.clone().any(|(_, found)| found.cure.is_some());
        if of_class.next().is_some() && !cured {
            complaints.push(format!("no case of the class '{}' is cured", class.name));
        }
    }
    complaints
}
