//! Trees as patterns.

use super::super::pattern::{Pattern, PatternNode};
use robovec_ir::Operation;
use robovec_ir::diagnostic::{Diagnostic, clip};
use robovec_ir::parenthesised::{Forest, error};
use robovec_num::decimal;

/// The reason why a tree is no pattern.
pub(super) enum PatternProblem {
    /// It is well formed, but robovec has no such operation.
    Unsupported(Diagnostic),
    /// It is wrong.
    Wrong(Diagnostic),
}

/// The sides of one rule as read.
#[derive(Default)]
pub(super) struct RuleSides {
    pub(super) variables: Vec<String>,
    /// Variables written as `(Num a)`: they are numbers.
    pub(super) constants: Vec<u32>,
}

/// A step of reading: a tree still to be read, or an operation whose operands
/// have been read.
enum ReadingStep {
    Read(u32),
    Apply(Operation, usize),
}

impl RuleSides {
    /// The number of a variable.
    pub(super) fn variable(&mut self, name: &str) -> u32 {
        // Egg marks its variables.
        let name = name.trim_start_matches('?');
        let known = self.variables.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            self.variables.push(name.to_owned());
            self.variables.len() - 1
        }) as u32
    }

    /// The pattern of a tree.
    pub(super) fn pattern(
        &mut self,
        forest: &Forest<'_>,
        root: u32,
    ) -> Result<Pattern, PatternProblem> {
        let mut pattern = Pattern::default();
        let mut operands: Vec<u32> = Vec::new();
        let mut steps = vec![ReadingStep::Read(root)];
        while let Some(step) = steps.pop() {
            if pattern.nodes.len() >= Pattern::LARGEST {
                let most = Pattern::LARGEST;
                let message = format!("a side of a rule has at most {most} operations and values");
                return Err(PatternProblem::Wrong(error(
                    forest.get(root).span.clone(),
                    message,
                )));
            }
            match step {
                ReadingStep::Apply(operation, arity) => {
                    let from = operands.len() - arity;
                    let taken = operands.split_off(from);
                    operands.push(pattern.operation(operation, &taken));
                }
                ReadingStep::Read(tree) => {
                    if let Some(node) = self.leaf(forest, tree)? {
                        operands.push(pattern.push(node));
                        continue;
                    }
                    let operation = operation(forest, tree)?;
                    let children = &forest.elements(tree)[1..];
                    steps.push(ReadingStep::Apply(operation, children.len()));
                    steps.extend(children.iter().rev().map(|&child| ReadingStep::Read(child)));
                }
            }
        }
        Ok(pattern)
    }

    /// A variable or number: an atom, `(Num …)` or `(Var "…")`.
    fn leaf(
        &mut self,
        forest: &Forest<'_>,
        tree: u32,
    ) -> Result<Option<PatternNode>, PatternProblem> {
        let wrapped = match forest.elements(tree) {
            [head, inner] => forest.atom(*head).zip(forest.atom(*inner)),
            _ => None,
        };
        let (atom, is_number) = match (forest.atom(tree), wrapped) {
            (Some(atom), _) => (atom, false),
            (None, Some((head, atom))) if head.eq_ignore_ascii_case("num") => (atom, true),
            _ => return Ok(None),
        };
        let span = forest.get(tree).span.clone();
        if let Some(number) = number(atom) {
            if !number.is_finite() {
                let message = format!("the number {} is too large", clip(atom));
                return Err(PatternProblem::Wrong(error(span, message)));
            }
            if decimal::is_lost(atom, number) {
                let message = format!("the number {} is too small", clip(atom));
                return Err(PatternProblem::Wrong(error(span, message)));
            }
            return Ok(Some(PatternNode::Number(number + 0.0)));
        }
        let mut letters = atom.trim_start_matches('?').chars();
        let is_name = letters
            .next()
            .is_some_and(|first| first.is_alphabetic() || first == '_')
            && letters.all(|letter| letter.is_alphanumeric() || letter == '_');
        if !is_name || ["PI", "E", "INFINITY", "NAN"].contains(&atom) {
            let message = format!("'{}' is not a variable or number of robovec", clip(atom));
            return Err(PatternProblem::Unsupported(error(span, message)));
        }
        let variable = self.variable(atom);
        if is_number && !self.constants.contains(&variable) {
            self.constants.push(variable);
        }
        Ok(Some(PatternNode::Variable(variable)))
    }
}

/// A number, possibly a fraction such as `1/2`.
pub(super) fn number(atom: &str) -> Option<f64> {
    let parse = |text: &str| {
        let digits = text.trim_start_matches(['-', '+']);
        let starts = digits.starts_with(|first: char| first.is_ascii_digit() || first == '.');
        starts.then(|| text.parse::<f64>().ok()).flatten()
    };
    match atom.split_once('/') {
        Some((above, below)) => Some(parse(above)? / parse(below)?),
        None => parse(atom),
    }
}

/// The operation a list applies, with the right number of operands.
fn operation(forest: &Forest<'_>, tree: u32) -> Result<Operation, PatternProblem> {
    let span = forest.get(tree).span.clone();
    let Some(head) = forest.head(tree) else {
        let message = "expected an operation with its operands";
        return Err(PatternProblem::Wrong(error(span, message)));
    };
    let count = forest.elements(tree).len() - 1;
    let operation = match head.to_lowercase().as_str() {
        "+" | "add" => Operation::Add,
        "-" | "sub" if count != 1 => Operation::Sub,
        "-" | "neg" => Operation::Neg,
        "*" | "mul" => Operation::Mul,
        "/" | "div" => Operation::Div,
        "sin" => Operation::Sin,
        "cos" => Operation::Cos,
        "sqrt" => Operation::Sqrt,
        _ => {
            let head_span = forest.get(forest.elements(tree)[0]).span.clone();
            let message = format!("robovec has no operation '{}'", clip(head));
            return Err(PatternProblem::Unsupported(error(head_span, message)));
        }
    };
    if operation.arity() != count {
        let wanted = match operation.arity() {
            1 => "one operand",
            _ => "two operands",
        };
        let message = format!("'{}' takes {wanted}, not {count}", clip(head));
        return Err(PatternProblem::Wrong(error(span, message)));
    }
    Ok(operation)
}
