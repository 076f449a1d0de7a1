//! The tokens of the grammar, shared by the three languages.
//!
//! A reference to an array element is one token whatever the language writes
//! (`s->dpt[3][1]`, `s.dpt(3,1)`, `s.dpt[3,1]`): this keeps the grammar free
//! of the languages' index syntax and halves the work of the parser.

use robovec_ir::{Operation, Symbol};

/// A byte range of the source text; files are refused beyond 4 GiB.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Span {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Span {
    pub(super) fn new(start: usize, end: usize) -> Span {
        // The reader refuses texts whose offsets do not fit.
        Span {
            start: start as u32,
            end: end as u32,
        }
    }

    pub(super) fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

const OF_DATA: u32 = 1 << 31;

/// An identifier, and whether it was reached through the data structure
/// (`s->frc`, `s.frc`).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) struct Name(u32);

impl Name {
    pub(super) fn local(symbol: Symbol) -> Name {
        Name(symbol.0)
    }

    pub(super) fn of_data(symbol: Symbol) -> Name {
        Name(symbol.0 | OF_DATA)
    }

    pub(super) fn symbol(self) -> Symbol {
        Symbol(self.0 & !OF_DATA)
    }

    pub(super) fn is_of_data(self) -> bool {
        self.0 & OF_DATA != 0
    }
}

/// An array element; indices count from 1, the second is 0 for a vector.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Element {
    pub(super) name: Name,
    pub(super) row: u32,
    pub(super) column: u32,
}

/// A terminal of the grammar.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Token {
    Name(Name),
    Element(Element),
    Number(f64),
    /// `sin`, `cos` or `sqrt`.
    Function(Operation),
    /// `zeros(3,6)` and its like; the extents as an element's indices.
    Zeros((u32, u32)),
    /// A string literal.
    Text,
    /// A word of a C declaration; true for a floating-point type.
    Type(bool),
    Plus,
    Minus,
    Star,
    Slash,
    Equals,
    Open,
    Close,
    BracketOpen,
    BracketClose,
    BraceOpen,
    BraceClose,
    Comma,
    Colon,
    Ampersand,
    /// The end of a statement: `;`, or a line end where that ends one.
    End,
    /// `function` of Matlab.
    FunctionHead,
    /// `def` of Python.
    Def,
    /// `end` of Matlab.
    BlockEnd,
    Switch,
    Case,
    Default,
    Break,
    Return,
    /// `while` with its condition.
    While,
    /// `if` with its condition.
    If,
    /// `else if` in one word, with its condition.
    ElseIf,
    Else,
    /// `for`, `do`, `goto`: never accepted.
    Refused,
    /// Any other character: never accepted.
    Other,
}
