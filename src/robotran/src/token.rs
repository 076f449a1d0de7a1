//! The tokens of the grammar, shared by the three languages.
//!
//! A reference to an array element is one token in any language
//! (`s->dpt[3][1]`, `s.dpt(3,1)`, `s.dpt[3,1]`): this keeps the grammar free of
//! the languages' index syntax and halves the work of the parser.

use super::literal::Literal;
use robovec_ir::{Operation, Symbol};

/// A byte range of the source text; files are refused beyond 4 GiB.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SourceSpan {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl SourceSpan {
    /// The bytes from `start` up to `end`.
    pub fn new(start: usize, end: usize) -> SourceSpan {
        // The reader refuses texts whose offsets do not fit.
        SourceSpan {
            start: start as u32,
            end: end as u32,
        }
    }

    pub(crate) fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A lexeme that is no token, with the reason; the texts lie apart, since every
/// token that is right has the size of an error.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct LexicalError {
    pub(super) span: SourceSpan,
    reason: Box<[&'static str; 2]>,
}

impl LexicalError {
    #[cold]
    pub(super) fn new(span: SourceSpan, message: &'static str, note: &'static str) -> LexicalError {
        LexicalError {
            span,
            reason: Box::new([message, note]),
        }
    }

    pub(super) fn message(&self) -> &'static str {
        self.reason[0]
    }

    pub(super) fn note(&self) -> &'static str {
        self.reason[1]
    }
}

const OF_DATA: u32 = 1 << 31;

/// An identifier; true when reached through the data structure (`s->frc`).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) struct RobotranName(u32);

impl RobotranName {
    pub(super) fn local(symbol: Symbol) -> RobotranName {
        RobotranName(symbol.0)
    }

    pub(super) fn of_data(symbol: Symbol) -> RobotranName {
        RobotranName(symbol.0 | OF_DATA)
    }

    pub(super) fn symbol(self) -> Symbol {
        Symbol(self.0 & !OF_DATA)
    }

    pub(super) fn is_of_data(self) -> bool {
        self.0 & OF_DATA != 0
    }
}

/// An array element; indices count from 1, the second is 0 for a vector, and
/// both are 0 for the target of a C pointer (`*power`).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct RobotranElement {
    pub(super) name: RobotranName,
    pub(super) row: u32,
    pub(super) column: u32,
}

/// Words before a name in a C declaration.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(super) struct TypeWords(u8);

impl TypeWords {
    /// `const` and its like, which change no number.
    pub(super) const QUALIFIER: TypeWords = TypeWords(0);
    pub(super) const DOUBLE: TypeWords = TypeWords(1);
    pub(super) const SINGLE: TypeWords = TypeWords(2);
    /// `int` and its like.
    pub(super) const WHOLE: TypeWords = TypeWords(4);
    pub(super) const NOTHING: TypeWords = TypeWords(8);
    /// Robotran's structures.
    pub(super) const STRUCTURE: TypeWords = TypeWords(16);

    /// All words of both.
    pub(super) fn and(self, other: TypeWords) -> TypeWords {
        TypeWords(self.0 | other.0)
    }

    pub(super) fn is_double(self) -> bool {
        self == TypeWords::DOUBLE
    }

    pub(super) fn is_whole(self) -> bool {
        self == TypeWords::WHOLE
    }

    /// True for floating-point numbers of another length than 64 bits.
    pub(super) fn is_other_float(self) -> bool {
        self.0 & TypeWords::SINGLE.0 != 0 || self == TypeWords::DOUBLE.and(TypeWords::WHOLE)
    }
}

/// A terminal of the grammar.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum RobotranToken {
    Name(RobotranName),
    Element(RobotranElement),
    Number(Literal),
    /// `sin`, `cos` or `sqrt`.
    Function(Operation),
    /// `zeros(3,6)` and its like; the extents as an element's indices.
    Zeros((u32, u32)),
    /// A string literal.
    Text,
    /// A word of a C declaration.
    Type(TypeWords),
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
