//! A module: functions and the tables they share.

use crate::entity::{Operand, OperandKind};
use crate::function::{Array, Function, Node};
use crate::history::same_histories;
use crate::source::{SourceSet, Sources};
use crate::symbol::{Name, Symbols};
use crate::value_formats::same_formats;

/// The tables that all functions of a module share.
#[derive(Clone, Default, Debug)]
pub struct Tables {
    /// Names.
    pub symbols: Symbols,
    /// Places in the user's files.
    pub sources: Sources,
}

impl Tables {
    /// A function whose numbers refer to these tables.
    pub fn view<'a>(&'a self, function: &'a Function) -> View<'a> {
        View {
            tables: self,
            function,
        }
    }
}

/// Functions with their names and sources.
///
/// Two modules are equal when they state the same: how strings, constants and
/// places are numbered inside does not count.
#[derive(Clone, Default, Debug)]
pub struct Module {
    /// Names and places.
    pub tables: Tables,
    /// The functions, in order of appearance.
    pub functions: Vec<Function>,
}

impl Module {
    /// An empty module.
    pub fn new() -> Module {
        Module::default()
    }

    /// The function of a name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }
}

impl PartialEq for Module {
    fn eq(&self, other: &Module) -> bool {
        self.tables.sources.files == other.tables.sources.files
            && self.functions.len() == other.functions.len()
            && self
                .functions
                .iter()
                .zip(&other.functions)
                .all(|(left, right)| {
                    same_function(self.tables.view(left), other.tables.view(right))
                })
    }
}

/// A function with the tables its numbers refer to.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Names and places.
    pub tables: &'a Tables,
    /// The function.
    pub function: &'a Function,
}

/// True when two functions, each with its own tables, state the same.
pub fn same_function(left: View<'_>, right: View<'_>) -> bool {
    let (a, b) = (left.function, right.function);
    a.name == b.name
        && a.level == b.level
        && a.metadata == b.metadata
        // Without nodes there is nothing to say about times.
        && a.timing.as_deref().unwrap_or_default() == b.timing.as_deref().unwrap_or_default()
        && a.schedule == b.schedule
        && same_formats(a.formats.as_ref(), b.formats.as_ref())
        && same_histories(a.histories.as_ref(), b.histories.as_ref())
        && same_arrays(left, a.inputs(), right, b.inputs())
        && same_arrays(left, a.outputs(), right, b.outputs())
        && same_list(&a.boundaries, &b.boundaries, |x, y| {
            x.callee == y.callee
                && x.arguments == y.arguments
                && x.result == y.result
                && same_sources(left, x.sources, right, y.sources)
        })
        && same_list(a.nodes(), b.nodes(), |x, y| same_node(left, x, right, y))
        && same_list(&a.assignments, &b.assignments, |x, y| {
            x.output == y.output
                && same_operand(left, x.operand, right, y.operand)
                && same_sources(left, x.sources, right, y.sources)
        })
        && match (&a.placement, &b.placement) {
            (None, None) => true,
            (Some(x), Some(y)) => {
                x.reads == y.reads
                    && x.buffers == y.buffers
                    && x.write_starts == y.write_starts
                    && x.writes == y.writes
                    && x.homes == y.homes
                    && same_list(&x.preloads, &y.preloads, |p, q| {
                        p.word == q.word && same_operand(left, p.operand, right, q.operand)
                    })
            }
            (None, Some(_)) | (Some(_), None) => false,
        }
}

/// True when two functions, each with its own tables, have the same arrays,
/// calls, nodes and outputs. Metadata, source places, histories, times and
/// schedules do not count: only the values that a function computes, and their
/// order, do.
pub fn same_equations(left: View<'_>, right: View<'_>) -> bool {
    let (a, b) = (left.function, right.function);
    a.name == b.name
        && same_arrays(left, a.inputs(), right, b.inputs())
        && same_arrays(left, a.outputs(), right, b.outputs())
        && same_list(&a.boundaries, &b.boundaries, |x, y| {
            x.callee == y.callee && x.arguments == y.arguments && x.result == y.result
        })
        && same_formats(a.formats.as_ref(), b.formats.as_ref())
        && same_list(a.nodes(), b.nodes(), |x, y| {
            same_operation(left, x, right, y)
        })
        && same_list(&a.assignments, &b.assignments, |x, y| {
            x.output == y.output && same_operand(left, x.operand, right, y.operand)
        })
}

fn same_list<T>(left: &[T], right: &[T], same: impl Fn(&T, &T) -> bool) -> bool {
    left.len() == right.len() && left.iter().zip(right).all(|(x, y)| same(x, y))
}

fn same_arrays(left: View<'_>, a: &[Array], right: View<'_>, b: &[Array]) -> bool {
    same_list(a, b, |x, y| {
        x.shape == y.shape && left.tables.symbols.text(x.name) == right.tables.symbols.text(y.name)
    })
}

fn same_node(left: View<'_>, a: &Node, right: View<'_>, b: &Node) -> bool {
    same_operation(left, a, right, b) && same_sources(left, a.sources, right, b.sources)
}

fn same_operation(left: View<'_>, a: &Node, right: View<'_>, b: &Node) -> bool {
    a.operation == b.operation
        && same_name(left, a.name, right, b.name)
        && same_list(a.operands(), b.operands(), |&x, &y| {
            same_operand(left, x, right, y)
        })
}

fn same_name(left: View<'_>, a: Name, right: View<'_>, b: Name) -> bool {
    if a.is_none() || b.is_none() {
        return a.is_none() == b.is_none();
    }
    a.suffix == b.suffix && left.tables.symbols.text(a.base) == right.tables.symbols.text(b.base)
}

fn same_operand(left: View<'_>, a: Operand, right: View<'_>, b: Operand) -> bool {
    match (a.kind(), b.kind()) {
        (OperandKind::Constant(x), OperandKind::Constant(y)) => {
            left.function.constant_number(x).to_bits()
                == right.function.constant_number(y).to_bits()
        }
        (x, y) => x == y,
    }
}

fn same_sources(left: View<'_>, a: SourceSet, right: View<'_>, b: SourceSet) -> bool {
    left.tables
        .sources
        .places(a)
        .eq(right.tables.sources.places(b))
}
