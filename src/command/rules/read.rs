//! Rules that a command works with, and `robovec rules list`.

use super::super::{CommandFailure, input};
use crate::command::emit;
use clap::Args;
use robovec_io::files::limited;
use robovec_ir::diagnostic::suggestion;
use robovec_rules::{BUILT_IN, DEFAULT, RuleSet};
use std::fmt::Write;
use std::path::Path;

/// The rules of some files, or of names of files that ship.
pub(super) fn read(names: &[String]) -> Result<RuleSet, CommandFailure> {
    let mut all = RuleSet::default();
    for (index, name) in names.iter().enumerate() {
        // Naming a file twice is no mistake.
        if names[..index].contains(name) {
            continue;
        }
        all.extend(one(name)?)?;
    }
    Ok(all)
}

/// The rules of some files; of none, those that ship.
pub(super) fn read_or_shipped(names: &[String]) -> Result<RuleSet, CommandFailure> {
    match names {
        [] => read(&shipped()),
        names => read(names),
    }
}

/// The rules of one file, or of one that ships.
fn one(name: &str) -> Result<RuleSet, CommandFailure> {
    if let Some(set) = RuleSet::named(name) {
        return Ok(set);
    }
    let path = Path::new(name);
    if path.extension().is_none() && name != "-" && !path.exists() {
        let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
        let mut notes: Vec<String> = suggestion(name, names.iter().copied())
            .into_iter()
            .collect();
        notes.push(format!("rules: {}, or a .rules file", names.join(", ")));
        return Err(CommandFailure::advised(
            format!("there are no rules '{name}'"),
            notes,
        ));
    }
    let text = input::text(path, &limited::RULES)?;
    RuleSet::parse(&text, name).map_err(CommandFailure)
}

/// The rules that passes use: those of the names and, unless they are not
/// wanted, those that ship. False rules are reported and left out.
pub(crate) fn sound(names: &[String], with_default: bool) -> Result<RuleSet, CommandFailure> {
    let mut all = match with_default {
        // Tests prove that what ships is sound.
        true => RuleSet::built_in(),
        false => RuleSet::default(),
    };
    let is_new = |name: &&String| {
        let ships = BUILT_IN.iter().any(|(known, _)| known == name);
        !ships || !all.rules.iter().any(|rule| rule.group == **name)
    };
    // A file that ships and is named once more is there already.
    let new: Vec<String> = names.iter().filter(is_new).cloned().collect();
    let (sound, warnings) = read(&new)?.sound();
    emit(&warnings);
    all.extend(sound)?;
    Ok(all)
}

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
    let set = read_or_shipped(&arguments.files)?;
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
