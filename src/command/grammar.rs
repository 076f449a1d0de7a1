//! One grammar for all commands: the words that mean one thing everywhere, the
//! groups of commands, and an example or two of each.
//!
//! **Invariants.** A word of [`WORDS`] takes the same kind of value in every
//! command that has it ([`apply`] writes its name); every command is in one
//! group and has examples, which tests read as command lines. The page
//! `docs/commands.md` is made from here.

use super::former::{FORMER, FormerCommand};
use clap::{Arg, Command};
use robovec_present::number::or_nothing;
use std::fmt::Write;

/// A word of the command line.
struct GrammarWord {
    long: &'static str,
    /// Name of its value; `None` for a word without one.
    value: Option<&'static str>,
    meaning: &'static str,
}

const fn word(
    long: &'static str,
    value: Option<&'static str>,
    meaning: &'static str,
) -> GrammarWord {
    GrammarWord {
        long,
        value,
        meaning,
    }
}

const WORDS: [GrammarWord; 20] = [
    word(
        "function",
        Some("NAME"),
        "a function of a file that has several, or the function to generate from a model (by default `dirdyna`); names separated by commas where several are allowed",
    ),
    word(
        "formulation",
        Some("NAME"),
        "the recursion that generates a model's equations ([generate.md](generate.md))",
    ),
    word(
        "model",
        Some("FILE"),
        "the model that the equations come from, with its parameters and joints",
    ),
    word(
        "passes",
        Some("PIPELINE"),
        "passes to run first ([passes.md](passes.md)); `@FILE` reads them from a file",
    ),
    word(
        "machine",
        Some("MACHINE"),
        "the machine to compile for: a name of `robovec-opt --list-machines`, or a `.toml` file",
    ),
    word(
        "scene",
        Some("FILE"),
        "the scene that describes the use of the functions ([scenes.md](scenes.md))",
    ),
    word(
        "rules",
        Some("FILE"),
        "additional rewriting rules ([rules.md](rules.md))",
    ),
    word(
        "laws",
        Some("FILE"),
        "laws of springs, dampers, forces and driven joints ([sim.md](sim.md))",
    ),
    word(
        "number",
        Some("FORMAT"),
        "the number format of the computation: `f32`, `float(8,17)`, `fixed(12,19)` … ([formats.md](formats.md)); `float` or `double` for C",
    ),
    word("language", Some("LANGUAGE"), "the language to write"),
    word(
        "input-language",
        Some("LANGUAGE"),
        "the language to read, if name and content of the file do not show it",
    ),
    word(
        "states",
        Some("STATES"),
        "the number of random states; `eval` also takes a file of states",
    ),
    word(
        "seed",
        Some("SEED"),
        "the seed of all random points and states; the same seed gives the same bytes",
    ),
    word(
        "jobs",
        Some("N"),
        "the number of threads; by default the number of processors",
    ),
    word(
        "resume",
        None,
        "use the results that an earlier run left in the folder",
    ),
    word(
        "shard",
        Some("K/N"),
        "only this share of the work, for several workers on one folder ([below](#in-shares))",
    ),
    word("json", None, "write the results as JSON instead of text"),
    word(
        "csv",
        None,
        "write the results as a CSV table instead of text",
    ),
    word(
        "quiet",
        None,
        "`-q`: print neither progress nor remarks; warnings and errors are always printed",
    ),
    word(
        "verbose",
        None,
        "`-v`: progress every two seconds, where no terminal is as well (every ten without the word), and how long it took; of `robovec-opt` the time of every pass",
    ),
];

/// Commands grouped by purpose.
pub(super) const GROUPS: [(&str, &[&str]); 5] = [
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
const EXAMPLES: &[(&str, &[&str])] = &[
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
    match WORDS.iter().find(|word| word.long == long) {
        Some(GrammarWord {
            value: Some(value), ..
        }) if flag.get_action().takes_values() => flag.value_name(value),
        Some(_) | None => flag,
    }
}

/// Description of a command, on one line.
fn about(program: &Command, name: &str) -> String {
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

/// The section about several workers on one folder.
const SHARES: &str = "
## In shares

What takes hours can be shared by any number of workers that see one folder and have the same robovec, on one machine or many. A share keeps its results in `results/points` and writes no tables:

```sh
robovec explore bogie serial-23 -o results --shard 1/8
```

A worker that was stopped is started again and goes on; results that were cut off are computed anew. When all are done, one more run writes what a single run writes, byte for byte:

```sh
robovec explore bogie serial-23 -o results --resume
```

All other words are given to every share alike.

| command | what is shared |
|---|---|
| `explore` | choices to be measured; the searches for programs, each with its share of the numbers of elements first |
| `explore --designs` | placements on designs; the searches as for choices |
| `explore --plan` | placements; all of a model after a pipeline are in one share |
| `rules bench` | rules on inputs |
| `optimise` | programs and schedules of the search, as described below |

What `optimise` tries next depends on what came of all that it tried before, so that a share of its search cannot be done alone. There every worker does the whole search, but of the programs that are made at a time first those of its share, and takes from the folder what others have made by then. One that is alone does all of it, and none waits for another. Little is gained: a program that was found must be made again where the search goes on from it ([results](results-processors.md#times-of-the-compiler)). What it is for is a search that was stopped. Errors, times of C and the proof are left to the last run.

`scripts/on-hyperqueue` does all of it with HyperQueue, also on a cluster ([plans.md](plans.md#on-several-machines)); with Slurm alone, an array of jobs with `--shard $SLURM_ARRAY_TASK_ID/8` does.
";

/// The page `docs/commands.md`.
pub fn manual() -> String {
    let [_, tool] = super::commands();
    let mut text = String::from(
        "# The commands\n\n`robovec-opt` compiles; `robovec` does the rest. A subject is a file of \
         equations (Robotran's C, Matlab or Python, `.rvir`, `.fpcore`), a model (`.mbs`, `.urdf`, `.xml`) \
         or the name of a model that is built in (`bogie`, `serial-23`), for every command that \
         takes one.\n\n## Options with the same meaning in all commands\n\n| option | meaning |\n|---|---|\n",
    );
    for GrammarWord {
        long,
        value,
        meaning,
    } in WORDS
    {
        let value = or_nothing(value, |value| format!(" {value}"));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| `--{long}{value}` | {meaning} |");
    }
    text.push_str(
        "| `-o`, `--output` | where results go: a file, or a folder for several |\n| `--force` | \
         replace files that robovec did not write |\n| `--base`, `--right-angles` | how robots \
         (`.urdf`, `.xml`) are read, where models are ([robots.md](robots.md)) |\n| `--tool-seconds` | when compilers and \
         simulators are stopped |\n",
    );
    for (title, names) in GROUPS {
        let _ = writeln!(text, "\n## {title}\n");
        for name in names {
            let _ = writeln!(text, "`robovec {name}`: {}\n", about(&tool, name));
            for (_, lines) in EXAMPLES.iter().filter(|(known, _)| known == name) {
                let _ = writeln!(text, "```sh\n{}\n```\n", lines.join("\n"));
            }
        }
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text.push_str(SHARES);
    text.push_str("\n## Former commands\n\n| before | now | results |\n|---|---|---|\n");
    for FormerCommand { line, now, results } in FORMER {
        let _ = writeln!(text, "| `robovec {line}` | `robovec {now}` | {results} |");
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
                if let Some(word) = WORDS.iter().find(|word| word.long == long) {
                    let takes = flag.get_action().takes_values();
                    assert_eq!(takes, word.value.is_some(), "{place}");
                    let names = flag.get_value_names().unwrap_or_default();
                    let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
                    if let Some(value) = word.value {
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
