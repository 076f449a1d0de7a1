//! The operations a node can perform.

crate::named! {
    /// The operation that a node performs on its operands.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    #[repr(u8)]
    pub enum Operation {
        /// The operand itself; only at the equations level (`Z1 = q[13]`).
        Copy = "copy",
        /// `-a`; only at the equations level: `atomise` makes it `0 - a`.
        Neg = "neg",
        /// `a + b`.
        Add = "add",
        /// `a - b`.
        Sub = "sub",
        /// `a * b`.
        Mul = "mul",
        /// `a / b`.
        Div = "div",
        /// `sin(a)`.
        Sin = "sin",
        /// `cos(a)`.
        Cos = "cos",
        /// `sqrt(a)`.
        Sqrt = "sqrt",
        /// `a * b + c`, rounded once.
        Fma = "fma",
        /// `a * b - c`, rounded once.
        Fms = "fms",
        /// `c - a * b`, rounded once.
        Fnma = "fnma",
    }
}

impl Operation {
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
}
