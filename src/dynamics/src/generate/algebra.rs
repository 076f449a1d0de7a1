//! Sums of products: the form of an equation while it is written.
//!
//! A [`Scalar`] is nothing, one, or a named quantity, with a sign. Because the
//! sign belongs to the scalar, a quantity and its negative share one equation,
//! and a minus is paid for only where it survives into an output.

use smallvec::SmallVec;
use std::ops::Neg;

/// A quantity with a sign: zero, one, a number, an input element or the result
/// of an equation. The lowest bit is the sign, the others name the atom.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(super) struct Scalar(u32);

impl Scalar {
    pub(super) const ZERO: Scalar = Scalar(0);
    pub(super) const ONE: Scalar = Scalar(2);
    /// The first atom that is neither zero nor one.
    pub(super) const FIRST_ATOM: u32 = 2;

    pub(super) fn of_atom(atom: u32) -> Scalar {
        assert!(atom < 1 << 31, "an atom leaves room for the sign");
        Scalar(atom << 1)
    }

    pub(super) fn atom(self) -> u32 {
        self.0 >> 1
    }

    pub(super) fn is_zero(self) -> bool {
        self == Scalar::ZERO
    }

    pub(super) fn is_negative(self) -> bool {
        self.0 & 1 == 1
    }

    pub(super) fn magnitude(self) -> Scalar {
        Scalar(self.0 & !1)
    }

    pub(super) fn negated_if(self, negate: bool) -> Scalar {
        if negate { -self } else { self }
    }
}

impl Neg for Scalar {
    type Output = Scalar;

    fn neg(self) -> Scalar {
        if self.is_zero() {
            self
        } else {
            Scalar(self.0 ^ 1)
        }
    }
}

/// A factor of a product: an atom, or a sum in parentheses.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(super) enum ProductFactor {
    /// A quantity without its sign.
    Atom(u32),
    /// A group of the arena of equations.
    Group(u32),
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct SignedProduct {
    pub(super) negative: bool,
    pub(super) factors: SmallVec<[ProductFactor; 4]>,
}

impl SignedProduct {
    /// The product of scalars; `None` when it is zero.
    pub(super) fn product(scalars: &[Scalar]) -> Option<SignedProduct> {
        let mut term = SignedProduct {
            negative: false,
            factors: SmallVec::new(),
        };
        for &scalar in scalars {
            if scalar.is_zero() {
                return None;
            }
            term.negative ^= scalar.is_negative();
            if scalar.magnitude() != Scalar::ONE {
                term.factors.push(ProductFactor::Atom(scalar.atom()));
            }
        }
        Some(term)
    }

    /// The product of the term and scalars; `None` when it is zero.
    pub(super) fn times(&self, scalars: &[Scalar]) -> Option<SignedProduct> {
        let mut product = SignedProduct::product(scalars)?;
        product.negative ^= self.negative;
        product.factors.extend_from_slice(&self.factors);
        Some(product)
    }
}

/// A sum of products, in the order in which it will be written.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub(super) struct Sum {
    pub(super) terms: SmallVec<[SignedProduct; 8]>,
}

impl Sum {
    pub(super) fn new() -> Sum {
        Sum::default()
    }

    pub(super) fn of(scalar: Scalar) -> Sum {
        Sum::product(&[scalar])
    }

    pub(super) fn product(scalars: &[Scalar]) -> Sum {
        let mut sum = Sum::new();
        sum.add(scalars);
        sum
    }

    pub(super) fn total(scalars: &[Scalar]) -> Sum {
        let mut sum = Sum::new();
        for &scalar in scalars {
            sum.add(&[scalar]);
        }
        sum
    }

    pub(super) fn add(&mut self, scalars: &[Scalar]) -> &mut Sum {
        self.terms.extend(SignedProduct::product(scalars));
        self
    }

    pub(super) fn subtract(&mut self, scalars: &[Scalar]) -> &mut Sum {
        if let Some(mut term) = SignedProduct::product(scalars) {
            term.negative ^= true;
            self.terms.push(term);
        }
        self
    }

    pub(super) fn add_term(&mut self, term: Option<SignedProduct>) -> &mut Sum {
        self.terms.extend(term);
        self
    }

    pub(super) fn add_scaled(&mut self, scalars: &[Scalar], other: &Sum) -> &mut Sum {
        let scaled = other.terms.iter().filter_map(|term| term.times(scalars));
        self.terms.extend(scaled);
        self
    }

    pub(super) fn add_sum(&mut self, other: &Sum) -> &mut Sum {
        self.terms.extend(other.terms.iter().cloned());
        self
    }

    pub(super) fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }
}

/// The scalar of a joint in a list that is empty where all are zero.
pub(super) fn given(scalars: &[Scalar], joint: usize) -> Scalar {
    scalars.get(joint).copied().unwrap_or(Scalar::ZERO)
}

pub(super) fn dot(one: &[Scalar], other: &[Scalar]) -> Sum {
    assert_eq!(one.len(), other.len(), "vectors of one length");
    let mut sum = Sum::new();
    for (&a, &b) in one.iter().zip(other) {
        sum.add(&[a, b]);
    }
    sum
}
