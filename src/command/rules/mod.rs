//! `robovec rules`: a bench for rules of rewriting (docs/rules.md).

mod bench;
mod check;
mod exchange;
mod find;
mod list;
mod profile;
mod read;
mod why;
mod why_not;

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
    /// Tell which rule earns how many cycles and operations on equations
    Bench(bench::BenchArguments),
    /// Prove or refute rules, and tell what they do to numbers
    Check(check::CheckArguments),
    /// Write rules in the syntax of another tool
    Export(exchange::ExportArguments),
    /// Find new rules and rank them by what they would gain
    Find(find::FindArguments),
    /// Read rules of another tool, and tell their classes
    Import(exchange::ImportArguments),
    /// List rules with their reasons
    List(list::ListArguments),
    /// Tell what rules do to errors, cycles, operations and graphs
    Profile(profile::ProfileArguments),
    /// Tell by which rules a value came about
    Why(why::WhyArguments),
    /// Tell how rules lead from one term to another, or why they do not
    WhyNot(why_not::WhyNotArguments),
}

/// Runs the command.
pub(super) fn run(arguments: &RulesArguments) -> Result<String, Failure> {
    match &arguments.command {
        Command::Bench(arguments) => bench::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Export(arguments) => exchange::export(arguments),
        Command::Find(arguments) => find::run(arguments),
        Command::Import(arguments) => exchange::import(arguments),
        Command::List(arguments) => list::run(arguments),
        Command::Profile(arguments) => profile::run(arguments),
        Command::Why(arguments) => why::run(arguments),
        Command::WhyNot(arguments) => why_not::run(arguments),
    }
}
