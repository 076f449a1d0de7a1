//! Rules in the syntax of other tools: programs of egglog and rule groups of
//! Herbie. Both are parenthesised text and share a reader.
//!
//! Losses: egglog has no place for a class, and Herbie none for conditions
//! (rules with conditions are left out) or for both directions (two rules). A
//! variable with a condition becomes a number, `(Num a)`, in egglog, since the
//! condition can be tested only for numbers.

mod read;
mod term;
#[cfg(test)]
mod tests;
mod write;

use super::RuleSet;
use robovec_ir::diagnostic::Report;

/// A syntax of another tool.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Syntax {
    /// `(rewrite left right)` and `(birewrite left right)` of egglog, with
    /// the constructors `Add`, `Sub`, `Mul`, `Div`, `Neg`, `Sin`, `Cos`,
    /// `Sqrt` and `Num`.
    Egglog,
    /// `(define-rules group [name left right] …)` of Herbie.
    Herbie,
}

/// Reads the rules of a text. Also warnings about rules that robovec cannot
/// express; they are left out.
///
/// # Errors
///
/// The malformed part, with its place.
pub fn import(text: &str, file_name: &str, syntax: Syntax) -> Result<(RuleSet, Report), Report> {
    read::import(text, file_name, syntax)
}

/// The rules as a text of another tool.
pub fn export(set: &RuleSet, syntax: Syntax) -> String {
    write::export(set, syntax)
}
