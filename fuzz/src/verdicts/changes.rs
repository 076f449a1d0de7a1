//! Changes that make a true rule false.

use super::theorems::number;
use super::{parsed, precise};
use arbitrary::{Result, Unstructured};
use robovec_ir::Operation;
use robovec_rules::{Pattern, PatternNode, Rule};

/// A false rule made from a true one; `None` when the change did not make it
/// false, or not for certain.
pub(super) fn changed(bytes: &mut Unstructured<'_>, rule: &Rule) -> Result<Option<Rule>> {
    let mut changed = rule.clone();
    // True when the change is false by construction and needs no trial.
    let certain = match bytes.int_in_range(0..=9)? {
        0 => number_changed(bytes, &mut changed.right)?,
        1 => number_changed(bytes, &mut changed.left)?,
        2 | 3 => operation_changed(bytes, &mut changed.right)?,
        4 => operand_changed(bytes, &mut changed.right)?,
        5 => term_added(bytes, &mut changed.right)?,
        6 | 7 => hole(bytes, &mut changed)?,
        8 => root(bytes, &mut changed)?,
        _ => {
            if changed.conditions.is_empty() {
                return Ok(None);
            }
            changed.conditions.clear();
            false
        }
    };
    // The changed patterns may not form a rule.
    let Some(again) = parsed(&changed.to_string()) else {
        return Ok(None);
    };
    Ok((certain || precise::is_false(&again)).then_some(again))
}

/// A node that a test takes.
fn some_node(
    bytes: &mut Unstructured<'_>,
    pattern: &Pattern,
    test: impl Fn(&PatternNode) -> bool,
) -> Result<usize> {
    let nodes = pattern.nodes.iter().enumerate();
    let fitting: Vec<usize> = nodes
        .filter(|(_, node)| test(node))
        .map(|(index, _)| index)
        .collect();
    bytes.choose(&fitting).copied()
}

fn number_changed(bytes: &mut Unstructured<'_>, pattern: &mut Pattern) -> Result<bool> {
    let node = some_node(bytes, pattern, |node| {
        matches!(node, PatternNode::Number(_))
    })?;
    if let PatternNode::Number(number) = &mut pattern.nodes[node] {
        let old = *number;
        *number = match bytes.int_in_range(0..=8)? {
            0 => old + 1.0,
            1 => -old,
            2 => old * 2.0,
            3 => old * 2f64.powi(61),
            4 => old * 2f64.powi(-61),
            5 => old * (1.0 + f64::EPSILON),
            6 => old * (1.0 - 1e-6),
            7 => 0.0,
            _ => 1.0 / old,
        };
        if !number.is_finite() {
            *number = 3.0;
        }
    }
    Ok(false)
}

fn operation_changed(bytes: &mut Unstructured<'_>, pattern: &mut Pattern) -> Result<bool> {
    let node = some_node(bytes, pattern, |node| {
        matches!(node, PatternNode::Operation(..))
    })?;
    if let PatternNode::Operation(operation, [a, b]) = &mut pattern.nodes[node] {
        *operation = match *operation {
            Operation::Add => Operation::Sub,
            Operation::Sub if bytes.arbitrary()? => {
                std::mem::swap(a, b);
                Operation::Sub
            }
            Operation::Sub => Operation::Add,
            Operation::Mul => *bytes.choose(&[Operation::Add, Operation::Div, Operation::Sub])?,
            Operation::Div if bytes.arbitrary()? => {
                std::mem::swap(a, b);
                Operation::Div
            }
            Operation::Div => Operation::Mul,
            Operation::Sin => *bytes.choose(&[Operation::Cos, Operation::Neg])?,
            Operation::Cos => *bytes.choose(&[Operation::Sin, Operation::Sqrt])?,
            Operation::Sqrt => *bytes.choose(&[Operation::Neg, Operation::Sin])?,
            _ => Operation::Sin,
        };
    }
    Ok(false)
}

fn operand_changed(bytes: &mut Unstructured<'_>, pattern: &mut Pattern) -> Result<bool> {
    let node = some_node(bytes, pattern, |node| {
        matches!(node, PatternNode::Operation(..))
    })?;
    let place = bytes.int_in_range(0..=1)?;
    let other = bytes.int_in_range(0..=node - 1)? as u32;
    if let PatternNode::Operation(_, operands) = &mut pattern.nodes[node] {
        operands[place] = other;
    }
    Ok(false)
}

/// Adds a number of any size to a pattern.
fn term_added(bytes: &mut Unstructured<'_>, pattern: &mut Pattern) -> Result<bool> {
    let value: f64 = number(bytes)?.parse().expect("a decimal number");
    let root = pattern.root() as u32;
    let added = pattern.push(PatternNode::Number(value));
    pattern.operation(Operation::Add, &[root, added]);
    Ok(false)
}

/// Multiplies the right side by a quotient of equal terms that is not defined
/// somewhere.
fn hole(bytes: &mut Unstructured<'_>, rule: &mut Rule) -> Result<bool> {
    let variables = rule.left.variables();
    let free: Vec<u32> = variables
        .into_iter()
        .filter(|&variable| rule.requirements(variable).next().is_none())
        .collect();
    let variable = *bytes.choose(&free)?;
    let value: f64 = number(bytes)?.parse().expect("a decimal number");
    let form = bytes.int_in_range(0..=5)?;
    let side = &mut rule.right;
    let root = side.root() as u32;
    let mut zero = || {
        let v = side.push(PatternNode::Variable(variable));
        let k = side.push(PatternNode::Number(value));
        match form {
            0 => side.operation(Operation::Sub, &[v, k]),
            1 => side.operation(Operation::Add, &[k, v]),
            2 => {
                let two = side.push(PatternNode::Number(2.0));
                let twice = side.operation(Operation::Mul, &[two, v]);
                side.operation(Operation::Sub, &[twice, k])
            }
            3 => {
                let square = side.operation(Operation::Mul, &[v, v]);
                side.operation(Operation::Sub, &[square, k])
            }
            4 => {
                let times = side.operation(Operation::Mul, &[v, k]);
                let one = side.push(PatternNode::Number(1.0));
                side.operation(Operation::Sub, &[times, one])
            }
            _ => side.operation(Operation::Cos, &[v]),
        }
    };
    let (above, below) = (zero(), zero());
    let product = rule.right.operation(Operation::Mul, &[root, above]);
    rule.right.operation(Operation::Div, &[product, below]);
    // Every term has a real zero; the left side is defined there when it is
    // defined everywhere.
    Ok(!rule
        .left
        .uses(|operation| matches!(operation, Operation::Div | Operation::Sqrt)))
}

/// Makes the right side a root of its square, or the left side the root of the
/// square of the right side: false for negative values.
fn root(bytes: &mut Unstructured<'_>, rule: &mut Rule) -> Result<bool> {
    let square_root = |side: &mut Pattern| {
        let root = side.root() as u32;
        let square = side.operation(Operation::Mul, &[root, root]);
        side.operation(Operation::Sqrt, &[square]);
    };
    if bytes.arbitrary()? {
        square_root(&mut rule.right);
    } else {
        square_root(&mut rule.left);
    }
    Ok(false)
}
