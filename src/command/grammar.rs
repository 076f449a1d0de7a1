//! One grammar for all commands: the words that mean one thing everywhere, the
//! groups of commands, and an example or two of each; former commands.
//!
//! **Invariants.** A word of [`WORDS`] takes the same kind of value in every
//! command that has it ([`apply`] writes its name); every command is in one
//! group and has examples. Tests read them and compare `docs/commands.md`.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use std::fmt::Write;

/// Words of the command line, with the names of their values.
pub const WORDS: [(&str, Option<&str>); 20] = [
    ("function", Some("NAME")),
    ("formulation", Some("NAME")),
    ("model", Some("FILE")),
    ("passes", Some("PIPELINE")),
    ("machine", Some("MACHINE")),
    ("scene", Some("FILE")),
    ("rules", Some("FILE")),
    ("laws", Some("FILE")),
    ("number", Some("FORMAT")),
    ("language", Some("LANGUAGE")),
    ("input-language", Some("LANGUAGE")),
    ("states", Some("STATES")),
    ("seed", Some("SEED")),
    ("jobs", Some("N")),
    ("resume", None),
    ("shard", Some("K/N")),
    ("json", None),
    ("csv", None),
    ("quiet", None),
    ("verbose", None),
];

/// Commands grouped by purpose.
pub const GROUPS: [(&str, &[&str]); 5] = [
    (
        "Get the best program",
        &["optimise", "explore", "view", "bench"],
    ),
    ("Use models", &["model", "gen", "sim", "project"]),
    (
        "Check correctness and accuracy",
        &["eval", "check", "error", "stress"],
    ),
    ("Meet requirements and build hardware", &["fit", "rtl"]),
    ("Study rewriting rules", &["rules"]),
];

/// Examples of a command, for the root of the repository.
pub fn examples(name: &str) -> Vec<&'static str> {
    let lines = include_str!("examples.txt").lines();
    let is_of = |line: &&str| line.split(' ').nth(1) == Some(name);
    lines.filter(is_of).collect()
}

/// The command with words of the grammar, its examples and its groups.
pub(super) fn apply(command: Command) -> Command {
    let groups = groups(&command);
    let command = command.mut_subcommands(|sub| {
        let lines = examples(sub.get_name()).join("\n  ");
        let sub = words(sub);
        if lines.is_empty() {
            return sub;
        }
        sub.after_help(format!("Examples:\n  {lines}"))
    });
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{groups}\nOptions:\n{{options}}\n\n\
         'robovec COMMAND --help' describes a command, with examples; docs/commands.md describes the \
         options that commands share.\n"
    ))
}

/// The words of the grammar take values of the same names.
pub(super) fn words(command: Command) -> Command {
    command.mut_args(value_name).mut_subcommands(words)
}

fn value_name(flag: Arg) -> Arg {
    let long = flag.get_long().unwrap_or_default();
    match WORDS.iter().find(|(known, _)| *known == long) {
        Some((_, Some(value))) if flag.get_action().takes_values() => flag.value_name(value),
        Some(_) | None => flag,
    }
}

/// Description of a command, on one line.
pub fn about(program: &Command, name: &str) -> String {
    let about = program.find_subcommand(name).and_then(Command::get_about);
    let about = about.expect("commands of groups are described");
    about.to_string().replace('\n', " ")
}

fn groups(command: &Command) -> String {
    let mut text = String::new();
    for (title, names) in GROUPS {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n{title}:");
        for name in names {
            let _ = writeln!(text, "  {name:<12} {}", about(command, name));
        }
    }
    text
}

/// Command lines of former versions, each with the one that has the same results.
pub const FORMER: [(&str, &str); 15] = [
    ("accuracy FILE…", "error FILE… --passes '$shorten'"),
    ("accuracy FILE… --outputs", "error FILE…"),
    ("equilibrium MODEL", "sim equilibrium MODEL"),
    ("errors FILE", "error FILE… --blame"),
    ("errors FILE --method interval", "error FILE… --prove"),
    ("front SUBJECT…", "explore SUBJECT…"),
    ("modal MODEL", "sim modal MODEL"),
    ("neglect SCENE", "fit SCENE --reduce"),
    ("scene SCENE", "fit SCENE --explain"),
    ("simulate FOLDER", "rtl simulate FOLDER"),
    ("study", "explore --plan thesis"),
    ("sweep SUBJECT…", "explore SUBJECT… --designs"),
    ("synthesise", "rtl synthesise"),
    ("trig FILE…", "error FILE… --series"),
    (
        "write FILE… --language LANGUAGE",
        "gen FILE… --language LANGUAGE",
    ),
];

/// The error of the command line, with advice where it names a former command.
pub(super) fn former(mut error: clap::Error) -> clap::Error {
    let name = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(name)) if error.kind() == ErrorKind::InvalidSubcommand => name,
        Some(_) | None => return error,
    };
    let is_it = |(line, _): &&(&str, &str)| line.split(' ').next() == Some(name);
    let advice: Vec<_> = FORMER
        .iter()
        .filter(is_it)
        .map(|(line, now)| format!("robovec {line} is now: robovec {now}").into())
        .collect();
    if !advice.is_empty() {
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(advice));
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of an example, quotes taken away.
    fn split(line: &str) -> Vec<String> {
        let words = line.split_whitespace();
        words.map(|word| word.replace('\'', "")).collect()
    }

    #[test]
    fn every_command_is_in_one_group_and_has_examples_that_are_read() {
        let [_, tool] = super::super::commands();
        for sub in tool.get_subcommands().filter(|sub| !sub.is_hide_set()) {
            let name = sub.get_name();
            let groups = GROUPS.iter().filter(|(_, names)| names.contains(&name));
            assert_eq!(groups.count(), 1, "{name} is in one group");
            let lines = examples(name);
            assert!(!lines.is_empty(), "{name} has no example");
            for line in lines {
                let read = tool.clone().try_get_matches_from(split(line));
                assert!(read.is_ok(), "{line}: {}", read.expect_err("as seen"));
                assert_eq!(split(line)[1], name);
            }
        }
    }

    #[test]
    fn words_of_the_grammar_take_the_same_values_everywhere() {
        fn check(command: &Command) {
            for flag in command.get_arguments() {
                let long = flag.get_long().unwrap_or_default();
                let place = format!("{} --{long}", command.get_name());
                if let Some((_, value)) = WORDS.iter().find(|(known, _)| *known == long) {
                    let takes = flag.get_action().takes_values();
                    assert_eq!(takes, value.is_some(), "{place}");
                    let names = flag.get_value_names().unwrap_or_default();
                    let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
                    if let Some(value) = *value {
                        assert_eq!(names, [value], "{place}");
                    }
                }
                // Words that went under other names before.
                assert!(
                    !["format", "formats", "random"].contains(&long) || flag.is_hide_set(),
                    "{place}"
                );
                if long == "output" {
                    assert_eq!(flag.get_short(), Some('o'), "{place}");
                }
            }
            command.get_subcommands().for_each(check);
        }
        super::super::commands().iter().for_each(check);
    }

    #[test]
    fn former_names_are_answered_with_commands_that_are_there() {
        let [_, tool] = crate::command::commands();
        for (line, now) in FORMER {
            let name = line.split(' ').next().expect("a split has a first part");
            let error = tool.clone().try_get_matches_from(["robovec", name]);
            let told = former(error.expect_err("a former name")).to_string();
            assert!(told.contains(&format!("is now: robovec {now}")), "{told}");
            let mut command = &tool;
            for word in now.split(' ') {
                if let Some(inner) = command.find_subcommand(word) {
                    command = inner;
                } else if let Some(long) = word.strip_prefix("--") {
                    let mut flags = command.get_arguments();
                    assert!(flags.any(|flag| flag.get_long() == Some(long)), "{now}");
                }
            }
            assert_ne!(command.get_name(), tool.get_name(), "{now}");
        }
    }
}
