//! The command line of `robovec-opt`.

use super::flags::{SEED, choice, whole};
use super::input::LANGUAGES;
use super::progress::TellingArguments;
use clap::builder::{PossibleValuesParser, StyledStr};
use clap::{CommandFactory, Parser, ValueEnum};
use clap_complete::engine::{ArgValueCandidates, CompletionCandidate};
use robovec_framework::manager::Limit;
use robovec_io::sources::EquationLanguage;
use robovec_passes::registry::REGISTRY;
use std::ffi::OsString;
use std::path::PathBuf;

/// Reads equations of a multibody system (Robotran C, Matlab or Python, or
/// robovec's own text) or makes them from a model (.mbs, .urdf, .xml), runs a pipeline of
/// passes over them and writes the result.
#[derive(Parser, Debug)]
#[command(
    name = "robovec-opt",
    version,
    after_help = "Example:\n  robovec-opt examples/suspension/mbs_dirdyna_suspension.m \
                  -passes=atomise,balance,place --report -\n\n\
                  Long options may be written with one dash. '--list-passes' shows the passes, \
                  '--help-pass NAME' the manual page of one."
)]
pub(crate) struct OptimiserArguments {
    /// File to read, or - for the standard input
    #[arg(required_unless_present_any = ["list_passes", "help_pass", "list_machines", "completion"])]
    pub(crate) input: Option<PathBuf>,

    /// Pipeline, e.g. atomise,fixpoint(fold,cse),place; @FILE reads it from a file
    #[arg(long, value_name = "PIPELINE", add = ArgValueCandidates::new(pass_candidates))]
    pub(crate) passes: Option<String>,

    /// File (or, for several memory images, folder) to write instead of the standard output
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,

    /// Replace files that robovec did not write
    #[arg(long)]
    pub(crate) force: bool,

    /// Language of the input; by default found from its name and content
    #[arg(long = "input-language", alias = "language", value_parser = choice(&LANGUAGES))]
    pub(crate) language: Option<EquationLanguage>,

    /// Only this function of the input; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    pub(crate) function: Option<String>,

    /// Machine to compile for: a name of '--list-machines' or a .toml file; by
    /// default the scene's, or thesis
    #[arg(long, add = ArgValueCandidates::new(machine_candidates))]
    pub(crate) machine: Option<String>,

    /// Scene (.scene.toml) that describes the use of the functions: passes and
    /// measurements use its values, ranges and outputs
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,

    /// Additional rewriting rules: a .rules file, or a name of 'robovec rules
    /// list'
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Vec<String>,

    /// Use only the rules that '--rules' names
    #[arg(long, requires = "rules")]
    pub(crate) no_default_rules: bool,

    /// Folder of a custom target for codegen{target=template}: target.toml and
    /// template.jinja
    #[arg(long, value_name = "FOLDER")]
    pub(crate) target: Option<PathBuf>,

    /// Write a report: FILE.json, any other FILE as text, or - for the standard error
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) telling: TellingArguments,

    /// Print the function before these passes (all without names)
    #[arg(long, value_name = "PASSES", num_args = 0..=1, default_missing_value = "*",
          require_equals = true)]
    pub(crate) print_before: Option<String>,

    /// Print the function after these passes (all without names)
    #[arg(long, value_name = "PASSES", num_args = 0..=1, default_missing_value = "*",
          require_equals = true)]
    pub(crate) print_after: Option<String>,

    /// Print the function after every pass
    #[arg(long)]
    pub(crate) print_after_all: bool,

    /// Print the function after passes that changed it, whole or as a difference
    #[arg(long, value_name = "HOW", num_args = 0..=1, default_missing_value = "full",
          require_equals = true, value_parser = PossibleValuesParser::new(["full", "diff"]))]
    pub(crate) print_changed: Option<String>,

    /// Print with every value the passes and rules that made it
    #[arg(long)]
    pub(crate) print_history: bool,

    /// Print how a value (%OM16) or an output (M[1,2]) came to be, instead of printing the result
    #[arg(long, value_name = "VALUE")]
    pub(crate) explain: Option<String>,

    /// Write every state of every function into numbered files, with an index.json
    #[arg(long, value_name = "DIR")]
    pub(crate) dump_dir: Option<PathBuf>,

    /// Verify the function after every pass
    #[arg(long, num_args = 0..=1, default_value_t = true, default_missing_value = "true",
          require_equals = true, action = clap::ArgAction::Set)]
    pub(crate) verify_each: bool,

    /// After every pass, check at N random points that the function is
    /// unchanged
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "4",
          require_equals = true, add = whole(1, 1_000_000, "every pass is checked at every point"))]
    pub(crate) check_each: Option<u32>,

    /// Run only the first P passes, with only the first N rewrites of the last
    /// one, and print what was run
    #[arg(long, value_name = "P[:N]")]
    pub(crate) bisect_limit: Option<Limit>,

    /// File for the input of a pass that fails, with the command
    #[arg(long, value_name = "FILE")]
    pub(crate) reproducer: Option<PathBuf>,

    /// Run the command in the header of a reproducer; other options add to it
    #[arg(long)]
    pub(crate) run_reproducer: bool,

    /// When a pass fails, find the rewrite that causes it and the smallest
    /// program that shows it; checks every pass
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "reduced.rvir",
          require_equals = true)]
    pub(crate) auto_reduce: Option<PathBuf>,

    /// Maximum work of --auto-reduce: values of the programs tried, times
    /// passes
    #[arg(long, value_name = "N", default_value_t = robovec_framework::reduce::WORK,
          add = whole(0, 1_000_000_000_000, "every step of the search runs passes over a program"))]
    pub(crate) reduce_work: u64,

    /// Seed of all random points and states
    #[arg(long, default_value_t = 1, add = SEED)]
    pub(crate) seed: u64,

    /// Print the time and memory of every pass
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1,
          default_missing_value = "table", require_equals = true)]
    pub(crate) time_passes: Option<TableFormat>,

    /// Print what every pass counted
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1,
          default_missing_value = "table", require_equals = true)]
    pub(crate) stats: Option<TableFormat>,

    /// Simulate the memory images on N random states and compare with the evaluator
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "1",
          require_equals = true, add = whole(1, 100_000, "the program is run cycle by cycle on every state"))]
    pub(crate) simulate: Option<u32>,

    /// Print the pipeline with its presets expanded
    #[arg(long)]
    pub(crate) print_pipeline: bool,

    /// List the passes and presets
    #[arg(long)]
    pub(crate) list_passes: bool,

    /// Show the manual page of a pass
    #[arg(long, value_name = "NAME", add = ArgValueCandidates::new(pass_name_candidates))]
    pub(crate) help_pass: Option<String>,

    /// List the machines that ship with robovec
    #[arg(long)]
    pub(crate) list_machines: bool,

    /// Print the script that makes a shell complete options, passes and machines
    #[arg(long, value_name = "SHELL",
          value_parser = PossibleValuesParser::new(["bash", "elvish", "fish", "powershell", "zsh"]))]
    pub(crate) completion: Option<String>,
}

/// The command line, with the limits of its numbers.
pub(crate) fn command() -> clap::Command {
    super::grammar::words(super::flags::enforce(OptimiserArguments::command()))
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TableFormat {
    /// A table of text
    Table,
    /// JSON
    Json,
}

/// Long options may have one dash: `-passes=cse` becomes `--passes=cse`.
pub(crate) fn normalise(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    arguments
        .enumerate()
        .map(|(index, argument)| match argument.to_str() {
            Some(text) if index > 0 && is_single_dash_long(text) => format!("-{text}").into(),
            Some(_) | None => argument,
        })
        .collect()
}

fn is_single_dash_long(text: &str) -> bool {
    let Some(name) = text.strip_prefix('-') else {
        return false;
    };
    let word = name.split_once('=').map_or(name, |(word, _)| word);
    word.len() > 2
        && word
            .bytes()
            .all(|byte| byte.is_ascii_lowercase() || byte == b'-')
        && !word.starts_with('-')
}

fn candidate(name: String, help: String) -> CompletionCandidate {
    CompletionCandidate::new(name).help(Some(StyledStr::from(help)))
}

fn pass_name_candidates() -> Vec<CompletionCandidate> {
    REGISTRY
        .passes
        .iter()
        .map(|info| candidate(info.name.to_owned(), info.summary().to_owned()))
        .collect()
}

fn pass_candidates() -> Vec<CompletionCandidate> {
    let presets = REGISTRY
        .presets
        .iter()
        .map(|preset| candidate(format!("${}", preset.name), preset.summary.to_owned()));
    pass_name_candidates().into_iter().chain(presets).collect()
}

fn machine_candidates() -> Vec<CompletionCandidate> {
    robovec_ir::machine::BUILT_IN
        .iter()
        .map(|(name, _)| CompletionCandidate::new(*name))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn one_dash_is_enough_for_long_options() {
        let words = [
            "robovec-opt",
            "-passes=cse",
            "-o",
            "-",
            "--report",
            "a-passes",
            "-h",
        ];
        let normal = normalise(words.iter().map(OsString::from));
        let expected = [
            "robovec-opt",
            "--passes=cse",
            "-o",
            "-",
            "--report",
            "a-passes",
            "-h",
        ];
        assert_eq!(normal, expected.map(OsString::from));
    }
}
