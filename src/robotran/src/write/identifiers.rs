//! Who has which identifier in a file.

use super::arrays::{ArrayRole, FileArrays};
use super::names::{FileIdentifiers, is_word};
use super::plan::WrittenStatement;
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Function, Input, Name, Shape, Symbol, Symbols};
use rustc_hash::FxBuildHasher;

/// Gives every value of the file its identifier.
pub(super) fn identifiers(
    functions: &[&Function],
    symbols: &Symbols,
    arrays: &FileArrays,
) -> FileIdentifiers {
    let mut names = FileIdentifiers::new();
    let own = own_arguments(functions[0]);
    for array in &arrays.all {
        let scalar = array.shape == Shape::Scalar && array.role == ArrayRole::Argument;
        let own = symbols
            .find(&array.name)
            .is_some_and(|name| own.contains(&name));
        if !(scalar && own) {
            names.reserve(&array.name);
        }
    }
    for function in functions {
        for call in &function.boundaries {
            let words = call.arguments.iter().chain(&call.result);
            for word in words.filter(|word| is_word(word) && arrays.find(word).is_none()) {
                names.reserve(word);
            }
        }
    }
    for function in functions {
        names.keep(function.nodes().iter().map(|node| node.name), symbols);
    }
    for function in functions {
        names.derive(function.nodes().iter().map(|node| node.name), symbols);
    }
    names
}

/// The numbers handed to user functions whose temporaries have their names.
fn own_arguments(function: &Function) -> HashSet<Symbol, FxBuildHasher> {
    let own = function.assignments.iter().filter_map(|assignment| {
        let (array, _, rank) = function.output_element(assignment.output);
        let name = function.node(assignment.operand.value()?).name;
        (rank == 0 && name == Name::plain(array.name)).then_some(array.name)
    });
    own.collect()
}

/// A temporary for every input element that must be kept.
pub(super) fn kept(
    function: &Function,
    plan: &[WrittenStatement],
    names: &mut FileIdentifiers,
    symbols: &Symbols,
) -> HashMap<Input, Box<str>, FxBuildHasher> {
    let mut kept = HashMap::default();
    for statement in plan {
        if let WrittenStatement::Keep(input) = *statement {
            let (array, indices, rank) = function.input_element(input);
            let mut wanted = symbols.text(array.name).to_owned();
            for index in &indices[..rank] {
                wanted.push_str(&format!("_{index}"));
            }
            kept.insert(input, names.fresh(&wanted, 0, symbols));
        }
    }
    kept
}
