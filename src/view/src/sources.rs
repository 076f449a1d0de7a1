//! Places for equations that came without: a model's, or text of robovec's own.

use robovec_framework::rewrite::owners;
use robovec_ir::{Module, SourcePlace, print};
use std::collections::BTreeMap;

/// Gives the equations of a module that has no places those of its printed
/// text, under this name; returns the text, or `None` when a place is known
/// already.
pub fn place_lines(module: &mut Module, name: &str) -> Option<String> {
    if !module.tables.sources.files.is_empty() {
        return None;
    }
    let text = print::print_module(module);
    let file = module.tables.sources.add_file(name);
    let mut lines = text.lines().zip(1..);
    for index in 0..module.functions.len() {
        let mut places = BTreeMap::new();
        for (line, number) in lines.by_ref() {
            if line == "}" {
                break;
            }
            if let Some((left, _)) = line.trim_start().split_once(" = ") {
                let column = line.len() - line.trim_start().len() + 1;
                let place = SourcePlace {
                    file,
                    line: number,
                    column: column as u32,
                    end_line: number,
                    end_column: line.chars().count() as u32,
                };
                places.insert(left.to_owned(), place);
            }
        }
        assign(module, index, &places);
    }
    Some(text)
}

/// Gives values and outputs the places of their names; inner nodes of an
/// expression that of their equation.
fn assign(module: &mut Module, index: usize, places: &BTreeMap<String, SourcePlace>) {
    let tables = &mut module.tables;
    let function = &mut module.functions[index];
    let names: Vec<String> = function
        .assignments
        .iter()
        .map(|assignment| {
            let view = robovec_ir::View { tables, function };
            print::print_output(view, assignment.output)
        })
        .collect();
    let owners = owners(tables, function);
    let mut by_owner = BTreeMap::new();
    for (assignment, name) in function.assignments.iter_mut().zip(&names) {
        if let Some(&place) = places.get(name) {
            assignment.sources = tables.sources.single(place);
            if let Some(value) = assignment.operand.value() {
                by_owner.insert(owners[value.index()], assignment.sources);
            }
        }
    }
    let values: Vec<_> = function.values().map(|(value, _)| value).collect();
    for &value in &values {
        let name = function.node(value).name;
        if name.is_none() {
            continue;
        }
        let text = format!("%{}", name.display(&tables.symbols));
        if let Some(&place) = places.get(&text) {
            let sources = tables.sources.single(place);
            function.node_mut(value).sources = sources;
            by_owner.insert(name.base, sources);
        }
    }
    for value in values {
        if function.node(value).name.is_none()
            && let Some(&sources) = by_owner.get(&owners[value.index()])
        {
            function.node_mut(value).sources = sources;
        }
    }
}
