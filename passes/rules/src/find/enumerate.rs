//! All terms up to a size, distinguished by their values.
//!
//! Terms are built from the smallest ones up, only from representatives: of
//! terms with equal values at points of two prime fields the first one. Every
//! other term of that value is one side of a candidate, the representative the
//! other; their equality is then proved like any rule.

use super::super::check::{RuleField, RuleResidue};
use super::super::pattern::{Pattern, PatternNode, apply};
use hashbrown::HashMap;
use robovec_ir::Operation::{self, Add, Cos, Mul, Sin, Sub};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::field::Modulus;

/// The terms that are tried.
#[derive(Clone, PartialEq, Debug)]
pub struct TermSpace {
    /// Maximum number of operations of a term.
    pub operations: u32,
    /// Variables besides an angle.
    pub variables: u32,
    /// Numbers that occur as written.
    pub numbers: Vec<f64>,
    /// True to add sine and cosine of an angle, as one value each.
    pub trigonometric: bool,
    /// Maximum number of terms tried.
    pub budget: usize,
}

impl Default for TermSpace {
    fn default() -> TermSpace {
        TermSpace {
            operations: 4,
            variables: 3,
            numbers: Vec::new(),
            trigonometric: false,
            budget: 200_000,
        }
    }
}

/// Points that distinguish terms: two of each field.
pub(super) const POINTS: usize = 4;

/// Selects the fields.
const SEED: u64 = 1;

type TermFingerprint = [RuleResidue; POINTS];

fn key(fingerprint: &TermFingerprint) -> [u64; POINTS] {
    fingerprint.map(|number| number.value)
}

/// Two terms of equal value; the first one is the larger.
pub(super) struct RuleCandidate {
    pub(super) left: Pattern,
    pub(super) right: Pattern,
}

/// The terms that were tried.
pub(super) struct Enumeration {
    pub(super) candidates: Vec<RuleCandidate>,
    /// Terms tried.
    pub(super) tried: usize,
    /// Terms of different value.
    pub(super) different: usize,
    /// True when all terms of the space were tried.
    pub(super) complete: bool,
}

/// A term: a leaf or an operation on earlier terms.
#[derive(Clone, Copy)]
pub(super) enum EnumeratedTerm {
    Leaf(PatternNode),
    /// A sine or cosine of a variable.
    Turn(Operation, u32),
    Operation(Operation, [u32; 2]),
}

pub(super) struct EnumeratedTerms {
    fields: Vec<RuleField>,
    terms: Vec<EnumeratedTerm>,
    values: Vec<TermFingerprint>,
    /// By value: the value as an angle does not matter here.
    known: HashMap<[u64; POINTS], u32>,
    /// Representatives by number of operations.
    levels: Vec<Vec<u32>>,
    /// The number of operations of each.
    sizes: Vec<u8>,
}

/// Tries all terms of a space, in a fixed order.
pub(super) fn enumerate(space: &TermSpace) -> Enumeration {
    let mut candidates = Vec::new();
    let (terms, tried, complete) = EnumeratedTerms::all(space, &mut |terms, term, same| {
        candidates.push(RuleCandidate {
            left: terms.pattern(term),
            right: terms.written(same),
        });
    });
    Enumeration {
        candidates,
        tried,
        different: terms.known.len(),
        complete,
    }
}

/// Called with a term that has the value of an earlier one, and of that.
type OnSame<'a> = &'a mut dyn FnMut(&EnumeratedTerms, EnumeratedTerm, u32);

impl EnumeratedTerms {
    /// All terms of a space, the number of terms tried, and whether the
    /// enumeration is complete.
    fn all(space: &TermSpace, on_same: OnSame<'_>) -> (EnumeratedTerms, usize, bool) {
        let pair = RuleField::pair(SEED).map(|field| field.on_circle(space.trigonometric));
        let mut terms = EnumeratedTerms {
            fields: (0..POINTS)
                .map(|point| pair[point % 2].at(point as u64))
                .collect(),
            terms: Vec::new(),
            values: Vec::new(),
            known: HashMap::new(),
            levels: vec![Vec::new()],
            sizes: Vec::new(),
        };
        terms.leaves(space);
        let (mut tried, mut complete) = (0, true);
        for size in 1..=space.operations as usize {
            terms.levels.push(Vec::new());
            for first in 0..size {
                let sizes = [first, size - 1 - first];
                complete &= terms.combine(sizes, space.budget, &mut tried, on_same);
            }
        }
        (terms, tried, complete)
    }

    /// The terms of a space of different value.
    pub(super) fn of(space: &TermSpace) -> EnumeratedTerms {
        EnumeratedTerms::all(space, &mut |_, _, _| {}).0
    }

    /// The terms with this number of operations.
    pub(super) fn level(&self, size: usize) -> &[u32] {
        self.levels.get(size).map_or(&[], Vec::as_slice)
    }

    /// The term of a value, and its number of operations.
    pub(super) fn term_of(&self, value: &[u64; POINTS]) -> Option<(u32, usize)> {
        let term = *self.known.get(value)?;
        Some((term, usize::from(self.sizes[term as usize])))
    }

    pub(super) fn value(&self, term: u32) -> [u64; POINTS] {
        key(&self.values[term as usize])
    }

    /// The value of a pattern whose variables are those of the space; its
    /// angle has the number after them.
    pub(super) fn value_of(&self, pattern: &Pattern, variables: u32) -> [u64; POINTS] {
        let value = |field: &RuleField| {
            let inputs = field.inputs(&vec![false; variables as usize + 1]);
            pattern.evaluate(field, &inputs).value
        };
        std::array::from_fn(|point| value(&self.fields[point]))
    }

    /// The arithmetic at each point.
    pub(super) fn moduli(&self) -> [Modulus; POINTS] {
        std::array::from_fn(|point| self.fields[point].modulus())
    }

    /// A term written out.
    pub(super) fn written(&self, term: u32) -> Pattern {
        self.pattern(self.terms[term as usize])
    }

    fn leaves(&mut self, space: &TermSpace) {
        let count = (space.variables + u32::from(space.trigonometric)) as usize;
        let points: Vec<Vec<RuleResidue>> = self
            .fields
            .iter()
            .map(|field| field.inputs(&vec![false; count]))
            .collect();
        let at = |variable: u32| -> TermFingerprint {
            std::array::from_fn(|point| points[point][variable as usize])
        };
        // Nothing is built from zero: known rules remove it again.
        let zero = std::array::from_fn(|point| self.fields[point].literal(0.0));
        self.push(EnumeratedTerm::Leaf(PatternNode::Number(0.0)), zero);
        for variable in 0..space.variables {
            self.leaf(
                EnumeratedTerm::Leaf(PatternNode::Variable(variable)),
                at(variable),
            );
        }
        for &number in &space.numbers {
            let value = std::array::from_fn(|point| self.fields[point].literal(number));
            self.leaf(EnumeratedTerm::Leaf(PatternNode::Number(number)), value);
        }
        if space.trigonometric {
            let angle = at(space.variables);
            for turn in [Sin, Cos] {
                let value = self.apply(turn, [angle, angle]);
                self.leaf(EnumeratedTerm::Turn(turn, space.variables), value);
            }
        }
    }

    fn leaf(&mut self, term: EnumeratedTerm, value: TermFingerprint) {
        if let Some(index) = self.push(term, value) {
            self.levels[0].push(index);
        }
    }

    fn apply(&self, operation: Operation, [a, b]: [TermFingerprint; 2]) -> TermFingerprint {
        std::array::from_fn(|point| apply(&self.fields[point], operation, a[point], b[point]))
    }

    /// Adds a term unless one of its value is known.
    fn push(&mut self, term: EnumeratedTerm, value: TermFingerprint) -> Option<u32> {
        let key = key(&value);
        if self.known.contains_key(&key) {
            return None;
        }
        let index = self.terms.len() as u32;
        self.known.insert(key, index);
        self.terms.push(term);
        self.values.push(value);
        self.sizes.push(self.levels.len() as u8 - 1);
        Some(index)
    }

    /// All operations on representatives of two sizes; false when the budget
    /// does not suffice.
    fn combine(
        &mut self,
        [first, second]: [usize; 2],
        budget: usize,
        tried: &mut usize,
        on_same: OnSame<'_>,
    ) -> bool {
        let (left, right) = (self.levels[first].clone(), self.levels[second].clone());
        for &a in &left {
            for &b in &right {
                for operation in [Add, Sub, Mul] {
                    // Of both orders of operands one is enough.
                    if operation.is_commutative() && a < b {
                        continue;
                    }
                    if *tried >= budget {
                        return false;
                    }
                    *tried += 1;
                    let operands = [self.values[a as usize], self.values[b as usize]];
                    let value = self.apply(operation, operands);
                    let term = EnumeratedTerm::Operation(operation, [a, b]);
                    if let Some(index) = self.push(term, value) {
                        self.levels[first + second + 1].push(index);
                        continue;
                    }
                    let same = self.known[&key(&value)];
                    on_same(self, term, same);
                }
            }
        }
        true
    }

    fn pattern(&self, root: EnumeratedTerm) -> Pattern {
        enum WritingStep {
            Write(EnumeratedTerm),
            Apply(Operation),
        }
        let mut pattern = Pattern::default();
        let mut operands: Vec<u32> = Vec::new();
        let mut steps = vec![WritingStep::Write(root)];
        while let Some(step) = steps.pop() {
            let node = match step {
                WritingStep::Write(EnumeratedTerm::Leaf(node)) => pattern.push(node),
                WritingStep::Write(EnumeratedTerm::Turn(operation, angle)) => {
                    let angle = pattern.push(PatternNode::Variable(angle));
                    pattern.operation(operation, &[angle])
                }
                WritingStep::Write(EnumeratedTerm::Operation(operation, [a, b])) => {
                    steps.push(WritingStep::Apply(operation));
                    steps.push(WritingStep::Write(self.terms[b as usize]));
                    steps.push(WritingStep::Write(self.terms[a as usize]));
                    continue;
                }
                WritingStep::Apply(operation) => {
                    let from = operands.len() - 2;
                    let taken = operands.split_off(from);
                    pattern.operation(operation, &taken)
                }
            };
            operands.push(node);
        }
        pattern
    }
}
