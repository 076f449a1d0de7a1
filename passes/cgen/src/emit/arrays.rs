//! Arrays that count from 1: element 0 of each direction is there and not
//! used.

use super::Real;
use robovec_ir::{Array, Shape};

/// Rows and columns that are kept of an array.
pub(crate) fn dimensions(shape: Shape) -> [u64; 2] {
    match shape {
        Shape::Scalar => [1, 1],
        Shape::Vector(length) => [1, u64::from(length) + 1],
        Shape::Matrix(rows, columns) => [u64::from(rows) + 1, u64::from(columns) + 1],
    }
}

/// The number of numbers that are kept of an array.
pub(crate) fn extent(array: &Array) -> u64 {
    let [rows, columns] = dimensions(array.shape);
    rows * columns
}

/// The place of an element among the numbers that are kept of an array.
pub(crate) fn place(array: &Array, offset: u32) -> u64 {
    match array.shape.indices(offset) {
        (_, 0) => 0,
        ([index, _], 1) => u64::from(index),
        ([row, column], _) => {
            let [_, columns] = dimensions(array.shape);
            u64::from(row) * columns + u64::from(column)
        }
    }
}

/// The number of indices of an array.
pub(crate) fn rank(shape: Shape) -> usize {
    match shape {
        Shape::Scalar => 0,
        Shape::Vector(_) => 1,
        Shape::Matrix(..) => 2,
    }
}

/// An array as a parameter. `rows` declares a matrix: a name with
/// brackets after it, or a pointer to rows.
pub(crate) fn parameter(
    real: Real,
    name: &str,
    shape: Shape,
    is_output: bool,
    rows: Rows,
) -> String {
    let constant = if is_output { "" } else { "const " };
    let real = real.name();
    let [_, columns] = dimensions(shape);
    match (shape, rows) {
        (Shape::Scalar, _) if is_output => format!("{real} *{name}"),
        (Shape::Scalar, _) => format!("{real} {name}"),
        (_, Rows::None) => format!("{constant}{real} *restrict {name}"),
        (Shape::Vector(_), _) => format!("{constant}{real} *{name}"),
        (Shape::Matrix(..), Rows::Brackets) => format!("{constant}{real} {name}[][{columns}]"),
        (Shape::Matrix(..), Rows::Pointer) => format!("{constant}{real} (*{name})[{columns}]"),
    }
}

/// The declaration of a matrix as a parameter; C makes no difference.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Rows {
    /// `double a[][4]`.
    Brackets,
    /// `double (*a)[4]`.
    Pointer,
    /// `double *restrict a`: vectors and matrices of any order, which do not
    /// overlap.
    None,
}

/// An element of a parameter that [`parameter`] declares.
pub(crate) fn element(
    name: &str,
    shape: Shape,
    is_output: bool,
    row: &str,
    column: &str,
) -> String {
    match shape {
        Shape::Scalar if is_output => format!("*{name}"),
        Shape::Scalar => name.to_owned(),
        Shape::Vector(_) => format!("{name}[{column}]"),
        Shape::Matrix(..) => format!("{name}[{row}][{column}]"),
    }
}
