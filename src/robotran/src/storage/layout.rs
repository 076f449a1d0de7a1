//! The extents of arrays, and the numbers of their elements.

use super::{ArrayUse, Initial, LARGEST_STORAGE, POINTED_AT, Storage, StorageBuilder, StoredArray};
use crate::Language;
use crate::conventions::least_extent;
use crate::explain::refusal;
use crate::syntax::{LeafKind, StatementKind, SyntaxTree};
use crate::token::{RobotranName, SourceSpan};
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{MAX_INPUT_ELEMENTS, Shape, Symbol};
use std::ops::Range;

/// True where one of Robotran's arrays has another number of indices: one
/// index into a matrix means another element in Matlab and a row in Python.
fn is_known_otherwise(name: &str, rank: u32) -> bool {
    match name {
        "q" | "qd" | "qdd" | "Qq" | "c" | "m" => rank == 2,
        "M" | "Jac" | "l" | "In" | "frc" | "trq" | "dpt" | "sens.R" | "sens.J" => rank == 1,
        _ => false,
    }
}

impl StorageBuilder<'_> {
    pub(super) fn lay_out(&mut self, storage: &mut Storage, uses: &[ArrayUse]) {
        assert_eq!(storage.names.len(), uses.len(), "every array has its uses");
        let mut total = 0u64;
        for (name, used) in storage.names.clone().into_iter().zip(uses) {
            let text = self.symbols.text(name.symbol());
            if self.foreign && self.language != Language::C && is_known_otherwise(text, used.rank) {
                self.unknown_rank(storage, name);
            }
            let mut stated = self.extents.iter();
            let (rows, columns) = match stated.find(|(name, _, _)| name == text) {
                Some(&(_, rows, columns)) => (rows, columns),
                None => least_extent(text, self.joints),
            };
            self.check_joints(text, used);
            let rows = rows.max(used.rows).max(1);
            let columns = columns.max(used.columns).max(1);
            let shape = match used.rank {
                2 => Shape::Matrix(rows, columns),
                POINTED_AT => Shape::Scalar,
                _ => Shape::Vector(rows),
            };
            storage.arrays.push(StoredArray {
                name,
                shape,
                offset: total.min(LARGEST_STORAGE) as u32,
                initial: Initial::Nothing,
                local: false,
                held: (0, 0),
                known: true,
            });
            total = total.saturating_add(shape.len() as u64);
            if total > LARGEST_STORAGE {
                self.storage_too_large(name, used);
                storage.len = 0;
                return;
            }
        }
        storage.len = total as usize;
    }

    /// Warns when the equations know more joints than the header.
    fn check_joints(&mut self, text: &str, used: &ArrayUse) {
        let joint = match text {
            "q" | "qd" | "qdd" | "m" | "c" | "Qq" => used.rows,
            "l" | "In" | "frc" | "trq" => used.columns,
            _ => 0,
        };
        if self.joints > 0 && joint > self.joints {
            self.warnings.push(
                Diagnostic::warning()
                    .with_message(format!(
                        "the header has {} joints, but joint {joint} of `{text}` is used",
                        self.joints
                    ))
                    .with_note(
                        "header and equations come from different models; generate the file again",
                    ),
            );
        }
    }

    pub(super) fn replace_elements(&mut self, storage: &mut Storage) {
        let mut last = (RobotranName::local(Symbol(u32::MAX >> 1)), 0);
        for index in self.elements.clone() {
            let element = self.syntax.elements[index];
            if element.name != last.0 {
                let array = storage.find(element.name);
                last = (element.name, array.expect("every element is in an array"));
            }
            let array = storage.arrays[last.1 as usize];
            let column = element.column;
            let indices = [element.row, column];
            let rank = match (element.row, column) {
                (0, 0) => 0,
                (_, 0) => 1,
                _ => 2,
            };
            // Extents cover every use; wrong ranks were reported before.
            let offset = array.shape.offset(&indices[..rank]).unwrap_or(0);
            let replaced = &mut self.syntax.elements[index];
            replaced.row = array.offset + offset;
            replaced.column = last.1;
        }
    }

    pub(super) fn find_input_shapes(&mut self, storage: &mut Storage, uses: &[ArrayUse]) {
        let mut elements = 0;
        for (number, used) in uses.iter().enumerate() {
            let array = storage.arrays[number];
            let Initial::Input(name) = array.initial else {
                continue;
            };
            if used.rank == 0 {
                continue;
            }
            let shapes = &mut storage.input_shapes;
            let before = shapes.get(&name).map_or(0, |shape| shape.len() as u64);
            let known = shapes.entry(name).or_insert(array.shape);
            *known = match (*known, array.shape) {
                (Shape::Scalar, Shape::Scalar) => Shape::Scalar,
                (Shape::Vector(a), Shape::Vector(b)) => Shape::Vector(a.max(b)),
                (Shape::Matrix(a, b), Shape::Matrix(c, d)) => Shape::Matrix(a.max(c), b.max(d)),
                _ => {
                    let mut elements = self.elements.clone();
                    let first =
                        elements.find(|&index| self.syntax.elements[index].column == number as u32);
                    self.wrong_rank(first, array.name);
                    return;
                }
            };
            elements += known.len() as u64 - before;
            if elements > MAX_INPUT_ELEMENTS {
                self.inputs_too_large(number as u32, array.name);
                return;
            }
        }
    }
}

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

    /// The array that makes all inputs larger than allowed.
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
