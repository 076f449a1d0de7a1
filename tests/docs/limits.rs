//! The table of limits: every number that a user can write, its range, and the
//! cost of a larger one.
//!
//! Limits are where their numbers are declared ([`NumberLimit`]); this
//! module gathers them, for the manual (`docs/limits.md`) and for the tests
//! that try every number at its ends.

use clap::Command;
use robovec::command::{commands, flags::FlagLimit};
use robovec::{evaluate_command, files::limited, motion, robotran, scene, study};
use robovec_framework::pipeline::{DEFAULT_ROUNDS, ROUNDS};
use robovec_ir::{machine, parse};
use robovec_model::{family, mbs};
use robovec_num::limits::{Amount, NumberLimit};
use robovec_passes::registry::REGISTRY;
use std::collections::BTreeSet;
use std::fmt::Write;

/// A line of the table of limits.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct LimitRow {
    /// The place of the number: a pass, a program, a kind of file.
    pub(crate) place: String,
    /// Its name in that source.
    pub(crate) name: String,
    /// Allowed numbers.
    pub(crate) limit: NumberLimit,
    /// The default; empty when the number must be given.
    pub(crate) usual: String,
}

/// The limits of the fields of a kind of file, for the table.
fn field_rows(place: &str, fields: &[(&str, NumberLimit, &str)]) -> Vec<LimitRow> {
    let row = |&(name, limit, usual): &(&str, NumberLimit, &str)| LimitRow {
        place: place.to_owned(),
        name: name.to_owned(),
        limit,
        usual: usual.to_owned(),
    };
    fields.iter().map(row).collect()
}

/// A part of the table: its subject, a remark, and its lines.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct LimitSection {
    /// The title.
    pub(crate) title: &'static str,
    /// Remark on all its lines.
    pub(crate) remark: &'static str,
    /// The lines.
    pub(crate) rows: Vec<LimitRow>,
}

/// The table.
pub(crate) fn sections() -> Vec<LimitSection> {
    let section = |title, remark, rows| LimitSection {
        title,
        remark,
        rows,
    };
    vec![
        section(
            "Options of passes",
            "Written in pipelines: `eqsat{window=20}`. The limits of number formats are in \
             docs/formats.md.",
            pass_rows(),
        ),
        section(
            "Flags of programs",
            "For a flag that takes a list, the limit applies to every number in the list.",
            commands().iter().flat_map(flag_rows).collect(),
        ),
        section("Numbers in words of the command line", "", words()),
        section(
            "Files that are read",
            "In bytes. Folders, devices and named pipes are refused; `-` and the pipes of a \
             shell, `<(...)`, are read up to the limit.",
            file_rows(),
        ),
        section(
            "Machine files",
            "",
            field_rows(
                "machine file",
                &[machine::fields::FIELDS, robovec_num::format::fields::FIELDS].concat(),
            ),
        ),
        section("Scenes", "", field_rows("scene", scene::FIELDS)),
        section(
            "Laws of `robovec sim`",
            "",
            field_rows("laws", motion::laws::FIELDS),
        ),
        section(
            "Plans of `robovec explore`",
            "",
            field_rows("plan", study::plan::FIELDS),
        ),
        section("Models (.mbs)", "", field_rows("model", mbs::FIELDS)),
        section(
            "Robotran's files",
            "Sizes in comments have the same limits as indices in equations.",
            field_rows("Robotran file", robotran::FIELDS),
        ),
        section(
            "robovec's own text (.rvir)",
            "",
            field_rows("text", parse::FIELDS),
        ),
    ]
}

/// The limits of all options of all passes, and of groups.
fn pass_rows() -> Vec<LimitRow> {
    let mut rows = Vec::new();
    for pass in REGISTRY.passes {
        for option in pass.options {
            rows.extend(option.limit.map(|limit| LimitRow {
                place: pass.name.to_owned(),
                name: option.name.to_owned(),
                limit,
                usual: (option.default)(),
            }));
        }
    }
    rows.push(LimitRow {
        place: "fixpoint".to_owned(),
        name: "max".to_owned(),
        limit: ROUNDS,
        usual: DEFAULT_ROUNDS.to_string(),
    });
    rows
}

/// The limits of a program's flags, subcommands included.
fn flag_rows(command: &Command) -> Vec<LimitRow> {
    let mut rows: Vec<LimitRow> = Vec::new();
    let program = command.get_name();
    let mut rest = vec![(command.get_name().to_owned(), command)];
    while let Some((place, command)) = rest.pop() {
        for flag in command.get_arguments() {
            let Some((&FlagLimit(limit), long)) = flag.get::<FlagLimit>().zip(flag.get_long())
            else {
                continue;
            };
            let usual = flag.get_default_values().iter();
            let usual: Vec<String> = usual
                .map(|value| value.to_string_lossy().into_owned())
                .collect();
            // A global flag is one, in however many commands it is.
            let own = if flag.is_global_set() {
                program
            } else {
                &place
            };
            let name = format!("--{long}");
            if !rows.iter().any(|row| row.place == own && row.name == name) {
                rows.push(LimitRow {
                    place: own.to_owned(),
                    name,
                    limit,
                    usual: usual.join(","),
                });
            }
        }
        let inner = command.get_subcommands();
        let mut inner: Vec<(String, &Command)> = inner
            .map(|inner| (format!("{place} {}", inner.get_name()), inner))
            .collect();
        inner.reverse();
        rest.append(&mut inner);
    }
    rows
}

/// Numbers that are part of a word.
fn words() -> Vec<LimitRow> {
    let row = |place: &str, name: &str, limit: NumberLimit, usual: &str| LimitRow {
        place: place.to_owned(),
        name: name.to_owned(),
        limit,
        usual: usual.to_owned(),
    };
    vec![
        row(
            "robovec bench, front, study, sweep, rules find",
            "serial-N",
            family::JOINTS,
            "",
        ),
        row("robovec eval", "--number BITS", evaluate_command::BITS, ""),
        row(
            "robovec-opt",
            "--bisect-limit P:N",
            robovec_framework::manager::LIMIT,
            "",
        ),
    ]
}

fn file_rows() -> Vec<LimitRow> {
    let row = |file: limited::FileLimit| LimitRow {
        place: "any program".to_owned(),
        name: file.what.to_owned(),
        limit: file.bytes,
        usual: String::new(),
    };
    limited::ALL.into_iter().map(row).collect()
}

/// The table as Markdown; `docs/limits.md` is this text, and a test keeps it
/// so.
pub(crate) fn manual() -> String {
    let mut text = "# Limits\n\n\
        The smallest and the largest value of every number that a user can give, made from the declarations.\n\n\
        A number beyond its limit is refused; the message gives its name, the allowed range and the reason.\n\
        Within the limits a small input takes seconds; for large inputs the largest numbers may \
        take long.\n"
        .to_owned();
    for section in sections() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n## {}\n", section.title);
        if !section.remark.is_empty() {
            let _ = writeln!(text, "{}\n", section.remark);
        }
        text.push_str(
            "| of | number | least | most | usual | why not more |\n|---|---|---|---|---|---|\n",
        );
        for row in &section.rows {
            let _ = writeln!(
                text,
                "| {} | `{}` | {} | {} | {} | {} |",
                row.place,
                row.name,
                row.limit.least(),
                row.limit.most(),
                row.usual,
                row.limit.reason(),
            );
        }
    }
    text
}

#[test]
fn every_number_stands_in_the_table_once_with_a_reason() {
    let mut seen = BTreeSet::new();
    for section in sections() {
        assert!(!section.rows.is_empty(), "{}", section.title);
        for row in section.rows {
            let name = format!("{} {}", row.place, row.name);
            assert!(!row.limit.reason().is_empty(), "{name}");
            assert!(seen.insert(name.clone()), "{name} is listed twice");
        }
    }
}

#[test]
fn what_a_number_usually_is_is_allowed() {
    for row in sections().into_iter().flat_map(|section| section.rows) {
        for usual in row.usual.split(',').filter(|usual| !usual.is_empty()) {
            let Ok(number) = usual.parse::<f64>() else {
                continue;
            };
            let amount = if row.limit.is_whole() {
                Amount::Whole(number as u64)
            } else {
                Amount::Real(number)
            };
            assert!(
                row.limit.admits(amount),
                "{} {}: {usual}",
                row.place,
                row.name
            );
        }
    }
}
