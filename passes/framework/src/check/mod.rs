//! The semantic check between two versions of a function.
//!
//! The claim that a pass makes by its [`NumericClass`] is tested:
//!
//! - every class but *approximating*: all outputs are equal
//!   - at random points of two prime fields whose primes are drawn from the
//!     seed and the constants of both versions. Two rational functions that
//!     differ agree at a random point with probability at most `degree / p`,
//!     unless their difference vanishes modulo the prime. Sine and cosine are
//!     points of the circle, on which angles add up, for *real-trig* and
//!     independent elements otherwise; for *real* the square of a root is its
//!     radicand;
//!   - in double-double within a bound of its error that follows from the
//!     operations, at states near and far, whole and not, positive and
//!     negative, and near the constants of both versions. This image decides
//!     what a field cannot: signs of roots, poles, constants that vanish
//!     modulo a prime.
//!
//!   A difference in any image is a difference. Beside equality the domain is
//!   compared: that the version after is defined wherever the version before
//!   is, is refuted, proved, or left open with the condition in question
//!   ([`DomainVerdict`]). An output that divides by
//!   zero at every point has no value in a field, nor a bound; as IEEE
//!   arithmetic may still end in a number (`1/(1/0)`), it is compared in
//!   double-double with a tolerance;
//! - *exact*, and every function in which values have their own formats: all
//!   outputs are also bit-equal in binary64 and binary32, or in these formats,
//!   except that zeros of either sign are equal (a minus becomes `0 - x`) and
//!   that outputs with an infinite or NaN intermediate value may become
//!   anything (`0*x` becomes `0`);
//! - *approximating*: what the pass promised ([`Promise`]) holds, and the
//!   distance between the versions is measured in double-double.
//!
//! A pass that differentiates makes another function, which is compared, in the
//! same two images, with dual numbers of the function before
//! ([`check_derivative`]).
//!
//! Beside the verdict is the effect of the pass on the rounding error of the
//! outputs, in binary32 and binary64 against double-double.
//!
//! The field check is one-sided: versions that it rejects differ as functions
//! of unknown `sin`, `cos` and `sqrt` (see [`robovec_num::field`]); identities
//! that need more than their parity, the circle and sums of angles are rejected
//! too.

mod constants;
mod derivative;
mod domain;
mod failure;
mod field;
mod numbers;
mod numeric;
mod pairing;
mod poles;
mod promise;
mod small;
mod states;

use crate::differentiation::Differentiation;
use crate::instances::Instances;
use crate::scene::Scene;
pub use constants::{LARGEST_MOVE, moved};
use domain::DomainRequirement;
use failure::{Failed, explain};
pub use failure::{Failure, FailureKind, Values};
use field::FieldComparison;
use numbers::Survey;
use pairing::Pairs;
pub use promise::Promise;
use robovec_analysis::accuracy::{ErrorSummary, Measurement, measure};
use robovec_analysis::class::NumericClass;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Output, View};
use robovec_num::ball::Balls;
use robovec_num::field::{CircleField, Field, FieldPoint, PrimeField, RootField};
use robovec_num::format::Format;
use robovec_num::limits::counted;
use small::SmallVerdict;
pub use states::{StatePlace, StateScale};
use std::array;
use std::fmt;

/// The findings of the check.
#[derive(Clone, PartialEq, Debug)]
pub struct CheckVerdict {
    /// The class that was claimed.
    pub class: NumericClass,
    /// The number of points and states it was tested at.
    pub points: u32,
    /// The seed they come from.
    pub seed: u64,
    /// The first output that breaks the claim; `None` when it holds.
    pub failure: Option<Failure>,
    /// Outputs that divide by zero at every point before: these were compared
    /// in double-double only, where that gives a number.
    pub undefined: u32,
    /// Rounding errors in binary32 and binary64; `None` after a failure and for
    /// derivatives, where a comparison has no meaning.
    pub errors: Option<[ErrorChange; 2]>,
    /// The distance by which an *approximating* pass moved the outputs.
    pub deviation: Option<Deviation>,
    /// The number of states at which numbers were compared.
    pub states: u32,
    /// The output that the fewest states decided, and their number: at others
    /// its value was not known well enough to show a difference.
    pub fewest: Option<(String, u32)>,
    /// The places where the versions are defined.
    pub domain: DomainVerdict,
    /// The largest distance there of outputs that must be equal, relative to
    /// the largest element of their array.
    pub distance: f64,
    /// The distance by which rounding constants moved outputs, as a part of
    /// the largest element of their array; `None` where none were rounded.
    pub moved: Option<f64>,
    /// True when an *approximating* pass promised a bound, and it holds.
    pub promised: bool,
}

/// The domain of the version after relative to that of the version before, as
/// far as it was decided.
#[derive(Clone, PartialEq, Default, Debug)]
pub enum DomainVerdict {
    /// They are the same.
    #[default]
    Same,
    /// The version after is defined wherever the version before is, and does
    /// not have this condition of the version before.
    Wider(String),
    /// This condition of the version after was neither proved to follow from
    /// those of the version before nor refuted.
    Open(String),
}

/// The rounding errors of a function before and after a pass.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ErrorChange {
    /// Before the pass.
    pub before: ErrorSummary,
    /// After it.
    pub after: ErrorSummary,
}

/// The distance between two versions in double-double, over random states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Deviation {
    /// The largest difference of an array's element over its largest element.
    pub worst_normwise: f64,
    /// The largest relative difference of an element.
    pub worst_relative: f64,
    /// The element with the largest relative difference.
    pub output: Option<Output>,
}

/// Checks the claim of a pass of a class, between its input and its output, at
/// a number of random points.
///
/// Costs about three nanoseconds per operation, version and point for the
/// field and ten for the rounding errors.
pub fn check(
    before: View<'_>,
    after: View<'_>,
    class: NumericClass,
    states: &States,
    points: u32,
) -> CheckVerdict {
    check_promise(before, after, (class, None), states, points)
}

/// Checks the claim of a pass's class, and its further promises.
pub fn check_promise(
    before: View<'_>,
    after: View<'_>,
    (class, promise): (NumericClass, Option<&Promise>),
    states: &States,
    points: u32,
) -> CheckVerdict {
    let mut verdict = CheckVerdict::new(class, states, points);
    match Pairs::new(before, after) {
        Ok(pairs) => judge(&pairs, states, promise, &mut verdict),
        Err(unpaired) => verdict.failure = Some(unpaired.failure(before, after)),
    }
    if verdict.failure.is_none() {
        verdict.errors = Some(error_changes([before, after], states, verdict.points));
    }
    verdict
}

/// Checks a pass of a class that makes several instances of a function: each of
/// them must equal the function before, for any inputs of the others. The first
/// instance that is not ends the check.
pub fn check_instances(
    before: View<'_>,
    after: View<'_>,
    instances: &Instances,
    class: NumericClass,
    states: &States,
    points: u32,
) -> CheckVerdict {
    let mut verdict = CheckVerdict::new(class, states, points);
    for instance in 1..=instances.count {
        match Pairs::instance(before, after, instances, instance) {
            Ok(pairs) => judge(&pairs, states, None, &mut verdict),
            Err(unpaired) => verdict.failure = Some(unpaired.failure(before, after)),
        }
        if verdict.failure.is_some() {
            return verdict;
        }
    }
    verdict.errors = Some(error_changes([before, after], states, verdict.points));
    verdict
}

/// Checks a program for a derivative: its values, and its products with a
/// random direction (or with random weights), must be those that dual numbers
/// of the function before give ([`robovec_num::dual`]).
///
/// The verdict has no rounding errors, since there is no earlier version to
/// compare with.
pub fn check_derivative(
    before: View<'_>,
    after: View<'_>,
    differentiation: &Differentiation,
    states: &States,
    points: u32,
) -> CheckVerdict {
    let mut verdict = CheckVerdict::new(NumericClass::Real, states, points);
    derivative::judge(before, after, differentiation, states, &mut verdict);
    verdict
}

/// A function made for a scene, with the function and the numbers it was made
/// of.
#[derive(Clone, Copy)]
pub struct Specialised<'a> {
    /// The function before.
    pub before: View<'a>,
    /// The function after, in which numbers are still expressions.
    pub witness: View<'a>,
    /// The function after.
    pub after: View<'a>,
    /// The scene it was made for.
    pub scene: Option<&'a Scene>,
}

/// Checks the claim of a pass that makes a function for a scene: outputs that
/// the scene does not need may be absent, and inputs that it binds have their
/// numbers. The claim is about the witness; the function after must be the
/// witness with its constant expressions replaced by their values.
pub fn check_specialised(
    subject: Specialised<'_>,
    class: NumericClass,
    states: &States,
    points: u32,
) -> CheckVerdict {
    let Specialised {
        before,
        witness,
        after,
        scene,
    } = subject;
    let mut verdict = CheckVerdict::new(class, states, points);
    let empty = Scene::default();
    match Pairs::within(before, witness, scene.unwrap_or(&empty)) {
        Ok(pairs) => {
            judge(&pairs, states, None, &mut verdict);
            if verdict.failure.is_none() {
                let rounded = judge_rounding(&pairs, after, states, &mut verdict);
                verdict.failure = rounded
                    .err()
                    .map(|reason| Failure::about(FailureKind::Constants { reason }, after));
            }
        }
        Err(unpaired) => verdict.failure = Some(unpaired.failure(before, witness)),
    }
    if verdict.failure.is_none() {
        verdict.errors = Some(error_changes([before, after], states, verdict.points));
    }
    verdict
}

/// Checks that a function is its witness with rounded constants, and that these
/// move no output too far.
fn judge_rounding(
    pairs: &Pairs<'_>,
    after: View<'_>,
    states: &States,
    verdict: &mut CheckVerdict,
) -> Result<(), String> {
    constants::compare(pairs.after.function, after)?;
    let inputs = (0..verdict.points).map(|state| {
        let [_, inputs] = pairs.state(states, state);
        inputs
    });
    let (part, output) = moved(pairs.after, after, &inputs.collect::<Vec<_>>());
    verdict.moved = Some(part);
    match output {
        Some(output) if part > LARGEST_MOVE => Err(format!(
            "rounding constants to binary64 changes {} by {part:.1e} of the largest element of \
             its array, but only {LARGEST_MOVE:.1e} is allowed",
            print_output(after, output)
        )),
        _ => Ok(()),
    }
}

fn judge(
    pairs: &Pairs<'_>,
    states: &States,
    promise: Option<&Promise>,
    verdict: &mut CheckVerdict,
) {
    let states = &match promise {
        Some(promise) => promise.states(states),
        None => states.clone(),
    };
    let rounds = verdict.points;
    match verdict.class {
        NumericClass::Approximating => {
            verdict.deviation = Some(numeric::deviation(pairs, states, rounds));
            judge_promise(pairs, states, promise, verdict);
        }
        NumericClass::RealTrig => judge_equality::<CircleField>(pairs, states, verdict),
        // The laws of roots cost twice the time.
        NumericClass::Real if pairs.take_roots() => {
            judge_equality::<RootField>(pairs, states, verdict);
        }
        NumericClass::Real | NumericClass::Exact => {
            judge_equality::<PrimeField>(pairs, states, verdict);
        }
    }
    if verdict.class != NumericClass::Approximating && verdict.failure.is_none() {
        match verdict.class {
            NumericClass::RealTrig => judge_domain::<CircleField>(pairs, states, verdict),
            _ => judge_domain::<PrimeField>(pairs, states, verdict),
        }
    }
    // Formats of single values are part of a function, whatever is claimed of
    // it as one of real numbers.
    let formats = [pairs.before, pairs.after].map(|view| view.function.formats.is_some());
    let bits = match verdict.class {
        NumericClass::Exact => true,
        NumericClass::Real | NumericClass::RealTrig => formats.contains(&true),
        NumericClass::Approximating => false,
    };
    if verdict.failure.is_none()
        && bits
        && let Some(found) = numeric::first_bit_difference(pairs, states, rounds)
    {
        let field = first_field(pairs, verdict.seed);
        verdict.failure = Some(explain(pairs, states, found, None, &field));
    }
}

/// A field in which values of the same name are compared.
fn first_field(pairs: &Pairs<'_>, seed: u64) -> PrimeField {
    let [prime, _] = pairs.primes(seed);
    PrimeField::at(prime, FieldPoint { seed })
}

impl Failed {
    /// The failure, of a kind that numbers show.
    fn explain(
        self,
        pairs: &Pairs<'_>,
        states: &States,
        kind: fn(Values) -> FailureKind,
        verdict: &CheckVerdict,
    ) -> Failure {
        let found = (self.pair, kind(self.values));
        let field = first_field(pairs, verdict.seed);
        explain(pairs, states, found, self.inputs.as_deref(), &field)
    }
}

/// Outputs given to the prover of rules.
const MAX_SMALL: usize = 16;

/// The domain: conditions that do not follow from those before are proved or
/// refuted output by output where these are small, else searched for places
/// where they do not hold.
fn judge_domain<F: Field>(pairs: &Pairs<'_>, states: &States, verdict: &mut CheckVerdict) {
    let open = domain::open::<F>(pairs, 1, states, verdict.seed);
    let mut left = Vec::new();
    for (number, &condition) in open.iter().enumerate() {
        let small = if number < MAX_SMALL {
            small::decided(pairs, condition.pair, states)
        } else {
            SmallVerdict::Open
        };
        match small {
            SmallVerdict::Proved => {}
            SmallVerdict::Refuted(failed) => {
                let kind = FailureKind::Hole;
                verdict.failure = Some(failed.explain(pairs, states, kind, verdict));
                return;
            }
            SmallVerdict::Open => left.push(condition),
        }
    }
    if let Some(first) = left.first() {
        if let Some((failed, requirement)) = poles::first(pairs, states, &left) {
            let kind = match requirement {
                DomainRequirement::Nonzero => FailureKind::Pole,
                DomainRequirement::NotNegative => FailureKind::Hole,
            };
            verdict.failure = Some(failed.explain(pairs, states, kind, verdict));
            return;
        }
        verdict.domain = DomainVerdict::Open(first.text(pairs.after));
    } else if let Some(first) = domain::open::<F>(pairs, 0, states, verdict.seed).first() {
        verdict.domain = DomainVerdict::Wider(first.text(pairs.before));
    }
}

/// Equality as functions: in the fields and in numbers.
fn judge_equality<F: Field>(pairs: &Pairs<'_>, states: &States, verdict: &mut CheckVerdict) {
    let rounds = verdict.points;
    let numbers = |only: Option<usize>| {
        let survey = Survey {
            rounds: numbers::everywhere(pairs, rounds),
            only,
        };
        numbers::compare(pairs, &Balls, states, survey)
    };
    let found = match field::compare::<F>(pairs, rounds, verdict.seed) {
        FieldComparison::Different { pair, field } => {
            // Numbers tell more than residues, where they show the difference.
            let kind = match numbers(Some(pair)) {
                Err(failed) => FailureKind::Numbers(failed.values),
                Ok(_) => {
                    let [before, after] = field::residues(pairs, pair, &field);
                    FailureKind::Field {
                        prime: field.prime().modulus(),
                        before,
                        after,
                    }
                }
            };
            Some(explain(pairs, states, (pair, kind), None, &field))
        }
        FieldComparison::Equal { undefined } => {
            verdict.undefined = undefined.len() as u32;
            let failed = match numbers(None) {
                Err(failed) => Some(failed),
                Ok(agreement) => {
                    (verdict.states, verdict.distance) = (agreement.states, agreement.distance);
                    let decided = agreement.decided.iter().enumerate();
                    verdict.fewest = decided
                        .filter(|(pair, _)| !undefined.contains(pair))
                        .min_by_key(|(_, decided)| **decided)
                        .map(|(pair, &decided)| {
                            (print_output(pairs.before, pairs.list[pair].output), decided)
                        });
                    numeric::first_distance(pairs, &undefined, states, rounds)
                }
            };
            failed.map(|failed| failed.explain(pairs, states, FailureKind::Numbers, verdict))
        }
    };
    verdict.failure = found;
}

/// Tests whether an approximating pass keeps its promise.
fn judge_promise(
    pairs: &Pairs<'_>,
    states: &States,
    promise: Option<&Promise>,
    verdict: &mut CheckVerdict,
) {
    let Some(promise) = promise else { return };
    match promise.keeps(pairs, states, verdict.points) {
        Ok(count) => (verdict.states, verdict.promised) = (count, true),
        Err(failed) => {
            let failure = failed.explain(pairs, states, FailureKind::Promise, verdict);
            verdict.failure = Some(failure);
        }
    }
}

fn error_changes(versions: [View<'_>; 2], states: &States, points: u32) -> [ErrorChange; 2] {
    let formats = [Format::BINARY32, Format::BINARY64];
    let [before, after] =
        versions.map(|view| measure(view, states, points, &formats, Measurement::QUICK));
    array::from_fn(|index| ErrorChange {
        before: before.formats[index].summary(),
        after: after.formats[index].summary(),
    })
}

/// The seed of the `n`th point of a run.
fn nth_seed(seed: u64, n: u32) -> u64 {
    seed.wrapping_add(u64::from(n) << 32)
}

impl CheckVerdict {
    /// The verdict before any finding.
    fn new(class: NumericClass, states: &States, points: u32) -> CheckVerdict {
        CheckVerdict {
            class,
            points: points.max(1),
            seed: states.seed(),
            failure: None,
            undefined: 0,
            errors: None,
            deviation: None,
            states: 0,
            fewest: None,
            moved: None,
            domain: DomainVerdict::Same,
            distance: 0.0,
            promised: false,
        }
    }

    /// True when the claim holds.
    pub fn holds(&self) -> bool {
        self.failure.is_none()
    }

    /// True when numbers decided about every output.
    pub fn is_decided(&self) -> bool {
        self.fewest.as_ref().is_none_or(|(_, decided)| *decided > 0)
    }

    /// True when no part of the claim is open: every output was decided, and is
    /// defined wherever it was before.
    pub fn is_complete(&self) -> bool {
        self.is_decided() && !matches!(self.domain, DomainVerdict::Open(_))
    }
}

impl fmt::Display for CheckVerdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(failure) = &self.failure {
            return write!(formatter, "not {}: {failure}", self.class);
        }
        let CheckVerdict { class, states, .. } = self;
        if let Some(deviation) = self.deviation {
            write!(
                formatter,
                "{class}, outputs moved by at most {:.1e} of their array's largest element at {}",
                deviation.worst_normwise,
                counted(self.points, "state")
            )?;
            if self.promised {
                write!(formatter, ", as promised at {}", counted(*states, "state"))?;
            }
            return Ok(());
        }
        let points = counted(self.points, "point");
        let decided = self.fewest.as_ref().filter(|(_, decided)| decided < states);
        if let Some((output, 0)) = decided {
            return write!(
                formatter,
                "no verdict: numbers decide {output} at none of {states} states, though it is \
                 {class}, equal at {points} of two prime fields"
            );
        }
        let domain = match self.domain {
            DomainVerdict::Same => "",
            DomainVerdict::Wider(_) => " wherever the first is defined,",
            DomainVerdict::Open(_) => " where both are defined,",
        };
        write!(
            formatter,
            "{class}, equal{domain} at {points} of two prime fields and at {}",
            counted(*states, "state")
        )?;
        if let Some((output, decided)) = decided {
            write!(formatter, " ({output} at {decided} of them)")?;
        }
        write!(formatter, " within {:.1e}", self.distance)?;
        if let Some(moved) = self.moved {
            write!(formatter, ", constants rounded within {moved:.1e}")?;
        }
        match &self.domain {
            DomainVerdict::Same => Ok(()),
            DomainVerdict::Wider(condition) => {
                write!(formatter, "; the first also needs that {condition}")
            }
            DomainVerdict::Open(condition) => {
                write!(
                    formatter,
                    "; nothing shows that {condition} wherever the first is defined"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests;
