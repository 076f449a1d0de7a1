//! Rules for other tools.

use super::super::RuleSet;
use super::super::pattern::{Pattern, PatternNode};
use super::super::rule::{Requirement, Rule};
use super::Syntax;
use robovec_ir::Operation;
use std::fmt::Write;

/// The sort of terms and its constructors, which every program declares.
const DATATYPE: &str = "(datatype Math\n  (Num f64)\n  (Var String)\n  (Add Math Math)\n  \
                        (Sub Math Math)\n  (Mul Math Math)\n  (Div Math Math)\n  (Neg Math)\n  \
                        (Sin Math)\n  (Cos Math)\n  (Sqrt Math))\n\n";

pub(super) fn export(set: &RuleSet, syntax: Syntax) -> String {
    match syntax {
        Syntax::Egglog => egglog(set),
        Syntax::Herbie => herbie(set),
    }
}

fn egglog(set: &RuleSet) -> String {
    let mut text = DATATYPE.to_owned();
    for rule in &set.rules {
        let command = if rule.both_ways {
            "birewrite"
        } else {
            "rewrite"
        };
        let side = |pattern| term(pattern, rule, Syntax::Egglog);
        let (left, right) = (side(&rule.left), side(&rule.right));
        let conditions: Vec<String> = rule
            .conditions
            .iter()
            .filter_map(|condition| {
                let variable = &rule.variables[condition.variable as usize];
                match condition.requirement {
                    Requirement::Constant => None,
                    Requirement::Nonzero => Some(format!("(!= {variable} 0.0)")),
                    Requirement::Positive => Some(format!("(> {variable} 0.0)")),
                }
            })
            .collect();
        let when = match conditions[..] {
            [] => String::new(),
            _ => format!(" :when ({})", conditions.join(" ")),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "; {}: {}", rule.name, rule.reason);
        let _ = writeln!(text, "({command} {left} {right}{when})");
    }
    text
}

fn herbie(set: &RuleSet) -> String {
    let mut text = String::new();
    let mut group: Option<&str> = None;
    for rule in &set.rules {
        if group != Some(&rule.group) {
            text.push_str(if group.is_some() { "\n)\n\n" } else { "" });
            let _ = write!(text, "(define-rules {}", rule.group);
            group = Some(&rule.group);
        }
        if !rule.conditions.is_empty() {
            let _ = write!(text, "\n  ; {} has conditions: left out", rule.name);
            continue;
        }
        if !rule.reason.is_empty() {
            let _ = write!(text, "\n  ; {}", rule.reason);
        }
        for rule in rule.directed() {
            let side = |pattern| term(pattern, &rule, Syntax::Herbie);
            let name = rule.name.replace('.', "-");
            let (left, right) = (side(&rule.left), side(&rule.right));
            let _ = write!(text, "\n  [{name} {left} {right}]");
        }
    }
    text.push_str(if group.is_some() { "\n)\n" } else { "" });
    text
}

fn name(operation: Operation, syntax: Syntax) -> &'static str {
    let (egglog, herbie) = match operation {
        Operation::Add => ("Add", "+"),
        Operation::Sub => ("Sub", "-"),
        Operation::Mul => ("Mul", "*"),
        Operation::Div => ("Div", "/"),
        Operation::Neg => ("Neg", "neg"),
        Operation::Sin => ("Sin", "sin"),
        Operation::Cos => ("Cos", "cos"),
        Operation::Sqrt => ("Sqrt", "sqrt"),
        other => (other.name(), other.name()),
    };
    match syntax {
        Syntax::Egglog => egglog,
        Syntax::Herbie => herbie,
    }
}

fn term(pattern: &Pattern, rule: &Rule, syntax: Syntax) -> String {
    let mut texts: Vec<String> = Vec::with_capacity(pattern.nodes.len());
    for node in &pattern.nodes {
        let text = match *node {
            PatternNode::Variable(variable) => {
                let name = rule.variables[variable as usize].clone();
                // A condition is known to hold of numbers only.
                let is_number = rule.requirements(variable).next().is_some();
                match (syntax, is_number) {
                    (Syntax::Egglog, true) => format!("(Num {name})"),
                    _ => name,
                }
            }
            PatternNode::Number(number) => match syntax {
                Syntax::Egglog => format!("(Num {number:?})"),
                Syntax::Herbie => format!("{number}"),
            },
            PatternNode::Operation(operation, operands) => {
                let operands = &operands[..operation.arity()];
                let operands: Vec<&str> = operands
                    .iter()
                    .map(|&operand| texts[operand as usize].as_str())
                    .collect();
                format!("({} {})", name(operation, syntax), operands.join(" "))
            }
        };
        texts.push(text);
    }
    texts.pop().expect("a pattern has a root")
}
