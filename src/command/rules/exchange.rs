//! `robovec rules import` and `robovec rules export`.

use super::super::{CommandFailure, input, output};
use super::read;
use crate::command::emit;
use crate::command::flags::{FlagChoice, choice};
use clap::Args;
use robovec_io::files::limited;
use robovec_ir::diagnostic::{Diagnostic, Severity};
use robovec_rules::check::{RuleVerdict, check, diagnose};
use robovec_rules::syntax::{self, Syntax};
use std::path::{Path, PathBuf};

/// Trials in floating point to find the class of an imported rule.
const TRIALS: usize = 20_000;

/// Syntaxes of other tools.
const SYNTAXES: [FlagChoice<Syntax>; 2] = [
    (
        &["egglog"],
        "Programs of egglog: (rewrite left right)",
        Syntax::Egglog,
    ),
    (
        &["herbie"],
        "Rule groups of Herbie: (define-rules group [name left right])",
        Syntax::Herbie,
    ),
];

/// Arguments of `rules import`.
#[derive(Args, Debug)]
pub(super) struct ImportArguments {
    /// File with rules of another tool, or - for the standard input
    file: PathBuf,
    /// Its syntax
    #[arg(long, value_parser = choice(&SYNTAXES))]
    syntax: Syntax,
    /// File to write instead of the standard output
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
}

/// Arguments of `rules export`.
#[derive(Args, Debug)]
pub(super) struct ExportArguments {
    /// Rule files, or names of files that ship; all that ship by default
    files: Vec<String>,
    /// The syntax to write
    #[arg(long, value_parser = choice(&SYNTAXES))]
    syntax: Syntax,
    /// File to write instead of the standard output
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
}

/// Reads rules of another tool, finds their classes, and gives them as a rule
/// file. Rules that are false or not proved are reported and become comments; a
/// false one is an error, which comes after all others have been written.
pub(super) fn import(arguments: &ImportArguments) -> Result<String, CommandFailure> {
    let text = input::text(&arguments.file, &limited::FOREIGN_RULES)?;
    let name = arguments.file.display().to_string();
    let (mut set, mut report) = syntax::import(&text, &name, arguments.syntax)?;
    if set.rules.is_empty() {
        let message = format!("{name} gives no rule");
        let note = "egglog has (rewrite left right), Herbie (define-rules group [name left right])";
        report.extend([Diagnostic::error().with_message(message).with_note(note)]);
        return Err(CommandFailure(report));
    }
    let mut lines = String::new();
    for rule in &mut set.rules {
        let finding = check(rule, TRIALS);
        rule.class = finding.class;
        let before = match finding.verdict {
            RuleVerdict::Proved(_) => "",
            RuleVerdict::False(_) => "# false: ",
            RuleVerdict::Unproved(_) => "# not proved: ",
        };
        report.extend(diagnose(rule, &finding).map(|mut found| {
            // It may well be true.
            if let RuleVerdict::Unproved(_) = finding.verdict {
                found.severity = Severity::Warning;
            }
            found
        }));
        lines += &format!("{before}{rule}\n");
    }
    let text = deliver(lines, arguments.output.as_deref())?;
    if report.has_errors() {
        output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))?;
        return Err(CommandFailure(report));
    }
    emit(&report);
    Ok(text)
}

/// Writes rules for another tool.
pub(super) fn export(arguments: &ExportArguments) -> Result<String, CommandFailure> {
    let set = read::read_or_shipped(&arguments.files)?;
    let text = syntax::export(&set, arguments.syntax);
    deliver(text, arguments.output.as_deref())
}

/// Writes a text to a file, or hands it on for the standard output.
pub(super) fn deliver(text: String, path: Option<&Path>) -> Result<String, CommandFailure> {
    match path {
        Some(path) if path != Path::new("-") => {
            output::write_file(path, |writer| writer.write_all(text.as_bytes()))?;
            Ok(String::new())
        }
        _ => Ok(text),
    }
}
