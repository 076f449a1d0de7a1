//! Forms and their terms, packed: there are several for every class, and
//! networks have millions of classes.

use super::term::{Class, ProductTerm};
use crate::sums::places::PlaceTable;
use robovec_ir::Input;
use rustc_hash::FxBuildHasher;
use std::hash::BuildHasher;
use std::ops::Range;

/// A form in which a class can be computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ChoiceForm<'a> {
    /// An input, or its negation.
    Input(Input, bool),
    /// A constant, by its bits.
    Constant(u64),
    /// An operation that is neither a sum nor a product: index into
    /// [`ChoiceNetwork::opaques`](super::network::ChoiceNetwork::opaques).
    Opaque(u32),
    /// Signed terms, at least two.
    Sum(&'a [ProductTerm]),
    /// A product of at least two classes: the first ones of the terms.
    Product(&'a [ProductTerm]),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum FormKind {
    Input,
    Constant,
    Opaque,
    Sum,
    Product,
}

impl FormKind {
    const ALL: [FormKind; 5] = [
        FormKind::Input,
        FormKind::Constant,
        FormKind::Opaque,
        FormKind::Sum,
        FormKind::Product,
    ];

    fn of(product: bool) -> FormKind {
        if product {
            FormKind::Product
        } else {
            FormKind::Sum
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct FormRecord {
    /// The class, the kind, and a flag: true when the sum or product is the
    /// negation of the class's value.
    packed: u32,
    /// Start of its terms, which end at those of the next form.
    start: u32,
}

impl FormRecord {
    fn new(class: Class, kind: FormKind, negated: bool, start: u32) -> FormRecord {
        let packed = class.0 << 4 | (kind as u32) << 1 | u32::from(negated);
        FormRecord { packed, start }
    }

    #[inline]
    fn class(self) -> Class {
        Class(self.packed >> 4)
    }

    #[inline]
    fn kind(self) -> FormKind {
        FormKind::ALL[(self.packed >> 1 & 7) as usize]
    }

    #[inline]
    fn negated(self) -> bool {
        self.packed & 1 == 1
    }
}

/// In this number of parts forms are sorted.
const SORTED_PARTS: usize = 8;

/// All forms, in the order they were made.
#[derive(Default)]
pub(crate) struct FormStore {
    records: Vec<FormRecord>,
    terms: Vec<ProductTerm>,
    constants: Vec<u64>,
    /// Sums and products by their terms. Equal terms have equal values, and
    /// are a form of one class.
    known: PlaceTable,
}

impl FormStore {
    /// Reserves memory for this number of forms and terms.
    pub(crate) fn reserve(&mut self, forms: usize, terms: usize) {
        self.records.reserve(forms);
        self.terms.reserve(terms);
        let hash_at = hash_at(&self.records, &self.terms);
        self.known.reserve(forms, hash_at);
    }

    /// Number of forms.
    pub(crate) fn len(&self) -> usize {
        self.records.len()
    }

    #[inline]
    fn range(&self, form: u32) -> Range<usize> {
        range(&self.records, self.terms.len(), form)
    }

    fn push(&mut self, class: Class, kind: FormKind, terms: &[ProductTerm], negated: bool) -> u32 {
        assert!(!terms.is_empty(), "a form has a term");
        let start = u32::try_from(self.terms.len()).expect("terms are counted in 32 bits");
        let record = FormRecord::new(class, kind, negated, start);
        self.records.push(record);
        self.terms.extend_from_slice(terms);
        self.records.len() as u32 - 1
    }

    pub(crate) fn push_input(&mut self, class: Class, input: Input, negative: bool) -> u32 {
        let place = ProductTerm::new(Class(input.0), Class::ONE, negative);
        self.push(class, FormKind::Input, &[place], false)
    }

    pub(crate) fn push_constant(&mut self, class: Class, bits: u64) -> u32 {
        let place = ProductTerm::new(Class(self.constants.len() as u32), Class::ONE, false);
        self.constants.push(bits);
        self.push(class, FormKind::Constant, &[place], false)
    }

    pub(crate) fn push_opaque(&mut self, class: Class, index: u32) -> u32 {
        let place = ProductTerm::new(Class(index), Class::ONE, false);
        self.push(class, FormKind::Opaque, &[place], false)
    }

    /// Adds a sum or product, in the order that its terms are looked for in,
    /// unless it is known.
    pub(crate) fn insert(
        &mut self,
        class: Class,
        terms: &[ProductTerm],
        product: bool,
        negated: bool,
    ) -> Option<u32> {
        match self.find(terms, product) {
            Some(_) => None,
            None => Some(self.insert_new(class, terms, product, negated)),
        }
    }

    /// Adds a sum that is not looked for again.
    pub(crate) fn push_sum(&mut self, class: Class, terms: &[ProductTerm], negated: bool) -> u32 {
        self.push(class, FormKind::Sum, terms, negated)
    }

    /// Adds a sum or product that is not known.
    pub(crate) fn insert_new(
        &mut self,
        class: Class,
        terms: &[ProductTerm],
        product: bool,
        negated: bool,
    ) -> u32 {
        let form = self.push(class, FormKind::of(product), terms, negated);
        let hash_at = hash_at(&self.records, &self.terms);
        self.known.insert(hash(terms, product), form, hash_at);
        form
    }

    /// The sum or product of these terms.
    pub(crate) fn find(&self, terms: &[ProductTerm], product: bool) -> Option<u32> {
        let equal = |form: u32| self.is(form, terms, product);
        self.known.find(hash(terms, product), equal)
    }

    /// True when a form is the sum or product of these terms.
    #[inline]
    pub(crate) fn is(&self, form: u32, terms: &[ProductTerm], product: bool) -> bool {
        self.records[form as usize].kind() == FormKind::of(product)
            && self.terms[self.range(form)] == *terms
    }

    /// Gives every class another number and puts the forms into their order;
    /// those of one class stay in the order they were made. No form is found
    /// any more.
    pub(crate) fn sort(&mut self, numbers: &[Class]) {
        self.known = PlaceTable::default();
        for form in 0..self.records.len() {
            let range = self.range(form as u32);
            let record = self.records[form];
            let class = numbers[record.class().index()];
            self.records[form] =
                FormRecord::new(class, record.kind(), record.negated(), record.start);
            if matches!(record.kind(), FormKind::Sum | FormKind::Product) {
                for term in &mut self.terms[range] {
                    let [a, b] = [term.a, term.b()].map(|class| numbers[class.index()]);
                    *term = ProductTerm::new(a, b, term.negative());
                }
            }
        }
        let mut sorted = FormStore {
            records: Vec::with_capacity(self.records.len()),
            terms: Vec::with_capacity(self.terms.len()),
            constants: std::mem::take(&mut self.constants),
            known: PlaceTable::default(),
        };
        // What was moved is freed part by part: there is never a second copy.
        let mut begin = 0;
        for part in 1..=SORTED_PARTS {
            let end = numbers.len() * part / SORTED_PARTS;
            for form in self.sorted(begin..end) {
                let record = self.records[form as usize];
                let terms = &self.terms[self.range(form)];
                sorted.push(record.class(), record.kind(), terms, record.negated());
            }
            self.drop_below(Class(end as u32));
            begin = end;
        }
        *self = sorted;
    }

    /// The forms of some classes, in their order.
    fn sorted(&self, classes: Range<usize>) -> Vec<u32> {
        let mut places = vec![0u32; classes.len() + 1];
        let members = self.records.iter().zip(0..);
        let members = members.filter(|(record, _)| classes.contains(&record.class().index()));
        let members = members.map(|(record, form)| (record.class().index() - classes.start, form));
        for (class, _) in members.clone() {
            places[class + 1] += 1;
        }
        for class in 0..classes.len() {
            places[class + 1] += places[class];
        }
        let mut sorted = vec![0; places[classes.len()] as usize];
        for (class, form) in members {
            sorted[places[class] as usize] = form;
            places[class] += 1;
        }
        sorted
    }

    fn drop_below(&mut self, end: Class) {
        let (mut forms, mut terms) = (0, 0);
        for form in 0..self.records.len() {
            let range = self.range(form as u32);
            let record = self.records[form];
            if record.class() < end {
                continue;
            }
            let start = terms as u32;
            terms += range.len();
            self.terms.copy_within(range, start as usize);
            self.records[forms] = FormRecord { start, ..record };
            forms += 1;
        }
        self.records.truncate(forms);
        self.terms.truncate(terms);
        self.records.shrink_to_fit();
        self.terms.shrink_to_fit();
    }

    pub(crate) fn class(&self, form: u32) -> Class {
        self.records[form as usize].class()
    }

    /// Tests whether a sum or product is the negation of its class's value.
    pub(crate) fn is_negated(&self, form: u32) -> bool {
        self.records[form as usize].negated()
    }

    #[inline(always)]
    pub(crate) fn form(&self, form: u32) -> ChoiceForm<'_> {
        let terms = &self.terms[self.range(form)];
        match self.records[form as usize].kind() {
            FormKind::Input => ChoiceForm::Input(Input(terms[0].a.0), terms[0].negative()),
            FormKind::Constant => ChoiceForm::Constant(self.constants[terms[0].a.index()]),
            FormKind::Opaque => ChoiceForm::Opaque(terms[0].a.0),
            FormKind::Sum => ChoiceForm::Sum(terms),
            FormKind::Product => ChoiceForm::Product(terms),
        }
    }
}

/// Place of the terms of a form among all terms, of which this is the number.
#[inline]
fn range(records: &[FormRecord], count: usize, form: u32) -> Range<usize> {
    let start = records[form as usize].start as usize;
    let next = records.get(form as usize + 1);
    start..next.map_or(count, |next| next.start as usize)
}

/// The hash of a form's sum or product.
fn hash_at(records: &[FormRecord], all: &[ProductTerm]) -> impl Fn(u32) -> u64 {
    |form| {
        let terms = &all[range(records, all.len(), form)];
        hash(terms, records[form as usize].kind() == FormKind::Product)
    }
}

/// The hash by which a sum or product is found.
pub(crate) fn hash(terms: &[ProductTerm], product: bool) -> u64 {
    FxBuildHasher.hash_one((terms, product))
}
