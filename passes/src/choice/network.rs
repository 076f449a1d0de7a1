//! Classes of equal values and their forms.

use super::forms::{ChoiceForm, FormStore, hash};
use super::recent::RecentSums;
use super::term::{Class, ProductTerm, SignedClass};
use crate::sums::terms::cancel;
use crate::sums::values::ValueTable;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_ir::{Input, Operand, Operation, SourceSet, Symbol};
use robovec_num::arithmetic::Arithmetic;
use smallvec::SmallVec;

/// An operation that is not rewritten.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opaque {
    pub(crate) operation: Operation,
    pub(crate) operands: [Option<SignedClass>; Operand::MAX_COUNT],
    /// True when the class is the negation of the result.
    pub(crate) negative: bool,
}

/// Sums that are forms of one class, with their hashes.
#[derive(Default)]
pub(crate) struct OwnForms(Vec<(u64, u32)>);

/// Attributes of a class besides its value.
#[derive(Clone, Copy, Debug)]
struct Record {
    /// The form it was made with.
    first: u32,
    /// Origin: index into the network's origins.
    origin: u32,
}

const NONE: u32 = u32::MAX;

/// Forms of a network in which forms are composed, for each operation of the
/// function: 9 and 11 were counted for chains of 130 and 23 joints.
pub(crate) const FORMS_PER_OPERATION: usize = 8;

/// Room between the ranks of two classes of the function read.
pub(crate) const RANK_STEP: u64 = 1 << 32;

/// Classes and forms.
pub(crate) struct ChoiceNetwork {
    /// By class.
    pub(crate) values: ValueTable,
    ranks: Vec<u64>,
    classes: Vec<Record>,
    /// Symbols that classes are named after, and equations they come from.
    origins: Vec<(Symbol, SourceSet)>,
    forms: FormStore,
    recent: RecentSums,
    pub(crate) opaques: Vec<Opaque>,
    /// The symbol that new classes are named after, and their sources.
    pub(crate) origin: (Symbol, SourceSet),
}

impl ChoiceNetwork {
    /// A network with the class of 1 alone.
    pub(crate) fn new(images: Images) -> ChoiceNetwork {
        let mut network = ChoiceNetwork {
            values: ValueTable::new(images),
            ranks: Vec::new(),
            classes: Vec::new(),
            origins: Vec::new(),
            forms: FormStore::default(),
            recent: RecentSums::default(),
            opaques: Vec::new(),
            origin: (Symbol(0), SourceSet::EMPTY),
        };
        let class = network.class(images.one(), 0).class;
        assert_eq!(class, Class::ONE, "the class of 1 comes first");
        let form = network.forms.push_constant(class, 1.0f64.to_bits());
        network.note_form(class, form);
        network
    }

    /// Reserves memory for a network of about the size that composition makes
    /// from this number of operations. Vectors that grow to that leave memory
    /// in pieces, which no larger one can use, and tables that grow take a
    /// tenth of the time at 500,000 operations.
    pub(crate) fn reserve(&mut self, operations: usize) {
        let (classes, forms) = (2 * operations, FORMS_PER_OPERATION * operations);
        self.values.reserve(classes);
        self.ranks.reserve(classes);
        self.classes.reserve(classes);
        self.forms.reserve(forms, forms);
    }

    /// Number of classes.
    pub(crate) fn len(&self) -> usize {
        self.classes.len()
    }

    /// Number of forms.
    pub(crate) fn form_count(&self) -> usize {
        self.forms.len()
    }

    /// Numbers the classes again, in order of rank: the new number of each. No
    /// form can be added any more; the tables for finding classes and forms are
    /// freed.
    pub(crate) fn sort(&mut self) -> Vec<Class> {
        self.values = ValueTable::new(self.values.images);
        self.recent = RecentSums::default();
        let ranks = std::mem::take(&mut self.ranks);
        let mut order: Vec<u32> = (0..ranks.len() as u32).collect();
        order.sort_unstable_by_key(|&class| (ranks[class as usize], class));
        drop(ranks);
        let classes = order.iter().map(|&class| self.classes[class as usize]);
        self.classes = classes.collect();
        let mut places = vec![Class::ONE; order.len()];
        for (place, &class) in order.iter().enumerate() {
            places[class as usize] = Class(place as u32);
        }
        assert_eq!(places[0], Class::ONE, "the class of 1 stays first");
        let operands = self
            .opaques
            .iter_mut()
            .flat_map(|opaque| &mut opaque.operands);
        for operand in operands.flatten() {
            operand.class = places[operand.class.index()];
        }
        self.forms.sort(&places);
        places
    }

    /// The class of a value, made when it does not exist, and a flag: true when
    /// the value is its negation.
    pub(crate) fn class(&mut self, value: Fingerprint, rank: u64) -> SignedClass {
        let (place, negative) = self.values.place(value);
        if place as usize == self.classes.len() {
            // Forms hold more beside a class.
            assert!(place < NONE >> 4, "classes are counted in 28 bits");
            self.ranks.push(rank);
            if self.origins.last() != Some(&self.origin) {
                self.origins.push(self.origin);
            }
            self.classes.push(Record {
                first: NONE,
                origin: self.origins.len() as u32 - 1,
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
        self.classes[class.index()].first != NONE
    }

    pub(crate) fn value(&self, class: Class) -> Fingerprint {
        self.values.value(class.index())
    }

    pub(crate) fn sum_value(&self, terms: &[ProductTerm]) -> Fingerprint {
        let images = &self.values.images;
        images.sum(terms.iter().map(|term| {
            let a = self.value(term.a);
            let product = if term.is_product() {
                images.mul(a, self.value(term.b()))
            } else {
                a
            };
            images.negate_if(term.negative(), product)
        }))
    }

    pub(crate) fn product_value(&self, factors: &[Class]) -> Fingerprint {
        let factors = factors.iter().map(|&factor| self.value(factor));
        self.values.images.product(factors)
    }

    pub(crate) fn rank(&self, class: Class) -> u64 {
        self.ranks[class.index()]
    }

    /// The symbol after which a class is named, and its equations.
    pub(crate) fn origin_of(&self, class: Class) -> (Symbol, SourceSet) {
        self.origins[self.classes[class.index()].origin as usize]
    }

    /// Records the equations of a class.
    pub(crate) fn set_sources(&mut self, class: Class, sources: SourceSet) {
        let owner = self.origin_of(class).0;
        self.classes[class.index()].origin = self.origins.len() as u32;
        self.origins.push((owner, sources));
    }

    /// The form a class was made with.
    pub(crate) fn first_form(&self, class: Class) -> Option<u32> {
        let first = self.classes[class.index()].first;
        (first != NONE).then_some(first)
    }

    #[inline(always)]
    pub(crate) fn form(&self, form: u32) -> ChoiceForm<'_> {
        self.forms.form(form)
    }

    /// The class of a form.
    pub(crate) fn class_of(&self, form: u32) -> Class {
        self.forms.class(form)
    }

    /// Tests whether a sum or product is the negation of its class's value.
    pub(crate) fn is_negated(&self, form: u32) -> bool {
        self.forms.is_negated(form)
    }

    /// Calls a function with every class a form uses.
    #[inline]
    pub(crate) fn operands(&self, form: u32, mut visit: impl FnMut(Class)) {
        match self.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => {}
            ChoiceForm::Opaque(index) => {
                let operands = self.opaques[index as usize].operands;
                operands
                    .iter()
                    .flatten()
                    .for_each(|operand| visit(operand.class));
            }
            ChoiceForm::Product(factors) => factors.iter().for_each(|factor| visit(factor.a)),
            ChoiceForm::Sum(terms) => {
                for term in terms {
                    visit(term.a);
                    if term.is_product() {
                        visit(term.b());
                    }
                }
            }
        }
    }

    /// Notes a form that a class got.
    fn note_form(&mut self, class: Class, form: u32) {
        debug_assert!(
            self.is_above_operands(class, form),
            "a form uses only classes of smaller rank"
        );
        let first = &mut self.classes[class.index()].first;
        if *first == NONE {
            *first = form;
        }
    }

    /// True when a class has a greater rank than all operands of a form.
    fn is_above_operands(&self, class: Class, form: u32) -> bool {
        let mut is_above = true;
        let rank = self.rank(class);
        self.operands(form, |operand| is_above &= self.rank(operand) < rank);
        is_above
    }

    pub(crate) fn input(&mut self, input: Input, value: Fingerprint) -> SignedClass {
        let signed = self.class(value, 0);
        if !self.is_defined(signed.class) {
            let form = self.forms.push_input(signed.class, input, signed.negative);
            self.note_form(signed.class, form);
        }
        signed
    }

    /// The class of a literal.
    pub(crate) fn constant(&mut self, number: f64) -> SignedClass {
        let signed = self.class(self.values.images.literal(number), 0);
        if !self.is_defined(signed.class) {
            let number = if signed.negative { -number } else { number };
            let form = self.forms.push_constant(signed.class, number.to_bits());
            self.note_form(signed.class, form);
        }
        signed
    }

    /// Gives a class an operation as its form, unless it has one.
    pub(crate) fn add_opaque(&mut self, class: Class, opaque: Opaque) {
        if !self.is_defined(class) {
            let form = self.forms.push_opaque(class, self.opaques.len() as u32);
            self.opaques.push(opaque);
            self.note_form(class, form);
        }
    }

    /// Adds a sum of [tidy](ChoiceNetwork::tidy) terms as a form of the class
    /// with its value, or, `negated`, with the negated value. Refused when it
    /// is known already or would use a class of no smaller rank.
    pub(crate) fn add_sum(&mut self, class: Class, terms: &mut [ProductTerm], negated: bool) {
        if let [only] = *terms {
            if only.is_product() {
                let factors = &mut [only.a, only.b()];
                self.add_product(class, factors, negated ^ only.negative());
            }
            return;
        }
        let flipped = normalise(terms);
        self.add_form(class, terms, false, negated ^ flipped);
    }

    /// As [`ChoiceNetwork::add_sum`] of a sum that was composed for the class,
    /// but refused only when it is one of `own`, forms of the class with their
    /// hashes, to which it is added. No search needs to find it, and the table
    /// of all forms would be several times as large with such forms.
    pub(crate) fn add_composed(
        &mut self,
        class: Class,
        terms: &mut [ProductTerm],
        own: &mut OwnForms,
    ) {
        if terms.len() < 2 {
            return self.add_sum(class, terms, false);
        }
        let flipped = normalise(terms);
        let hash = hash(terms, false);
        let is_it =
            |&(known, form): &(u64, u32)| known == hash && self.forms.is(form, terms, false);
        if !own.0.iter().any(is_it) && self.is_allowed(class, terms) {
            let form = self.forms.push_sum(class, terms, flipped);
            self.note_form(class, form);
            own.0.push((hash, form));
        }
    }

    /// Finds the forms of a class that composed ones are compared with: the one
    /// it was made with, when that is a sum.
    pub(crate) fn own_forms(&self, class: Class, own: &mut OwnForms) {
        own.0.clear();
        if let Some(first) = self.first_form(class)
            && let ChoiceForm::Sum(terms) = self.form(first)
        {
            own.0.push((hash(terms, false), first));
        }
    }

    /// Adds a product as a form of a class, as [`ChoiceNetwork::add_sum`].
    pub(crate) fn add_product(&mut self, class: Class, factors: &mut [Class], negated: bool) {
        let terms = sorted_factors(factors);
        self.add_form(class, &terms, true, negated);
    }

    fn add_form(&mut self, class: Class, terms: &[ProductTerm], product: bool, negated: bool) {
        if !self.is_allowed(class, terms) {
            return;
        }
        if let Some(form) = self.forms.insert(class, terms, product, negated) {
            self.note_form(class, form);
        }
    }

    /// As [`add_form`](ChoiceNetwork::add_form), of terms that are not known.
    fn add_new_form(&mut self, class: Class, terms: &[ProductTerm], product: bool, negated: bool) {
        if self.is_allowed(class, terms) {
            let form = self.forms.insert_new(class, terms, product, negated);
            self.note_form(class, form);
        }
    }

    /// True when terms can be a form of a class.
    fn is_allowed(&self, class: Class, terms: &[ProductTerm]) -> bool {
        let rank = self.rank(class);
        let low = |class: Class| self.ranks[class.index()] < rank;
        terms.len() >= 2 && terms.iter().all(|term| low(term.a) && low(term.b()))
    }

    /// The class that has these terms as a form, and a flag: true when they are
    /// the negation of it.
    fn known(&self, terms: &[ProductTerm], product: bool) -> Option<SignedClass> {
        let form = self.forms.find(terms, product)?;
        Some(SignedClass {
            class: self.forms.class(form),
            negative: self.forms.is_negated(form),
        })
    }

    /// The class of a sum of terms, with this sum as one of its forms; `None`
    /// when the value is zero. A sum that is a class already known is that
    /// class.
    pub(crate) fn sum(&mut self, terms: &mut Vec<ProductTerm>) -> Option<SignedClass> {
        if let [] | [_] = terms[..] {
            return self.new_sum(terms);
        }
        let place = RecentSums::place(terms);
        if let Some(class) = self.recent.find(place, terms) {
            return class;
        }
        let given = SmallVec::from_slice(terms);
        let class = self.new_sum(terms);
        self.recent.keep(place, given, class);
        class
    }

    /// As [`ChoiceNetwork::sum`], of a sum that may not have been searched for.
    fn new_sum(&mut self, terms: &mut Vec<ProductTerm>) -> Option<SignedClass> {
        self.tidy(terms);
        match terms[..] {
            [] => return None,
            [term] if !term.is_product() => {
                return Some(SignedClass {
                    class: term.a,
                    negative: term.negative(),
                });
            }
            [term] => {
                return Some(self.signed_product(&mut [term.a, term.b()], term.negative()));
            }
            _ => {}
        }
        let flipped = normalise(terms);
        if let Some(signed) = self.known(terms, false) {
            return Some(signed.flip(flipped));
        }
        let value = self.sum_value(terms);
        if value.is_zero() {
            return None;
        }
        let used = terms.iter().flat_map(|term| [term.a, term.b()]);
        let rank = used.map(|class| self.rank(class)).fold(0, u64::max);
        // A new class has the sign of the sum as it was given.
        let value = self.values.images.negate_if(flipped, value);
        let signed = self.class(value, rank + 1);
        self.add_new_form(signed.class, terms, false, signed.negative ^ flipped);
        Some(signed)
    }

    /// The class of a product of classes, with this product as one of its
    /// forms; of no factors, 1.
    pub(crate) fn product(&mut self, factors: &mut [Class]) -> SignedClass {
        self.signed_product(factors, false)
    }

    /// As [`ChoiceNetwork::product`], of the product or its negation.
    fn signed_product(&mut self, factors: &mut [Class], negative: bool) -> SignedClass {
        let terms = sorted_factors(factors);
        let terms = &terms[terms.partition_point(|factor| factor.a == Class::ONE)..];
        if let [] | [_] = terms {
            let class = terms.first().map_or(Class::ONE, |factor| factor.a);
            return SignedClass { class, negative };
        }
        if let Some(signed) = self.known(terms, true) {
            return signed.flip(negative);
        }
        let value = self.product_value(factors);
        let ranks = factors.iter().map(|&factor| self.rank(factor));
        let rank = ranks.fold(0, u64::max);
        // A new class has the sign of the product as it was given.
        let value = self.values.images.negate_if(negative, value);
        let signed = self.class(value, rank + 1);
        self.add_new_form(signed.class, terms, true, signed.negative ^ negative);
        signed
    }

    /// Drops terms that cancel, orders the others and appends 1.
    pub(crate) fn tidy(&self, terms: &mut Vec<ProductTerm>) {
        for term in terms.iter_mut() {
            *term = term.ordered();
        }
        if terms.len() > 1 {
            cancel(terms, ProductTerm::opposite);
        }
    }
}

/// Makes the first of tidy terms positive; true when all signs were changed for
/// that. The terms stay in order: of one product there is one sign.
fn normalise(terms: &mut [ProductTerm]) -> bool {
    let flipped = terms.first().is_some_and(|term| term.negative());
    if flipped {
        for term in terms.iter_mut() {
            *term = term.opposite();
        }
    }
    flipped
}

/// Factors in order, as terms.
fn sorted_factors(factors: &mut [Class]) -> SmallVec<[ProductTerm; 4]> {
    factors.sort_unstable();
    let factors = factors.iter();
    factors
        .map(|&factor| ProductTerm::new(factor, Class::ONE, false))
        .collect()
}
