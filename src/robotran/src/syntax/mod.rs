//! A file as the grammar sees it: flat lists of nodes and of statements.
//!
//! Invariant: the nodes of an expression are in one run of the arena, every
//! operand before its user. Lowering is therefore one loop over the run.

mod builder;

pub(super) use self::builder::SyntaxBuilder;

use super::literal::Literal;
use super::token::{RobotranElement, RobotranName, SourceSpan};
use robovec_ir::{Operation, Symbol};

/// One operation of an expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct SyntaxNode {
    pub(super) operands: [SyntaxLeaf; 2],
    pub(super) operation: Operation,
    /// It is in parentheses.
    pub(super) grouped: bool,
    /// In Python: its number of bits as a whole number; 0 for a float.
    pub(super) whole_bits: u8,
}

impl SyntaxNode {
    pub(super) fn operands(&self) -> &[SyntaxLeaf] {
        &self.operands[..self.operation.arity()]
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SyntaxStatement {
    pub(super) kind: StatementKind,
    pub(super) span: SourceSpan,
    /// Number of [`SyntaxTree::elements`] before it and inside it.
    pub(super) elements: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum StatementKind {
    /// `target = root`, whose nodes are the run from `first` to `end`.
    Equation {
        target: SyntaxLeaf,
        root: SyntaxLeaf,
        first: u32,
        end: u32,
    },
    /// An entry of [`SyntaxTree::calls`].
    Call(u32),
    /// An entry of [`SyntaxTree::extents`]: `M = zeros(6,6)` or `double P[4];`.
    Extent(u32),
    /// An integer variable of the solver: `int iter = 0;`.
    Counter(RobotranName),
    /// A pointer of C that is declared and points at nothing yet.
    Pointer(RobotranName),
    /// A whole-array assignment such as `q = s->q;`, already processed.
    Prologue,
    /// An entry of [`SyntaxTree::heads`].
    Head(u32),
    BlockOpen,
    BlockClose,
    Switch(RobotranName),
    Case(u32),
    DefaultCase,
    Break,
    Return,
    While,
    If,
    ElseIf,
    Else,
}

/// A call of a function that is not one of the three known ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct FunctionCall {
    pub(super) target: Option<SyntaxLeaf>,
    pub(super) callee: RobotranName,
    /// First and last-but-one entry of [`SyntaxTree::arguments`].
    pub(super) arguments: (u32, u32),
}

/// An argument of a call; [`SyntaxLeaf::NONE`] when it is no expression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Argument {
    pub(super) leaf: SyntaxLeaf,
    pub(super) span: SourceSpan,
}

/// An array of known extent.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeclaredArray {
    pub(super) name: RobotranName,
    pub(super) rows: u32,
    pub(super) columns: u32,
    /// True for `zeros`, which also gives values.
    pub(super) zeroed: bool,
}

#[derive(Clone, Debug)]
pub(super) struct FunctionHeader {
    pub(super) name: Symbol,
    pub(super) parameters: Vec<RobotranName>,
    /// The parameters of C that are whole numbers.
    pub(super) whole: Vec<RobotranName>,
    /// Results of a Matlab function.
    pub(super) outputs: Vec<RobotranName>,
    /// The first entry of [`SyntaxTree::elements`] that belongs to the function.
    pub(super) first_element: u32,
}

/// A file.
#[derive(Default, Debug)]
pub(super) struct SyntaxTree {
    pub(super) nodes: Vec<SyntaxNode>,
    pub(super) elements: Vec<RobotranElement>,
    pub(super) numbers: Vec<Literal>,
    pub(super) statements: Vec<SyntaxStatement>,
    pub(super) calls: Vec<FunctionCall>,
    pub(super) arguments: Vec<Argument>,
    pub(super) extents: Vec<DeclaredArray>,
    pub(super) heads: Vec<FunctionHeader>,
}

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

const ELEMENT: u32 = 1 << KIND_SHIFT;

const NUMBER: u32 = 2 << KIND_SHIFT;

const SCALAR: u32 = 3 << KIND_SHIFT;

const SCALAR_OF_DATA: u32 = 1 << 29;

/// Maximum number of nodes, elements, literals or names of a file.
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

    fn element(index: u32) -> SyntaxLeaf {
        debug_assert!(
            (index as usize) < CAPACITY,
            "a text within the limit has fewer elements"
        );
        SyntaxLeaf(ELEMENT | index)
    }

    fn number(index: u32) -> SyntaxLeaf {
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
