//! `inline` undoes `atomise`: taking its equations apart again gives the same
//! operations on the same operands.

use crate::generate::{Kind, module};
use crate::text::{check_round_trip, check_sound, lower};
use arbitrary::{Result, Unstructured};
use robovec_ir::{Function, Level, OperandKind, print};
use std::collections::BTreeMap;

/// Takes a random module apart, puts it together and takes it apart again.
///
/// # Panics
///
/// Panics when the result differs, or an equation is too large.
pub fn inline_undoes_atomise(data: &[u8]) {
    // Too few bytes for a function are no finding.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    let operations = bytes.int_in_range(1..=40)?;
    let kind = *bytes.choose(&[Kind::Tame, Kind::Wild])?;
    let mut module = module(bytes, kind)?;
    let execute = |module: &mut _, text: &str| assert!(lower(module, text, "thesis"));
    execute(&mut module, "atomise");
    let atomic = module.clone();
    execute(&mut module, &format!("inline{{operations={operations}}}"));
    let text = print::print_module(&module);
    for function in &module.functions {
        assert_eq!(function.level, Level::Equations);
        assert!(largest(function) <= operations, "{operations}: {text}");
    }
    check_sound(&module);
    check_round_trip(&module);
    execute(&mut module, "atomise");
    for (left, right) in atomic.functions.iter().zip(&module.functions) {
        assert_eq!(shape(left), shape(right), "{text}");
    }
    Ok(())
}

/// Operations of the largest equation.
fn largest(function: &Function) -> u32 {
    let mut sizes: Vec<u32> = Vec::new();
    for node in function.nodes() {
        let inner = node.operands().iter().filter_map(|operand| operand.value());
        let inner = inner.filter(|value| function.node(*value).name.is_none());
        let own = u32::from(node.operation != robovec_ir::Operation::Copy);
        sizes.push(own + inner.map(|value| sizes[value.index()]).sum::<u32>());
    }
    sizes.into_iter().max().unwrap_or(0)
}

/// Expressions with their numbers of occurrences, and the outputs.
type Shape = (BTreeMap<String, usize>, Vec<u32>, Vec<(u32, String)>);

/// Number of computations of each expression, and the expressions of the
/// outputs, for any names and order.
fn shape(function: &Function) -> Shape {
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let mut counts: Vec<u32> = Vec::new();
    let mut numbers: Vec<usize> = Vec::new();
    let word = |operand: robovec_ir::Operand, numbers: &[usize]| match operand.kind() {
        OperandKind::Value(value) => format!("%{}", numbers[value.index()]),
        OperandKind::Input(input) => format!("in{}", input.0),
        OperandKind::Constant(constant) => {
            format!("{:?}", function.constant_number(constant))
        }
        OperandKind::None => String::new(),
    };
    // Numbers in an order of their own: by depth, then by text, so that the
    // order of the nodes does not matter.
    let mut depths: Vec<u32> = Vec::new();
    for node in function.nodes() {
        let inner = node.operands().iter().filter_map(|operand| operand.value());
        let deepest = inner.map(|value| depths[value.index()] + 1).max();
        depths.push(deepest.unwrap_or(0));
    }
    let mut order: Vec<usize> = (0..depths.len()).collect();
    order.sort_by_key(|&index| depths[index]);
    numbers.resize(depths.len(), 0);
    for level in order.chunk_by(|&a, &b| depths[a] == depths[b]) {
        let mut level: Vec<(String, usize)> = (level.iter())
            .map(|&index| {
                let node = &function.nodes()[index];
                let operands = node.operands.map(|operand| word(operand, &numbers));
                (format!("{} {operands:?}", node.operation.name()), index)
            })
            .collect();
        level.sort();
        for (text, index) in level {
            let next = counts.len();
            let number = *known.entry(text).or_insert(next);
            if number == next {
                counts.push(0);
            }
            counts[number] += 1;
            numbers[index] = number;
        }
    }
    let outputs = (function.assignments.iter())
        .map(|assignment| (assignment.output.0, word(assignment.operand, &numbers)))
        .collect();
    (known, counts, outputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_functions_come_back() {
        let mut ran = 0;
        cases::of_sizes(800, 6000, |bytes| {
            run(bytes)?;
            ran += 1;
            Ok(())
        });
        assert!(ran > 20, "only {ran} programs were large enough");
    }
}
