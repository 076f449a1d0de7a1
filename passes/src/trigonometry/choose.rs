//! The choice of polynomials for a range.

use super::options::CircularMethod;
use robovec_ir::Format;
use robovec_num::trigonometry::{Circular, Halved, MAX_ORDER, Polynomial};

/// The options of the user.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wish {
    pub(super) method: CircularMethod,
    /// 0: the smallest order that keeps `error`.
    pub(super) order: u32,
    pub(super) error: f64,
    pub(super) halvings: u32,
    /// The format coefficients are rounded to.
    pub(super) format: Option<Format>,
}

/// Polynomials for a range, with their proved errors.
#[derive(Clone, Debug)]
pub(super) struct PolynomialChoice {
    pub(super) halved: Halved,
    /// The orders of sine and cosine.
    pub(super) orders: [u32; 2],
    /// Proved absolute errors of sine and cosine.
    pub(super) errors: [f64; 2],
}

impl Wish {
    /// The polynomials for angles of at most `range` radians; `None` when no
    /// order keeps the error.
    pub(super) fn choose(&self, range: f64, wanted: [bool; 2]) -> Option<PolynomialChoice> {
        if self.order > 0 {
            return Some(self.choice([self.order; 2], range));
        }
        if self.halvings > 0 {
            // The doubled errors mix both polynomials.
            return (1..=MAX_ORDER)
                .map(|order| self.choice([order; 2], range))
                .find(|choice| self.is_met(choice, wanted));
        }
        let mut orders = [1; 2];
        for (which, of) in Circular::BOTH.into_iter().enumerate() {
            if wanted[which] {
                orders[which] = (1..=MAX_ORDER)
                    .filter(|order| order % 2 == of.first_power() || *order == 1)
                    .find(|&order| {
                        self.polynomial(of, order, range).proved_error(range) <= self.error
                    })?;
            }
        }
        Some(self.choice(orders, range))
    }

    fn is_met(&self, choice: &PolynomialChoice, wanted: [bool; 2]) -> bool {
        let mut errors = choice.errors.iter().zip(wanted);
        errors.all(|(&error, wanted)| !wanted || error <= self.error)
    }

    fn choice(&self, orders: [u32; 2], range: f64) -> PolynomialChoice {
        let mut halved = Halved {
            sine: Polynomial::taylor(Circular::Sine, 1),
            cosine: Polynomial::taylor(Circular::Cosine, 1),
            halvings: self.halvings,
        };
        let small = halved.reduced(range);
        halved.sine = self.polynomial(Circular::Sine, orders[0], small);
        halved.cosine = self.polynomial(Circular::Cosine, orders[1], small);
        PolynomialChoice {
            orders,
            errors: halved.proved_errors(range),
            halved,
        }
    }

    fn polynomial(&self, of: Circular, order: u32, range: f64) -> Polynomial {
        match (self.method, self.format) {
            (CircularMethod::Minimax, format) => Polynomial::minimax(of, order, range, format),
            (_, None) => Polynomial::taylor(of, order),
            (_, Some(format)) => Polynomial::taylor(of, order).rounded(format),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WISH: Wish = Wish {
        method: CircularMethod::Taylor,
        order: 0,
        error: 1e-6,
        halvings: 0,
        format: None,
    };

    #[test]
    fn the_least_order_that_keeps_the_error_is_found() {
        // x^5/120 and x^6/720 at 0.1 are 8.3e-8 and 1.4e-9; x^3/6 and x^4/24
        // are 1.7e-4 and 4.2e-6.
        let choice = WISH.choose(0.1, [true; 2]).expect("there is one");
        assert_eq!(choice.orders, [3, 4]);
        assert!(choice.errors.iter().all(|&error| error <= 1e-6));
        let choice = WISH.choose(0.1, [true, false]).expect("there is one");
        assert_eq!(choice.orders, [3, 1]);
        let fitted = Wish {
            method: CircularMethod::Minimax,
            ..WISH
        };
        // Fitted, the cosine of order 2 is off by x^4/24/8 only.
        let choice = fitted.choose(0.1, [true; 2]).expect("there is one");
        assert_eq!(choice.orders, [3, 2]);
        let choices = [WISH, fitted].map(|wish| wish.choose(3.0, [true; 2]).expect("there is one"));
        assert!(choices[1].orders[0] < choices[0].orders[0]);
        assert!(choices[1].orders[1] < choices[0].orders[1]);
    }

    #[test]
    fn halving_lowers_the_order_and_no_order_is_beyond_reach() {
        let plain = WISH.choose(3.0, [true; 2]).expect("there is one");
        let halved = Wish {
            halvings: 3,
            ..WISH
        };
        let halved = halved.choose(3.0, [true; 2]).expect("there is one");
        assert!(halved.orders[0] < plain.orders[0]);
        assert!(halved.errors.iter().all(|&error| error <= 1e-6));
        let impossible = Wish {
            error: 1e-30,
            ..WISH
        };
        assert!(impossible.choose(3.0, [true; 2]).is_none());
    }
}
