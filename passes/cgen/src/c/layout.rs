//! Arrangement of arrays whose elements count from 0.

use hashbrown::HashMap;
use robovec_framework::option_words;
use robovec_ir::{Array, Assignment, Function, Operand, Output, Shape};
use rustc_hash::FxBuildHasher;

option_words! {
    /// Order of the elements of arrays that count from 0.
    #[derive(Default)]
    pub enum ElementOrder {
        /// Row by row.
        #[default]
        Row = "row",
        /// Column by column.
        Column = "column",
        /// Column by column; of symmetric outputs the upper triangle.
        Packed = "packed",
    }
}

/// Arrangement of the arrays of a plain signature.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Layout {
    /// Indices from 1; row and column 0 exist and are not used.
    #[default]
    FromOne,
    /// Indices from 0, without gaps.
    FromZero {
        /// Order of the elements.
        order: ElementOrder,
        /// Only elements of outputs that are set are kept.
        is_sparse: bool,
    },
}

/// Arrangement of one output array that counts from 0.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct OutputLayout {
    /// Rows and columns; a vector is one column, a scalar has one of each.
    pub extents: [u32; 2],
    /// Row and column, from 0, of each element that is kept, in order.
    pub kept: Vec<[u32; 2]>,
    /// Only the upper triangle of a symmetric matrix is kept.
    pub is_triangle: bool,
    /// Elements that are kept and never set.
    pub has_gaps: bool,
}

impl OutputLayout {
    /// True if the elements kept are all elements.
    pub fn is_dense(&self) -> bool {
        let [rows, columns] = self.extents.map(u64::from);
        self.kept.len() as u64 == rows * columns
    }
}

/// The function without the assignments of zeros: what is left can differ from
/// zero.
pub fn without_zeros(mut function: Function) -> Function {
    let is_zero = |set: &Assignment| function.number(set.operand) == Some(0.0);
    let kept: Vec<Assignment> = (function.assignments.iter())
        .filter(|set| !is_zero(set))
        .copied()
        .collect();
    function.assignments = kept;
    function
}

/// The function with the assignments of the same elements as another one: zeros
/// where it sets none.
pub fn with_elements_of(mut function: Function, other: &Function) -> Function {
    let zero = function.constant(0.0).into();
    let old = std::mem::take(&mut function.assignments);
    let set: HashMap<Output, Assignment, FxBuildHasher> =
        old.into_iter().map(|set| (set.output, set)).collect();
    let same = other.assignments.iter().map(|wanted| Assignment {
        operand: set.get(&wanted.output).map_or(zero, |set| set.operand),
        ..*wanted
    });
    function.assignments = same.collect();
    function
}

/// Rows and columns of an array; a vector is one column.
pub fn extents(shape: Shape) -> [u32; 2] {
    match shape {
        Shape::Scalar => [1, 1],
        Shape::Vector(length) => [length, 1],
        Shape::Matrix(rows, columns) => [rows, columns],
    }
}

/// Row and column, from 0, of an element of an array.
pub fn indices(shape: Shape, offset: u32) -> [u32; 2] {
    match shape.indices(offset) {
        (_, 0) => [0, 0],
        ([index, _], 1) => [index - 1, 0],
        ([row, column], _) => [row - 1, column - 1],
    }
}

/// Position of an element among those of an array that keeps all of them.
pub fn place(array: &Array, offset: u32, order: ElementOrder) -> u32 {
    let [row, column] = indices(array.shape, offset);
    let [rows, columns] = extents(array.shape);
    match order {
        ElementOrder::Row => row * columns + column,
        ElementOrder::Column | ElementOrder::Packed => column * rows + row,
    }
}

/// Arrangement of all outputs of a function.
#[derive(Debug)]
pub(super) struct OutputLayouts {
    /// One for each output array.
    pub(super) arrays: Vec<OutputLayout>,
    /// Position of each output element that is kept.
    places: Vec<Option<u32>>,
}

impl OutputLayouts {
    pub(super) fn new(function: &Function, order: ElementOrder, is_sparse: bool) -> OutputLayouts {
        let assignments = function.assignments.iter();
        let set: HashMap<Output, Operand, FxBuildHasher> = assignments
            .map(|assignment| (assignment.output, assignment.operand))
            .collect();
        let mut places = vec![None; function.output_len()];
        let arrays = function.outputs().iter().map(|array| {
            let at = |offset: u32| set.get(&Output(array.offset + offset)).copied();
            let is_triangle = order == ElementOrder::Packed && is_symmetric(array.shape, at);
            let mut kept: Vec<u32> = (0..array.shape.len() as u32)
                .filter(|&offset| {
                    let [row, column] = indices(array.shape, offset);
                    (!is_sparse || at(offset).is_some()) && (row <= column || !is_triangle)
                })
                .collect();
            kept.sort_by_key(|&offset| place(array, offset, order));
            for (position, &offset) in kept.iter().enumerate() {
                places[(array.offset + offset) as usize] = Some(position as u32);
            }
            OutputLayout {
                extents: extents(array.shape),
                has_gaps: kept.iter().any(|&offset| at(offset).is_none()),
                kept: (kept.iter())
                    .map(|&offset| indices(array.shape, offset))
                    .collect(),
                is_triangle,
            }
        });
        OutputLayouts {
            arrays: arrays.collect(),
            places,
        }
    }

    /// Position of an output element in its array; `None` if it is not kept.
    pub(super) fn place(&self, output: Output) -> Option<u32> {
        self.places[output.0 as usize]
    }

    /// True for an assignment of an element that is kept.
    pub(super) fn keeps(&self, assignment: &Assignment) -> bool {
        self.place(assignment.output).is_some()
    }
}

/// True for a square matrix whose triangles are set to the same operands.
fn is_symmetric(shape: Shape, at: impl Fn(u32) -> Option<Operand>) -> bool {
    let Shape::Matrix(rows, columns) = shape else {
        return false;
    };
    let mut pairs = (0..rows).flat_map(|row| (0..row).map(move |column| (row, column)));
    rows == columns
        && pairs.all(|(row, column)| at(row * columns + column) == at(column * columns + row))
}
