//! The e-graph of one window, and the normal form of its inputs.
//!
//! Zeros, ones and signs are taken care of where a form is made: a sum holds
//! no zero and no pair of opposite terms, a product no one and no sign, and a
//! sum that is only subtracted becomes a sum that is only added. These are
//! the rules without which no saturation with `0 - x` ends.

use super::form::{ClassAnalysis, ClassFacts, ClassReference, EquivalentForm, terms};
use crate::sums::terms::cancel;
use egg::{EGraph, Id};
use hashbrown::HashMap;
use robovec_ir::Operation;
use rustc_hash::FxBuildHasher;

/// The widest sum or product that is made: signs lie in 64 bits, and wider
/// ones are better left to balancing.
pub(crate) const WIDEST: usize = 24;
const _: () = assert!(WIDEST <= 64, "a word holds the signs of the widest sum");

/// The maker of a form that did not enter with the window: an index into the
/// rules, or into the structural steps after them.
pub(crate) type FormMaker = u32;

/// An e-graph over sums and products.
pub(crate) struct EquivalenceGraph {
    pub(crate) egraph: EGraph<EquivalentForm, ClassAnalysis>,
    /// The first maker of each form; forms of the window itself have no entry.
    makers: HashMap<Id, FormMaker, FxBuildHasher>,
    /// The present maker of forms.
    pub(crate) maker: Option<FormMaker>,
}

impl From<EGraph<EquivalentForm, ClassAnalysis>> for EquivalenceGraph {
    fn from(egraph: EGraph<EquivalentForm, ClassAnalysis>) -> EquivalenceGraph {
        EquivalenceGraph {
            egraph,
            makers: HashMap::default(),
            maker: None,
        }
    }
}

impl EquivalenceGraph {
    pub(crate) fn new() -> EquivalenceGraph {
        EGraph::new(ClassAnalysis).into()
    }

    /// Number of forms ever made, which budgets limit.
    pub(crate) fn size(&self) -> usize {
        self.egraph.nodes().len()
    }

    fn add(&mut self, form: EquivalentForm) -> Id {
        let before = self.egraph.nodes().len();
        let id = self.egraph.add(form);
        if self.egraph.nodes().len() > before
            && let Some(maker) = self.maker
        {
            self.makers.insert(Id::from(before), maker);
        }
        id
    }

    /// The maker of a form that is in the e-graph; `None` when it came with the
    /// window.
    pub(crate) fn maker_of(&self, form: &EquivalentForm) -> Option<FormMaker> {
        // The memo holds the node's own number, not that of its class; it is
        // found again by looking for the equal node that was made first.
        self.makers.get(&self.made(form)?).copied()
    }

    fn made(&self, form: &EquivalentForm) -> Option<Id> {
        let canonical = |node: &EquivalentForm| {
            let mut node = node.clone();
            for child in egg::Language::children_mut(&mut node) {
                *child = self.egraph.find(*child);
            }
            node
        };
        let wanted = canonical(form);
        let place = self
            .egraph
            .nodes()
            .iter()
            .position(|node| egg::Language::matches(node, form) && canonical(node) == wanted)?;
        Some(Id::from(place))
    }

    pub(crate) fn find(&self, id: Id) -> Id {
        self.egraph.find(id)
    }

    fn facts(&self, id: Id) -> ClassFacts {
        self.egraph[self.egraph.find(id)].data
    }

    /// The number of a class, if it is one.
    pub(crate) fn number_of(&self, id: Id) -> Option<f64> {
        self.facts(id).number.map(f64::from_bits)
    }

    /// A value of the surroundings.
    pub(crate) fn leaf(&mut self, number: u32) -> Id {
        self.add(EquivalentForm::Leaf(number))
    }

    /// A number; a negative one is the negation of a positive one.
    pub(crate) fn number(&mut self, number: f64) -> ClassReference {
        // Zero has no sign over the real numbers.
        let magnitude = if number == 0.0 { 0.0 } else { number.abs() };
        ClassReference {
            class: self.add(EquivalentForm::Number(magnitude.to_bits())),
            negative: number < 0.0,
        }
    }

    /// The term with its class found, and seen through a minus.
    fn resolve(&self, term: ClassReference) -> ClassReference {
        let mut term = ClassReference {
            class: self.find(term.class),
            ..term
        };
        // Minuses of minuses are rare; a chain of them is not followed far.
        for _ in 0..4 {
            match self.facts(term.class).minus {
                Some(inner) => {
                    term = ClassReference {
                        class: self.find(inner),
                        negative: !term.negative,
                    }
                }
                None => break,
            }
        }
        term
    }

    /// The sum of terms, in normal form; `None` when it is too wide.
    pub(crate) fn sum(&mut self, summands: &[ClassReference]) -> Option<ClassReference> {
        let terms = summands.iter().map(|&term| self.resolve(term));
        let mut normal: Vec<ClassReference> = terms
            .filter(|term| self.number_of(term.class) != Some(0.0))
            .collect();
        cancel(&mut normal, ClassReference::negated);
        match normal[..] {
            [] => return Some(self.number(0.0)),
            [single] => return Some(single),
            _ => {}
        }
        if normal.len() > WIDEST {
            return None;
        }
        // The first term is added: a difference and its opposite are one class.
        let negative = normal[0].negative;
        let mut signs = 0;
        for (index, term) in normal.iter().enumerate() {
            signs |= u64::from(term.negative ^ negative) << index;
        }
        let children = normal.iter().map(|term| term.class).collect();
        let class = self.add(EquivalentForm::Sum(signs, children));
        Some(ClassReference { class, negative })
    }

    /// The product of factors, in normal form; `None` when it is too wide.
    pub(crate) fn product(&mut self, factors: &[ClassReference]) -> Option<ClassReference> {
        let mut normal: Vec<Id> = Vec::with_capacity(factors.len());
        let mut negative = false;
        for &factor in factors {
            let factor = self.resolve(factor);
            negative ^= factor.negative;
            match self.number_of(factor.class) {
                Some(0.0) => return Some(self.number(0.0)),
                Some(1.0) => {}
                _ => normal.push(factor.class),
            }
        }
        let class = match normal[..] {
            [] => self.number(1.0).class,
            [single] => single,
            _ if normal.len() > WIDEST => return None,
            _ => {
                normal.sort_unstable();
                self.add(EquivalentForm::Product(normal.into()))
            }
        };
        Some(ClassReference { class, negative })
    }

    /// Any other operation. Signs come out of quotients, sines and cosines.
    pub(crate) fn other(
        &mut self,
        operation: Operation,
        operands: &[ClassReference],
    ) -> ClassReference {
        let resolved: Vec<ClassReference> =
            operands.iter().map(|&term| self.resolve(term)).collect();
        let odd = resolved.iter().any(|term| term.negative);
        let (children, negative): (Vec<Id>, bool) = match operation {
            Operation::Div | Operation::Sin => (
                resolved.iter().map(|term| term.class).collect(),
                resolved
                    .iter()
                    .fold(false, |sign, term| sign ^ term.negative),
            ),
            Operation::Cos => (resolved.iter().map(|term| term.class).collect(), false),
            _ if odd => {
                let children = resolved.iter().map(|&term| self.value(term)).collect();
                (children, false)
            }
            _ => (resolved.iter().map(|term| term.class).collect(), false),
        };
        ClassReference {
            class: self.add(EquivalentForm::Other(operation, children.into())),
            negative,
        }
    }

    /// The class whose value is that of the term.
    pub(crate) fn value(&mut self, term: ClassReference) -> Id {
        let term = self.resolve(term);
        if !term.negative {
            return term.class;
        }
        self.add(EquivalentForm::Sum(1, [term.class].into()))
    }

    /// Makes a class and a term equal; true when that was new.
    pub(crate) fn equate(&mut self, class: Id, term: ClassReference) -> bool {
        let value = self.value(term);
        self.egraph.union(class, value)
    }

    /// All classes, in order of their numbers.
    pub(crate) fn classes(&self) -> Vec<Id> {
        let mut ids: Vec<Id> = self.egraph.classes().map(|class| class.id).collect();
        ids.sort_unstable();
        ids
    }

    /// The forms of a class, in their own order.
    pub(crate) fn forms(&self, class: Id) -> &[EquivalentForm] {
        &self.egraph[class].nodes
    }

    /// The sums of a class as lists of terms, minuses excepted.
    pub(crate) fn sums(&self, class: Id) -> impl Iterator<Item = Vec<ClassReference>> + '_ {
        self.forms(class).iter().filter_map(|form| match form {
            EquivalentForm::Sum(signs, children) if children.len() > 1 => {
                Some(terms(*signs, children).collect())
            }
            _ => None,
        })
    }
}
