//! `robovec rules`: a bench for rules of rewriting (docs/rules.md).

mod check;
mod exchange;
mod list;
mod profile;
mod read;

pub(crate) use read::sound;

use super::Failure;
use clap::{Args, Subcommand};

/// A bench for rules of rewriting
#[derive(Args, Debug)]
pub(super) struct RulesArguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Prove or refute rules, and tell what they do to numbers
    Check(check::CheckArguments),
    /// Write rules in the syntax of another tool
    Export(exchange::ExportArguments),
    /// Read rules of another tool, and tell their classes
    Import(exchange::ImportArguments),
    /// List rules with their reasons
    List(list::ListArguments),
    /// Tell what rules do to errors, cycles, operations and graphs
    Profile(profile::ProfileArguments),
}

/// Runs the command.
pub(super) fn run(arguments: &RulesArguments) -> Result<String, Failure> {
    match &arguments.command {
        Command::Check(arguments) => check::run(arguments),
        Command::Export(arguments) => exchange::export(arguments),
        Command::Import(arguments) => exchange::import(arguments),
        Command::List(arguments) => list::run(arguments),
        Command::Profile(arguments) => profile::run(arguments),
    }
}
