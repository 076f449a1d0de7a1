//! `robovec rules list`.

use super::super::CommandFailure;
use super::read;
use clap::Args;
use robovec_rules::{BUILT_IN, DEFAULT};
use std::fmt::Write;

/// Arguments of `rules list`.
#[derive(Args, Debug)]
pub(super) struct ListArguments {
    /// Rule files, or names of files that ship; all that ship by default
    files: Vec<String>,
}

/// The names of all files that ship.
pub(super) fn shipped() -> Vec<String> {
    BUILT_IN
        .iter()
        .map(|(name, _)| (*name).to_owned())
        .collect()
}

pub(super) fn run(arguments: &ListArguments) -> Result<String, CommandFailure> {
    let names = if arguments.files.is_empty() {
        shipped()
    } else {
        arguments.files.clone()
    };
    let set = read::read(&names)?;
    let mut text = String::new();
    let mut group = "";
    for rule in &set.rules {
        if rule.group != group {
            group = &rule.group;
            let ships = BUILT_IN.iter().any(|(name, _)| *name == group);
            let unused = ships && !DEFAULT.contains(&group);
            let note = if unused { " (not used by default)" } else { "" };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{group}{note}:");
        }
        let _ = writeln!(text, "  {rule}");
    }
    Ok(text)
}
