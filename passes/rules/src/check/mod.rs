//! Proving and refuting rules.
//!
//! A rule is true when, wherever its conditions hold and its left side is
//! defined, its right side is defined and has the same value. A proof has
//! three parts, and a difference in any of them is a difference:
//!
//! - *The same function.* Without roots a rule is an identity of rational
//!   functions of its variables and of sines and cosines, so it is decided at
//!   random points of two prime fields (Schwartz and Zippel): first with sine
//!   and cosine independent (class real), then with angles on the circle (class
//!   real-trig). With roots there are enough points that every combination of
//!   signs occurs. See [`agree`].
//! - *Defined where the left side is.* No divisor of the right side can be
//!   zero there and no number under its roots negative. That is proved by
//!   bounds and by factors, not by trying. See [`domain`].
//! - *The same numbers.* At states near and far, whole and broken, of either
//!   sign, the sides are computed with bounds of the errors and must not lie
//!   apart; and in binary64 or binary32 some bits must be equal.
//!
//! A false rule is refuted by numbers, the smallest where possible, else near
//! zeros of its divisors and radicands. A rule that no numbers refute is
//! neither proved nor refuted, and no pass uses it.

mod agree;
mod ball;
mod bits;
mod counterexample;
mod domain;
mod facts;
mod field;
mod joined;
mod line;
mod point;
mod polynomial;
mod primes;
mod proof;
mod states;
#[cfg(test)]
mod tests;
mod zeros;

pub use bits::{Note, NoteKind};
pub use counterexample::Counterexample;
pub(super) use field::{RuleField, RuleResidue};
pub use proof::{Doubt, Proof};

use super::RuleSet;
use super::rule::Rule;
use robovec_analysis::class::NumericClass;
use robovec_ir::diagnostic::{Diagnostic, Label, Report};

/// Random trials in floating point for a report.
pub const TRIALS: usize = 20_000;

/// Random trials when the rules are only to be used.
const FEW_TRIALS: usize = 2_000;

/// Verdict on a rule.
#[derive(Clone, PartialEq, Debug)]
pub enum RuleVerdict {
    /// Equal over the reals wherever the left side is defined.
    Proved(Proof),
    /// Refuted.
    False(Counterexample),
    /// Neither proved nor refuted.
    Unproved(Doubt),
}

/// The findings about a rule.
#[derive(Clone, PartialEq, Debug)]
pub struct Finding {
    /// The verdict on the rule.
    pub verdict: RuleVerdict,
    /// The numeric class, as found; that of the declaration when the rule is
    /// not proved.
    pub class: NumericClass,
    /// The part of random points where both sides have the same bits, from 0
    /// to 1: in binary32 or, where none have in that, in binary64.
    pub equal_bits: f64,
    /// The events at special values.
    pub notes: Vec<Note>,
}

impl Finding {
    /// True when a pass may use the rule.
    pub fn is_sound(&self) -> bool {
        matches!(self.verdict, RuleVerdict::Proved(_))
    }
}

/// Proves or refutes a rule over the reals, without trials of its bits.
pub fn decide(rule: &Rule) -> RuleVerdict {
    proof::verdict(rule)
}

/// Proves or refutes a rule, with this number of random trials in floating
/// point. The verdict does not depend on their number.
pub fn check(rule: &Rule, trials: usize) -> Finding {
    let mut verdict = decide(rule);
    let trials = match verdict {
        // What a false rule does to bits is of little interest.
        RuleVerdict::False(_) => trials.min(FEW_TRIALS),
        _ => trials,
    };
    let mut bits = bits::try_bits(rule, trials);
    if let (RuleVerdict::Proved(_), true) = (&verdict, bits.equal == 0.0) {
        verdict = RuleVerdict::Unproved(Doubt::Bits);
    }
    let mut class = match &verdict {
        RuleVerdict::Proved(proof) if proof.circle => NumericClass::RealTrig,
        RuleVerdict::Proved(_) => NumericClass::Real,
        RuleVerdict::False(_) | RuleVerdict::Unproved(_) => rule.class,
    };
    if let RuleVerdict::False(_) = verdict {
        // What it does to zeros is then of no interest.
        bits.notes.clear();
    }
    if class == NumericClass::Real && bits.exact && matches!(verdict, RuleVerdict::Proved(_)) {
        class = NumericClass::Exact;
    }
    Finding {
        verdict,
        class,
        equal_bits: bits.equal,
        notes: bits.notes,
    }
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

/// The message about a rule that does not keep its promise.
pub fn diagnose(rule: &Rule, finding: &Finding) -> Option<Diagnostic> {
    let places = &rule.places;
    let label = |place: &std::ops::Range<usize>| Label::primary(places.file, place.clone());
    let sides = places.left.start.min(places.right.start)..places.left.end.max(places.right.end);
    let name = &rule.name;
    match &finding.verdict {
        RuleVerdict::False(found) => {
            let diagnostic = Diagnostic::error()
                .with_message(format!("the rule '{name}' is false"))
                .with_labels(vec![label(&sides).with_message(found.to_string())]);
            let advice = if found.defined {
                "no pass uses it; the other rules are used"
            } else {
                "no pass uses it; a condition such as 'when nonzero(a)' may save it"
            };
            Some(diagnostic.with_note(advice))
        }
        RuleVerdict::Unproved(doubt) => Some(
            Diagnostic::error()
                .with_message(format!("the rule '{name}' is neither proved nor refuted"))
                .with_labels(vec![label(&sides).with_message(doubt.to_string())])
                .with_note("no pass uses it"),
        ),
        RuleVerdict::Proved(_) if finding.class > rule.class => Some(
            Diagnostic::error()
                .with_message(format!("the rule '{name}' is true, but not {}", rule.class))
                .with_labels(vec![
                    label(&places.class).with_message(format!("found: class={}", finding.class)),
                ])
                .with_note("passes use it with the class that was found"),
        ),
        RuleVerdict::Proved(_) => None,
    }
}
