//! Finding new rules.
//!
//! Terms are enumerated and distinguished by their values in the prime field
//! (the characteristic vectors of Ruler, with a field that decides instead of
//! samples that suggest); terms of equal values that differ in more than order
//! and grouping are a candidate. A candidate that the known rules derive within
//! a budget is dropped, the smallest ones first, so that those that are left
//! derive the others. They are ranked by the cycles that they would save on the
//! critical paths of functions.
//!
//! Alternatively the left sides are those that occur in functions ([`mine`]),
//! and only right sides are searched for.

mod enumerate;
mod mine;
mod normal;
mod rank;
#[cfg(test)]
mod tests;

pub use enumerate::TermSpace;
pub use mine::{MinedRules, MiningSpace, mine};
pub use rank::RuleGain;

use super::RuleSet;
use super::check::{self, Finding};
use super::graph::{GraphBudget, GraphTerm, are_equal, rewrites, term};
use super::pattern::Pattern;
use super::rule::Rule;
use egg::Rewrite;
use enumerate::{RuleCandidate, enumerate};
use hashbrown::HashSet;
use rank::Timed;
use robovec_analysis::class::NumericClass;
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Function, Machine};

/// The limits of a derivation.
const DERIVATION: GraphBudget = GraphBudget {
    nodes: 300,
    iterations: 3,
};

/// Candidates examined at most, the smallest ones.
const MAX_CANDIDATES: usize = 4_000;

/// Random trials in floating point to find the class of a rule.
const TRIALS: usize = 2_000;

/// A rule that was found.
#[derive(Clone, PartialEq, Debug)]
pub struct Found {
    /// The rule, in the direction that gains more.
    pub rule: Rule,
    /// Its gain.
    pub gain: RuleGain,
}

/// The outcome of a search.
#[derive(Clone, PartialEq, Debug)]
pub struct RuleSearch {
    /// Terms tried.
    pub tried: usize,
    /// Number of different values among them.
    pub different: usize,
    /// True when all terms of the space were tried and all candidates
    /// examined.
    pub complete: bool,
    /// Candidates that differ by more than order, grouping and names.
    pub candidates: usize,
    /// Candidates that the known rules derive.
    pub derived: usize,
    /// The rules that are left, by gain.
    pub found: Vec<Found>,
}

/// Searches a space of terms for rules that `known` does not derive, and ranks
/// them by their gain on functions at the atomic level. `progress` receives the
/// number of candidates done and the number of all.
pub fn find(
    space: &TermSpace,
    known: &RuleSet,
    functions: &[&Function],
    machine: &Machine,
    progress: &mut dyn FnMut(usize, usize),
) -> RuleSearch {
    let enumeration = enumerate(space);
    let mut candidates = distinct(enumeration.candidates, space);
    let complete = enumeration.complete && candidates.len() <= MAX_CANDIDATES;
    candidates.truncate(MAX_CANDIDATES);
    let count = candidates.len();
    let letters = Letters {
        count: space.variables,
        angle: space.variables,
    };
    let (found, derived) = Sieve {
        known,
        derivation: DERIVATION,
        letters,
    }
    .keep(candidates, functions, machine, progress);
    RuleSearch {
        tried: enumeration.tried,
        different: enumeration.different,
        complete,
        candidates: count,
        derived,
        found,
    }
}

/// Rules that candidates must not follow from, and the names of their
/// variables.
struct Sieve<'a> {
    known: &'a RuleSet,
    derivation: GraphBudget,
    letters: Letters,
}

/// The names of variables: this number of letters, and the angle by its number.
#[derive(Clone, Copy)]
struct Letters {
    count: u32,
    angle: u32,
}

impl Letters {
    fn names(self) -> Vec<String> {
        let name = |index: u32| match index {
            _ if index == self.angle => "t".to_owned(),
            // Letters are enough for the number of variables that can be tried.
            _ => char::from(b'a' + (index % 19) as u8).to_string(),
        };
        (0..=self.count.max(self.angle)).map(name).collect()
    }
}

impl Sieve<'_> {
    /// The candidates that are proved and that neither known rules nor those
    /// before them derive, by gain on functions; and the number of derived
    /// ones.
    fn keep(
        &self,
        candidates: Vec<RuleCandidate>,
        functions: &[&Function],
        machine: &Machine,
        progress: &mut dyn FnMut(usize, usize),
    ) -> (Vec<Found>, usize) {
        let weights = Weights::cycles(machine);
        let timed: Vec<Timed<'_>> = functions
            .iter()
            .map(|function| Timed::new(function, &weights))
            .collect();
        // A rule with a condition does not hold of every value.
        let free = self.known.rules.iter();
        let free = free.filter(|rule| rule.conditions.is_empty());
        let mut rewrites: Vec<Rewrite<GraphTerm, ()>> = free.flat_map(rewrites).collect();
        let (mut found, mut derived) = (Vec::new(), 0);
        let count = candidates.len();
        for (index, candidate) in candidates.into_iter().enumerate() {
            progress(index, count);
            if derives(&rewrites, &candidate, self.derivation) {
                derived += 1;
                continue;
            }
            let Some(rule) = rule(&candidate, found.len() + 1, self.letters) else {
                continue;
            };
            rewrites.extend(self::rewrites(&rule));
            found.push(best(rule, &timed, machine));
        }
        // Of equal gains the smaller rule, which was found first.
        found.sort_by_key(|found| std::cmp::Reverse(found.gain));
        for (index, found) in found.iter_mut().enumerate() {
            found.rule.name = format!("found-{}", index + 1);
        }
        (found, derived)
    }
}

/// One candidate of those that differ by order, grouping and names only, and
/// none whose sides do; small ones first.
fn distinct(candidates: Vec<RuleCandidate>, space: &TermSpace) -> Vec<RuleCandidate> {
    let same: Vec<u32> = (0..=space.variables).collect();
    let mut names = HashSet::new();
    let mut distinct: Vec<RuleCandidate> = candidates
        .into_iter()
        .filter(|candidate| {
            let (left, right) = (&candidate.left, &candidate.right);
            normal::normal(left, &same) != normal::normal(right, &same)
                && names.insert(normal::name(
                    left,
                    right,
                    space.variables,
                    space.trigonometric,
                ))
        })
        .collect();
    // The order of equally large ones is that of the enumeration.
    distinct.sort_by_key(|candidate| candidate.left.nodes.len() + candidate.right.nodes.len());
    distinct
}

/// Tests whether known rules make the sides equal.
fn derives(
    rewrites: &[Rewrite<GraphTerm, ()>],
    candidate: &RuleCandidate,
    budget: GraphBudget,
) -> bool {
    let terms = [term(&candidate.left), term(&candidate.right)];
    are_equal(&terms, rewrites, budget)
}

/// A candidate as a rule, if it is sound: it always is except for an accident
/// of the field.
fn rule(candidate: &RuleCandidate, number: usize, letters: Letters) -> Option<Rule> {
    let (mut left, mut right) = (candidate.left.clone(), candidate.right.clone());
    let bound = |from: &Pattern, to: &Pattern| {
        let known = from.variables();
        to.variables()
            .iter()
            .all(|variable| known.contains(variable))
    };
    if left.is_variable() || !bound(&left, &right) {
        std::mem::swap(&mut left, &mut right);
    }
    if left.is_variable() || !bound(&left, &right) {
        return None;
    }
    let both_ways = !right.is_variable() && bound(&right, &left);
    let mut rule = Rule {
        name: format!("found-{number}"),
        group: "found".to_owned(),
        both_ways,
        class: NumericClass::RealTrig,
        ..Rule::new(letters.names(), left, right)
    };
    let finding: Finding = check::check(&rule, TRIALS);
    rule.class = finding.class;
    finding.is_sound().then_some(rule)
}

/// The direction of a rule that gains more.
fn best(rule: Rule, functions: &[Timed<'_>], machine: &Machine) -> Found {
    let directed = rule.directed().into_iter();
    let gains = directed.map(|rule| Found {
        gain: rank::gain(&rule, functions, machine),
        rule,
    });
    // Of equal ones the first direction, towards the smaller term.
    let key = |found: &Found| (found.gain.cycles, found.gain.operations);
    let better = |one: &Found, other: &Found| key(one) > key(other);
    let best = gains.reduce(|best, other| if better(&other, &best) { other } else { best });
    best.unwrap_or(Found {
        rule,
        gain: RuleGain::default(),
    })
}
