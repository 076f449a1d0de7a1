//! The table of limits: every number that a user can write, its range, and the
//! cost of a larger one.
//!
//! Limits are where their numbers are declared ([`NumberLimit`]); this
//! module, above all rooms that declare some, only gathers them, for the manual (`docs/limits.md`) and for the
//! tests that try every number at its ends.

use crate::{evaluate_command, motion, robotran, scene, study};
use robovec_framework::pipeline;
use robovec_io::files::limited;
use robovec_ir::parse;
use robovec_model::{family, mbs};
pub use robovec_num::limits::LimitRow;
use robovec_num::limits::{self, NumberLimit};
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;

/// A part of the table: its subject, a remark, and its lines.
#[derive(Clone, PartialEq, Debug)]
pub struct LimitSection {
    /// The title.
    pub title: &'static str,
    /// Remark on all its lines.
    pub remark: &'static str,
    /// The lines.
    pub rows: Vec<LimitRow>,
}

/// The table.
pub fn sections() -> Vec<LimitSection> {
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
            pipeline::limits(&REGISTRY),
        ),
        section(
            "Flags of programs",
            "For a flag that takes a list, the limit applies to every number in the list.",
            super::commands()
                .iter()
                .flat_map(super::flags::rows)
                .collect(),
        ),
        section("Numbers in words of the command line", "", words()),
        section(
            "Files that are read",
            "In bytes. Folders, devices and named pipes are refused; `-` and the pipes of a \
             shell, `<(...)`, are read up to the limit.",
            file_rows(),
        ),
        section("Machine files", "", robovec_ir::machine::fields::rows()),
        section("Scenes", "", limits::rows("scene", scene::FIELDS)),
        section(
            "Laws of `robovec sim`",
            "",
            limits::rows("laws", motion::laws::FIELDS),
        ),
        section(
            "Plans of `robovec explore`",
            "",
            limits::rows("plan", study::plan::FIELDS),
        ),
        section("Models (.mbs)", "", limits::rows("model", mbs::FIELDS)),
        section(
            "Robotran's files",
            "Sizes in comments have the same limits as indices in equations.",
            limits::rows("Robotran file", robotran::FIELDS),
        ),
        section(
            "robovec's own text (.rvir)",
            "",
            limits::rows("text", parse::FIELDS),
        ),
    ]
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
pub fn manual() -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

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
                    limits::Amount::Whole(number as u64)
                } else {
                    limits::Amount::Real(number)
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
}
