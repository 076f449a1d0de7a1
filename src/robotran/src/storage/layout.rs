//! The extents of arrays, and the numbers of their elements.

use super::{ArrayUse, Initial, LARGEST_STORAGE, POINTED_AT, Storage, StorageBuilder, StoredArray};
use crate::Language;
use crate::conventions::least_extent;
use crate::token::RobotranName;
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{MAX_INPUT_ELEMENTS, Shape, Symbol};

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
            // Extents cover every use; a use of the wrong rank is an error
            // reported before.
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
