//! Ranges of inputs by the precondition of a core.
//!
//! Comparisons of one variable with numbers become its range, with both ends:
//! `<` is read as `<=`. Other conditions of `:pre` are left out, which makes
//! the ranges larger than needed and never too small.

use super::CoreProblems;
use super::core::Core;
use super::number::{CoreLiteral, literal};
use robovec_ir::diagnostic::{Diagnostic, Label};
use robovec_ir::parenthesised::{Forest, error};
use robovec_ir::states::Ranges;
use std::collections::BTreeMap;

enum ComparedSide<'a> {
    Number(f64),
    Variable(&'a str),
}

/// The ranges of the arguments, which their names in the file give.
pub(super) fn ranges(
    forest: &Forest<'_>,
    core: &Core,
    arguments: &BTreeMap<String, String>,
    problems: &mut CoreProblems,
) -> Ranges {
    let mut found: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    let Some(condition) = core.property(forest, ":pre") else {
        return Ranges::default();
    };
    let mut open = vec![condition];
    while let Some(tree) = open.pop() {
        match forest.head(tree) {
            Some("and") => open.extend(forest.elements(tree)[1..].iter().rev()),
            Some(relation @ ("<" | "<=" | ">" | ">=" | "==")) => {
                let sides = forest.elements(tree)[1..].iter();
                let sides: Option<Vec<ComparedSide<'_>>> =
                    sides.map(|&side| read(forest, side, arguments)).collect();
                let known = sides.is_some_and(|sides| compare(relation, sides, &mut found));
                if !known {
                    left_out(forest, tree, problems);
                }
            }
            _ if forest.atom(tree) == Some("TRUE") => {}
            _ => left_out(forest, tree, problems),
        }
    }
    let mut ranges = Ranges::default();
    for (name, input) in arguments {
        match found.get(name.as_str()).copied() {
            Some([low, high]) if low > high => {
                let span = forest.get(condition).span.clone();
                let message = format!("no value of '{name}' satisfies this");
                problems.errors.push(error(span, message));
            }
            Some([low, high]) if low.is_finite() && high.is_finite() => {
                ranges.set(input, [0, 0], low, high);
            }
            Some(_) | None => {
                let message = format!("':pre' gives '{name}' no range with two ends");
                warn(forest, condition, message, problems);
            }
        }
    }
    ranges
}

fn warn(forest: &Forest<'_>, tree: u32, message: String, problems: &mut CoreProblems) {
    let label = Label::primary(0, forest.get(tree).span.clone());
    let warning = Diagnostic::warning().with_message(message);
    problems.warnings.push(warning.with_labels(vec![label]));
}

fn left_out(forest: &Forest<'_>, tree: u32, problems: &mut CoreProblems) {
    let message = "this condition gives no range of an input and is left out".to_owned();
    warn(forest, tree, message, problems);
}

/// Adds the range that a comparison gives; `false` when it gives none.
fn compare<'a>(
    relation: &str,
    mut sides: Vec<ComparedSide<'a>>,
    found: &mut BTreeMap<&'a str, [f64; 2]>,
) -> bool {
    if relation.starts_with('>') {
        sides.reverse();
    }
    let variables = sides
        .iter()
        .filter(|side| matches!(side, ComparedSide::Variable(_)));
    let alone = variables.count() == 1;
    let numbers = |sides: &[ComparedSide<'_>], start: f64, pick: fn(f64, f64) -> f64| {
        sides.iter().fold(start, |found, side| match side {
            ComparedSide::Number(number) => pick(found, *number),
            ComparedSide::Variable(_) => found,
        })
    };
    for (place, side) in sides.iter().enumerate() {
        let ComparedSide::Variable(name) = side else {
            continue;
        };
        // Equality does not ask on which side a number stands.
        let (before, after) = match relation {
            "==" => (&sides[..], &sides[..]),
            _ => (&sides[..place], &sides[place..]),
        };
        let low = numbers(before, f64::NEG_INFINITY, f64::max);
        let high = numbers(after, f64::INFINITY, f64::min);
        let whole = [f64::NEG_INFINITY, f64::INFINITY];
        let range = found.entry(name).or_insert(whole);
        *range = [range[0].max(low), range[1].min(high)];
    }
    alone
}

/// A side that is a variable or a number.
fn read<'a>(
    forest: &Forest<'_>,
    tree: u32,
    arguments: &'a BTreeMap<String, String>,
) -> Option<ComparedSide<'a>> {
    if let Some(atom) = forest.atom(tree) {
        return match arguments.get_key_value(atom) {
            Some((name, _)) => Some(ComparedSide::Variable(name)),
            None => number(atom).map(ComparedSide::Number),
        };
    }
    // Its rounding moves an end by half a unit in the last place.
    let [operation, operands @ ..] = forest.elements(tree) else {
        return None;
    };
    let operands = operands
        .iter()
        .map(|&operand| number(forest.atom(operand)?));
    let operands: Vec<f64> = operands.collect::<Option<_>>()?;
    let result = match (forest.atom(*operation)?, operands.as_slice()) {
        ("-", [a]) => -a,
        ("+", [a, b]) => a + b,
        ("-", [a, b]) => a - b,
        ("*", [a, b]) => a * b,
        ("/", [a, b]) => a / b,
        _ => return None,
    };
    result.is_finite().then_some(ComparedSide::Number(result))
}

fn number(atom: &str) -> Option<f64> {
    match literal(atom) {
        CoreLiteral::Number(number) | CoreLiteral::Long(number) => Some(number),
        CoreLiteral::TooLarge | CoreLiteral::TooSmall | CoreLiteral::None => None,
    }
}
