//! Files that show a mistake of a pass, and running them again.
//!
//! A reproducer is a program in the text form under a header of comments: `//
//! RUN:` as the file tests of passes have it, so that it can become one, and
//! `// reproduce:` with the command that `--run-reproducer` obeys.

use super::CommandFailure;
use super::arguments::OptimiserArguments;
use super::input::USUAL_MACHINE;
use robovec_framework::pipeline::Pipeline;
use robovec_ir::{Machine, Module, print};
use std::fmt::Write;
use std::path::Path;

/// Beginning of the line with the command.
const COMMAND: &str = "// reproduce: robovec-opt FILE";

/// Random points of the check.
pub(super) fn points(arguments: &OptimiserArguments) -> u32 {
    arguments.check_each.unwrap_or(4)
}

/// True if a pass of the pipeline writes by the template of `--target`.
pub(super) fn uses_target(pipeline: &Pipeline) -> bool {
    pipeline.to_string().contains("target=template")
}

/// The text of a reproducer; `about` becomes comments.
pub(super) fn text(
    program: &Module,
    pipeline: &Pipeline,
    arguments: &OptimiserArguments,
    about: &str,
) -> String {
    let machine = arguments.machine.as_deref().unwrap_or(USUAL_MACHINE);
    let shipped = match Machine::built_in(machine) {
        Some(_) if machine != USUAL_MACHINE => format!(" {machine}"),
        Some(_) | None => String::new(),
    };
    let mut text = format!("// RUN: {pipeline}{shipped}\n{COMMAND}");
    let points = points(arguments);
    let mut words = vec![
        format!("--passes={pipeline}"),
        format!("--check-each={points}"),
        format!("--seed={}", arguments.seed),
    ];
    // Without either the machine is the scene's.
    if arguments.machine.is_some() || arguments.scene.is_none() {
        words.insert(1, format!("--machine={machine}"));
    }
    words.extend(arguments.rules.iter().map(|name| format!("--rules={name}")));
    if let Some(target) = &arguments.target
        && uses_target(pipeline)
    {
        words.push(format!("--target={}", target.display()));
    }
    if let Some(scene) = &arguments.scene {
        words.push(format!("--scene={}", scene.display()));
    }
    if arguments.no_default_rules {
        words.push("--no-default-rules".to_owned());
    }
    for word in words {
        // Writing to a string cannot fail.
        let _ = write!(text, " {}", quoted(&word));
    }
    text.push('\n');
    for line in about.lines() {
        let _ = writeln!(text, "// {line}");
    }
    text + &print::print_module(program)
}

fn quoted(word: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_./=,:@%+".contains(&byte);
    if !word.is_empty() && word.bytes().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// The command in a reproducer, as words, without the program and the file.
pub(super) fn command(path: &Path, text: &str) -> Result<Vec<String>, CommandFailure> {
    let line = text.lines().find_map(|line| line.strip_prefix(COMMAND));
    let words = line.and_then(words);
    words.ok_or_else(|| {
        CommandFailure::advised(
            format!("{} is not a reproducer", path.display()),
            vec![format!(
                "it needs a line '{COMMAND} OPTIONS'; '--reproducer FILE' and '--auto-reduce' \
                 write such files"
            )],
        )
    })
}

/// Splits a line as a shell does; `None` when a quote is not closed.
fn words(line: &str) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match letter {
            ' ' => words.extend(word.take()),
            '\'' => {
                let word = word.get_or_insert_default();
                loop {
                    match letters.next()? {
                        '\'' => break,
                        inside => word.push(inside),
                    }
                }
            }
            '\\' => word.get_or_insert_default().push(letters.next()?),
            other => word.get_or_insert_default().push(other),
        }
    }
    words.extend(word);
    Some(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_words_are_read_back() {
        for word in ["--seed=1", "a b", "it's", "", "fixpoint{max=2}(a,b)", r"\"] {
            let line = format!(" {} x", quoted(word));
            let expected = if word.is_empty() {
                vec!["", "x"]
            } else {
                vec![word, "x"]
            };
            assert_eq!(
                words(&line),
                Some(expected.iter().map(ToString::to_string).collect())
            );
        }
        assert_eq!(words("'open"), None);
    }
}
