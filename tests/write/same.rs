//! Equality of two modules, up to the changes of a language.

use robovec_framework::rewrite::lay_out;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{
    Array, Assignment, Function, Input, Module, Name, Node, Operand, OperandKind, Output, Symbol,
    View, same_equations,
};
use std::collections::HashMap;

/// Parts that a language changes: the names of user functions, the sensor file
/// of Python that a function comes from, and names that no language accepts.
fn normalised(module: &Module) -> Module {
    let mut module = module.clone();
    for function in &mut module.functions {
        for call in &mut function.boundaries {
            let name = call.callee.replace("usrfun.user_", "user_");
            let name = name.replace("usrfun.", "user_");
            let name = name.replace("user_fext", "user_ExtForces");
            let name = name.replace("user_flink", "user_LinkForces");
            call.callee = name.replace("user_call_", "user_");
        }
        function.name = function.name.replace("gensensor", "sensor");
        for index in 0..function.nodes().len() {
            let value = robovec_ir::Value(index as u32);
            let name = function.node(value).name;
            if !name.is_none() && name.suffix > 0 {
                let text = name.display(&module.tables.symbols).replace('.', "_");
                let plain = Name::plain(module.tables.symbols.intern(&text));
                function.node_mut(value).name = plain;
            }
        }
    }
    module
}

/// The function with its arrays in order of their names: where Matlab must
/// return arrays that C keeps in its structure, their order differs.
pub(super) fn sorted(view: View<'_>) -> Function {
    let old = view.function;
    let mut new = Function::new(&old.name, old.level);
    new.boundaries = old.boundaries.clone();
    let by_name = |arrays: &[Array]| {
        let mut arrays = arrays.to_vec();
        arrays.sort_by_key(|array| view.tables.symbols.text(array.name));
        arrays
    };
    let inputs: HashMap<Symbol, u32> = by_name(old.inputs())
        .iter()
        .map(|array| (array.name, new.add_input(array.name, array.shape).offset))
        .collect();
    let outputs: HashMap<Symbol, u32> = by_name(old.outputs())
        .iter()
        .map(|array| (array.name, new.add_output(array.name, array.shape).offset))
        .collect();
    let mut moved = |operand: Operand| match operand.kind() {
        OperandKind::Input(input) => {
            let (array, _, _) = old.input_element(input);
            Input(inputs[&array.name] + input.0 - array.offset).into()
        }
        OperandKind::Constant(constant) => new.constant(old.constant_number(constant)).into(),
        OperandKind::Value(_) | OperandKind::None => operand,
    };
    let nodes: Vec<Node> = (old.nodes().iter())
        .map(|node| Node {
            operands: node.operands.map(&mut moved),
            ..*node
        })
        .collect();
    let assignments = (old.assignments.iter())
        .map(|assignment| {
            let (array, _, _) = old.output_element(assignment.output);
            Assignment {
                output: Output(outputs[&array.name] + assignment.output.0 - array.offset),
                operand: moved(assignment.operand),
                ..*assignment
            }
        })
        .collect();
    new.assignments = assignments;
    for node in nodes {
        new.push(node);
    }
    new.sort_assignments();
    lay_out(&new)
}

pub(super) fn assert_same(expected: &Module, found: &Module, what: &str) {
    let (expected, found) = (normalised(expected), normalised(found));
    assert_eq!(expected.functions.len(), found.functions.len(), "{what}");
    for (left, right) in expected.functions.iter().zip(&found.functions) {
        let (left, right) = (
            View {
                tables: &expected.tables,
                function: left,
            },
            View {
                tables: &found.tables,
                function: right,
            },
        );
        assert_eq!(verify(right), [], "{what}");
        let (sorted_left, sorted_right) = (sorted(left), sorted(right));
        let sorted_left = View {
            function: &sorted_left,
            ..left
        };
        let sorted_right = View {
            function: &sorted_right,
            ..right
        };
        if !same_equations(left, right) && !same_equations(sorted_left, sorted_right) {
            let without_places = |module: &Module| {
                let text = print_module(module);
                let lines = text
                    .lines()
                    .map(|line| line.split(" @").next().unwrap_or(line));
                lines
                    .filter(|line| !line.starts_with("source ") && !line.contains("meta "))
                    .collect::<Vec<_>>()
                    .join("\n")
            };
            let alone = |view: View<'_>, function: Function| Module {
                tables: view.tables.clone(),
                functions: vec![function],
            };
            let (before, after) = (alone(left, sorted(left)), alone(right, sorted(right)));
            let (before, after) = (without_places(&before), without_places(&after));
            for (left, right) in before.lines().zip(after.lines()) {
                assert_eq!(left, right, "{what}");
            }
            panic!("{what}: {} differs", left.function.name);
        }
    }
}
