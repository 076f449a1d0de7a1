//! Derivatives of one operation with respect to its operands.
//!
//! *Tangent* ones are the usual derivatives. *Secant* ones are the quotients
//! of differences between two evaluations, so that
//!
//! > computed result − exact result = Σ secant × (computed − exact operand)
//!
//! holds exactly and not only to first order: for a product the secants are the
//! exact second factor and the computed first one. An error propagated by
//! secants loses no second-order term, for any condition number; between equal
//! evaluations the two kinds agree.
//!
//! The third operand of a fused operation only enters a sum; its derivative
//! is [`third`] and is not stored.

use robovec_ir::Operation;

/// Derivatives by the first two operands at one point, from the operands and
/// the result.
pub fn tangent(operation: Operation, [a, b, _]: [f64; 3], result: f64) -> [f64; 2] {
    match operation {
        Operation::Copy => [1.0, 0.0],
        Operation::Neg => [-1.0, 0.0],
        Operation::Add => [1.0, 1.0],
        Operation::Sub => [1.0, -1.0],
        Operation::Mul | Operation::Fma | Operation::Fms => [b, a],
        Operation::Fnma => [-b, -a],
        Operation::Div => [1.0 / b, -result / b],
        Operation::Sin => [a.cos(), 0.0],
        Operation::Cos => [-a.sin(), 0.0],
        Operation::Sqrt => [0.5 / result, 0.0],
    }
}

/// An operand or a result in both evaluations.
#[derive(Clone, Copy)]
pub(super) struct EvaluationPair {
    /// In exact arithmetic, to binary64.
    pub(super) exact: f64,
    /// In the format.
    pub(super) computed: f64,
    /// Computed less exact, to binary64 even where the two nearly agree.
    pub(super) error: f64,
}

/// Quotients of differences between the exact evaluation and another.
pub(super) fn secant(operation: Operation, [a, b, _]: [EvaluationPair; 3], exact: f64) -> [f64; 2] {
    // The mean of the angles, and sin(d)/d for half their difference.
    let wave = || {
        let half = 0.5 * a.error;
        let ratio = if half == 0.0 { 1.0 } else { half.sin() / half };
        (a.exact + half, ratio)
    };
    match operation {
        // An operand that overflowed: how far it is off is known of none of
        // these, and zero times an infinite error is not zero.
        Operation::Div if b.computed.is_infinite() => [0.0, f64::NAN],
        Operation::Sqrt if a.computed.is_infinite() => [f64::NAN, 0.0],
        Operation::Copy => [1.0, 0.0],
        Operation::Neg => [-1.0, 0.0],
        Operation::Add => [1.0, 1.0],
        Operation::Sub => [1.0, -1.0],
        Operation::Mul | Operation::Fma | Operation::Fms => [b.exact, a.computed],
        Operation::Fnma => [-b.exact, -a.computed],
        Operation::Div => [1.0 / b.computed, -exact / b.computed],
        Operation::Sin => {
            let (mean, ratio) = wave();
            [mean.cos() * ratio, 0.0]
        }
        Operation::Cos => {
            let (mean, ratio) = wave();
            [-mean.sin() * ratio, 0.0]
        }
        Operation::Sqrt => [1.0 / (a.computed.sqrt() + exact), 0.0],
    }
}

/// The derivative with respect to the third operand, if there is one.
#[inline]
pub fn third(operation: Operation) -> f64 {
    match operation {
        Operation::Fms => -1.0,
        _ => 1.0,
    }
}
