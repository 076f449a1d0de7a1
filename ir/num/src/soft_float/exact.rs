//! Exact results as integers, for results beyond binary64.
//!
//! Every function returns `None` where binary64's own result is exact: for
//! operands or results that are zero, and for infinities and NaN.

/// A finite number that is not zero: `significand * 2^exponent` with a sign.
///
/// Invariant: where the number was not exact, the last bit of the significand
/// is set ("and a little more") and at least 62 bits are before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactNumber {
    pub(super) negative: bool,
    pub(super) significand: u128,
    pub(super) exponent: i32,
}

/// The place of the leading bit of both terms of a sum: two places are left
/// for the carry.
const LEADING: u32 = 125;

impl ExactNumber {
    /// A binary64 number, its significand's leading bit at place 63.
    fn new(number: f64) -> Option<ExactNumber> {
        let bits = number.to_bits();
        let field = (bits >> 52 & 0x7FF) as i32;
        let fraction = bits & ((1 << 52) - 1);
        let (significand, exponent) = match field {
            0 => (fraction, -1074),
            0x7FF => return None,
            _ => (fraction | 1 << 52, field - 1075),
        };
        if significand == 0 {
            return None;
        }
        let shift = significand.leading_zeros();
        Some(ExactNumber {
            negative: bits >> 63 == 1,
            significand: u128::from(significand << shift),
            exponent: exponent - shift as i32,
        })
    }

    /// The exponent of the leading bit.
    pub(super) fn leading(&self) -> i32 {
        self.exponent + self.significand.ilog2() as i32
    }

    /// The same number with its leading bit at [`LEADING`]; the bits shifted
    /// out must be zeros.
    fn aligned(self) -> ExactNumber {
        let place = self.significand.ilog2();
        let (significand, shift) = if place > LEADING {
            let shift = place - LEADING;
            assert!(
                self.significand.trailing_zeros() >= shift,
                "only zeros are shifted out"
            );
            (self.significand >> shift, shift as i32)
        } else {
            let shift = LEADING - place;
            (self.significand << shift, -(shift as i32))
        };
        ExactNumber {
            significand,
            exponent: self.exponent + shift,
            ..self
        }
    }

    /// The sum. Terms have at most 106 significant bits, so that no bit of the
    /// smaller one is lost where leading bits can cancel.
    fn plus(self, other: ExactNumber) -> Option<ExactNumber> {
        let (a, b) = (self.aligned(), other.aligned());
        let (large, small) = if (a.exponent, a.significand) >= (b.exponent, b.significand) {
            (a, b)
        } else {
            (b, a)
        };
        let shifted = shifted_right(small.significand, large.exponent.abs_diff(small.exponent));
        let significand = if large.negative == small.negative {
            large.significand + shifted
        } else {
            large.significand - shifted
        };
        (significand != 0).then_some(ExactNumber {
            significand,
            ..large
        })
    }
}

/// A shift to the right that leaves a mark where it drops bits.
fn shifted_right(significand: u128, shift: u32) -> u128 {
    if shift >= 128 {
        return u128::from(significand != 0);
    }
    let kept = significand >> shift;
    kept | u128::from(kept << shift != significand)
}

/// `a + b`.
pub(super) fn sum(a: f64, b: f64) -> Option<ExactNumber> {
    ExactNumber::new(a)?.plus(ExactNumber::new(b)?)
}

/// `a * b`.
pub(super) fn product(a: f64, b: f64) -> Option<ExactNumber> {
    let (a, b) = (ExactNumber::new(a)?, ExactNumber::new(b)?);
    Some(ExactNumber {
        negative: a.negative != b.negative,
        significand: a.significand * b.significand,
        exponent: a.exponent + b.exponent,
    })
}

/// `a / b`.
pub(super) fn quotient(a: f64, b: f64) -> Option<ExactNumber> {
    let (a, b) = (ExactNumber::new(a)?, ExactNumber::new(b)?);
    let dividend = a.significand << 63;
    let rest = dividend % b.significand;
    assert!(
        dividend / b.significand >= 1 << 62,
        "an inexact quotient has 62 bits before its last"
    );
    Some(ExactNumber {
        negative: a.negative != b.negative,
        significand: (dividend / b.significand) | u128::from(rest != 0),
        exponent: a.exponent - 63 - b.exponent,
    })
}

/// `sqrt(a)`.
pub(super) fn root(a: f64) -> Option<ExactNumber> {
    let a = ExactNumber::new(a).filter(|a| !a.negative)?;
    let shift = 62 + (a.exponent & 1) as u32;
    let radicand = a.significand << shift;
    let root = radicand.isqrt();
    assert!(
        root >= 1 << 62,
        "an inexact root has 62 bits before its last"
    );
    Some(ExactNumber {
        negative: false,
        significand: root | u128::from(root * root != radicand),
        exponent: (a.exponent - shift as i32) / 2,
    })
}

/// `a * b + c`.
pub(super) fn fused(a: f64, b: f64, c: f64) -> Option<ExactNumber> {
    if !c.is_finite() {
        return None;
    }
    let product = product(a, b)?;
    match ExactNumber::new(c) {
        Some(c) => product.plus(c),
        None => Some(product),
    }
}
