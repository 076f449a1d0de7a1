//! The language of the e-graph: signed sums and products of any arity.
//!
//! Associativity and commutativity by rule cost exponentially many e-nodes (3^n
//! for a sum of n terms), so sums and products are represented as bags. A term
//! has its sign in the sum, and a product has none, so that the rules about
//! signs need no e-nodes either.

use egg::{Analysis, DidMerge, EGraph, Id, Language};
use robovec_ir::Operation;

/// One way to compute the value of an e-class.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum EquivalentForm {
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

impl Language for EquivalentForm {
    type Discriminant = (u8, u64);

    fn discriminant(&self) -> (u8, u64) {
        match self {
            EquivalentForm::Leaf(number) => (0, u64::from(*number)),
            EquivalentForm::Number(bits) => (1, *bits),
            EquivalentForm::Sum(signs, _) => (2, *signs),
            EquivalentForm::Product(_) => (3, 0),
            EquivalentForm::Other(operation, _) => (4, *operation as u64),
        }
    }

    fn matches(&self, other: &EquivalentForm) -> bool {
        self.discriminant() == other.discriminant()
            && self.children().len() == other.children().len()
    }

    fn children(&self) -> &[Id] {
        match self {
            EquivalentForm::Leaf(_) | EquivalentForm::Number(_) => &[],
            EquivalentForm::Sum(_, children)
            | EquivalentForm::Product(children)
            | EquivalentForm::Other(_, children) => children,
        }
    }

    fn children_mut(&mut self) -> &mut [Id] {
        match self {
            EquivalentForm::Leaf(_) | EquivalentForm::Number(_) => &mut [],
            EquivalentForm::Sum(_, children)
            | EquivalentForm::Product(children)
            | EquivalentForm::Other(_, children) => children,
        }
    }
}

/// A reference to an e-class, perhaps with the other sign.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct ClassReference {
    pub(crate) class: Id,
    pub(crate) negative: bool,
}

impl ClassReference {
    pub(crate) fn negated(self) -> ClassReference {
        self.signed(true)
    }

    /// The term, with its sign turned on request.
    pub(crate) fn signed(self, negative: bool) -> ClassReference {
        ClassReference {
            class: self.class,
            negative: self.negative ^ negative,
        }
    }
}

impl From<Id> for ClassReference {
    fn from(class: Id) -> ClassReference {
        ClassReference {
            class,
            negative: false,
        }
    }
}

/// The signed terms of a sum.
pub(crate) fn terms(signs: u64, children: &[Id]) -> impl Iterator<Item = ClassReference> + '_ {
    children
        .iter()
        .enumerate()
        .map(move |(index, &class)| ClassReference {
            class,
            negative: signs >> index & 1 == 1,
        })
}

/// The facts about an e-class that normalisation needs immediately.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(crate) struct ClassFacts {
    /// The bits of the class's number, if it is one.
    pub(crate) number: Option<u64>,
    /// A class this one is the negation of.
    pub(crate) minus: Option<Id>,
}

/// Keeps the [`ClassFacts`] of every e-class.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct ClassAnalysis;

impl Analysis<EquivalentForm> for ClassAnalysis {
    type Data = ClassFacts;

    fn make(_: &mut EGraph<EquivalentForm, Self>, form: &EquivalentForm, _: Id) -> ClassFacts {
        match form {
            EquivalentForm::Number(bits) => ClassFacts {
                number: Some(*bits),
                minus: None,
            },
            EquivalentForm::Sum(1, children) if children.len() == 1 => ClassFacts {
                number: None,
                minus: Some(children[0]),
            },
            _ => ClassFacts::default(),
        }
    }

    fn merge(&mut self, a: &mut ClassFacts, b: ClassFacts) -> DidMerge {
        let before = *a;
        a.number = a.number.or(b.number);
        a.minus = a.minus.or(b.minus);
        DidMerge(*a != before, *a != b)
    }
}
