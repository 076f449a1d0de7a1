//! Polynomials that represent a sine or a cosine.

use crate::double_double::Double;
use crate::format::Format;
use crate::soft_float::FormatArithmetic;

crate::named! {
    /// One of the two circular functions.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum Circular {
        /// The sine: odd powers of the angle.
        Sine = "sine",
        /// The cosine: even powers of the angle.
        Cosine = "cosine",
    }
}

impl Circular {
    /// Both functions.
    pub const BOTH: [Circular; 2] = [Circular::Sine, Circular::Cosine];

    /// The power of the angle that the first coefficient multiplies.
    pub fn first_power(self) -> u32 {
        match self {
            Circular::Sine => 1,
            Circular::Cosine => 0,
        }
    }

    /// The number of coefficients of a polynomial of an order: those of powers
    /// up to the order.
    pub fn terms(self, order: u32) -> usize {
        ((order.max(1) - self.first_power()) / 2 + 1) as usize
    }

    /// The first coefficients of the function's own series, to some 100 bits:
    /// `(-1)^k / (2k + first power)!`.
    pub fn series(self, terms: usize) -> Vec<Double> {
        let mut coefficients = Vec::with_capacity(terms);
        let mut coefficient = Double::from(1.0);
        let mut power = f64::from(self.first_power());
        for _ in 0..terms {
            coefficients.push(coefficient);
            let next = (power + 1.0) * (power + 2.0);
            coefficient = -(coefficient / Double::from(next));
            power += 2.0;
        }
        coefficients
    }
}

/// The largest order a polynomial can have: the series of both functions
/// then end below the rounding of binary64 for any angle of a turn.
pub const MAX_ORDER: u32 = 31;

/// The largest range polynomials are judged on, in radians: beyond five turns
/// no series of [`MAX_ORDER`] is of use.
pub const LARGEST_RANGE: f64 = 32.0;

/// A polynomial in the square of the angle: `c[0] + c[1] x^2 + c[2] x^4 …`,
/// which for a sine is multiplied by the angle.
///
/// Invariant: there is at least one coefficient.
#[derive(Clone, PartialEq, Debug)]
pub struct Polynomial {
    /// The function that it represents.
    pub of: Circular,
    /// Its coefficients, rounded to the format.
    pub coefficients: Vec<f64>,
}

impl Polynomial {
    /// The series of Taylor up to an order: all terms whose power of the
    /// angle is at most the order. Order 1 is `sin x = x` and `cos x = 1`,
    /// order 3 is `x - x^3/6` and `1 - x^2/2`, as in the thesis.
    pub fn taylor(of: Circular, order: u32) -> Polynomial {
        let series = of.series(of.terms(order));
        Polynomial {
            of,
            coefficients: series.iter().map(|number| number.high).collect(),
        }
    }

    /// The largest power of the angle.
    pub fn degree(&self) -> u32 {
        assert!(
            !self.coefficients.is_empty(),
            "a polynomial has a coefficient"
        );
        2 * (self.coefficients.len() as u32 - 1) + self.of.first_power()
    }

    /// The polynomial with its coefficients rounded to a format.
    #[must_use]
    pub fn rounded(&self, format: Format) -> Polynomial {
        let arithmetic = FormatArithmetic::new(format);
        let coefficients = self.coefficients.iter();
        Polynomial {
            of: self.of,
            coefficients: coefficients
                .map(|&number| arithmetic.convert(number))
                .collect(),
        }
    }

    /// Its value to some 100 bits.
    pub fn at(&self, angle: Double) -> Double {
        let square = angle * angle;
        let mut sum = Double::from(0.0);
        for &coefficient in self.coefficients.iter().rev() {
            sum = sum * square + Double::from(coefficient);
        }
        match self.of {
            Circular::Sine => sum * angle,
            Circular::Cosine => sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_count_as_in_the_thesis() {
        let taylor = |of, order| Polynomial::taylor(of, order).coefficients;
        assert_eq!(taylor(Circular::Sine, 1), [1.0]);
        assert_eq!(taylor(Circular::Cosine, 1), [1.0]);
        assert_eq!(taylor(Circular::Sine, 2), [1.0]);
        assert_eq!(taylor(Circular::Cosine, 2), [1.0, -0.5]);
        assert_eq!(taylor(Circular::Sine, 3), [1.0, -1.0 / 6.0]);
        assert_eq!(taylor(Circular::Cosine, 3), [1.0, -0.5]);
        assert_eq!(taylor(Circular::Sine, 5).len(), 3);
        assert_eq!(taylor(Circular::Cosine, 7).len(), 4);
        assert_eq!(Polynomial::taylor(Circular::Sine, 7).degree(), 7);
        assert_eq!(Polynomial::taylor(Circular::Cosine, 7).degree(), 6);
    }

    #[test]
    fn coefficients_round_to_the_nearest_of_a_format() {
        let sine = Polynomial::taylor(Circular::Sine, 3);
        let rounded = |format: &str| {
            sine.rounded(format.parse().expect("it is one"))
                .coefficients
        };
        assert_eq!(rounded("f32"), [1.0, f64::from(-1.0f32 / 6.0)]);
        assert_eq!(rounded("f64"), [1.0, -1.0 / 6.0]);
        assert_eq!(rounded("fixed(3,2)"), [1.0, -0.25]);
    }
}
