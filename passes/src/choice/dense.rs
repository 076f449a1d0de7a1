//! A network copied for going over it again and again.
//!
//! Only what an output can use is copied; classes are numbered in order of
//! rank, so that operands come first and lie near their users, and the terms
//! of all forms lie in one vector.

use super::forms::ChoiceForm;
use super::network::{ChoiceNetwork, Class, SignedClass};
use crate::sums::earliest::{LatestTwo, finish, levels};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;

/// The operation of a form on its terms.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum DenseKind {
    /// Nothing: an input or constant.
    Leaf,
    /// An operation of this weight.
    Opaque(u32),
    /// Adds them.
    Sum,
    /// Multiplies them.
    Product,
}

#[derive(Clone, Copy, Debug)]
struct DenseForm {
    /// Where its terms start; those of the next form end them.
    start: u32,
    /// Operations.
    cost: u32,
    kind: DenseKind,
}

/// What a place hands on to its users while forms are chosen.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct FlowState {
    /// The operations that each user bears.
    pub(crate) flow: f64,
    pub(crate) arrival: u32,
}

/// The copy. Places, forms and terms count from 0.
pub(crate) struct Dense {
    classes: Vec<Class>,
    places: Vec<u32>,
    /// The start of the forms of each place, and the end of the last ones.
    starts: Vec<u32>,
    forms: Vec<DenseForm>,
    /// The forms' numbers in the network.
    originals: Vec<u32>,
    terms: Vec<(u32, u32)>,
}

impl Dense {
    /// The second factor of a term that is no product.
    pub(crate) const NONE: u32 = u32::MAX;

    pub(crate) fn new(
        network: &ChoiceNetwork,
        timing: &Weights,
        outputs: &[Option<SignedClass>],
    ) -> Dense {
        let by_class = FormsByClass::new(network);
        let mut classes = reachable(network, &by_class, outputs);
        classes.sort_unstable_by_key(|&class| (network.rank(class), class));
        let mut places = vec![Dense::NONE; network.len()];
        for (place, class) in classes.iter().enumerate() {
            places[class.index()] = place as u32;
        }
        let mut dense = Dense {
            starts: Vec::with_capacity(classes.len() + 1),
            classes,
            places,
            forms: Vec::new(),
            originals: Vec::new(),
            terms: Vec::new(),
        };
        for index in 0..dense.classes.len() {
            dense.starts.push(dense.forms.len() as u32);
            for &form in by_class.of(dense.classes[index]) {
                dense.push(network, timing, form);
            }
        }
        dense.starts.push(dense.forms.len() as u32);
        dense
    }

    fn push(&mut self, network: &ChoiceNetwork, timing: &Weights, original: u32) {
        let start = self.terms.len() as u32;
        let own = self.starts.len() as u32 - 1;
        let (kind, cost) = match network.form(original) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => (DenseKind::Leaf, 0),
            ChoiceForm::Opaque(index) => {
                let opaque = &network.opaques[index as usize];
                for operand in opaque.operands.iter().flatten() {
                    let place = self.place(operand.class);
                    self.terms.push((place, Dense::NONE));
                }
                let operation = opaque.operation;
                let weight = timing.of(operation);
                (
                    DenseKind::Opaque(weight),
                    u32::from(!operation.is_trigonometric()),
                )
            }
            ChoiceForm::Product(factors) => {
                for factor in factors {
                    let place = self.place(factor.a);
                    self.terms.push((place, Dense::NONE));
                }
                (DenseKind::Product, factors.len() as u32 - 1)
            }
            ChoiceForm::Sum(terms) => {
                let mut cost = terms.len() as u32 - 1;
                for term in terms {
                    let b = match term.is_product() {
                        true => self.place(term.b()),
                        false => Dense::NONE,
                    };
                    cost += u32::from(term.is_product());
                    let a = self.place(term.a);
                    self.terms.push((a, b));
                }
                (DenseKind::Sum, cost)
            }
        };
        debug_assert!(
            self.terms[start as usize..]
                .iter()
                .all(|&(a, b)| [a, b].map(|used| used < own || used == Dense::NONE) == [true; 2]),
            "a form uses only classes of earlier places"
        );
        self.forms.push(DenseForm { start, cost, kind });
        self.originals.push(original);
    }

    /// Number of places.
    pub(crate) fn len(&self) -> usize {
        self.classes.len()
    }

    /// The place of a class.
    pub(crate) fn place(&self, class: Class) -> u32 {
        let place = self.places[class.index()];
        debug_assert_ne!(
            place,
            Dense::NONE,
            "only what an output can use has a place"
        );
        place
    }

    /// The class at a place.
    pub(crate) fn class(&self, place: usize) -> Class {
        self.classes[place]
    }

    /// The forms of a place, in the order they were made.
    pub(crate) fn forms(&self, place: usize) -> std::ops::Range<u32> {
        self.starts[place]..self.starts[place + 1]
    }

    /// A form's number in the network.
    pub(crate) fn original(&self, form: u32) -> u32 {
        self.originals[form as usize]
    }

    pub(crate) fn kind(&self, form: u32) -> DenseKind {
        self.forms[form as usize].kind
    }

    /// Operations of a form.
    pub(crate) fn cost(&self, form: u32) -> u32 {
        self.forms[form as usize].cost
    }

    pub(crate) fn terms(&self, form: u32) -> &[(u32, u32)] {
        let start = self.forms[form as usize].start as usize;
        match self.forms.get(form as usize + 1) {
            Some(next) => &self.terms[start..next.start as usize],
            None => &self.terms[start..],
        }
    }

    /// Calls a function with the places a form uses, with one that it uses
    /// twice twice.
    #[inline]
    pub(crate) fn operands(&self, form: u32, mut visit: impl FnMut(u32)) {
        for &(a, b) in self.terms(form) {
            visit(a);
            if b != Dense::NONE {
                visit(b);
            }
        }
    }

    fn term_arrivals<'a>(
        &'a self,
        timing: &Weights,
        arrivals: &'a [u32],
        form: u32,
    ) -> impl Iterator<Item = u32> + 'a {
        let multiply = timing.of(Operation::Mul);
        self.terms(form).iter().map(move |&(a, b)| {
            let first = arrivals[a as usize];
            match b {
                Dense::NONE => first,
                b => first.max(arrivals[b as usize]).saturating_add(multiply),
            }
        })
    }

    /// The operations of a form and its share of those of its operands, a time
    /// before which it is not available, and whether it is available then.
    pub(crate) fn flow(
        &self,
        timing: &Weights,
        states: &[FlowState],
        form: u32,
    ) -> (f64, u32, bool) {
        let multiply = timing.of(Operation::Mul);
        let mut sum = 0.0;
        let mut latest = LatestTwo::default();
        for &(a, b) in self.terms(form) {
            let state = &states[a as usize];
            sum += state.flow;
            let mut time = state.arrival;
            if b != Dense::NONE {
                let state = &states[b as usize];
                sum += state.flow;
                time = time.max(state.arrival).saturating_add(multiply);
            }
            latest.add(time);
        }
        let (time, exact) = match self.kind(form) {
            DenseKind::Leaf => (0, true),
            DenseKind::Opaque(weight) => (latest.finish(0).0.saturating_add(weight), true),
            DenseKind::Sum => latest.finish(timing.of(Operation::Add)),
            DenseKind::Product => latest.finish(multiply),
        };
        (f64::from(self.cost(form)) + sum, time, exact)
    }

    /// When a form is available.
    pub(crate) fn arrival(&self, timing: &Weights, arrivals: &[u32], form: u32) -> u32 {
        let terms = self.term_arrivals(timing, arrivals, form);
        match self.kind(form) {
            DenseKind::Leaf => 0,
            DenseKind::Opaque(weight) => terms.max().unwrap_or(0).saturating_add(weight),
            DenseKind::Sum => finish(terms, timing.of(Operation::Add)),
            DenseKind::Product => finish(terms, timing.of(Operation::Mul)),
        }
    }

    /// For each term of a sum or product, how many additions (or
    /// multiplications) it goes through.
    pub(crate) fn levels(
        &self,
        timing: &Weights,
        arrivals: &[u32],
        form: u32,
    ) -> SmallVec<[u32; 16]> {
        let times: SmallVec<[u32; 16]> = self.term_arrivals(timing, arrivals, form).collect();
        match self.kind(form) {
            DenseKind::Product => levels(&times, timing.of(Operation::Mul)),
            _ => levels(&times, timing.of(Operation::Add)),
        }
    }
}

/// The forms of a network by class, in the order they were made.
struct FormsByClass {
    starts: Vec<u32>,
    forms: Vec<u32>,
}

impl FormsByClass {
    fn new(network: &ChoiceNetwork) -> FormsByClass {
        let count = network.form_count() as u32;
        let mut starts = vec![0; network.len() + 1];
        for form in 0..count {
            starts[network.class_of(form).index() + 1] += 1;
        }
        for class in 0..network.len() {
            starts[class + 1] += starts[class];
        }
        let mut next = starts.clone();
        let mut forms = vec![0; count as usize];
        for form in 0..count {
            let place = &mut next[network.class_of(form).index()];
            forms[*place as usize] = form;
            *place += 1;
        }
        FormsByClass { starts, forms }
    }

    fn of(&self, class: Class) -> &[u32] {
        let [start, end] = [0, 1].map(|next| self.starts[class.index() + next] as usize);
        &self.forms[start..end]
    }
}

/// All classes that some form of an output's class leads to.
fn reachable(
    network: &ChoiceNetwork,
    by_class: &FormsByClass,
    outputs: &[Option<SignedClass>],
) -> Vec<Class> {
    let mut seen = vec![false; network.len()];
    let mut classes = Vec::new();
    let mut open: Vec<Class> = outputs
        .iter()
        .flatten()
        .map(|output| output.class)
        .collect();
    while let Some(class) = open.pop() {
        if std::mem::replace(&mut seen[class.index()], true) {
            continue;
        }
        classes.push(class);
        for &form in by_class.of(class) {
            network.operands(form, |operand| {
                if !seen[operand.index()] {
                    open.push(operand);
                }
            });
        }
    }
    classes
}
