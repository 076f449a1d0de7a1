//! Index newtypes: the entities of the representation.
//!
//! Everything lives in vectors and is named by a `u32`, so that a program of
//! 600,000 operations has no pointers to chase, can be cloned with a few
//! `memcpy`s and is traversed by a counting loop.

use std::fmt;

/// A node of a function: one operation. Its number is its place in program
/// order, so an operand's number is always smaller than its user's.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Value(pub u32);

/// An element of the flattened inputs of a function (see
/// [`crate::Array::offset`]); counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Input(pub u32);

/// An element of the flattened outputs of a function; counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Output(pub u32);

/// A literal of a function; counted from 0 in its table of constants.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Constant(pub u32);

impl Value {
    /// The place of the node in program order, counted from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Input {
    /// The place in the flattened inputs, counted from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Output {
    /// The place in the flattened outputs, counted from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Constant {
    /// The place in the table of constants, counted from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

const KIND_SHIFT: u32 = 30;
const INDEX_MASK: u32 = (1 << KIND_SHIFT) - 1;

/// The largest number of values, inputs or constants a function can hold.
pub const CAPACITY: usize = INDEX_MASK as usize;

/// An operand of a node: another value, an input element or a constant, packed
/// into 32 bits. [`Operand::kind`] decodes it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Operand(u32);

/// An [`Operand`], decoded.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum OperandKind {
    /// The result of a node.
    Value(Value),
    /// An element of an input array.
    Input(Input),
    /// A literal.
    Constant(Constant),
    /// No operand, after those that an operation takes.
    None,
}

impl Operand {
    /// The absent operand after those that an operation takes.
    pub const NONE: Operand = Operand(u32::MAX);

    /// The maximum number of operands an operation takes: a fused multiply-add
    /// has three. They are part of the node, which grows by four bytes for the
    /// third; a table beside the nodes would save them and slow down every
    /// traversal.
    pub const MAX_COUNT: usize = 3;

    /// The operands of an operation, filled up with [`Operand::NONE`].
    #[inline]
    pub fn list<const COUNT: usize>(given: [Operand; COUNT]) -> [Operand; Operand::MAX_COUNT] {
        const { assert!(COUNT <= Operand::MAX_COUNT) };
        let mut operands = [Operand::NONE; Operand::MAX_COUNT];
        operands[..COUNT].copy_from_slice(&given);
        operands
    }

    /// The decoded operand.
    #[inline]
    pub fn kind(self) -> OperandKind {
        match self.0 >> KIND_SHIFT {
            0 => OperandKind::Value(Value(self.0)),
            1 => OperandKind::Input(Input(self.0 & INDEX_MASK)),
            2 => OperandKind::Constant(Constant(self.0 & INDEX_MASK)),
            _ => OperandKind::None,
        }
    }

    /// The value, when the operand is one.
    #[inline]
    pub fn value(self) -> Option<Value> {
        // Values come first, so that their bits are their number.
        (self.0 <= INDEX_MASK).then_some(Value(self.0))
    }

    /// The entry that a table of values, in program order, has for the operand;
    /// `None` for an operand that is no value, or beyond the table.
    #[inline]
    pub fn entry<T>(self, table: &[T]) -> Option<&T> {
        // What is no value has larger bits than any table has entries.
        table.get(self.0 as usize)
    }

    /// The entry of a value, or the default for an input or constant, which is
    /// available from the start.
    #[inline]
    pub fn entry_or_default<T: Copy + Default>(self, table: &[T]) -> T {
        self.entry(table).copied().unwrap_or_default()
    }

    /// The constant, when the operand is one.
    #[inline]
    pub fn constant(self) -> Option<Constant> {
        match self.kind() {
            OperandKind::Constant(constant) => Some(constant),
            OperandKind::Value(_) | OperandKind::Input(_) | OperandKind::None => None,
        }
    }

    /// The input element, when the operand is one.
    #[inline]
    pub fn input(self) -> Option<Input> {
        match self.kind() {
            OperandKind::Input(input) => Some(input),
            OperandKind::Value(_) | OperandKind::Constant(_) | OperandKind::None => None,
        }
    }

    /// True for [`Operand::NONE`].
    #[inline]
    pub fn is_none(self) -> bool {
        self == Operand::NONE
    }

    /// The kind (0 to 3, as [`OperandKind`] lists them) and the index, without
    /// a branch; the absent operand has index [`CAPACITY`].
    #[inline]
    pub(crate) fn parts(self) -> (usize, usize) {
        (
            (self.0 >> KIND_SHIFT) as usize,
            (self.0 & INDEX_MASK) as usize,
        )
    }

    /// The packed bits: a dense, order-preserving key for tables.
    #[inline]
    pub fn bits(self) -> u32 {
        self.0
    }
}

impl From<Value> for Operand {
    #[inline]
    fn from(value: Value) -> Operand {
        assert!(value.0 <= INDEX_MASK, "a value's number fits an operand");
        Operand(value.0)
    }
}

impl From<Input> for Operand {
    #[inline]
    fn from(input: Input) -> Operand {
        Operand(1 << KIND_SHIFT | input.0)
    }
}

impl From<Constant> for Operand {
    #[inline]
    fn from(constant: Constant) -> Operand {
        assert!(
            constant.0 <= INDEX_MASK,
            "a constant's number fits an operand"
        );
        Operand(2 << KIND_SHIFT | constant.0)
    }
}

impl fmt::Debug for Operand {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.kind().fmt(formatter)
    }
}
