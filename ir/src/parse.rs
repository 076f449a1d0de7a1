//! The text form, read.
//!
//! Reading and writing are inverse at every level: `parse(print(m)) == m`,
//! and `print(parse(t)) == t` for printed `t`. Text written by hand may be
//! laid out freely (`docs/text-format.md`).
//!
//! The grammar (`grammar.lalrpop`) describes single statements; its `builder`
//! has the state of the function and line, and makes nodes immediately. After
//! an error reading continues at the next line. Rules beyond the grammar are
//! left to the [verifier](crate::verify), whose answers get places in the text;
//! so text that parses is always a verified module.

mod attributes;
mod body;
mod builder;
mod finish;
mod header;
mod lexer;
mod names;
mod parts;
mod problems;
mod syntax;
mod undefined;

lalrpop_util::lalrpop_mod!(
    #[allow(
        clippy::all,
        clippy::unwrap_used,
        missing_docs,
        private_interfaces,
        unreachable_pub,
        unused_parens,
        unused_imports
    )]
    grammar,
    "/parse/grammar.rs"
);

use crate::diagnostic::{Diagnostic, Label};
use crate::machine::Machine;
use crate::module::Module;
use crate::print::HEADER;
use builder::ModuleBuilder;
use lexer::Tokens;
use robovec_num::limits::NumberLimit;

/// The limits of numbers in the text form: name, limit, and the default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("elements of all inputs", header::INPUT_ELEMENTS, ""),
    ("elements of all outputs", header::OUTPUT_ELEMENTS, ""),
    ("cycle", builder::CYCLE, ""),
    ("address", builder::ADDRESS, ""),
    ("elements of a kind in a schedule", builder::ELEMENT, ""),
];

/// Texts of this many bytes and more are refused.
const MAX_BYTES: usize = 1 << 31;

/// Reads a module from its text form. The name is that of the file, for
/// messages that must state it; labels refer to file 0.
///
/// # Errors
///
/// Messages for the first twenty errors, in order of their place, when the
/// text is not a module that the [verifier](crate::verify) accepts.
pub fn parse_module(name: &str, text: &str) -> Result<Module, Vec<Diagnostic>> {
    parse_with(name, text, None)
}

/// A machine, and the test for functions, by name, that are verified for it.
#[derive(Clone, Copy)]
pub struct VerificationTarget<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Called with the name of every function.
    pub wanted: &'a dyn Fn(&str) -> bool,
}

/// As [`parse_module`]; schedules must be for the machine, too, and
/// placements right on it.
///
/// # Errors
///
/// As [`parse_module`], and the violations that
/// [`verify_placement`](crate::verify::verify_placement) finds, at their
/// places in the text.
pub fn parse_placed(
    name: &str,
    text: &str,
    target: VerificationTarget<'_>,
) -> Result<Module, Vec<Diagnostic>> {
    parse_with(name, text, Some(target))
}

fn parse_with(
    name: &str,
    text: &str,
    target: Option<VerificationTarget<'_>>,
) -> Result<Module, Vec<Diagnostic>> {
    if text.len() >= MAX_BYTES {
        let message = format!("{name} is larger than 2 GiB, which no function needs");
        return Err(vec![Diagnostic::error().with_message(message)]);
    }
    check_version(text)?;
    let mut builder = ModuleBuilder::new(text);
    builder.target = target;
    let mut tokens = Tokens::new(text);
    let parser = grammar::StatementsParser::new();
    while let Err(error) = parser.parse(&mut builder, &mut tokens) {
        builder.syntax_error(error, &tokens);
        if builder.is_full() {
            break;
        }
        tokens.skip_statement();
    }
    builder.finish()
}

/// A first line that names another version of the format is refused; no such
/// line is needed in text written by hand.
fn check_version(text: &str) -> Result<(), Vec<Diagnostic>> {
    let mut lines = text.split(['\r', '\n']);
    let line = lines.next().expect("a text has a first part");
    let stem = HEADER.trim_end_matches(|character: char| character.is_ascii_digit());
    let Some(version) = line.trim_end().strip_prefix(stem) else {
        return Ok(());
    };
    let number = !version.is_empty() && version.bytes().all(|byte| byte.is_ascii_digit());
    if !number || line.trim_end() == HEADER {
        return Ok(());
    }
    Err(vec![
        Diagnostic::error()
            .with_message(format!("version {version} of the text form is not known"))
            .with_label(Label::primary(0, 0..line.len()))
            .with_note(format!(
                "help: this program reads text that begins with '{HEADER}'"
            )),
    ])
}
