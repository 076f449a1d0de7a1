//! Look-ahead: values as linear functions of values further back.
//!
//! The sums of a recursion are linear in the late values: `x = Σ c·u + e`, the
//! coefficients `c` and the remainder `e` being ready long before the `u`.
//! Substituting the same form of each `u` gives `x` as a linear function of the
//! operands of the `u`, with coefficients that can be computed beside the
//! recursion.
//!
//! The distance back is measured in time: at a *frontier* a class is written in
//! the values available then, and every variable after it is replaced by its
//! own form at the same frontier. Variables of one frontier are thus of one
//! age, and few: the state of the recursion. A form is composed directly, of
//! the class's equation and the forms of its operands, and of the form at a
//! nearer frontier and the forms of its variables. Both ways compute the same
//! coefficients and the same remainder, so they meet in the same classes, and
//! choosing among them is choosing a parallel prefix network (Sklansky 1960;
//! Kogge and Stone 1973; Ladner and Fischer 1980) by arrival times.
//! Coefficients are the same for all right-hand sides of a recursion (the
//! columns of a mass matrix), and are found to be.

use super::forms::ChoiceForm;
use super::import::{Import, import};
use super::network::{ChoiceNetwork, FORMS_PER_OPERATION, OwnForms};
use super::term::{Class, ProductTerm};
use super::timing::Arrivals;
use robovec_analysis::critical_path::Weights;
use robovec_analysis::critical_path::longest;
use robovec_framework::fingerprint::Images;
use robovec_framework::pass::Context;
use robovec_ir::Function;
use smallvec::{SmallVec, smallvec};
use std::ops::Range;

/// The limits on the reach and the width of forms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompositionLimits {
    /// Cycles from one frontier to the next.
    pub(crate) grid: u32,
    /// The number of frontiers a form looks back; of every distance.
    pub(crate) frontiers: u32,
    /// The number of times that the distance between frontiers is doubled for
    /// looking further back.
    pub(crate) doublings: u32,
    /// A form has at most this number of late terms.
    pub(crate) width: usize,
    /// A form with more than the allowed late terms is kept if it has no more
    /// than these: the earliest of them are added to the terms that are known
    /// early.
    pub(crate) reach: usize,
    /// A variable that is available this number of cycles before the frontier
    /// is added to the terms that are known early.
    pub(crate) window: u32,
}

/// Sums `Σ coefficient · variable + rest`, each the value of a class with its
/// sign. Of every term the first class is the coefficient and the second the
/// variable, which is 1 in the rest.
#[derive(Default)]
struct LinearForms {
    /// End of the terms of each.
    ends: Vec<u32>,
    terms: Vec<ProductTerm>,
}

impl LinearForms {
    fn push(&mut self, terms: &[ProductTerm]) -> u32 {
        self.terms.extend_from_slice(terms);
        let end = u32::try_from(self.terms.len()).expect("terms are counted in 32 bits");
        self.ends.push(end);
        self.ends.len() as u32 - 1
    }

    fn terms(&self, form: u32) -> &[ProductTerm] {
        let before = (form as usize).checked_sub(1);
        let start = before.map_or(0, |before| self.ends[before]);
        &self.terms[start as usize..self.ends[form as usize] as usize]
    }
}

/// Treatment of a term while a form is composed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum TermPlan {
    /// It is added to the terms that are known early.
    Rest,
    /// It stays.
    Keep,
    /// This form is substituted for its variable.
    Substitute(u32),
}

/// Result of a composition.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
enum Composed {
    /// No form: it has no variables, or too many.
    #[default]
    Nothing,
    /// A form of the class that is not kept for others.
    Added,
    /// A form that may be substituted for the class.
    Kept(u32),
}

/// The last form composed of one kind. Where nothing became available between
/// two frontiers, the next one is the same.
#[derive(Default)]
struct LastComposition {
    /// The form it was composed of; `None` for the class's own.
    outer: Option<u32>,
    /// Treatment of each of its terms; empty when there was no composition.
    plan: Vec<TermPlan>,
    made: Composed,
}

/// Vectors that are kept from one composition to the next.
#[derive(Default)]
struct CompositionSpace {
    outer: Vec<ProductTerm>,
    plan: Vec<TermPlan>,
    variables: Vec<Class>,
    /// By variable, in the order of `variables`: its coefficient.
    coefficients: Vec<Vec<ProductTerm>>,
    rest: Vec<ProductTerm>,
    made: Vec<ProductTerm>,
    /// Forms of the class that is composed for.
    own: OwnForms,
}

/// A function as a network whose classes have forms that look back, and the
/// number of equations of the longest chain that is linear in its latest
/// values. `None`, with a remark, when the function cannot be analysed.
pub(crate) fn look_ahead(
    function: &Function,
    context: &mut Context<'_>,
    timing: Weights,
    limits: CompositionLimits,
) -> Option<(Import, u32)> {
    let images = Images::of(function, false);
    let mut import = import(&[function], context, timing, images)?;
    let chain = add_forms(&mut import, limits);
    import.sort();
    Some((import, chain))
}

fn add_forms(import: &mut Import, limits: CompositionLimits) -> u32 {
    let mut composer = Composer {
        network: &mut import.network,
        reference: &import.arrivals,
        limits,
        chains: Vec::new(),
        linear: LinearForms::default(),
        forms: Vec::new(),
        made: Vec::new(),
        space: CompositionSpace::default(),
    };
    // At once, as `ChoiceNetwork::reserve` says.
    let terms = FORMS_PER_OPERATION * import.classes.len();
    composer.linear.terms.reserve(terms);
    for &class in &import.classes {
        let origin = composer.network.origin_of(class);
        composer.network.origin = origin;
        composer.extend(class);
    }
    longest(&composer.chains)
}

struct Composer<'a> {
    network: &'a mut ChoiceNetwork,
    /// Arrivals of the function as read: they define the frontiers.
    reference: &'a Arrivals,
    limits: CompositionLimits,
    /// By class: the number of equations after it, each linear in the latest
    /// value of the one before.
    chains: Vec<u32>,
    linear: LinearForms,
    /// By class: its forms by frontier, the nearest first.
    forms: Vec<Range<u32>>,
    /// Frontiers and forms.
    made: Vec<(u32, u32)>,
    space: CompositionSpace,
}

impl Composer<'_> {
    /// All forms of a class whose operands have theirs.
    fn extend(&mut self, class: Class) {
        let Some(base) = self.base(class) else {
            return;
        };
        let count = class.index() + 1;
        if self.chains.len() < count {
            self.chains.resize(count, 0);
            self.forms.resize(count, 0..0);
        }
        let latest = base.iter().map(|term| term.b());
        let latest = latest.max_by_key(|&variable| self.key(variable));
        let behind = latest.and_then(|variable| self.chains.get(variable.index()));
        self.chains[class.index()] = 1 + behind.copied().unwrap_or(0);
        let frontiers = self.frontiers(self.reference.of(class));
        let (mut direct, mut split) = (LastComposition::default(), LastComposition::default());
        let first = self.made.len() as u32;
        let mut space = std::mem::take(&mut self.space);
        self.network.own_forms(class, &mut space.own);
        for &frontier in &frontiers {
            space.outer.clear();
            space.outer.extend_from_slice(&base);
            let mut made = self.compose(class, (None, true), frontier, &mut direct, &mut space);
            if let Some(middle) = self.middle(first, frontiers[0], frontier) {
                space.outer.clear();
                space.outer.extend_from_slice(self.linear.terms(middle));
                let keep = made == Composed::Nothing;
                let outer = (Some(middle), keep);
                let form = self.compose(class, outer, frontier, &mut split, &mut space);
                made = if keep { form } else { made };
            }
            if let Composed::Kept(form) = made {
                self.made.push((frontier, form));
            }
        }
        self.space = space;
        self.forms[class.index()] = first..self.made.len() as u32;
    }

    /// The frontiers of a class, the nearest first. Whatever lies between the
    /// class and one of its frontiers has that frontier too.
    fn frontiers(&self, arrival: u32) -> Vec<u32> {
        let first = (arrival.max(1) - 1) / self.limits.grid;
        let mut frontiers: Vec<u32> = Vec::new();
        for level in 0..=self.limits.doublings.min(31) {
            let nearest = first >> level << level;
            for back in 0..self.limits.frontiers {
                let Some(frontier) = nearest.checked_sub(back << level) else {
                    break;
                };
                if frontiers.last().is_none_or(|&last| frontier < last) {
                    frontiers.push(frontier);
                }
            }
        }
        frontiers
    }

    /// Of the forms made since `since` the one half way to a frontier.
    fn middle(&self, since: u32, first: u32, frontier: u32) -> Option<u32> {
        let half = frontier + (first - frontier).div_ceil(2);
        let made = self.made[since as usize..].iter();
        let nearest = made.min_by_key(|(at, _)| at.abs_diff(half));
        nearest.map(|&(_, form)| form)
    }

    /// The form of a class at a frontier, or at the nearest one before it.
    fn form_of(&self, class: Class, frontier: u32) -> Option<u32> {
        let made = self.forms.get(class.index())?.clone();
        let made = &self.made[made.start as usize..made.end as usize];
        let near = made.partition_point(|&(at, _)| at >= frontier);
        near.checked_sub(1).map(|last| made[last].1)
    }

    /// The class's own form.
    fn base(&mut self, class: Class) -> Option<SmallVec<[ProductTerm; 8]>> {
        let first = self.network.first_form(class)?;
        let negated = self.network.is_negated(first);
        match self.network.form(first) {
            ChoiceForm::Sum(terms) => {
                let terms = terms.iter().map(|&term| self.split(term));
                Some(terms.map(|term| term.opposite_if(negated)).collect())
            }
            ChoiceForm::Product(factors) => {
                let mut factors: SmallVec<[Class; 4]> =
                    factors.iter().map(|factor| factor.a).collect();
                factors.sort_by_key(|&factor| self.key(factor));
                let last = factors.pop()?;
                let coefficient = self.network.product(&mut factors);
                Some(smallvec![coefficient.times(last, negated)])
            }
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) | ChoiceForm::Opaque(_) => None,
        }
    }

    /// A term as coefficient and variable, the variable being the later one.
    fn split(&self, term: ProductTerm) -> ProductTerm {
        if self.key(term.a) <= self.key(term.b()) {
            term
        } else {
            ProductTerm::new(term.b(), term.a, term.negative())
        }
    }

    /// Treatment of a term at a frontier.
    fn plan(&self, term: ProductTerm, frontier: u32) -> TermPlan {
        let time = frontier * self.limits.grid;
        let arrival = self.reference.of(term.b());
        if arrival.saturating_add(self.limits.window) <= time || arrival == 0 {
            return TermPlan::Rest;
        }
        let inner = if arrival > time {
            self.form_of(term.b(), frontier)
        } else {
            None
        };
        match inner {
            Some(form) => TermPlan::Substitute(form),
            None => TermPlan::Keep,
        }
    }

    /// Substitutes the forms at a frontier for the variables after it in
    /// `space.outer`; adds the result to the class, and keeps it for others on
    /// request.
    fn compose(
        &mut self,
        class: Class,
        (outer, keep): (Option<u32>, bool),
        frontier: u32,
        last: &mut LastComposition,
        space: &mut CompositionSpace,
    ) -> Composed {
        space.plan.clear();
        let plan = space.outer.iter().map(|&term| self.plan(term, frontier));
        space.plan.extend(plan);
        let is_last = last.outer == outer && last.plan == space.plan;
        if is_last && !(keep && last.made == Composed::Added) {
            return last.made;
        }
        last.outer = outer;
        last.plan.clone_from(&space.plan);
        last.made = if self.collect(space) {
            self.add_composed(class, space, keep)
        } else {
            Composed::Nothing
        };
        last.made
    }

    /// Substitutes, and collects the coefficient of every variable. False when
    /// there are no variables or too many.
    fn collect(&self, space: &mut CompositionSpace) -> bool {
        space.variables.clear();
        space.rest.clear();
        let most = match self.limits.width {
            0 => 0,
            width => width.max(self.limits.reach),
        };
        for (&outer, &plan) in space.outer.iter().zip(&space.plan) {
            let form = match plan {
                TermPlan::Rest => {
                    space.rest.push(outer);
                    continue;
                }
                TermPlan::Keep => &[ProductTerm::new(Class::ONE, outer.b(), false)],
                TermPlan::Substitute(form) => self.linear.terms(form),
            };
            for &inner in form {
                let negative = outer.negative() ^ inner.negative();
                let term = ProductTerm::new(outer.a, inner.a, negative);
                if !inner.is_product() {
                    space.rest.push(term);
                    continue;
                }
                let known = space.variables.iter();
                let place = known.clone().position(|&known| known == inner.b());
                let place = place.unwrap_or(known.len());
                if place == space.variables.len() {
                    if place == most {
                        return false;
                    }
                    space.variables.push(inner.b());
                    match space.coefficients.get_mut(place) {
                        Some(coefficients) => coefficients.clear(),
                        None => space.coefficients.push(Vec::new()),
                    }
                }
                space.coefficients[place].push(term);
            }
        }
        !space.variables.is_empty()
    }

    /// The earliest variable that a form keeps, the latest ones being kept.
    fn earliest_kept(&self, variables: &[Class]) -> (u32, Class) {
        let others = variables.len().saturating_sub(self.limits.width);
        if others == 0 {
            return (0, Class::ONE);
        }
        let keys = variables.iter().map(|&variable| self.key(variable));
        let mut keys: SmallVec<[(u32, Class); 32]> = keys.collect();
        *keys.select_nth_unstable(others).1
    }

    /// Classes in the order of their arrivals.
    fn key(&self, class: Class) -> (u32, Class) {
        (self.reference.of(class), class)
    }

    /// Adds the form collected to its class.
    fn add_composed(&mut self, class: Class, space: &mut CompositionSpace, keep: bool) -> Composed {
        space.made.clear();
        let kept = self.earliest_kept(&space.variables);
        for (&variable, coefficient) in space.variables.iter().zip(&mut space.coefficients) {
            if let Some(coefficient) = self.network.sum(coefficient) {
                let term = coefficient.times(variable, false);
                if self.key(variable) < kept {
                    space.rest.push(term)
                } else {
                    space.made.push(term)
                }
            }
        }
        if let Some(rest) = self.network.sum(&mut space.rest) {
            space.made.push(rest.times(Class::ONE, false));
        }
        let made = if keep {
            Composed::Kept(self.linear.push(&space.made))
        } else {
            Composed::Added
        };
        self.network.tidy(&mut space.made);
        self.network
            .add_composed(class, &mut space.made, &mut space.own);
        made
    }
}
