//! Results of a search, printed and written.

use super::OptimiseArguments;
use super::given::GivenStarts;
use crate::command::CommandFailure;
use crate::command::output::{self, result_files};
use robovec_cgen::c;
use robovec_error::yardstick::account::share_cell;
use robovec_explore::optimise::{OptimisationQuestion, OptimisationTarget, Optimised, text};
use robovec_explore::program::{transformed_by, view};
use robovec_fpga::hardware;
use robovec_framework::manager::{self, Config};
use robovec_io::files::Replace;
use robovec_ir::diagnostic::counted;
use robovec_ir::{Machine, Module, print};
use robovec_passes::registry::REGISTRY;
use robovec_present::json::json_text;
use robovec_present::number::or_nothing;
use robovec_robotran::drop_in::{DropInOptions, drop_in};
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Writes what was found, and says what it is.
pub(super) fn tell(
    arguments: &OptimiseArguments,
    given: &GivenStarts,
    question: &OptimisationQuestion<'_>,
    found: &Optimised,
) -> Result<String, CommandFailure> {
    let facts = facts(given, question, found);
    let commands = commands(arguments, given, found);
    let mut text = format!("{}\n\n{facts}", text::table(found));
    let Some(folder) = &arguments.output else {
        text += &format!("\nto make it again:\n{commands}");
        return Ok(text);
    };
    let mut files = program_files(question, found)?;
    files.push(("commands.txt".to_owned(), commands.clone()));
    if !is_input(arguments, found) {
        let start = print::print_module(&given.starts[found.start].module);
        files.push((START.to_owned(), start));
    }
    let table = text::points_table(found);
    let figure = text::figure(found);
    files.extend(result_files(&table, json_text(&found.points), &figure));
    files.push((
        "optimise.html".to_owned(),
        text::page(&given.name, found, &facts, &commands),
    ));
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
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\nwritten to {}:", folder.display());
    let mut names: Vec<&str> = files
        .iter()
        .map(|(name, _)| {
            name.split_inclusive('/')
                .next()
                .expect("names are not empty")
        })
        .collect();
    names.dedup();
    for name in names {
        let _ = writeln!(text, "  {name}");
    }
    Ok(text)
}

/// The name of the file with the equations that the best program starts from,
/// where they are not those that came in.
pub(super) const START: &str = "start.rvir";

/// Facts about the program that was taken.
fn facts(given: &GivenStarts, question: &OptimisationQuestion<'_>, found: &Optimised) -> String {
    let best = &found.points[found.best];
    let mut text = format!("{}: {}\n", given.name, best.name);
    let mut line = |line: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    };
    if let (Some(cycles), Some(bound)) = (best.cycles, best.bound) {
        let machine = question.machine;
        let clock = hardware::clock(machine);
        let time = clock.microseconds(cycles);
        line(format!(
            "{} on {}, {time:.2} us at {}",
            counted(cycles, "cycle"),
            elements(machine),
            clock.text()
        ));
        if best.share.is_some() {
            let device = &machine.device.device().name;
            line(format!(
                "{} of {device} (estimated)",
                share_cell(best.share)
            ));
        }
        line(if cycles == bound {
            "no schedule of these operations on this machine is shorter".to_owned()
        } else {
            format!(
                "the proved bound for these operations on this machine is {bound}: {:.1} % less",
                100.0 * f64::from(cycles - bound) / f64::from(cycles)
            )
        });
    }
    if let Some(time) = best.nanoseconds {
        let compiler = question.compiler.map(|compiler| compiler.version.as_str());
        line(format!(
            "{time:.0} ns per state by {} {}",
            compiler.unwrap_or_default(),
            question.flags
        ));
    }
    line(counted(best.operations, "operation"));
    line(found.errors.text());
    line(format!("against the input: {}", found.proof));
    for (name, reason) in &given.left {
        line(format!("formulation {name} was left out: {reason}"));
    }
    text
}

/// The machine with its numbers of elements.
fn elements(machine: &Machine) -> String {
    let kinds = machine.elements.iter();
    let kinds: Vec<String> = kinds
        .map(|kind| format!("{} {}", kind.count, kind.kind))
        .collect();
    format!("{} ({})", machine.name, kinds.join(", "))
}

/// True when the program starts from the input itself, and that is a file:
/// built-in models have none.
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
            Ok(files)
        }
        OptimisationTarget::Cpu => {
            let program = print::print_module(&found.program);
            let mut files = match drop_in(&found.program, &DropInOptions::default()) {
                Ok(files) => files,
                // A function that is none of Robotran's has arrays of its own.
                Err(_) => plain_c(&found.program)?,
            };
            files.push((PROGRAM.to_owned(), program));
            Ok(files)
        }
        OptimisationTarget::Batch => {
            let mut files = artifacts(&found.program, "codegen{target=batch}", question)?;
            files.push((PROGRAM.to_owned(), print::print_module(&found.program)));
            Ok(files)
        }
    }
}

/// A function in C that takes its arrays one after the other.
fn plain_c(module: &Module) -> Result<Vec<(String, String)>, CommandFailure> {
    let options = c::Options {
        signature: c::Signature::Plain,
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
