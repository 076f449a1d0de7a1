//! The rolled program: loops, statements, and the places of all values.
//!
//! It needs nothing else: [`super::unroll`] runs it, and [`super::text`] writes
//! it, without looking at the function it was made from.

use super::nest::BodyElement;
use super::statements::Template;
use robovec_ir::{Array, Shape};

/// A space in which numbers are kept.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum StorageSpace {
    /// The work array.
    Work,
    /// The table of constants.
    Constants,
    /// An input array.
    Input(usize),
    /// An output array.
    Output(usize),
}

/// `base + factors . iterations + table[pass]`.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub(super) struct Index {
    pub(super) base: i64,
    /// Loops and the increment of each per iteration; none of it 0.
    pub(super) factors: Vec<(usize, i64)>,
    /// A table, and the loop whose passes count its entries.
    pub(super) table: Option<(usize, usize)>,
}

impl Index {
    /// An index that never changes.
    pub(super) fn fixed(base: i64) -> Index {
        Index {
            base,
            ..Index::default()
        }
    }
}

/// An element of a space: indices count from 1 in arrays (row and column of a
/// matrix, column alone of a vector) and from 0 elsewhere.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct SpaceElement {
    pub(super) space: StorageSpace,
    pub(super) row: Index,
    pub(super) column: Index,
}

#[derive(Clone, PartialEq, Debug)]
pub(super) enum LeafSource {
    /// The result of a position in this pass, of the same loop or one around.
    Position(usize),
    /// A variable that carries a result from pass to pass.
    Carried(usize),
    /// An element.
    Place(SpaceElement),
    /// A number.
    Number(f64),
}

/// A statement of the code.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Code {
    pub(super) template: u32,
    pub(super) sources: Vec<LeafSource>,
    pub(super) stores: Vec<SpaceElement>,
}

/// A variable that carries the result of a position of a loop to the next
/// pass.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Carried {
    pub(super) owner: usize,
    pub(super) position: usize,
    /// Its source in the first pass of a visit.
    pub(super) first: LeafSource,
}

/// A loop of the code.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct RolledLoop {
    /// The number of passes of a visit.
    pub(super) count: Index,
    pub(super) body: Vec<BodyElement>,
    /// True when no pass of a visit reads the result of another.
    pub(super) independent: bool,
    /// True for the loop of sines and cosines, whose body is the sine and the
    /// cosine of one angle.
    pub(super) circular: bool,
    /// True when a table counts its passes over all visits.
    pub(super) counted: bool,
}

/// Elements copied into the work array before an element of the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Copy {
    /// Number of elements.
    pub(super) count: u32,
    /// The source, and the steps in row and column.
    pub(super) space: StorageSpace,
    pub(super) from: [i64; 2],
    pub(super) step: [i64; 2],
    /// The first word of the work array they are copied to, and the step.
    pub(super) to: i64,
    pub(super) advance: i64,
}

#[derive(Clone, Debug)]
pub(super) struct RolledProgram {
    pub(super) templates: Vec<Template>,
    pub(super) items: Vec<BodyElement>,
    /// For each element of the program the index of its part.
    pub(super) parts: Vec<u32>,
    pub(super) loops: Vec<RolledLoop>,
    /// For each position.
    pub(super) codes: Vec<Code>,
    pub(super) carried: Vec<Carried>,
    /// For each loop the variables it carries.
    pub(super) carries: Vec<Vec<usize>>,
    /// Copies, with the element of the program they are before; in order.
    pub(super) copies: Vec<(usize, Copy)>,
    /// Words of the work array.
    pub(super) work: u32,
    pub(super) constants: Vec<f64>,
    pub(super) tables: Vec<Vec<u32>>,
}

/// The indices of an element as row and column.
pub(super) fn coordinates(array: &Array, indices: [u32; 2]) -> [i64; 2] {
    match array.shape {
        Shape::Scalar => [0, 0],
        Shape::Vector(_) => [0, i64::from(indices[0])],
        Shape::Matrix(..) => indices.map(i64::from),
    }
}
