//! Classes of equal values and their forms.

use crate::sums::terms::cancel;
use crate::sums::values::ValueTable;
use hashbrown::HashSet;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_ir::{Input, Operand, Operation, SourceSet, Symbol};
use robovec_num::arithmetic::Arithmetic;
use rustc_hash::FxBuildHasher;
use std::hash::BuildHasher;

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

/// A class with a sign.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct SignedClass {
    pub(crate) class: Class,
    pub(crate) negative: bool,
}

/// A signed product of two classes; the second is [`Class::ONE`] for a plain
/// term.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct ProductTerm {
    pub(crate) a: Class,
    pub(crate) b: Class,
    pub(crate) negative: bool,
}

impl ProductTerm {
    fn opposite(self) -> ProductTerm {
        ProductTerm {
            negative: !self.negative,
            ..self
        }
    }

    pub(crate) fn is_product(self) -> bool {
        self.b != Class::ONE
    }
}

/// A form in which a class can be computed. Sums and products give the class's
/// value or its negation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ChoiceForm {
    /// An input, or its negation.
    Input(Input, bool),
    /// A constant, by its bits.
    Constant(u64),
    /// An operation that is neither a sum nor a product: index into
    /// [`ChoiceNetwork::opaques`].
    Opaque(u32),
    /// Signed terms, at least two: a range of the arena of terms.
    Sum(u32, u32),
    /// A product of at least two classes: a range of the arena of terms,
    /// whose second classes do not count.
    Product(u32, u32),
}

/// An operation that is taken as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opaque {
    pub(crate) operation: Operation,
    pub(crate) operands: [Option<SignedClass>; Operand::MAX_COUNT],
    /// True when the class is the negation of the result.
    pub(crate) negative: bool,
}

/// What is known of a class besides its value.
#[derive(Clone, Copy, Debug)]
struct Record {
    rank: u64,
    /// The most recent form; forms are chained.
    last: u32,
    owner: Symbol,
    sources: SourceSet,
}

const NONE: u32 = u32::MAX;

/// Room between the ranks of two classes of the function read.
pub(crate) const RANK_STEP: u64 = 1 << 32;

/// Classes and forms.
pub(crate) struct ChoiceNetwork {
    /// By class.
    pub(crate) values: ValueTable,
    classes: Vec<Record>,
    forms: Vec<(ChoiceForm, u32)>,
    /// Classes and hashes of their forms.
    known: HashSet<(Class, u64), FxBuildHasher>,
    terms: Vec<ProductTerm>,
    pub(crate) opaques: Vec<Opaque>,
    /// The symbol that new classes are named after, and their sources.
    pub(crate) origin: (Symbol, SourceSet),
}

impl ChoiceNetwork {
    /// A network with the class of 1 alone.
    pub(crate) fn new(images: Images) -> ChoiceNetwork {
        let mut network = ChoiceNetwork {
            values: ValueTable::new(images),
            classes: Vec::new(),
            forms: Vec::new(),
            known: HashSet::default(),
            terms: Vec::new(),
            opaques: Vec::new(),
            origin: (Symbol(0), SourceSet::EMPTY),
        };
        let class = network.class(images.one(), 0).class;
        assert_eq!(class, Class::ONE, "the class of 1 comes first");
        network.push_form(class, ChoiceForm::Constant(1.0f64.to_bits()));
        network
    }

    /// Number of classes.
    pub(crate) fn len(&self) -> usize {
        self.classes.len()
    }

    /// Number of forms.
    pub(crate) fn form_count(&self) -> usize {
        self.forms.len()
    }

    /// The class of a value, made when it does not exist, and whether the
    /// value is its negation.
    pub(crate) fn class(&mut self, value: Fingerprint, rank: u64) -> SignedClass {
        let (place, negative) = self.values.place(value);
        if place as usize == self.classes.len() {
            self.classes.push(Record {
                rank,
                last: NONE,
                owner: self.origin.0,
                sources: self.origin.1,
            });
        }
        let class = Class(place);
        SignedClass { class, negative }
    }

    /// The class of a value, if it exists.
    pub(crate) fn find(&self, value: Fingerprint) -> Option<SignedClass> {
        let (place, negative) = self.values.find(value)?;
        let class = Class(place);
        Some(SignedClass { class, negative })
    }

    /// True when the class has a form.
    pub(crate) fn is_defined(&self, class: Class) -> bool {
        self.classes[class.index()].last != NONE
    }

    /// The value of a class.
    pub(crate) fn value(&self, class: Class) -> Fingerprint {
        self.values.value(class.index())
    }

    /// The value of a term.
    pub(crate) fn term_value(&self, term: ProductTerm) -> Fingerprint {
        let product = self
            .values
            .images
            .mul(self.value(term.a), self.value(term.b));
        self.values.images.negate_if(term.negative, product)
    }

    /// The value of a sum of terms.
    pub(crate) fn sum_value(&self, terms: &[ProductTerm]) -> Fingerprint {
        self.values
            .images
            .sum(terms.iter().map(|&term| self.term_value(term)))
    }

    /// The rank of a class.
    pub(crate) fn rank(&self, class: Class) -> u64 {
        self.classes[class.index()].rank
    }

    /// The symbol a class is named after, and the equations it comes from.
    pub(crate) fn origin_of(&self, class: Class) -> (Symbol, SourceSet) {
        let record = &self.classes[class.index()];
        (record.owner, record.sources)
    }

    /// Says which equations a class comes from.
    pub(crate) fn set_sources(&mut self, class: Class, sources: SourceSet) {
        self.classes[class.index()].sources = sources;
    }

    /// The forms of a class, the most recent first.
    pub(crate) fn forms(&self, class: Class) -> impl Iterator<Item = u32> + '_ {
        let mut next = self.classes[class.index()].last;
        std::iter::from_fn(move || {
            let form = next;
            (form != NONE).then(|| {
                next = self.forms[form as usize].1;
                form
            })
        })
    }

    /// A form.
    pub(crate) fn form(&self, form: u32) -> ChoiceForm {
        self.forms[form as usize].0
    }

    /// The terms of a form (factors of a product as first classes); empty for
    /// the others.
    pub(crate) fn terms(&self, form: ChoiceForm) -> &[ProductTerm] {
        match form {
            ChoiceForm::Sum(start, end) | ChoiceForm::Product(start, end) => {
                &self.terms[start as usize..end as usize]
            }
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) | ChoiceForm::Opaque(_) => &[],
        }
    }

    /// Calls a function with every class a form uses.
    pub(crate) fn operands(&self, form: ChoiceForm, mut visit: impl FnMut(Class)) {
        match form {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => {}
            ChoiceForm::Opaque(index) => {
                let operands = self.opaques[index as usize].operands;
                operands
                    .iter()
                    .flatten()
                    .for_each(|operand| visit(operand.class));
            }
            ChoiceForm::Product(..) => self.terms(form).iter().for_each(|term| visit(term.a)),
            ChoiceForm::Sum(..) => {
                for term in self.terms(form) {
                    visit(term.a);
                    if term.is_product() {
                        visit(term.b);
                    }
                }
            }
        }
    }

    fn push_form(&mut self, class: Class, form: ChoiceForm) {
        debug_assert!(
            self.is_above_operands(class, form),
            "a form uses only classes of smaller rank"
        );
        let last = self.classes[class.index()].last;
        self.classes[class.index()].last = self.forms.len() as u32;
        self.forms.push((form, last));
    }

    /// True when a class has a greater rank than all that a form uses.
    fn is_above_operands(&self, class: Class, form: ChoiceForm) -> bool {
        let mut is_above = true;
        let rank = self.rank(class);
        self.operands(form, |operand| is_above &= self.rank(operand) < rank);
        is_above
    }

    /// The class of an input.
    pub(crate) fn input(&mut self, input: Input, value: Fingerprint) -> SignedClass {
        let signed = self.class(value, 0);
        if !self.is_defined(signed.class) {
            self.push_form(signed.class, ChoiceForm::Input(input, signed.negative));
        }
        signed
    }

    /// The class of a literal.
    pub(crate) fn constant(&mut self, number: f64) -> SignedClass {
        let signed = self.class(self.values.images.literal(number), 0);
        if !self.is_defined(signed.class) {
            let number = if signed.negative { -number } else { number };
            self.push_form(signed.class, ChoiceForm::Constant(number.to_bits()));
        }
        signed
    }

    /// Gives a class an operation as its form, unless it has one.
    pub(crate) fn add_opaque(&mut self, class: Class, opaque: Opaque) {
        if !self.is_defined(class) {
            let index = self.opaques.len() as u32;
            self.opaques.push(opaque);
            self.push_form(class, ChoiceForm::Opaque(index));
        }
    }

    /// Adds a sum as a form of a class whose value it has up to the sign.
    /// Refused when it is known already or would use a class of no smaller
    /// rank.
    pub(crate) fn add_sum(&mut self, class: Class, terms: &mut [ProductTerm]) -> bool {
        // The sign is free: it is settled when the form is written.
        normalise(terms);
        if let [only] = *terms {
            return only.is_product() && self.add_product(class, &mut [only.a, only.b]);
        }
        self.add_form(class, terms, false)
    }

    /// Adds a product as a form of a class, as [`ChoiceNetwork::add_sum`].
    pub(crate) fn add_product(&mut self, class: Class, factors: &mut [Class]) -> bool {
        factors.sort_unstable();
        let terms: Vec<ProductTerm> = factors
            .iter()
            .map(|&a| ProductTerm {
                a,
                b: Class::ONE,
                negative: false,
            })
            .collect();
        self.add_form(class, &terms, true)
    }

    fn add_form(&mut self, class: Class, terms: &[ProductTerm], product: bool) -> bool {
        let rank = self.rank(class);
        let low = |class: Class| self.classes[class.index()].rank < rank;
        if terms.len() < 2 || !terms.iter().all(|term| low(term.a) && low(term.b)) {
            return false;
        }
        let hash = FxBuildHasher.hash_one((terms, product));
        if !self.known.insert((class, hash)) {
            return false;
        }
        let start = self.terms.len() as u32;
        self.terms.extend_from_slice(terms);
        let end = self.terms.len() as u32;
        let form = match product {
            true => ChoiceForm::Product(start, end),
            false => ChoiceForm::Sum(start, end),
        };
        self.push_form(class, form);
        true
    }

    /// The class of a sum of terms, with this sum as one of its forms; `None`
    /// when the value is zero. A sum that is a class already known is that
    /// class.
    pub(crate) fn sum(&mut self, mut terms: Vec<ProductTerm>) -> Option<SignedClass> {
        self.tidy(&mut terms);
        match terms[..] {
            [] => return None,
            [term] if !term.is_product() => {
                return Some(SignedClass {
                    class: term.a,
                    negative: term.negative,
                });
            }
            _ => {}
        }
        let value = self.sum_value(&terms);
        if value.is_zero() {
            return None;
        }
        let rank = terms
            .iter()
            .map(|term| self.rank(term.a).max(self.rank(term.b)))
            .max()
            .unwrap_or(0);
        let signed = self.class(value, rank + 1);
        self.add_sum(signed.class, &mut terms);
        Some(signed)
    }

    /// The class of a product of classes, with this product as one of its
    /// forms; of no factors, 1.
    pub(crate) fn product(&mut self, factors: &mut Vec<Class>) -> SignedClass {
        factors.retain(|&factor| factor != Class::ONE);
        if let [] | [_] = factors[..] {
            return SignedClass {
                class: factors.first().copied().unwrap_or(Class::ONE),
                negative: false,
            };
        }
        let values = factors.iter().map(|&factor| self.value(factor));
        let value = self.values.images.product(values);
        let rank = factors.iter().map(|&factor| self.rank(factor)).max();
        let signed = self.class(value, rank.unwrap_or(0) + 1);
        self.add_product(signed.class, factors);
        signed
    }

    /// Drops terms that cancel, puts products that are classes
    /// already in as such, and 1 behind.
    pub(crate) fn tidy(&self, terms: &mut Vec<ProductTerm>) {
        for term in terms.iter_mut() {
            if term.a == Class::ONE {
                std::mem::swap(&mut term.a, &mut term.b);
            }
            if term.is_product() && term.b < term.a {
                std::mem::swap(&mut term.a, &mut term.b);
            }
        }
        cancel(terms, ProductTerm::opposite);
    }
}

/// Orders the terms of a sum and makes the first positive.
fn normalise(terms: &mut [ProductTerm]) {
    terms.sort_unstable();
    if terms.first().is_some_and(|term| term.negative) {
        for term in terms.iter_mut() {
            *term = term.opposite();
        }
        terms.sort_unstable();
    }
}
