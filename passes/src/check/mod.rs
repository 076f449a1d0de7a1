//! The semantic check between two versions of a function.
//!
//! What a pass claims by its [`NumericClass`] is tested, not believed:
//!
//! - every class but *approximating*: all outputs are equal at random points
//!   of the prime field of 2⁶¹ − 1. Two rational functions that differ agree
//!   at a random point with probability at most `degree / 2⁶¹`, and degrees
//!   of real models stay below a few thousand: one point leaves a chance of
//!   error of some 10⁻¹⁵, and there is no tolerance that could hide a wrong
//!   term. Sine and cosine are points of the circle for *real-trig* and
//!   independent elements otherwise;
//!   An output that divides by zero at every point has no value in a field;
//!   as IEEE arithmetic may still end in a number (`1/(1/0)`), it is compared
//!   in double-double instead, with a tolerance;
//! - *exact*: all outputs are also bit-equal in binary64 and binary32 at
//!   random states, save that zeros of either sign are equal (a minus becomes
//!   `0 - x`) and that outputs on whose way something was infinite or NaN may
//!   become anything (`0*x` becomes `0`);
//! - *approximating*: nothing is demanded, but the distance between the
//!   versions is measured in double-double.
//!
//! Beside the verdict stands what the pass did to the rounding error of the
//! outputs, in binary32 and binary64 against double-double.
//!
//! The field check is one-sided: what it rejects differs as a function of
//! unknown `sin`, `cos` and `sqrt` (see [`robovec_ir::field`]); identities
//! that need more than their parity and the circle are rejected too.

mod constants;
mod failure;
mod field;
mod numeric;
mod pairing;

use crate::analysis::accuracy::{Measurement, Summary, measure};
use crate::class::NumericClass;
use crate::instances::Instances;
use crate::scene::Scene;
use failure::explain;
pub use failure::{Failure, FailureKind};
use field::Comparison;
use pairing::Pairs;
use robovec_ir::field::PrimeField;
use robovec_ir::format::Format;
use robovec_ir::states::States;
use robovec_ir::{Output, View};
use std::array;
use std::fmt;

/// What the check found.
#[derive(Clone, PartialEq, Debug)]
pub struct Verdict {
    /// What was claimed.
    pub class: NumericClass,
    /// How many points and states it was tested at.
    pub points: u32,
    /// Where they come from.
    pub seed: u64,
    /// The first output that breaks the claim; `None` when it holds.
    pub failure: Option<Failure>,
    /// Outputs that divide by zero at every point before: these were compared
    /// in double-double only, where that gives a number.
    pub undefined: u32,
    /// Rounding errors in binary32 and binary64; `None` after a failure,
    /// when comparing them means nothing.
    pub errors: Option<[ErrorChange; 2]>,
    /// How far an *approximating* pass moved the outputs.
    pub deviation: Option<Deviation>,
}

/// The rounding errors of a function before and after a pass.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ErrorChange {
    /// Before the pass.
    pub before: Summary,
    /// After it.
    pub after: Summary,
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

/// Checks what a pass of a class claims, between the version it took and the
/// one it gave, at a number of random points.
///
/// Costs about three nanoseconds per operation, version and point for the
/// field and ten for the rounding errors.
pub fn check(
    before: View<'_>,
    after: View<'_>,
    class: NumericClass,
    states: &States,
    points: u32,
) -> Verdict {
    let mut verdict = Verdict::new(class, states, points);
    match Pairs::new(before, after) {
        Ok(pairs) => judge(&pairs, states, &mut verdict),
        Err(unpaired) => verdict.failure = Some(unpaired.failure(before, after)),
    }
    if verdict.failure.is_none() {
        verdict.errors = Some(error_changes([before, after], states, verdict.points));
    }
    verdict
}

/// Checks a pass of a class that makes several instances of a function: each
/// of them must be the function before, whatever the inputs of the others.
/// The first instance that is not ends the check.
pub fn check_instances(
    before: View<'_>,
    after: View<'_>,
    instances: &Instances,
    class: NumericClass,
    states: &States,
    points: u32,
) -> Verdict {
    let mut verdict = Verdict::new(class, states, points);
    for instance in 1..=instances.count {
        match Pairs::instance(before, after, instances, instance) {
            Ok(pairs) => judge(&pairs, states, &mut verdict),
            Err(unpaired) => verdict.failure = Some(unpaired.failure(before, after)),
        }
        if verdict.failure.is_some() {
            return verdict;
        }
    }
    verdict.errors = Some(error_changes([before, after], states, verdict.points));
    verdict
}

/// A function made for a scene, with what it was made of.
#[derive(Clone, Copy)]
pub struct Specialised<'a> {
    /// The function before.
    pub before: View<'a>,
    /// The function after, in which numbers are still expressions.
    pub witness: View<'a>,
    /// The function after.
    pub after: View<'a>,
    /// What it was made for.
    pub scene: Option<&'a Scene>,
}

/// Checks what a pass of a class claims that makes a function for a scene:
/// outputs that the scene does not need may be gone, and inputs that it binds
/// have their numbers. The claim is about the witness; the function after must
/// be the witness with its constant expressions replaced by their values.
pub fn check_specialised(
    subject: Specialised<'_>,
    class: NumericClass,
    states: &States,
    points: u32,
) -> Verdict {
    let Specialised {
        before,
        witness,
        after,
        scene,
    } = subject;
    let mut verdict = Verdict::new(class, states, points);
    let empty = Scene::default();
    match Pairs::within(before, witness, scene.unwrap_or(&empty)) {
        Ok(pairs) => judge(&pairs, states, &mut verdict),
        Err(unpaired) => verdict.failure = Some(unpaired.failure(before, witness)),
    }
    if verdict.failure.is_none()
        && let Err(reason) = constants::compare(witness.function, after)
    {
        verdict.failure = Some(Failure::about(FailureKind::Constants { reason }, after));
    }
    if verdict.failure.is_none() {
        verdict.errors = Some(error_changes([before, after], states, verdict.points));
    }
    verdict
}

fn judge(pairs: &Pairs<'_>, states: &States, verdict: &mut Verdict) {
    let (points, seed) = (verdict.points, verdict.seed);
    if verdict.class == NumericClass::Approximating {
        verdict.deviation = Some(numeric::deviation(pairs, states, points));
    } else {
        let circle = verdict.class == NumericClass::RealTrig;
        match field::compare(pairs, circle, points, seed) {
            Comparison::Equal { undefined } => {
                verdict.undefined = undefined.len() as u32;
                let difference = numeric::first_distance(pairs, &undefined, states, points);
                let field = PrimeField { seed, circle };
                verdict.failure =
                    difference.map(|(output, kind)| explain(pairs, kind, output, &field));
            }
            Comparison::Different {
                output,
                field,
                before,
                after,
            } => {
                let kind = FailureKind::Field {
                    point: field.seed,
                    before,
                    after,
                };
                verdict.failure = Some(explain(pairs, kind, output, &field));
            }
        }
    }
    if verdict.failure.is_none()
        && verdict.class == NumericClass::Exact
        && let Some((output, kind)) = numeric::first_bit_difference(pairs, states, points)
    {
        let field = PrimeField {
            seed,
            circle: false,
        };
        verdict.failure = Some(explain(pairs, kind, output, &field));
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

impl Verdict {
    /// Before anything is found.
    fn new(class: NumericClass, states: &States, points: u32) -> Verdict {
        Verdict {
            class,
            points: points.max(1),
            seed: states.seed(),
            failure: None,
            undefined: 0,
            errors: None,
            deviation: None,
        }
    }

    /// True when the claim holds.
    pub fn holds(&self) -> bool {
        self.failure.is_none()
    }

    /// What broke the claim, for people.
    pub fn failure(&self) -> Option<String> {
        self.failure.as_ref().map(ToString::to_string)
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(failure) = &self.failure {
            return write!(formatter, "not {}: {failure}", self.class);
        }
        write!(formatter, "{} at {} points", self.class, self.points)?;
        if let Some(deviation) = self.deviation {
            write!(
                formatter,
                ", outputs moved by at most {:.1e} of their array's largest element",
                deviation.worst_normwise
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
