//! Rules as text, from which the reader reads the same rules.

use super::pattern::{Pattern, PatternNode};
use super::rule::Rule;
use robovec_analysis::class::NumericClass;
use robovec_ir::Operation;
use std::fmt::{self, Write};

/// A piece of text and how strongly its outermost operation binds.
struct TermText {
    text: String,
    strength: u32,
}

impl TermText {
    /// The text, in parentheses when it binds more weakly than needed.
    fn within(&self, least: u32) -> String {
        if self.strength < least {
            format!("({})", self.text)
        } else {
            self.text.clone()
        }
    }
}

/// The binding strength of an operator between two operands.
fn strength(operation: Operation) -> u32 {
    match operation {
        Operation::Add | Operation::Sub => 1,
        _ => 2,
    }
}

/// Strength of a value, a call or a parenthesis.
const VALUE: u32 = 4;
/// Strength of a minus sign before a value.
const SIGN: u32 = 3;

impl Pattern {
    /// The pattern as text, with the names of its variables.
    pub fn to_text(&self, variables: &[String]) -> String {
        let mut pieces: Vec<TermText> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let piece = match *node {
                PatternNode::Variable(variable) => TermText {
                    text: variables[variable as usize].clone(),
                    strength: VALUE,
                },
                PatternNode::Number(number) => TermText {
                    text: format!("{number}"),
                    strength: if number < 0.0 { SIGN } else { VALUE },
                },
                PatternNode::Operation(operation, [a, b]) => {
                    operation_text(operation, &pieces[a as usize], &pieces[b as usize])
                }
            };
            pieces.push(piece);
        }
        pieces.pop().expect("a pattern has a root").text
    }
}

fn operation_text(operation: Operation, a: &TermText, b: &TermText) -> TermText {
    let sign = match operation {
        Operation::Add => " + ",
        Operation::Sub => " - ",
        Operation::Mul => "*",
        Operation::Div => "/",
        // A sign before a number would be read as part of the number.
        Operation::Neg if !a.text.starts_with(|first: char| first.is_ascii_digit()) => {
            return TermText {
                text: format!("-{}", a.within(VALUE)),
                strength: SIGN,
            };
        }
        _ => {
            return TermText {
                text: format!("{}({})", operation.name(), a.text),
                strength: VALUE,
            };
        }
    };
    let strength = strength(operation);
    TermText {
        text: format!("{}{sign}{}", a.within(strength), b.within(strength + 1)),
        strength,
    }
}

impl fmt::Display for Rule {
    /// The rule as a statement of a rule file, in one line.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let arrow = if self.both_ways { "<=>" } else { "=>" };
        let left = self.left.to_text(&self.variables);
        let right = self.right.to_text(&self.variables);
        write!(formatter, "rule {}: {left} {arrow} {right}", self.name)?;
        for (index, condition) in self.conditions.iter().enumerate() {
            let word = if index == 0 { " when" } else { "," };
            let name = condition.requirement.name();
            let variable = &self.variables[condition.variable as usize];
            write!(formatter, "{word} {name}({variable})")?;
        }
        if self.class != NumericClass::Approximating {
            write!(formatter, " class={}", self.class)?;
        }
        if !self.reason.is_empty() {
            write!(formatter, " \"{}\"", self.reason)?;
        }
        formatter.write_char(';')
    }
}
