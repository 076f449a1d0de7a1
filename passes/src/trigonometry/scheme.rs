//! The order in which a polynomial is evaluated.
//!
//! A polynomial of `n` terms is a low part and a high part times a power of
//! `t = x^2`; Horner's scheme always cuts after the first term, Estrin's in
//! the middle. Which cut is best depends on the cycles of adders and
//! multipliers. There are few terms, so all ways to cut are compared, parts
//! once each (dynamic programming): the earliest result wins, of equally
//! early ones that with the fewest operations. A sine's factor `x` multiplies
//! the whole, or the parts (which are then *led*), where it delays nothing.

use super::builder::RecipeBuilder;
use super::options::Scheme;
use robovec_ir::{Operand, Operation};
use robovec_num::trigonometry::{Circular, Polynomial};

/// Cycles of the operations a polynomial is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct OperationCycles {
    pub(super) add: u32,
    pub(super) multiply: u32,
}

/// The form in which a part is computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum PartForm {
    /// It is one term.
    Term,
    /// The part without the factor `x`, times `x`.
    Times,
    /// A low part of this many terms plus a high part times a power of `t`;
    /// `inside` when the factor `x` multiplies the high part, not the power.
    Cut { terms: usize, inside: bool },
}

/// The best way to compute a part.
#[derive(Clone, Copy, Debug)]
struct Best {
    /// Cycle of the result, counted from that of the angle.
    arrival: u32,
    /// Operations, without those of powers.
    operations: u32,
    /// Set of the powers needed: bit `k` for `t^k`, bit `LED + k` for `x t^k`.
    powers: u64,
    form: PartForm,
}

impl Best {
    fn key(&self) -> (u32, u32) {
        (self.arrival, self.operations + self.powers.count_ones())
    }
}

/// Position of the bits for `x t^k` in a set of powers, above those for `t^k`.
const LED: u32 = 32;

pub(super) struct PolynomialPlan<'a> {
    polynomial: &'a Polynomial,
    cycles: OperationCycles,
    /// Arrival of `t^k`, and the set of powers it needs.
    powers: Vec<(u32, u64)>,
    /// The best form of the terms from `first`, `count` of them, without and
    /// with the factor `x`.
    parts: Vec<Option<[Best; 2]>>,
}

impl<'a> PolynomialPlan<'a> {
    pub(super) fn new(
        polynomial: &'a Polynomial,
        cycles: OperationCycles,
        scheme: Scheme,
    ) -> PolynomialPlan<'a> {
        let terms = polynomial.coefficients.len();
        assert!(terms > 0, "a polynomial has a coefficient");
        let mut plan = PolynomialPlan {
            polynomial,
            cycles,
            powers: powers(terms, cycles),
            parts: vec![None; terms * (terms + 1)],
        };
        for count in 1..=terms {
            for first in 0..=terms - count {
                let bare = plan.choose(first, count, false, None, scheme);
                let led = plan.choose(first, count, true, Some(bare), scheme);
                let place = plan.place(first, count);
                plan.parts[place] = Some([bare, led]);
            }
        }
        plan
    }

    fn place(&self, first: usize, count: usize) -> usize {
        first * (self.polynomial.coefficients.len() + 1) + count
    }

    /// The best form of a part whose smaller parts are known.
    fn part(&self, first: usize, count: usize, led: bool) -> Best {
        self.parts[self.place(first, count)].expect("smaller parts are chosen first")
            [usize::from(led)]
    }

    fn choose(
        &self,
        first: usize,
        count: usize,
        led: bool,
        bare: Option<Best>,
        scheme: Scheme,
    ) -> Best {
        let multiply = self.cycles.multiply;
        if count == 1 {
            let unit = self.polynomial.coefficients[first] == 1.0;
            let product = u32::from(led && !unit);
            return Best {
                arrival: product * multiply,
                operations: product,
                powers: 0,
                form: PartForm::Term,
            };
        }
        let mut found: Vec<Best> = Vec::new();
        if let Some(bare) = bare {
            found.push(Best {
                arrival: bare.arrival + multiply,
                operations: bare.operations + 1,
                form: PartForm::Times,
                ..bare
            });
        }
        let cuts = match scheme {
            Scheme::Horner if led => 1..1,
            Scheme::Horner => 1..2,
            Scheme::Shortest => 1..count,
        };
        for terms in cuts {
            for inside in [false, true] {
                if inside && !led {
                    continue;
                }
                let low = self.part(first, terms, led);
                let high = self.part(first + terms, count - terms, inside);
                let (mut arrival, mut bits) = self.powers[terms];
                if led && !inside {
                    arrival += multiply;
                    bits |= 1 << (LED + terms as u32);
                }
                let product = high.arrival.max(arrival) + multiply;
                found.push(Best {
                    arrival: low.arrival.max(product) + self.cycles.add,
                    operations: low.operations + high.operations + 2,
                    powers: low.powers | high.powers | bits,
                    form: PartForm::Cut { terms, inside },
                });
            }
        }
        let best = found.into_iter().min_by_key(Best::key);
        best.expect("a part of several terms can be cut")
    }

    /// Builds the whole polynomial in a recipe.
    pub(super) fn build(&self, builder: &mut RecipeBuilder) -> Operand {
        let led = self.polynomial.of == Circular::Sine;
        self.write(builder, 0, self.polynomial.coefficients.len(), led)
    }

    /// Recursion no deeper than the number of terms.
    fn write(&self, builder: &mut RecipeBuilder, first: usize, count: usize, led: bool) -> Operand {
        let angle = builder.angle();
        match self.part(first, count, led).form {
            PartForm::Term => {
                let coefficient = self.polynomial.coefficients[first];
                let constant = builder.constant(coefficient);
                if !led {
                    constant
                } else if coefficient == 1.0 {
                    angle
                } else {
                    builder.push(Operation::Mul, constant, angle)
                }
            }
            PartForm::Times => {
                let rest = self.write(builder, first, count, false);
                builder.push(Operation::Mul, rest, angle)
            }
            PartForm::Cut { terms, inside } => {
                let low = self.write(builder, first, terms, led);
                let high = self.write(builder, first + terms, count - terms, inside);
                let mut power = self.power(builder, terms);
                if led && !inside {
                    power = builder.push(Operation::Mul, power, angle);
                }
                let product = builder.push(Operation::Mul, high, power);
                builder.push(Operation::Add, low, product)
            }
        }
    }

    fn power(&self, builder: &mut RecipeBuilder, power: usize) -> Operand {
        if power == 1 {
            let angle = builder.angle();
            return builder.push(Operation::Mul, angle, angle);
        }
        let half = power / 2;
        let (low, high) = (self.power(builder, half), self.power(builder, power - half));
        builder.push(Operation::Mul, low, high)
    }
}

/// For every power of `t` its arrival and the set of powers it needs, when it
/// is the product of two halves of about equal size.
fn powers(most: usize, cycles: OperationCycles) -> Vec<(u32, u64)> {
    let mut powers: Vec<(u32, u64)> = vec![(0, 0)];
    for power in 1..most.max(2) {
        let half = power / 2;
        let needs = powers[half].1 | powers[power - half.max(1)].1;
        let ready = match power {
            1 => 0,
            _ => powers[half].0.max(powers[power - half].0),
        };
        powers.push((ready + cycles.multiply, needs | 1 << power));
    }
    powers
}
