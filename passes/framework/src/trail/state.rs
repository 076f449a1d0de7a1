//! A state of a function, indexed by the names of its values.
//!
//! Two states are compared by their definitions, not by numbers of nodes, which
//! every pass assigns again: an operation with its operands, named operands by
//! their names, inner nodes of an expression recursively.

use super::names::ValueNames;
use hashbrown::HashMap;
use robovec_ir::print::print_output;
use robovec_ir::{
    Assignment, Function, Name, OperandKind, Output, SourceSet, Symbol, Tables, Value, View,
};
use rustc_hash::{FxBuildHasher, FxHasher};
use std::hash::{Hash, Hasher};

/// The definition of a value or output: equal numbers for equal definitions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Definition {
    body: u64,
    sources: SourceSet,
}

/// A value or an output of a function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DefinitionSubject {
    /// The node of a name.
    Value(Value),
    /// The assignment of this index.
    Output(usize),
}

/// The definitions of one state of a function.
pub(super) struct DefinitionState {
    bodies: Vec<u64>,
    names: ValueNames,
}

impl DefinitionState {
    /// Looks through a function once.
    pub(super) fn of(function: &Function) -> DefinitionState {
        let mut state = DefinitionState {
            bodies: Vec::with_capacity(function.nodes().len()),
            names: ValueNames::of(function),
        };
        for node in function.nodes() {
            let mut hasher = FxHasher::default();
            (node.operation as u32).hash(&mut hasher);
            for &operand in node.operands() {
                state.said_by(function, operand.kind()).hash(&mut hasher);
            }
            state.bodies.push(hasher.finish());
        }
        state
    }

    fn said_by(&self, function: &Function, operand: OperandKind) -> (u32, u64) {
        match operand {
            OperandKind::Value(value) => match function.node(value).name {
                Name::NONE => (0, self.bodies[value.index()]),
                name => (1, u64::from(name.base.0) << 32 | u64::from(name.suffix)),
            },
            OperandKind::Input(input) => (2, u64::from(input.0)),
            OperandKind::Constant(constant) => (3, function.constant_number(constant).to_bits()),
            OperandKind::None => (4, 0),
        }
    }

    pub(super) fn value(&self, name: Name) -> Option<Value> {
        self.names.find(name)
    }

    /// The definition of a value or output.
    pub(super) fn definition(&self, function: &Function, subject: DefinitionSubject) -> Definition {
        match subject {
            DefinitionSubject::Value(value) => Definition {
                body: self.bodies[value.index()],
                sources: function.node(value).sources,
            },
            DefinitionSubject::Output(index) => {
                let assignment = &function.assignments[index];
                let mut hasher = FxHasher::default();
                let said = self.said_by(function, assignment.operand.kind());
                said.hash(&mut hasher);
                Definition {
                    body: hasher.finish(),
                    sources: assignment.sources,
                }
            }
        }
    }

    /// The origin of a value that this state does not have, as names show: the
    /// value it is named after, or the output, or another value derived from
    /// the same equation.
    pub(super) fn namesake(&self, name: Name, owners: &OutputSymbols) -> Option<DefinitionSubject> {
        if let Some(value) = self.value(Name::plain(name.base)) {
            return Some(DefinitionSubject::Value(value));
        }
        let output = owners
            .0
            .get(&name.base)
            .copied()
            .map(DefinitionSubject::Output);
        output.or_else(|| {
            let derived = self.names.first(name.base);
            derived.map(DefinitionSubject::Value)
        })
    }
}

impl Definition {
    /// Tests whether only the source places are others.
    pub(super) fn is_merged(self, other: Definition) -> bool {
        self.body == other.body && self.sources != other.sources
    }
}

/// The symbols that values made for an output are named after, with the
/// index of its assignment.
pub(super) struct OutputSymbols(HashMap<Symbol, usize, FxBuildHasher>);

impl OutputSymbols {
    /// Those that occur: a symbol that was never made names no value.
    pub(super) fn of(tables: &Tables, function: &Function) -> OutputSymbols {
        let known = function.assignments.iter().enumerate();
        let known = known.filter_map(|(index, assignment)| {
            let text = crate::rewrite::output_name(View { tables, function }, assignment.output);
            Some((tables.symbols.find(&text)?, index))
        });
        OutputSymbols(known.collect())
    }
}

/// The assignment of an output element; assignments are in the order of
/// their elements.
pub(super) fn assignment_of(function: &Function, output: Output) -> Option<usize> {
    let assignments = &function.assignments;
    let by_element = |assignment: &Assignment| assignment.output.cmp(&output);
    assignments.binary_search_by(by_element).ok()
}

/// The name of a value or output in the text.
pub(super) fn name_of(view: View<'_>, subject: DefinitionSubject) -> String {
    match subject {
        DefinitionSubject::Value(value) => {
            let name = view.function.node(value).name;
            format!("%{}", name.display(&view.tables.symbols))
        }
        DefinitionSubject::Output(index) => {
            print_output(view, view.function.assignments[index].output)
        }
    }
}
