//! Reasons why the arrays of a function are refused.

use super::{ArrayUse, LARGEST_STORAGE, Storage, StorageBuilder};
use crate::explain::refusal;
use crate::syntax::{LeafKind, StatementKind, SyntaxTree};
use crate::token::{RobotranName, SourceSpan};
use robovec_ir::MAX_INPUT_ELEMENTS;
use std::ops::Range;

impl StorageBuilder<'_> {
    pub(super) fn late_meaning(&mut self, name: RobotranName, span: SourceSpan) {
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{text}` means another array from here on"),
            span,
            "its elements are used before, or it has a meaning already",
            "give every array one name, before its first element is used",
        ));
    }

    /// The array that makes all of them larger than allowed, by its use.
    pub(super) fn storage_too_large(&mut self, name: RobotranName, used: &ArrayUse) {
        let mut elements = self.elements.clone();
        let largest = elements.find(|&index| {
            let element = self.syntax.elements[index];
            let extreme = element.row == used.rows || element.column == used.columns;
            element.name.symbol() == name.symbol() && extreme
        });
        self.too_large(name, largest, LARGEST_STORAGE);
    }

    /// The array with this number that makes all inputs larger than allowed;
    /// its elements have their offsets already.
    pub(super) fn inputs_too_large(&mut self, number: u32, name: RobotranName) {
        let elements = self.elements.clone();
        let of_array = elements.filter(|&index| self.syntax.elements[index].column == number);
        let farthest = of_array.max_by_key(|&index| self.syntax.elements[index].row);
        self.too_large(name, farthest, MAX_INPUT_ELEMENTS);
    }

    fn too_large(&mut self, name: RobotranName, element: Option<usize>, most: u64) {
        let span = statement_of_element(self.syntax, self.statements.clone(), element);
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{text}` makes the arrays larger than any model needs"),
            span,
            "uses an extreme index",
            &format!("together they may have {most} elements; correct the index"),
        ));
    }

    pub(super) fn unknown_rank(&mut self, storage: &Storage, name: RobotranName) {
        let mut elements = self.elements.clone();
        let first =
            elements.find(|&index| storage.canonical(self.syntax.elements[index].name) == name);
        let span = statement_of_element(self.syntax, self.statements.clone(), first);
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("Robotran's array `{text}` has another number of indices"),
            span,
            "used here",
            "a vector has one index, a matrix two",
        ));
    }

    pub(super) fn wrong_rank(&mut self, element: Option<usize>, name: RobotranName) {
        let span = statement_of_element(self.syntax, self.statements.clone(), element);
        let name = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{name}` is used with one index and with two"),
            span,
            "differs from an earlier use",
            "an array has one number of indices; correct the odd one",
        ));
    }
}

/// The statement that holds an element, or the first: for messages only.
fn statement_of_element(
    syntax: &SyntaxTree,
    statements: Range<usize>,
    element: Option<usize>,
) -> SourceSpan {
    let wanted = element.map(|element| LeafKind::Element(element as u32));
    for statement in &syntax.statements[statements.clone()] {
        let StatementKind::Equation {
            target,
            root,
            first,
            end,
        } = statement.kind
        else {
            continue;
        };
        let nodes = &syntax.nodes[first as usize..end as usize];
        let mut leaves = nodes
            .iter()
            .flat_map(|node| node.operands())
            .chain([&target, &root]);
        if leaves.any(|leaf| Some(leaf.kind()) == wanted) {
            return statement.span;
        }
    }
    let first = syntax.statements.get(statements.start);
    first.map_or(SourceSpan { start: 0, end: 0 }, |statement| statement.span)
}
