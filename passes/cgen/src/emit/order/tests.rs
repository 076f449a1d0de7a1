use super::*;
use robovec_ir::Module;
use robovec_ir::parse::parse_module;

fn module(text: &str) -> Module {
    parse_module("test.rvir", text).expect("a module")
}

/// Two long chains in parallel, as a recursion makes them: first all steps
/// outwards, then all steps back.
fn waves(length: usize) -> String {
    use std::fmt::Write;
    let mut text = String::from("function f atomic {\n  in q[1..2]\n  out c[1..2]\n\n");
    for index in 1..=length {
        for chain in 1..=2 {
            let before = match index {
                1 => format!("q[{chain}]"),
                _ => format!("%A{chain}_{}", index - 1),
            };
            writeln!(text, "  %A{chain}_{index} = {before}*q[1]").expect("a string");
        }
    }
    for index in (1..=length).rev() {
        for chain in 1..=2 {
            let before = if index == length {
                format!("q[{chain}]")
            } else {
                format!("%B{chain}_{}", index + 1)
            };
            writeln!(text, "  %B{chain}_{index} = {before} + %A{chain}_{index}").expect("a string");
        }
    }
    text + "\n  c[1] = %B1_1\n  c[2] = %B2_1\n}\n"
}

/// The maximum number of values that wait to be read.
fn waiting(function: &Function, steps: &[CodeStep]) -> usize {
    let mut last = vec![0; function.nodes().len()];
    let reads = |step: &CodeStep| match *step {
        CodeStep::Define(value) => function.node(value).operands().to_vec(),
        CodeStep::Assign(index) => vec![function.assignments[index as usize].operand],
    };
    for (time, step) in steps.iter().enumerate() {
        for value in reads(step).iter().filter_map(|operand| operand.value()) {
            last[value.index()] = time;
        }
    }
    let mut live: Vec<usize> = Vec::new();
    let mut most = 0;
    for (time, step) in steps.iter().enumerate() {
        if let CodeStep::Define(value) = step {
            live.push(last[value.index()]);
        }
        most = most.max(live.len());
        live.retain(|&end| end > time);
    }
    most
}

#[test]
fn every_value_stands_once_and_behind_its_operands() {
    let module = module(&waves(50));
    let function = &module.functions[0];
    let computed = vec![true; function.nodes().len()];
    let steps = by_registers(function, &computed, 8);
    let mut done = vec![false; computed.len()];
    let mut assigned = 0;
    for step in &steps {
        match *step {
            CodeStep::Define(value) => {
                let operands = function.node(value).operands().iter();
                assert!(operands.filter_map(|o| o.value()).all(|v| done[v.index()]));
                assert!(!std::mem::replace(&mut done[value.index()], true));
            }
            CodeStep::Assign(index) => {
                let operand = function.assignments[index as usize].operand;
                assert!(operand.value().is_some_and(|value| done[value.index()]));
                assigned += 1;
            }
        }
    }
    assert!(done.iter().all(|&done| done));
    assert_eq!(assigned, 2);
}

#[test]
fn chains_are_done_one_after_the_other() {
    let module = module(&waves(100));
    let function = &module.functions[0];
    let computed = vec![true; function.nodes().len()];
    let program: Vec<CodeStep> = (function.values().map(|(value, _)| CodeStep::Define(value)))
        .chain([CodeStep::Assign(0), CodeStep::Assign(1)])
        .collect();
    let steps = by_registers(function, &computed, 8);
    assert!(waiting(function, &program) >= 200);
    assert!(
        waiting(function, &steps) <= 110,
        "{}",
        waiting(function, &steps)
    );
}

#[test]
fn what_is_in_memory_is_not_computed() {
    let module = module(&waves(10));
    let function = &module.functions[0];
    let mut computed = vec![true; function.nodes().len()];
    computed[0] = false;
    let steps = by_registers(function, &computed, 4);
    assert_eq!(steps.len(), function.nodes().len() - 1 + 2);
    assert!(!steps.contains(&CodeStep::Define(Value(0))));
}
