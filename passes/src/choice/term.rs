//! Classes with signs, and products of two of them: the terms of forms.

use std::cmp::Ordering;

/// A class: one value up to its sign. Counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Class(pub(crate) u32);

impl Class {
    /// The class of the number 1.
    pub(crate) const ONE: Class = Class(0);

    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct SignedClass {
    pub(crate) class: Class,
    pub(crate) negative: bool,
}

impl SignedClass {
    /// The negation, when it is requested.
    pub(crate) fn flip(self, negative: bool) -> SignedClass {
        SignedClass {
            negative: self.negative ^ negative,
            ..self
        }
    }

    /// The product with another class, or its negation.
    pub(crate) fn times(self, other: Class, negative: bool) -> ProductTerm {
        ProductTerm::new(self.class, other, self.negative ^ negative)
    }
}

/// A signed product of two classes; the second is [`Class::ONE`] for a plain
/// term. Ordered by the classes, then by the sign.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct ProductTerm {
    pub(crate) a: Class,
    /// The second class, shifted left, and the sign.
    second: u32,
}

impl Ord for ProductTerm {
    #[inline]
    fn cmp(&self, other: &ProductTerm) -> Ordering {
        // One comparison: terms are sorted more often than anything else.
        let key = |term: &ProductTerm| u64::from(term.a.0) << 32 | u64::from(term.second);
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for ProductTerm {
    #[inline]
    fn partial_cmp(&self, other: &ProductTerm) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl ProductTerm {
    pub(crate) fn new(a: Class, b: Class, negative: bool) -> ProductTerm {
        let second = b.0 << 1 | u32::from(negative);
        ProductTerm { a, second }
    }

    #[inline]
    pub(crate) fn b(self) -> Class {
        Class(self.second >> 1)
    }

    #[inline]
    pub(crate) fn negative(self) -> bool {
        self.second & 1 == 1
    }

    #[inline]
    pub(crate) fn is_product(self) -> bool {
        self.b() != Class::ONE
    }

    pub(crate) fn opposite(self) -> ProductTerm {
        let second = self.second ^ 1;
        ProductTerm { second, ..self }
    }

    pub(crate) fn opposite_if(self, negative: bool) -> ProductTerm {
        let second = self.second ^ u32::from(negative);
        ProductTerm { second, ..self }
    }

    /// The same product, its classes in order and then 1.
    pub(crate) fn ordered(self) -> ProductTerm {
        let (a, b) = (self.a, self.b());
        if a == Class::ONE || b != Class::ONE && b < a {
            ProductTerm::new(b, a, self.negative())
        } else {
            self
        }
    }
}
