//! The operations a node can perform.

/// The operation that a node performs on its operands.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[repr(u8)]
pub enum Operation {
    /// The operand itself; only at the equations level (`Z1 = q[13]`).
    Copy,
    /// `-a`; only at the equations level: `atomise` makes it `0 - a`.
    Neg,
    /// `a + b`.
    Add,
    /// `a - b`.
    Sub,
    /// `a * b`.
    Mul,
    /// `a / b`.
    Div,
    /// `sin(a)`.
    Sin,
    /// `cos(a)`.
    Cos,
    /// `sqrt(a)`.
    Sqrt,
    /// `a * b + c`, rounded once.
    Fma,
    /// `a * b - c`, rounded once.
    Fms,
    /// `c - a * b`, rounded once.
    Fnma,
}

impl Operation {
    /// All operations, in order of declaration.
    pub const ALL: [Operation; 12] = [
        Operation::Copy,
        Operation::Neg,
        Operation::Add,
        Operation::Sub,
        Operation::Mul,
        Operation::Div,
        Operation::Sin,
        Operation::Cos,
        Operation::Sqrt,
        Operation::Fma,
        Operation::Fms,
        Operation::Fnma,
    ];

    /// The number of operands of the operation: one to three.
    #[inline]
    pub fn arity(self) -> usize {
        match self {
            Operation::Add | Operation::Sub | Operation::Mul | Operation::Div => 2,
            Operation::Copy
            | Operation::Neg
            | Operation::Sin
            | Operation::Cos
            | Operation::Sqrt => 1,
            Operation::Fma | Operation::Fms | Operation::Fnma => 3,
        }
    }

    /// True when the first two operands (of a fused operation the factors)
    /// may be exchanged without changing a bit.
    #[inline]
    pub fn is_commutative(self) -> bool {
        matches!(self, Operation::Add | Operation::Mul) || self.is_fused()
    }

    /// True for a product and a sum in one operation, with one rounding.
    #[inline]
    pub fn is_fused(self) -> bool {
        matches!(self, Operation::Fma | Operation::Fms | Operation::Fnma)
    }

    /// True for sine and cosine, which the thesis' machine takes from the host
    /// and never counts.
    #[inline]
    pub fn is_trigonometric(self) -> bool {
        matches!(self, Operation::Sin | Operation::Cos)
    }

    /// The operation's name in machine files and statistics.
    #[inline]
    pub fn name(self) -> &'static str {
        match self {
            Operation::Copy => "copy",
            Operation::Neg => "neg",
            Operation::Add => "add",
            Operation::Sub => "sub",
            Operation::Mul => "mul",
            Operation::Div => "div",
            Operation::Sin => "sin",
            Operation::Cos => "cos",
            Operation::Sqrt => "sqrt",
            Operation::Fma => "fma",
            Operation::Fms => "fms",
            Operation::Fnma => "fnma",
        }
    }
}
