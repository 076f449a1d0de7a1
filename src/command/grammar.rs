//! One grammar for all commands: the words that mean one thing everywhere, the
//! groups of commands, and an example or two of each.
//!
//! **Invariants.** A word of [`WORDS`] takes the same kind of value in every
//! command that has it ([`apply`] writes its name); every command is in one
//! group and has examples, which tests read as command lines. A test compares
//! the page `docs/commands.md` with them.

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

/// Examples of every command, for the root of the repository.
pub const EXAMPLES: &[(&str, &[&str])] = &[
    (
        "bench",
        &[
            "robovec bench serial-23 bogie",
            "robovec bench examples/robots/arm.urdf --function invdyna_d --peers none",
        ],
    ),
    (
        "eval",
        &[
            "robovec eval bogie --states 3",
            "robovec eval examples/models/four-bar.mbs --function accelred --states 3 --csv",
        ],
    ),
    (
        "error",
        &[
            "robovec error examples/models/quarter-car.mbs --number f32,f16",
            "robovec error examples/suspension/mbs_dirdyna_suspension.m --passes '$shorten'",
            "robovec error examples/models/bogie.mbs --blame --outputs 'c[3]' --number f16",
            "robovec error examples/rounding/benchmarks.fpcore --function doppler1 --prove",
            "robovec error examples/models/bogie.mbs --series -o series",
        ],
    ),
    (
        "explore",
        &[
            "robovec explore bogie serial-23 -o results",
            "robovec explore bogie --designs --cpu -o results",
            "robovec explore --plan thesis -o results",
        ],
    ),
    (
        "fit",
        &[
            "robovec fit examples/scenes/bogie-1e-4.scene.toml -o fitted",
            "robovec fit examples/scenes/bogie-straight.scene.toml --explain",
            "robovec fit examples/scenes/car-ride.scene.toml --reduce -o reduced",
        ],
    ),
    (
        "gen",
        &[
            "robovec gen bogie --formulation composite -o bogie.rvir",
            "robovec gen examples/robots/arm.urdf --function invdyna_d --numbers --language c -o jacobians",
            "robovec gen examples/suspension/mbs_dirdyna_suspension.m --language c --passes '$cpu' -o new",
        ],
    ),
    (
        "model",
        &[
            "robovec model examples/robots/arm.urdf",
            "robovec model examples/robots/arm.urdf --base-parameters",
            "robovec model serial --joints 40 -o serial-40.mbs",
        ],
    ),
    (
        "sim",
        &[
            "robovec sim examples/models/quarter-car.mbs --laws examples/laws/quarter-car.toml --time 2 -o ride.csv",
            "robovec sim equilibrium examples/models/quarter-car.mbs --laws examples/laws/quarter-car.toml",
            "robovec sim modal examples/models/bogie.mbs --laws examples/laws/bogie.toml",
            "robovec sim fmu examples/models/quarter-car.mbs --laws examples/laws/quarter-car-tyre.toml -o quarter-car.fmu",
        ],
    ),
    (
        "check",
        &[
            "robovec check examples/suspension/mbs_dirdyna_suspension.m best/program.rvir --class real-trig",
        ],
    ),
    (
        "optimise",
        &[
            "robovec optimise examples/suspension/mbs_dirdyna_suspension.m -o best",
            "robovec optimise examples/models/double-pendulum.mbs --for batch -o batch",
        ],
    ),
    (
        "project",
        &[
            "robovec project examples/suspension",
            "robovec project examples/suspension -o new",
        ],
    ),
    (
        "rtl",
        &[
            "robovec rtl bogie --passes '$shorten,place' --machine side-split -o hardware --check verilator",
            "robovec rtl simulate images --machine thesis --inputs 0.1,0.2",
            "robovec rtl synthesise --add 5 --multiply 3",
        ],
    ),
    (
        "rules",
        &["robovec rules list", "robovec rules check mine.rules"],
    ),
    ("stress", &["robovec stress", "robovec stress --list"]),
    (
        "view",
        &[
            "robovec view examples/suspension/mbs_dirdyna_suspension.m -o suspension.html",
            "robovec view bogie --passes '$ahead,place' --check-each -o bogie.html",
            "robovec view bogie --dot bogie.dot --value 'c[3]' --trace bogie.json",
        ],
    ),
];

/// The command with the words of the grammar written alike, its examples and,
/// for the whole program, its groups.
pub(super) fn apply(command: Command) -> Command {
    let groups = groups(&command);
    let command = command.mut_subcommands(|sub| {
        let name = sub.get_name().to_owned();
        let examples = EXAMPLES.iter().find(|(known, _)| *known == name);
        let sub = words(sub);
        match examples {
            Some((_, lines)) => sub.after_help(format!("Examples:\n  {}", lines.join("\n  "))),
            None => sub,
        }
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

/// The commands by groups, with their descriptions.
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
            let known = EXAMPLES.iter().find(|(known, _)| *known == name);
            let (_, lines) = known.unwrap_or_else(|| panic!("{name} has no example"));
            for line in *lines {
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
}
