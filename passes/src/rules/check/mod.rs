//! Proving and refuting rules.
//!
//! Over the reals a rule without roots is an identity of rational functions
//! of its variables and of sines and cosines, so it is decided at random
//! points of a prime field (Schwartz and Zippel): two sides that differ agree
//! at one point with probability at most degree/2⁶¹, and eight points must
//! agree. First sine and cosine are independent (class real), then they lie
//! on the circle (class real-trig). A rule that fails both is refuted by
//! small integers; when none refute it, it is neither proved nor refuted
//! (the field knows neither sums of angles nor which sums are positive) and
//! no pass uses it.
//!
//! The field decides at points in general position. A rule whose right side
//! divides by zero at a point where the left side does not changes the
//! function there, and is false as well.

mod bits;
mod counterexample;
mod field;
#[cfg(test)]
mod tests;

pub use bits::{Note, NoteKind};
pub use counterexample::Counterexample;
pub(super) use field::RuleField;

use super::RuleSet;
use super::pattern::{Pattern, PatternNode};
use super::rule::{Requirement, Rule};
use crate::NumericClass;
use robovec_ir::Operation;
use robovec_ir::arithmetic::Arithmetic;
use robovec_ir::diagnostic::{Diagnostic, Label, Report};
use robovec_ir::field::{Field, PrimeField};

/// Points of the field at which both sides must agree.
pub const POINTS: u32 = 8;

/// Random trials in floating point for a report.
pub const TRIALS: usize = 20_000;

/// Random trials when the rules are only to be used.
const FEW_TRIALS: usize = 2_000;

/// Whether a rule holds.
#[derive(Clone, PartialEq, Debug)]
pub enum Verdict {
    /// Equal over the reals wherever the left side is defined.
    Proved {
        /// True when sine and cosine must lie on the circle.
        circle: bool,
        /// A bound on the degree of the difference of the sides, as a
        /// polynomial: a wrong rule passes one point with probability at most
        /// this over 2⁶¹.
        degree: u64,
    },
    /// Refuted.
    False(Counterexample),
    /// Not equal in the field, but no numbers were found that refute it; or
    /// never defined in the field.
    Unproved,
}

/// What is known of a rule.
#[derive(Clone, PartialEq, Debug)]
pub struct Finding {
    /// Whether it holds.
    pub verdict: Verdict,
    /// What it does to numbers, as found; that of the declaration when the
    /// rule is not proved.
    pub class: NumericClass,
    /// The part of random points in binary32 where both sides have the same
    /// bits, from 0 to 1.
    pub equal_bits: f64,
    /// What happens at special values.
    pub notes: Vec<Note>,
}

impl Finding {
    /// True when a pass may use the rule.
    pub fn is_sound(&self) -> bool {
        matches!(self.verdict, Verdict::Proved { .. })
    }

    /// True when the rule keeps what its author declares.
    pub fn keeps(&self, declared: NumericClass) -> bool {
        self.is_sound() && self.class <= declared
    }
}

/// Proves or refutes a rule, with so many random trials in floating point.
pub fn check(rule: &Rule, trials: usize) -> Finding {
    let verdict = verdict(rule);
    let mut class = match verdict {
        Verdict::Proved { circle: false, .. } => NumericClass::Real,
        Verdict::Proved { circle: true, .. } => NumericClass::RealTrig,
        Verdict::False(_) | Verdict::Unproved => rule.class,
    };
    let mut bits = bits::try_bits(rule, trials);
    if let Verdict::False(_) = verdict {
        // What it does to zeros is then of no interest.
        bits.notes.clear();
    }
    if class == NumericClass::Real && bits.exact {
        class = NumericClass::Exact;
    }
    Finding {
        verdict,
        class,
        equal_bits: bits.equal,
        notes: bits.notes,
    }
}

fn verdict(rule: &Rule) -> Verdict {
    let degree = degree(&rule.left).saturating_add(degree(&rule.right));
    for circle in [false, true] {
        if agrees(rule, circle) == Some(true) {
            return match counterexample::undefined(rule) {
                Some(hole) => Verdict::False(hole),
                None => Verdict::Proved { circle, degree },
            };
        }
    }
    match counterexample::search(rule) {
        Some(found) => Verdict::False(found),
        None => Verdict::Unproved,
    }
}

/// Whether the sides agree at points of the field; `None` when they are
/// hardly ever defined there.
fn agrees(rule: &Rule, circle: bool) -> Option<bool> {
    let mut seen = 0;
    for seed in 1..=u64::from(64 * POINTS) {
        // The two primes of the seed take turns.
        let field = RuleField(PrimeField::pair(seed / 2, circle)[(seed % 2) as usize]);
        let mut values = field.0.point(rule.variables.len());
        for condition in &rule.conditions {
            let value = &mut values[condition.variable as usize];
            // Squares play the part of positive numbers.
            if condition.requirement == Requirement::Positive {
                *value = field.mul(*value, *value);
            }
        }
        let left = rule.left.evaluate(&field, &values);
        let right = rule.right.evaluate(&field, &values);
        if PrimeField::is_undefined(left) || PrimeField::is_undefined(right) {
            continue;
        }
        if left != right {
            return Some(false);
        }
        seen += 1;
        if seen == POINTS {
            return Some(true);
        }
    }
    None
}

/// A bound on the degrees of numerator and denominator together. A sine is a
/// quotient of polynomials of degree 2 in a parameter of the circle.
fn degree(pattern: &Pattern) -> u64 {
    let mut degrees: Vec<(u64, u64)> = Vec::with_capacity(pattern.nodes.len());
    for node in &pattern.nodes {
        let found = match *node {
            PatternNode::Variable(_) => (1, 0),
            PatternNode::Number(_) => (0, 0),
            PatternNode::Operation(operation, [a, b]) => {
                let ((p, q), (r, s)) = (degrees[a as usize], degrees[b as usize]);
                match operation {
                    Operation::Copy | Operation::Neg => (p, q),
                    Operation::Add | Operation::Sub => (
                        p.saturating_add(s).max(r.saturating_add(q)),
                        q.saturating_add(s),
                    ),
                    Operation::Mul => (p.saturating_add(r), q.saturating_add(s)),
                    Operation::Div => (p.saturating_add(s), q.saturating_add(r)),
                    Operation::Sin | Operation::Cos => (2, 2),
                    Operation::Sqrt => (p, q),
                    // No pattern has three operands.
                    Operation::Fma | Operation::Fms | Operation::Fnma => {
                        (p.saturating_add(r), q.saturating_add(s))
                    }
                }
            }
        };
        degrees.push(found);
    }
    let (numerator, denominator) = degrees.last().copied().unwrap_or_default();
    numerator.saturating_add(denominator)
}

impl RuleSet {
    /// The rules that a pass may use, and messages about the others: a rule
    /// that is false or not proved is left out, one that declares a stronger
    /// class than it keeps is used with the class that was found.
    #[must_use]
    pub fn sound(self) -> (RuleSet, Report) {
        let mut report = self.report();
        let mut sound = RuleSet {
            rules: Vec::new(),
            files: self.files,
        };
        for mut rule in self.rules {
            let finding = check(&rule, FEW_TRIALS);
            report.extend(diagnose(&rule, &finding).map(|mut found| {
                found.severity = robovec_ir::diagnostic::Severity::Warning;
                found
            }));
            if finding.is_sound() {
                rule.class = rule.class.max(finding.class);
                sound.rules.push(rule);
            }
        }
        (sound, report)
    }
}

/// The message about a rule that does not keep what it promises.
pub fn diagnose(rule: &Rule, finding: &Finding) -> Option<Diagnostic> {
    let places = &rule.places;
    let label = |place: &std::ops::Range<usize>| Label::primary(places.file, place.clone());
    let sides = places.left.start.min(places.right.start)..places.left.end.max(places.right.end);
    let name = &rule.name;
    match &finding.verdict {
        Verdict::False(found) => {
            let diagnostic = Diagnostic::error()
                .with_message(format!("the rule '{name}' is false"))
                .with_labels(vec![label(&sides).with_message(found.to_string())]);
            let advice = if found.right.is_finite() {
                "no pass uses it; the other rules are used"
            } else {
                "no pass uses it; a condition such as 'when nonzero(a)' may save it"
            };
            Some(diagnostic.with_note(advice))
        }
        Verdict::Unproved => Some(
            Diagnostic::error()
                .with_message(format!("the rule '{name}' is neither proved nor refuted"))
                .with_labels(vec![label(&sides)])
                .with_notes(vec![
                    "the proof knows sin^2+cos^2=1 and square roots of squares, but neither \
                     sums of angles nor the signs of sums"
                        .to_owned(),
                    "no pass uses it".to_owned(),
                ]),
        ),
        Verdict::Proved { .. } if finding.class > rule.class => Some(
            Diagnostic::error()
                .with_message(format!("the rule '{name}' is true, but not {}", rule.class))
                .with_labels(vec![
                    label(&places.class).with_message(format!("found: class={}", finding.class)),
                ])
                .with_note("passes use it with the class that was found"),
        ),
        Verdict::Proved { .. } => None,
    }
}
