//! `robovec manual` and `robovec completion`: files for installation.

use super::{CommandFailure, commands, opt, output};
use clap::Args;
use clap::builder::PossibleValuesParser;
use clap_mangen::Man;
use std::path::PathBuf;

/// Folder of the pages.
#[derive(Args, Debug)]
pub(super) struct ManualArguments {
    /// Folder for the pages, one for each program and command
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

/// For which shell.
#[derive(Args, Debug)]
pub(super) struct CompletionArguments {
    /// The shell
    #[arg(value_parser = PossibleValuesParser::new(["bash", "elvish", "fish", "powershell", "zsh"]))]
    shell: String,
}

/// Writes manual pages of both programs and of every command.
pub(super) fn manual(arguments: &ManualArguments) -> Result<String, CommandFailure> {
    let mut pages = Vec::new();
    for mut program in commands() {
        program.build();
        page(&program, &mut pages)?;
    }
    output::write_files(&arguments.output, &pages)?;
    Ok(format!(
        "{} pages in {}\n",
        pages.len(),
        arguments.output.display()
    ))
}

fn page(command: &clap::Command, pages: &mut Vec<(String, String)>) -> Result<(), CommandFailure> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let mut text = Vec::new();
    let written = Man::new(command.clone()).render(&mut text);
    written.map_err(|error| CommandFailure::plain(format!("{name}: {error}")))?;
    let text = String::from_utf8_lossy(&text).into_owned();
    pages.push((format!("{name}.1"), text));
    let subs = command.get_subcommands();
    for sub in subs.filter(|sub| sub.get_name() != "help") {
        page(sub, pages)?;
    }
    Ok(())
}

/// The script that makes a shell complete the command line of `robovec`.
pub(super) fn completion(arguments: &CompletionArguments) -> Result<String, CommandFailure> {
    opt::completion("robovec", &arguments.shell)
}
