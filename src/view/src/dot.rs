//! The graph of a function in the language of Graphviz.

use robovec_analysis::critical_path::{Weights, arrivals, longest, tails};
use robovec_framework::trail::TrackedItem;
use robovec_ir::print::{print_operand, print_output};
use robovec_ir::{Function, Machine, OperandKind, Value, View};
use std::fmt::Write;

/// The dataflow graph of a value, an output, or all; longest paths are red.
pub fn dot(view: View<'_>, machine: &Machine, wanted: Option<TrackedItem>) -> String {
    let function = view.function;
    let weights = Weights::cycles(machine);
    let (arrivals, tails) = (arrivals(function, &weights), tails(function, &weights));
    let path = longest(&arrivals);
    let critical = |value: Value| arrivals[value.index()] + tails[value.index()] == path;
    let outputs = wanted_outputs(function, wanted);
    let needed = needed(function, wanted, &outputs);
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "digraph \"{}\" {{", function.name);
    let _ = writeln!(text, "  rankdir=LR\n  node [shape=box, fontname=monospace]");
    for (value, node) in function.values().filter(|(value, _)| needed[value.index()]) {
        let name = if node.name.is_none() {
            String::new()
        } else {
            format!("%{}\\n", node.name.display(&view.tables.symbols))
        };
        let colour = if critical(value) { ", color=red" } else { "" };
        let _ = writeln!(
            text,
            "  v{} [label=\"{name}{} at {}\"{colour}]",
            value.index(),
            node.operation.name(),
            arrivals[value.index()]
        );
        for &operand in node.operands() {
            let from = match operand.kind() {
                OperandKind::Value(operand) => format!("v{}", operand.index()),
                OperandKind::Input(_) | OperandKind::Constant(_) => {
                    format!("\"{}\"", print_operand(view, operand))
                }
                OperandKind::None => continue,
            };
            let red = operand.value().is_some_and(|operand| {
                critical(operand)
                    && critical(value)
                    && arrivals[operand.index()] + weights.of(node.operation)
                        == arrivals[value.index()]
            });
            let colour = if red { " [color=red]" } else { "" };
            let _ = writeln!(text, "  {from} -> v{}{colour}", value.index());
        }
    }
    for index in outputs {
        let assignment = &function.assignments[index];
        let name = print_output(view, assignment.output);
        let from = match assignment.operand.value() {
            Some(value) => format!("v{}", value.index()),
            None => format!("\"{}\"", print_operand(view, assignment.operand)),
        };
        let _ = writeln!(text, "  \"{name}\" [shape=ellipse]\n  {from} -> \"{name}\"");
    }
    text.push_str("}\n");
    text
}

fn wanted_outputs(function: &Function, wanted: Option<TrackedItem>) -> Vec<usize> {
    let all = 0..function.assignments.len();
    match wanted {
        None => all.collect(),
        Some(TrackedItem::Value(_)) => Vec::new(),
        Some(TrackedItem::Output(output)) => all
            .filter(|&index| function.assignments[index].output == output)
            .collect(),
    }
}

/// The nodes that a requested value depends on.
fn needed(function: &Function, wanted: Option<TrackedItem>, outputs: &[usize]) -> Vec<bool> {
    let mut needed = vec![false; function.nodes().len()];
    for &index in outputs {
        if let Some(value) = function.assignments[index].operand.value() {
            needed[value.index()] = true;
        }
    }
    if let Some(TrackedItem::Value(name)) = wanted {
        for (value, node) in function.values() {
            needed[value.index()] |= node.name == name;
        }
    }
    for (value, node) in function.values().rev() {
        if needed[value.index()] {
            let operands = node.operands().iter();
            for operand in operands.filter_map(|operand| operand.value()) {
                needed[operand.index()] = true;
            }
        }
    }
    needed
}
