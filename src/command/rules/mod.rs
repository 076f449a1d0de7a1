//! `robovec rules`: a bench for rules of rewriting (docs/rules.md).

mod bench;
mod check;
mod exchange;
mod find;
mod profile;
mod read;
mod why;
mod why_not;

pub(crate) use read::sound;

use super::CommandFailure;
use clap::{Args, Subcommand};

/// Check, measure and find rewriting rules
#[derive(Args, Debug)]
pub(super) struct RulesArguments {
    #[command(subcommand)]
    command: RulesCommand,
}

#[derive(Subcommand, Debug)]
enum RulesCommand {
    /// Measure how many cycles and operations each rule saves on equations
    Bench(bench::RuleBenchArguments),
    /// Prove or refute rules, and print their effect on rounding
    Check(check::RuleCheckArguments),
    /// Write rules in the syntax of another tool
    Export(exchange::ExportArguments),
    /// Find new rules and rank them by their gain
    Find(find::FindArguments),
    /// Read rules of another tool, and print their classes
    Import(exchange::ImportArguments),
    /// List rules with their reasons
    List(read::ListArguments),
    /// Print the effect of rules on errors, cycles, operations and graphs
    Profile(profile::ProfileArguments),
    /// Print the rules that made a value
    Why(why::WhyArguments),
    /// Print how rules lead from one term to another, or why they do not get
    /// there
    WhyNot(why_not::WhyNotArguments),
}

pub(super) fn run(arguments: &RulesArguments) -> Result<String, CommandFailure> {
    match &arguments.command {
        RulesCommand::Bench(arguments) => bench::run(arguments),
        RulesCommand::Check(arguments) => check::run(arguments),
        RulesCommand::Export(arguments) => exchange::export(arguments),
        RulesCommand::Find(arguments) => find::run(arguments),
        RulesCommand::Import(arguments) => exchange::import(arguments),
        RulesCommand::List(arguments) => read::run(arguments),
        RulesCommand::Profile(arguments) => profile::run(arguments),
        RulesCommand::Why(arguments) => why::run(arguments),
        RulesCommand::WhyNot(arguments) => why_not::run(arguments),
    }
}
