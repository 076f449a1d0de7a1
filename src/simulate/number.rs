//! The numbers that the elements compute with.
//!
//! Rust's `f32` and `f64` are IEEE binary32 and binary64, rounded to nearest
//! with ties to even, on every target. A machine without subnormal numbers
//! (`subnormals = false`) never holds one: loaded values and results smaller
//! than the least normal number become a zero of the same sign. A product is
//! flushed when it is that small *before* rounding, which is the cheaper test
//! in hardware; it differs from the test after rounding only where a product
//! would round up to the least normal number. Sums and differences that small
//! are exact, so there is only one test for them. A fused multiply-add is
//! judged by its rounded result.

use robovec_ir::Operation;

/// A number format with the arithmetic of the elements and of the host.
pub(super) trait Number: Copy + Default {
    /// From the bits of a word.
    fn from_word(word: u64) -> Self;
    /// The bits of a word.
    fn to_word(self) -> u64;
    /// The nearest number of the format.
    fn from_binary64(number: f64) -> Self;
    /// The number, exactly.
    fn to_binary64(self) -> f64;
    /// What an element or the host computes; operations ignore what lies
    /// behind their operands.
    fn compute(operation: Operation, operands: [Self; 3]) -> Self;
    /// True for a nonzero number below the least normal one.
    fn is_subnormal(self) -> bool;
    /// True when the exact product is nonzero and below the least normal
    /// number, for factors that are not subnormal.
    fn product_is_tiny(a: Self, b: Self) -> bool;
    /// Zero with the sign of the number.
    fn to_zero(self) -> Self;
}

/// As [`Number::compute`], without subnormal numbers when `flush` is set.
pub(super) fn compute<N: Number>(operation: Operation, operands: [N; 3], flush: bool) -> N {
    let result = N::compute(operation, operands);
    if !flush {
        return result;
    }
    let [a, b, _] = operands;
    let tiny = operation == Operation::Mul && N::product_is_tiny(a, b);
    if tiny {
        result.to_zero()
    } else {
        flushed(result, true)
    }
}

/// The number itself, or the zero that stands for it.
pub(super) fn flushed<N: Number>(number: N, flush: bool) -> N {
    if flush && number.is_subnormal() {
        number.to_zero()
    } else {
        number
    }
}

impl Number for f32 {
    fn from_word(word: u64) -> f32 {
        f32::from_bits(word as u32)
    }
    fn to_word(self) -> u64 {
        u64::from(self.to_bits())
    }
    fn from_binary64(number: f64) -> f32 {
        number as f32
    }
    fn to_binary64(self) -> f64 {
        f64::from(self)
    }
    fn compute(operation: Operation, [a, b, c]: [f32; 3]) -> f32 {
        match operation {
            Operation::Copy => a,
            Operation::Neg => -a,
            Operation::Add => a + b,
            Operation::Sub => a - b,
            Operation::Mul => a * b,
            Operation::Div => a / b,
            Operation::Sqrt => a.sqrt(),
            Operation::Fma => a.mul_add(b, c),
            Operation::Fms => a.mul_add(b, -c),
            Operation::Fnma => (-a).mul_add(b, c),
            // The host's sine and cosine: those of binary64, rounded once.
            Operation::Sin => f64::from(a).sin() as f32,
            Operation::Cos => f64::from(a).cos() as f32,
        }
    }
    fn is_subnormal(self) -> bool {
        f32::is_subnormal(self)
    }
    fn product_is_tiny(a: f32, b: f32) -> bool {
        // The product of two binary32 numbers is exact in binary64.
        let exact = (f64::from(a) * f64::from(b)).abs();
        exact > 0.0 && exact < f64::from(f32::MIN_POSITIVE)
    }
    fn to_zero(self) -> f32 {
        0.0f32.copysign(self)
    }
}

impl Number for f64 {
    fn from_word(word: u64) -> f64 {
        f64::from_bits(word)
    }
    fn to_word(self) -> u64 {
        self.to_bits()
    }
    fn from_binary64(number: f64) -> f64 {
        number
    }
    fn to_binary64(self) -> f64 {
        self
    }
    fn compute(operation: Operation, [a, b, c]: [f64; 3]) -> f64 {
        match operation {
            Operation::Copy => a,
            Operation::Neg => -a,
            Operation::Add => a + b,
            Operation::Sub => a - b,
            Operation::Mul => a * b,
            Operation::Div => a / b,
            Operation::Sqrt => a.sqrt(),
            Operation::Fma => a.mul_add(b, c),
            Operation::Fms => a.mul_add(b, -c),
            Operation::Fnma => (-a).mul_add(b, c),
            Operation::Sin => a.sin(),
            Operation::Cos => a.cos(),
        }
    }
    fn is_subnormal(self) -> bool {
        f64::is_subnormal(self)
    }
    fn product_is_tiny(a: f64, b: f64) -> bool {
        let (small, large) = if a.abs() <= b.abs() { (a, b) } else { (b, a) };
        let product = (small * large).abs();
        if product == 0.0 {
            return small != 0.0;
        }
        if product != f64::MIN_POSITIVE {
            return product < f64::MIN_POSITIVE;
        }
        // Rounded to the least normal number: up or down? Scaled up by a
        // power of two the residue of the product is a normal number. The
        // smaller factor is below 2^-510 here, so the scaling is exact.
        let scale = 2f64.powi(400);
        let residue = (small.abs() * scale).mul_add(large.abs(), -f64::MIN_POSITIVE * scale);
        residue < 0.0
    }
    fn to_zero(self) -> f64 {
        0.0f64.copysign(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product<N: Number>(a: N, b: N) -> f64 {
        compute(Operation::Mul, [a, b, N::default()], true).to_binary64()
    }

    #[test]
    fn tiny_results_are_flushed_before_rounding() {
        // 2^-126 (1 - 2^-24) rounds up to the least normal number.
        let below = 1.0 - f32::EPSILON / 2.0;
        let almost = f32::MIN_POSITIVE * 2.0;
        assert_eq!(almost * (below / 2.0), f32::MIN_POSITIVE, "it rounds up");
        assert_eq!(product(almost, below / 2.0), 0.0);
        assert_eq!(
            product(f32::MIN_POSITIVE, 1.0),
            f64::from(f32::MIN_POSITIVE)
        );
        let sign = product(-almost, below / 2.0);
        assert!(sign == 0.0 && sign.is_sign_negative());
        let below = 1.0 - f64::EPSILON / 2.0;
        let almost = f64::MIN_POSITIVE * 2.0;
        assert_eq!(almost * (below / 2.0), f64::MIN_POSITIVE, "it rounds up");
        assert_eq!(product(almost, below / 2.0), 0.0);
        assert_eq!(product(f64::MIN_POSITIVE, 1.0), f64::MIN_POSITIVE);
        assert_eq!(product(f64::MIN_POSITIVE, 0.5), 0.0);
    }

    #[test]
    fn sums_are_flushed_and_kept_by_choice() {
        let (a, b) = (f32::MIN_POSITIVE * 1.5, f32::MIN_POSITIVE);
        assert_eq!(compute(Operation::Sub, [a, b, 0.0], true), 0.0);
        assert_eq!(compute(Operation::Sub, [a, b, 0.0], false), a - b);
        assert!(compute(Operation::Sub, [b, a, 0.0], true).is_sign_negative());
    }
}
