//! Right sides for a left side that is given.
//!
//! The smallest terms of a few operations over the variables of a left side are
//! enumerated once; a right side of more operations is found by a search from
//! both ends: a small term is removed from the wanted value in all four ways in
//! which an operation can contain it, until the remainder is the value of an
//! enumerated term. So every right side is found that, except for its smallest
//! parts, is one chain of operations on enumerated terms.

use super::super::super::pattern::{Pattern, PatternNode};
use super::super::enumerate::{EnumeratedTerms, POINTS, TermSpace};
use super::shape::VARIABLES;
use hashbrown::HashMap;
use robovec_ir::Operation::{self, Add, Mul, Sub};

/// Operations of the terms that are enumerated, for few variables and many.
const DEPTHS: [(usize, u32); 2] = [(4, 4), (usize::MAX, 3)];

/// Terms enumerated for one set of variables, at most.
const TERMS: usize = 4_000_000;

/// Operations of a term that is taken off, at most.
const LARGEST_PART: usize = 3;

type TermValue = [u64; POINTS];

/// The terms over some variables and numbers.
struct Atoms {
    terms: EnumeratedTerms,
    /// The number of variables, and with that of the angle.
    variables: u32,
    /// Operations up to which every value is known.
    depth: usize,
    /// Inverses of the values that are taken off as factors.
    inverses: HashMap<u32, TermValue>,
}

/// Kinds of atoms of terms: this number of variables, sine and cosine of an
/// angle or not, and numbers by their bits.
#[derive(Clone, PartialEq, Eq)]
struct AtomKinds {
    variables: u32,
    trigonometric: bool,
    numbers: Vec<u64>,
}

/// All sets of variables that were needed so far.
#[derive(Default)]
pub(super) struct RightSides {
    known: Vec<(AtomKinds, Atoms)>,
}

/// The operation from which the term is removed, its side, and the rest.
#[derive(Clone, Copy)]
struct MeetingStep {
    operation: Operation,
    term: u32,
    term_is_first: bool,
}

/// One search.
struct Meeting<'a> {
    atoms: &'a Atoms,
    steps: Vec<MeetingStep>,
    work: usize,
    visit: &'a mut dyn FnMut(Pattern),
}

impl RightSides {
    /// Visits terms with at most this number of operations that are equal to a
    /// shape, small terms of a chain first; returns the number of lookups. At
    /// most `work` lookups are made.
    pub(super) fn each(
        &mut self,
        shape: &Pattern,
        operations: usize,
        work: usize,
        visit: &mut dyn FnMut(Pattern),
    ) -> usize {
        let place = self.place(shape);
        let atoms = &self.known[place].1;
        let inner = shape.renamed(|variable| match variable {
            VARIABLES => atoms.variables,
            other => other,
        });
        let wanted = atoms.terms.value_of(&inner, atoms.variables);
        let mut meeting = Meeting {
            atoms,
            steps: Vec::new(),
            work,
            visit,
        };
        meeting.search(wanted, operations);
        work - meeting.work
    }

    fn place(&mut self, shape: &Pattern) -> usize {
        let variables = shape.variables();
        let angle = variables.last() == Some(&VARIABLES);
        let count = (variables.len() - usize::from(angle)) as u32;
        let mut numbers: Vec<u64> = shape
            .nodes
            .iter()
            .filter_map(|node| match node {
                PatternNode::Number(number) if *number != 0.0 => Some(number.to_bits()),
                _ => None,
            })
            .collect();
        numbers.extend(angle.then_some(1f64.to_bits()));
        numbers.sort_unstable();
        numbers.dedup();
        let kinds = AtomKinds {
            variables: count,
            trigonometric: angle,
            numbers,
        };
        if let Some(place) = self.known.iter().position(|(known, _)| *known == kinds) {
            return place;
        }
        let atoms = Atoms::new(&kinds);
        self.known.push((kinds, atoms));
        self.known.len() - 1
    }
}

impl Atoms {
    fn new(kinds: &AtomKinds) -> Atoms {
        let AtomKinds {
            variables,
            trigonometric,
            ref numbers,
        } = *kinds;
        let leaves = variables as usize + numbers.len() + 2 * usize::from(trigonometric);
        let depth = DEPTHS.iter().find(|(most, _)| leaves <= *most);
        let operations = depth.expect("the last row fits all").1;
        let terms = EnumeratedTerms::of(&TermSpace {
            operations,
            variables,
            numbers: numbers.iter().map(|&bits| f64::from_bits(bits)).collect(),
            trigonometric,
            budget: TERMS,
        });
        let moduli = terms.moduli();
        let factors = (0..=LARGEST_PART).flat_map(|size| terms.level(size));
        let inverses = factors.map(|&term| {
            let value = terms.value(term);
            let inverse = std::array::from_fn(|point| moduli[point].invert(value[point]));
            (term, inverse)
        });
        Atoms {
            inverses: inverses.collect(),
            variables,
            depth: operations as usize,
            terms,
        }
    }

    /// Rests of a value after a term is taken off, in all ways.
    fn rests(&self, whole: &TermValue, term: u32) -> [(MeetingStep, TermValue); 4] {
        let moduli = self.terms.moduli();
        let part = self.terms.value(term);
        let each = |rest: &dyn Fn(usize) -> u64| -> TermValue { std::array::from_fn(rest) };
        let step = |operation, term_is_first| MeetingStep {
            operation,
            term,
            term_is_first,
        };
        let inverse = &self.inverses[&term];
        [
            (step(Add, true), each(&|p| moduli[p].sub(whole[p], part[p]))),
            (step(Sub, true), each(&|p| moduli[p].sub(part[p], whole[p]))),
            (
                step(Sub, false),
                each(&|p| moduli[p].add(whole[p], part[p])),
            ),
            (
                step(Mul, true),
                each(&|p| moduli[p].mul(whole[p], inverse[p])),
            ),
        ]
    }
}

impl Meeting<'_> {
    /// Looks up a value, and removes terms from it. As deep as a right side has
    /// operations.
    fn search(&mut self, wanted: TermValue, operations: usize) {
        if self.work == 0 {
            return;
        }
        self.work -= 1;
        if let Some((term, size)) = self.atoms.terms.term_of(&wanted)
            && size <= operations
        {
            let right = self.written(term);
            (self.visit)(right);
        }
        if operations <= self.atoms.depth {
            return;
        }
        // The smaller part is the one that is taken off.
        let atoms = self.atoms;
        for size in 0..=((operations - 1) / 2).min(LARGEST_PART) {
            for &term in atoms.terms.level(size) {
                for (step, rest) in atoms.rests(&wanted, term) {
                    // A factor of one leads nowhere.
                    if rest == wanted {
                        continue;
                    }
                    self.steps.push(step);
                    self.search(rest, operations - 1 - size);
                    self.steps.pop();
                }
            }
        }
    }

    /// The term that the steps make of the last one.
    fn written(&self, last: u32) -> Pattern {
        let terms = &self.atoms.terms;
        let mut whole = terms.written(last);
        for step in self.steps.iter().rev() {
            let part = terms.written(step.term);
            whole = if step.term_is_first {
                joined(step.operation, &part, &whole)
            } else {
                joined(step.operation, &whole, &part)
            };
        }
        let angle = self.atoms.variables;
        whole.renamed(|variable| match variable {
            _ if variable == angle => VARIABLES,
            other => other,
        })
    }
}

/// An operation on two terms.
fn joined(operation: Operation, first: &Pattern, second: &Pattern) -> Pattern {
    let mut whole = first.clone();
    let shift = whole.nodes.len() as u32;
    whole
        .nodes
        .extend(second.nodes.iter().map(|node| match *node {
            PatternNode::Operation(operation, operands) => {
                PatternNode::Operation(operation, operands.map(|operand| operand + shift))
            }
            other => other,
        }));
    let ends = [shift - 1, whole.nodes.len() as u32 - 1];
    whole.operation(operation, &ends);
    whole
}
