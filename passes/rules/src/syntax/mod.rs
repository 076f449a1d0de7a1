//! Rules in the syntax of other tools: programs of egglog and rule groups of
//! Herbie. Both are parenthesised text and share a reader.
//!
//! What is lost: egglog has no place for a class, Herbie none for conditions
//! (rules that have any are left out) nor for both ways (two rules). A
//! variable with a condition becomes a number, `(Num a)`, in egglog, since
//! only of numbers it is known that the condition holds.

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

/// Reads the rules of a text. Beside them warnings about rules that robovec
/// cannot express; they are left out.
///
/// # Errors
///
/// What is malformed, with its place.
pub fn import(text: &str, file_name: &str, syntax: Syntax) -> Result<(RuleSet, Report), Report> {
    read::import(text, file_name, syntax)
}

/// The rules as a text of another tool.
pub fn export(set: &RuleSet, syntax: Syntax) -> String {
    write::export(set, syntax)
}
