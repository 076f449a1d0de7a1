//! Operands of an expression, in 32 bits.

use crate::token::RobotranName;
use robovec_ir::Symbol;

/// Operand of an expression, packed into 32 bits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct SyntaxLeaf(u32);

/// A decoded [`SyntaxLeaf`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum LeafKind {
    /// The result of a node of the arena.
    Node(u32),
    /// An entry of [`SyntaxTree::elements`].
    Element(u32),
    /// An entry of [`SyntaxTree::numbers`].
    Number(u32),
    /// A bare name.
    Scalar(RobotranName),
}

const KIND_SHIFT: u32 = 30;

const PAYLOAD: u32 = (1 << KIND_SHIFT) - 1;

pub(super) const ELEMENT: u32 = 1 << KIND_SHIFT;

pub(super) const NUMBER: u32 = 2 << KIND_SHIFT;

const SCALAR: u32 = 3 << KIND_SHIFT;

const SCALAR_OF_DATA: u32 = 1 << 29;

/// The largest number of nodes, elements, literals or names of a file; a text
/// within the size limit of the reader has fewer.
pub(crate) const CAPACITY: usize = 1 << 29;

impl SyntaxLeaf {
    /// The absent second operand.
    pub(crate) const NONE: SyntaxLeaf = SyntaxLeaf(u32::MAX);

    pub(crate) fn scalar(name: RobotranName) -> SyntaxLeaf {
        let of_data = if name.is_of_data() { SCALAR_OF_DATA } else { 0 };
        SyntaxLeaf(SCALAR | of_data | name.symbol().0)
    }

    pub(crate) fn node(index: u32) -> SyntaxLeaf {
        debug_assert!(
            (index as usize) < CAPACITY,
            "a text within the limit has fewer nodes"
        );
        SyntaxLeaf(index)
    }

    pub(super) fn element(index: u32) -> SyntaxLeaf {
        debug_assert!(
            (index as usize) < CAPACITY,
            "a text within the limit has fewer elements"
        );
        SyntaxLeaf(ELEMENT | index)
    }

    pub(super) fn number(index: u32) -> SyntaxLeaf {
        debug_assert!(
            (index as usize) < CAPACITY,
            "a text within the limit has fewer literals"
        );
        SyntaxLeaf(NUMBER | index)
    }

    pub(crate) fn kind(self) -> LeafKind {
        let payload = self.0 & PAYLOAD;
        match self.0 & !PAYLOAD {
            0 => LeafKind::Node(payload),
            ELEMENT => LeafKind::Element(payload),
            NUMBER => LeafKind::Number(payload),
            _ => {
                let symbol = Symbol(payload & !SCALAR_OF_DATA);
                LeafKind::Scalar(if payload & SCALAR_OF_DATA == 0 {
                    RobotranName::local(symbol)
                } else {
                    RobotranName::of_data(symbol)
                })
            }
        }
    }
}
