//! The language of the e-graph: signed sums and products of any arity.
//!
//! Associativity and commutativity by rule cost exponentially many e-nodes
//! (3^n for a sum of n terms), so sums and products enter as what they are:
//! bags. A term carries its sign in the sum, and a product carries none, so
//! that the rules about signs need no e-nodes either.

use egg::{Analysis, DidMerge, EGraph, Id, Language};
use robovec_ir::Operation;

/// One way to compute the value of an e-class.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Form {
    /// A value of the surroundings, by its number.
    Leaf(u32),
    /// A number, by its bits.
    Number(u64),
    /// A sum; bit `i` of the signs is set when term `i` is subtracted. A sum
    /// of one subtracted term is a minus.
    Sum(u64, Box<[Id]>),
    /// A product of two or more factors.
    Product(Box<[Id]>),
    /// Any other operation.
    Other(Operation, Box<[Id]>),
}

impl Language for Form {
    type Discriminant = (u8, u64);

    fn discriminant(&self) -> (u8, u64) {
        match self {
            Form::Leaf(number) => (0, u64::from(*number)),
            Form::Number(bits) => (1, *bits),
            Form::Sum(signs, _) => (2, *signs),
            Form::Product(_) => (3, 0),
            Form::Other(operation, _) => (4, *operation as u64),
        }
    }

    fn matches(&self, other: &Form) -> bool {
        self.discriminant() == other.discriminant()
            && self.children().len() == other.children().len()
    }

    fn children(&self) -> &[Id] {
        match self {
            Form::Leaf(_) | Form::Number(_) => &[],
            Form::Sum(_, children) | Form::Product(children) | Form::Other(_, children) => children,
        }
    }

    fn children_mut(&mut self) -> &mut [Id] {
        match self {
            Form::Leaf(_) | Form::Number(_) => &mut [],
            Form::Sum(_, children) | Form::Product(children) | Form::Other(_, children) => children,
        }
    }
}

/// A reference to an e-class, perhaps with the other sign.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Term {
    pub(crate) class: Id,
    pub(crate) negative: bool,
}

impl Term {
    pub(crate) fn negated(self) -> Term {
        self.signed(true)
    }

    /// The term, with its sign turned if so asked.
    pub(crate) fn signed(self, negative: bool) -> Term {
        Term {
            class: self.class,
            negative: self.negative ^ negative,
        }
    }
}

impl From<Id> for Term {
    fn from(class: Id) -> Term {
        Term {
            class,
            negative: false,
        }
    }
}

/// The signed terms of a sum.
pub(crate) fn terms(signs: u64, children: &[Id]) -> impl Iterator<Item = Term> + '_ {
    children
        .iter()
        .enumerate()
        .map(move |(index, &class)| Term {
            class,
            negative: signs >> index & 1 == 1,
        })
}

/// What normalisation must know of an e-class at once.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(crate) struct Facts {
    /// The bits of the number the class is.
    pub(crate) number: Option<u64>,
    /// A class this one is the negation of.
    pub(crate) minus: Option<Id>,
}

/// Keeps the [`Facts`] of every e-class.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct Knowledge;

impl Analysis<Form> for Knowledge {
    type Data = Facts;

    fn make(_: &mut EGraph<Form, Self>, form: &Form, _: Id) -> Facts {
        match form {
            Form::Number(bits) => Facts {
                number: Some(*bits),
                minus: None,
            },
            Form::Sum(1, children) if children.len() == 1 => Facts {
                number: None,
                minus: Some(children[0]),
            },
            _ => Facts::default(),
        }
    }

    fn merge(&mut self, a: &mut Facts, b: Facts) -> DidMerge {
        let before = *a;
        a.number = a.number.or(b.number);
        a.minus = a.minus.or(b.minus);
        DidMerge(*a != before, *a != b)
    }
}
