//! Results of a search, printed and written.

use super::OptimiseArguments;
use super::given::GivenStarts;
use crate::command::output::{self, result_files};
use crate::command::{CommandFailure, progress};
use robovec_cgen::c;
use robovec_cgen::superword::SuperwordLanes;
use robovec_explore::optimise::answer::{self, OptimisationAnswer};
use robovec_explore::optimise::text::OptimisationPage;
use robovec_explore::optimise::{
    OptimisationPoint, OptimisationQuestion, OptimisationTarget, Optimised, text,
};
use robovec_explore::program::{depending, transformed_by, view};
use robovec_framework::manager::{self, Config};
use robovec_io::files::Replace;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Module, print};
use robovec_passes::registry::REGISTRY;
use robovec_present::json::json_text;
use robovec_present::number::or_nothing;
use robovec_present::text::{WIDTH, cut, headed, labelled};
use robovec_robotran::Language;
use robovec_robotran::drop_in::{DropInOptions, drop_in};
use robovec_robotran::write::{WriteOptions, write as write_equations};
use serde::Serialize;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Writes the chosen program, and reports it.
pub(super) fn report(
    arguments: &OptimiseArguments,
    given: &GivenStarts,
    question: &OptimisationQuestion<'_>,
    found: &Optimised,
) -> Result<String, CommandFailure> {
    let answer = OptimisationAnswer::of(found, question);
    let commands = commands(arguments, given, found);
    let subject = subject(arguments, found);
    let mut lines = answer.lines();
    let mut of_page = lines.clone();
    of_page.extend(left_out(given, |why| cut(why, REASON)));
    lines.extend(left_out(given, short_reason));
    let (last, rest) = match &arguments.output {
        None => {
            let again = "run again with '-o FOLDER', which writes it".to_owned();
            (vec![("use it", again)], String::new())
        }
        Some(folder) => {
            let mut files = program_files(question, found)?;
            files.extend(in_its_language(arguments, found));
            // The page lies in the folder; the terminal does not.
            let uses = |place| {
                if answer.is_slower() {
                    vec![("use it", format!("keep {}: it is faster", arguments.input))]
                } else {
                    uses(arguments, place, &files)
                }
            };
            of_page.extend(uses(Path::new("")));
            let last = uses(folder);
            files.push(("commands.txt".to_owned(), commands.clone()));
            if !is_input(arguments, found) {
                let start = print::print_module(&given.starts[found.start].module);
                files.push((START.to_owned(), start));
            }
            let code = code(arguments, given, found, &files);
            let texts = OptimisationPage {
                subject: &subject,
                answer: &answer,
                lines: &of_page,
                commands: &commands,
                code: code
                    .each_ref()
                    .map(|(name, text)| (name.as_str(), text.as_str())),
            };
            files.extend(results(found, &given.left, &texts));
            write(folder, &files)?;
            let pages = folder.join(PAGE);
            (
                last,
                format!("\nall of them: {}, optimise.csv", pages.display()),
            )
        }
    };
    let title = headed(&subject, &answer.headline());
    // Commands are copied: they are not folded.
    let last: String = (last.iter())
        .map(|(label, text)| format!("{label:<LABELS$}{text}\n"))
        .collect();
    // The table has the other choices as well, and the page everything.
    for label in [
        answer::OTHERS,
        answer::SCHEDULE,
        LEFT_OUT,
        answer::OPERATIONS,
        answer::ANY_STATE,
    ] {
        let parts = [&title, &labelled(&lines), &last];
        let height: usize = parts.iter().map(|part| part.lines().count()).sum();
        if height > SCREEN - FRAME - LEAST_ROWS {
            lines.retain(|(other, _)| *other != label);
        }
    }
    let head = title + &labelled(&lines) + &last;
    let rows = SCREEN.saturating_sub(head.lines().count() + FRAME);
    let table = text::front_table(found, answer.measure, rows);
    let mut text = format!("{head}\n{table}\n{}{rest}\n", text::numbers(found));
    if progress::is_verbose() {
        text += &format!("\n{}\n\nto make it again:\n{commands}", text::table(found));
        if given.scene.is_some() {
            text += "\n";
            text += &depending(view(&found.program));
        }
        for (name, reason) in &given.left {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "formulation {name} is left out: {reason}");
        }
    }
    Ok(text)
}

/// The file or model, and the function of a model.
fn subject(arguments: &OptimiseArguments, found: &Optimised) -> String {
    let input = Path::new(&arguments.input);
    let name = input
        .file_name()
        .unwrap_or(input.as_os_str())
        .to_string_lossy();
    let has_equations = input.extension().is_some_and(|extension| {
        let extension = extension.to_string_lossy();
        matches!(&*extension, "rvir" | "toml") || Language::from_extension(&extension).is_some()
    });
    if has_equations {
        return name.into_owned();
    }
    format!("{name} {}", found.program.functions[0].name)
}

/// Maximum number of lines of the report.
const SCREEN: usize = 20;
/// Lines of it around the rows of the table: its head, and blank ones.
const FRAME: usize = 6;
/// Minimum number of rows: the input and the program.
const LEAST_ROWS: usize = 2;
/// Width of the labels of the answer.
const LABELS: usize = "worst error  ".len();

/// Maximum number of characters of a reason on the page, and on the terminal.
const REASON: usize = 120;
const SHORT_REASON: usize = 34;

/// Label of formulations that take no part.
const LEFT_OUT: &str = "left out";

/// Formulations of the model that take no part, and why the first does not.
fn left_out(
    given: &GivenStarts,
    reason: impl Fn(&str) -> String,
) -> Option<(&'static str, String)> {
    let (_, why) = given.left.first()?;
    let names: Vec<&str> = given.left.iter().map(|(name, _)| name.as_str()).collect();
    let names = match names.as_slice() {
        [name] => (*name).to_owned(),
        names => counted(names.len(), "formulation"),
    };
    Some((LEFT_OUT, format!("{names}: {}", reason(why))))
}

/// The first part of a reason, for one line of the terminal.
fn short_reason(why: &str) -> String {
    let first = why.split(':').next().unwrap_or(why);
    format!("{} (more with '-v')", cut(first, SHORT_REASON))
}

/// Writes files about the trials.
fn results(
    found: &Optimised,
    left_out: &[(String, String)],
    texts: &OptimisationPage<'_>,
) -> Vec<(String, String)> {
    let data = OptimisationResults {
        answer: texts.answer,
        programs: found.points.len() - 1,
        not_timed: found.untimed,
        alike: found.alike,
        not_made: found.skipped.len(),
        left_out,
        points: &found.points,
    };
    let table = text::points_table(found);
    let figure = text::figure(found, texts.answer.measure);
    let mut files = result_files(&table, json_text(&data), &figure);
    files.push((PAGE.to_owned(), text::page(found, texts)));
    files
}

/// True for a file beside the page, in the language of the input.
fn is_in_its_language(name: &str, input: &Path) -> bool {
    let extension = Path::new(name).extension();
    !name.contains('/') && extension.is_some() && extension == input.extension()
}

/// Names and texts of the code before and after, in the input's language.
fn code(
    arguments: &OptimiseArguments,
    given: &GivenStarts,
    found: &Optimised,
    files: &[(String, String)],
) -> [(String, String); 2] {
    let input = Path::new(&arguments.input);
    let own = files
        .iter()
        .find(|(name, _)| is_in_its_language(name, input));
    if let (Some(own), Ok(bytes)) = (own, std::fs::read(input)) {
        let before = String::from_utf8_lossy(&bytes).into_owned();
        let name = format!("Input: {}", input.display());
        return [
            (name, before),
            (format!("Program: {}", own.0), own.1.clone()),
        ];
    }
    let before = print::print_module(&given.starts[0].module);
    let after = print::print_module(&found.program);
    let name = format!("Input: {}", subject(arguments, found));
    [(name, before), (format!("Program: {PROGRAM}"), after)]
}

#[derive(Serialize)]
struct OptimisationResults<'a> {
    answer: &'a OptimisationAnswer,
    /// Number of programs measured, beside the input.
    programs: usize,
    not_timed: usize,
    alike: usize,
    not_made: usize,
    /// Formulations that take no part, with the reasons.
    left_out: &'a [(String, String)],
    points: &'a [OptimisationPoint],
}

fn write(folder: &Path, files: &[(String, String)]) -> Result<(), CommandFailure> {
    let top: Vec<(&str, &str)> = files
        .iter()
        .filter(|(name, _)| !name.contains('/'))
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    output::write_folder(folder, &top, Replace::Results)?;
    for part in [HARDWARE, IMAGES] {
        let inside = files.iter().filter_map(|(name, content)| {
            let name = name.strip_prefix(part)?.strip_prefix('/')?;
            Some((name, content.as_str()))
        });
        let inside: Vec<(&str, &str)> = inside.collect();
        if !inside.is_empty() {
            // Most files of hardware are the same for every machine and bear
            // no mark.
            output::write_folder(&folder.join(part), &inside, Replace::Anything)?;
        }
    }
    Ok(())
}

/// The command that replaces the input by the program, and the files to use.
fn uses(
    arguments: &OptimiseArguments,
    folder: &Path,
    files: &[(String, String)],
) -> Vec<(&'static str, String)> {
    let input = Path::new(&arguments.input);
    let name = |name: &str| folder.join(name).display().to_string();
    let mut uses = Vec::new();
    for (label, part) in [("hardware", HARDWARE), ("images", IMAGES)] {
        if files.iter().any(|(name, _)| name.starts_with(part)) {
            uses.push((label, name(part)));
        }
    }
    let mut names = files.iter().map(|(name, _)| name);
    let in_place = names.find(|name| *name != PROGRAM && is_in_its_language(name, input));
    let in_place = in_place.map(Path::new);
    let code = files.iter().find(|(name, _)| name.ends_with(".c"));
    let is_batch = arguments.target == OptimisationTarget::Batch;
    uses.push((
        "use it",
        match (in_place.filter(|_| !is_batch), code) {
            (Some(own), _) => {
                let folder = input
                    .parent()
                    .filter(|_| input.file_name() == own.file_name());
                let place = folder.unwrap_or(input);
                let here = if place == Path::new("") {
                    Path::new(".")
                } else {
                    place
                };
                let (own, here) = (name(&own.to_string_lossy()), here.display().to_string());
                let width = LABELS + "cp  ".len() + own.chars().count() + here.chars().count();
                if width > WIDTH {
                    format!("cp {own} \\\n{:LABELS$}  {here}", "")
                } else {
                    format!("cp {own} {here}")
                }
            }
            (None, Some((code, _))) if arguments.target != OptimisationTarget::Fpga => name(code),
            (None, _) => name(PROGRAM),
        },
    ));
    uses
}

/// The program in the language of the input, unless it is C or Robotran has no
/// such function; other equations get the files of every target alone.
fn in_its_language(arguments: &OptimiseArguments, found: &Optimised) -> Vec<(String, String)> {
    let extension = Path::new(&arguments.input).extension();
    let extension = extension.map(|extension| extension.to_string_lossy());
    let language = extension.and_then(|extension| Language::from_extension(&extension));
    let Some(language) = language.filter(|language| *language != Language::C) else {
        return Vec::new();
    };
    write_equations(&found.program, language, &WriteOptions::default()).unwrap_or_default()
}

const PAGE: &str = "optimise.html";

/// Name of the file with the best program's start, if that is not the input.
pub(super) const START: &str = "start.rvir";

/// True when the program starts from the input itself, a file.
fn is_input(arguments: &OptimiseArguments, found: &Optimised) -> bool {
    found.start == 0 && Path::new(&arguments.input).is_file()
}

/// The commands that make the program again.
fn commands(arguments: &OptimiseArguments, given: &GivenStarts, found: &Optimised) -> String {
    let best = &found.points[found.best];
    let mut text = String::new();
    let input = if is_input(arguments, found) {
        arguments.input.clone()
    } else {
        let recipe = &given.starts[found.start].recipe;
        if !given.model.is_empty() && !recipe.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "robovec gen {} {recipe} -o {START}", given.model);
        }
        START.to_owned()
    };
    let mut words = vec!["robovec-opt".to_owned(), input];
    if let (Some(name), 0) = (&arguments.function, found.start) {
        words.push(format!("--function {name}"));
    }
    if let Some(name) = &arguments.machine {
        words.push(format!("--machine {name}"));
    }
    if let Some(path) = &arguments.scene {
        words.push(format!("--scene {}", path.display()));
    } else if found.start != 0 && given.scene.is_some() {
        words.push(format!("--scene {}", arguments.input));
    }
    let mut passes = best.passes.clone();
    if arguments.target == OptimisationTarget::Fpga {
        passes += &match arguments.elements {
            None => ",place".to_owned(),
            Some(count) => format!(",place{{n_add={count} n_multi={count}}}"),
        };
    }
    words.push(format!("'-passes={passes}'"));
    words.push(format!("-o {PROGRAM}"));
    let _ = writeln!(text, "{}", words.join(" "));
    text += &match arguments.target {
        OptimisationTarget::Fpga => {
            let machine = arguments.machine.as_deref();
            let machine = or_nothing(machine, |name| format!(" --machine {name}"));
            format!("robovec-opt {PROGRAM}{machine} '-passes=codegen{{target=rtl}}' -o rtl\n")
        }
        OptimisationTarget::Cpu => format!("robovec gen {PROGRAM} --language c --bounded -o .\n"),
        OptimisationTarget::Batch => {
            format!("robovec-opt {PROGRAM} '-passes=codegen{{target=batch}}' -o .\n")
        }
    };
    text
}

/// The name of the program's file.
pub(super) const PROGRAM: &str = "program.rvir";

/// Folders for hardware, and for memory images alone.
const HARDWARE: &str = "rtl";
const IMAGES: &str = "images";

/// The program, ready to use.
fn program_files(
    question: &OptimisationQuestion<'_>,
    found: &Optimised,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let fail = |error: &dyn std::fmt::Display| CommandFailure::plain(error.to_string());
    match question.target {
        OptimisationTarget::Fpga => {
            let (machine, scene) = (question.machine, question.scene);
            let placed = transformed_by(&found.program, "place", machine, scene);
            let placed = placed.map_err(|error| fail(&error))?;
            let mut files = vec![(PROGRAM.to_owned(), print::print_module(&placed))];
            for (target, folder) in [("rtl", HARDWARE), ("mif", IMAGES)] {
                match artifacts(&placed, &format!("codegen{{target={target}}}"), question) {
                    Ok(made) => {
                        let made = made.into_iter();
                        files.extend(made.map(|(name, text)| (format!("{folder}/{name}"), text)));
                        break;
                    }
                    // What hardware cannot be written for still has images.
                    Err(_) if target == "rtl" => {}
                    Err(error) => return Err(error),
                }
            }
            files.extend(in_c(&found.program, SuperwordLanes::None)?);
            Ok(files)
        }
        OptimisationTarget::Cpu => {
            // What is compiled here is timed with the vectors of this compiler.
            let superwords = match question.compiler {
                Some(_) => SuperwordLanes::Auto,
                None => SuperwordLanes::None,
            };
            let mut files = in_c(&found.program, superwords)?;
            files.push((PROGRAM.to_owned(), print::print_module(&found.program)));
            Ok(files)
        }
        OptimisationTarget::Batch => {
            let mut files = artifacts(&found.program, "codegen{target=batch}", question)?;
            files.push((PROGRAM.to_owned(), print::print_module(&found.program)));
            Ok(files)
        }
    }
}

/// C that replaces Robotran's file; of other functions, with their arrays.
fn in_c(
    module: &Module,
    superwords: SuperwordLanes,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let options = DropInOptions {
        c: c::Options {
            superwords,
            ..c::Options::default()
        },
        ..DropInOptions::default()
    };
    drop_in(module, &options).or_else(|_| plain_c(module, superwords))
}

/// A function in C that takes its arrays one after the other.
fn plain_c(
    module: &Module,
    superwords: SuperwordLanes,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let options = c::Options {
        signature: c::Signature::Plain,
        superwords,
        ..c::Options::default()
    };
    let files = c::files(view(module), &options);
    let files = files.map_err(|error| CommandFailure::plain(error.to_string()))?;
    Ok(files.to_vec())
}

/// Files that a pipeline makes of a module.
fn artifacts(
    module: &Module,
    passes: &str,
    question: &OptimisationQuestion<'_>,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let pipeline = REGISTRY
        .pipeline(passes)
        .expect("codegen has these targets");
    let mut module = module.clone();
    let mut log = io::sink();
    let config = Config {
        scene: question.scene,
        ..Config::new(question.machine, &mut log)
    };
    let outcome = manager::run(&mut module, &pipeline, config)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let files = outcome.artifacts.into_iter();
    Ok(files.map(|file| (file.name, file.text)).collect())
}
