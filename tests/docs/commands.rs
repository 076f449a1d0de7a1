//! The page `docs/commands.md`: its prose is written by hand, and its groups,
//! words and former commands are those of the program.

use robovec::command::commands;
use robovec::command::grammar::{FORMER, GROUPS, WORDS, about, examples};
use std::fmt::Write;

/// The page with the groups of commands as they are now.
///
/// # Panics
///
/// Panics when the written page lacks a word or a former command.
pub(super) fn page(written: &str) -> String {
    for (long, value) in WORDS {
        let value = value.map_or_else(String::new, |value| format!(" {value}"));
        let row = format!("\n| `--{long}{value}` | ");
        assert!(written.contains(&row), "docs/commands.md lacks {row}");
    }
    for (line, now) in FORMER {
        let row = format!("\n| `robovec {line}` | `robovec {now}` | ");
        assert!(written.contains(&row), "docs/commands.md lacks {row}");
    }
    let first = format!("\n## {}\n", GROUPS[0].0);
    let (before, rest) = written.split_once(&first).expect("groups of commands");
    let (_, after) = rest.split_once("\n## In shares\n").expect("a section");
    format!("{before}{}\n## In shares\n{after}", groups())
}

fn groups() -> String {
    let [_, tool] = commands();
    let mut text = String::new();
    for (title, names) in GROUPS {
        writeln!(text, "\n## {title}\n").expect("text takes all that is written");
        for name in names {
            let lines = examples(name);
            assert!(!lines.is_empty(), "'{name}' has examples");
            writeln!(
                text,
                "`robovec {name}`: {}\n\n```sh\n{}\n```\n",
                about(&tool, name),
                lines.join("\n")
            )
            .expect("text takes all that is written");
        }
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}
