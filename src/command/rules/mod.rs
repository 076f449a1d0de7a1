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

use super::CommandFailure;
use clap::{Args, Subcommand};

/// A bench for rules of rewriting
#[derive(Args, Debug)]
pub(super) struct RulesArguments {
    #[command(subcommand)]
    command: RulesCommand,
}

#[derive(Subcommand, Debug)]
enum RulesCommand {
    /// Print which rule earns how many cycles and operations on equations
    Bench(bench::RuleBenchArguments),
    /// Prove or refute rules, and print what they do to numbers
    Check(check::RuleCheckArguments),
    /// Write rules in the syntax of another tool
    Export(exchange::ExportArguments),
    /// Find new rules and rank them by what they would gain
    Find(find::FindArguments),
    /// Read rules of another tool, and print their classes
    Import(exchange::ImportArguments),
    /// List rules with their reasons
    List(list::ListArguments),
    /// Print what rules do to errors, cycles, operations and graphs
    Profile(profile::ProfileArguments),
    /// Print by which rules a value came about
    Why(why::WhyArguments),
    /// Print how rules lead from one term to another, or why they do not
    WhyNot(why_not::WhyNotArguments),
}

pub(super) fn run(arguments: &RulesArguments) -> Result<String, CommandFailure> {
    match &arguments.command {
        RulesCommand::Bench(arguments) => bench::run(arguments),
        RulesCommand::Check(arguments) => check::run(arguments),
        RulesCommand::Export(arguments) => exchange::export(arguments),
        RulesCommand::Find(arguments) => find::run(arguments),
        RulesCommand::Import(arguments) => exchange::import(arguments),
        RulesCommand::List(arguments) => list::run(arguments),
        RulesCommand::Profile(arguments) => profile::run(arguments),
        RulesCommand::Why(arguments) => why::run(arguments),
        RulesCommand::WhyNot(arguments) => why_not::run(arguments),
    }
}
