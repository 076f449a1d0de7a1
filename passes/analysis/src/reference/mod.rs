//! The exact outputs of a function, with a certificate.
//!
//! The reference for rounding errors must itself be certain. Three levels of
//! effort:
//!
//! - [`ReferenceEffort::DoubleDouble`]: about 106 bits and no proof; some fifty bits
//!   to spare over binary64 leave little doubt, and it is the fastest.
//! - [`ReferenceEffort::Certified`]: double-double with a bound of its error.
//!   Outputs whose ball holds a change from one binary64 number to the next
//!   are computed again in arbitrary precision, with twice the bits until
//!   one number is left ([Ziv's strategy](precise)). Outputs that are zero by
//!   an identity, which no precision would ever show, are recognised in the
//!   prime field.
//! - [`ReferenceEffort::Audit`]: everything in arbitrary precision, which shares no
//!   arithmetic with double-double.
//!
//! With the feature `mpfr`, `mpfr` evaluates a third time with another
//! library; the tests compare.
//!
//! **Invariant.** A function is evaluated over the real numbers: no operation
//! rounds, and literals and inputs are exactly their binary64 numbers.

#[cfg(feature = "mpfr")]
pub mod mpfr;
pub(crate) mod precise;
pub(crate) mod rounding;

use astro_float::Consts;
use robovec_ir::Function;
use robovec_ir::evaluate::evaluate;
use robovec_ir::plan::EvaluationPlan;
use robovec_num::ball::{self, Ball, Balls};
use robovec_num::double_double::{Double, DoubleDoubleLanes, DoubleLanes};
use robovec_num::field::{CircleField, Field, FieldPoint, Prime};
use std::array;
use std::fmt;
use std::str::FromStr;

/// States evaluated at a time.
pub const LANES: usize = 8;

/// The effort for the exact outputs.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum ReferenceEffort {
    /// Double-double, without a proof.
    #[default]
    DoubleDouble,
    /// Double-double with a bound, and arbitrary precision where the bound
    /// leaves a choice.
    Certified,
    /// Arbitrary precision for everything.
    Audit,
}

impl ReferenceEffort {
    /// Maximum number of operations of functions whose values are certified
    /// unasked; long chains of more take minutes to prove.
    const CERTIFIED_OPERATIONS: usize = 100_000;

    /// The effort that is reasonable for a function of this number of
    /// operations.
    pub fn of_size(operations: usize) -> ReferenceEffort {
        if operations <= ReferenceEffort::CERTIFIED_OPERATIONS {
            ReferenceEffort::Certified
        } else {
            ReferenceEffort::DoubleDouble
        }
    }
}

/// The evidence for an exact value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ExactEvidence {
    /// Double-double without a proof.
    Unproved,
    /// Double-double whose bound leaves one binary64 number.
    DoubleDouble,
    /// Number of bits, which leave one binary64 number.
    Precise(u32),
    /// Zero by an identity, or not distinguishable from zero.
    Zero,
    /// Not certain: not finite, or the bits that are tried at most were too
    /// few.
    Uncertain,
}

/// An exact output.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ExactOutput {
    /// The value; its upper half is the nearest binary64 number, proved
    /// unless `kind` states otherwise.
    pub value: Double,
    /// The largest distance of the real number from the value; infinite without
    /// a proof.
    pub bound: f64,
    /// The kind of evidence.
    pub kind: ExactEvidence,
}

impl ExactOutput {
    /// True when the upper half is proved to be the nearest binary64 number.
    pub fn is_certain(&self) -> bool {
        match self.kind {
            ExactEvidence::DoubleDouble | ExactEvidence::Precise(_) | ExactEvidence::Zero => true,
            ExactEvidence::Unproved | ExactEvidence::Uncertain => false,
        }
    }
}

/// Evaluates a function exactly, state after state.
pub struct ReferenceEvaluator<'a> {
    function: &'a Function,
    effort: ReferenceEffort,
    plan: EvaluationPlan,
    /// For each assignment whether it is zero in the prime field; found when
    /// first needed.
    zeros: Option<Vec<bool>>,
    /// Digits of pi for arbitrary precision, made when first needed.
    constants: Option<Consts>,
    balls: Vec<Ball<LANES>>,
    lanes: Vec<DoubleLanes<LANES>>,
}

impl<'a> ReferenceEvaluator<'a> {
    /// Makes a function ready.
    pub fn new(function: &'a Function, effort: ReferenceEffort) -> ReferenceEvaluator<'a> {
        ReferenceEvaluator {
            function,
            effort,
            plan: EvaluationPlan::new(function),
            zeros: None,
            constants: None,
            balls: Vec::new(),
            lanes: Vec::new(),
        }
    }

    /// The exact value of every assignment, in order, for each state.
    ///
    /// # Panics
    ///
    /// Panics when a state has not one number per input element.
    pub fn evaluate(&mut self, states: &[Vec<f64>]) -> Vec<Vec<ExactOutput>> {
        let mut results = Vec::with_capacity(states.len());
        for batch in states.chunks(LANES) {
            match self.effort {
                ReferenceEffort::DoubleDouble => self.unproved(batch, &mut results),
                ReferenceEffort::Certified => self.certified(batch, &mut results),
                ReferenceEffort::Audit => {
                    let all: Vec<usize> = (0..self.function.assignments.len()).collect();
                    for inputs in batch {
                        results.push(self.precise(inputs, &all));
                    }
                }
            }
        }
        results
    }

    /// The exact values of some assignments, counted from 0 in ascending
    /// order, in arbitrary precision; not finite where there is none.
    pub fn evaluate_places(&mut self, inputs: &[f64], places: &[usize]) -> Vec<ExactOutput> {
        debug_assert!(places.is_sorted(), "places ascend");
        self.precise(inputs, places)
    }

    fn unproved(&mut self, batch: &[Vec<f64>], results: &mut Vec<Vec<ExactOutput>>) {
        let inputs = gather(batch, DoubleLanes::new);
        let outputs = self
            .plan
            .run(&DoubleDoubleLanes::<LANES>, &inputs, &mut self.lanes);
        for lane in 0..batch.len() {
            let exact = |number: &DoubleLanes<LANES>| ExactOutput {
                value: number.lane(lane),
                bound: f64::INFINITY,
                kind: ExactEvidence::Unproved,
            };
            results.push(outputs.iter().map(exact).collect());
        }
    }

    fn certified(&mut self, batch: &[Vec<f64>], results: &mut Vec<Vec<ExactOutput>>) {
        let inputs = gather(batch, Ball::exact);
        let outputs = self.plan.run(&Balls::<LANES>, &inputs, &mut self.balls);
        for (lane, inputs) in batch.iter().enumerate() {
            let judge = |ball: &Ball<LANES>| certify(ball.value.lane(lane), ball.radius[lane]);
            let mut exact: Vec<ExactOutput> = outputs.iter().map(judge).collect();
            let open = self.uncertain(&mut exact);
            if !open.is_empty() {
                let precise = self.precise(inputs, &open);
                for (&place, value) in open.iter().zip(precise) {
                    exact[place] = value;
                }
            }
            results.push(exact);
        }
    }

    /// The assignments that must be computed again; those that are zero by an
    /// identity are set to zero.
    fn uncertain(&mut self, exact: &mut [ExactOutput]) -> Vec<usize> {
        let mut open = Vec::new();
        for (place, value) in exact.iter_mut().enumerate() {
            if value.is_certain() {
                continue;
            }
            // A constant may vanish in both fields by accident, so that their
            // word alone is not enough.
            let possible = value.value.high.abs() <= value.bound;
            let function = self.function;
            let zeros = self.zeros.get_or_insert_with(|| zeros(function));
            if possible && zeros[place] {
                *value = ExactOutput {
                    value: Double::from(0.0),
                    bound: 0.0,
                    kind: ExactEvidence::Zero,
                };
            } else {
                open.push(place);
            }
        }
        open
    }

    fn precise(&mut self, inputs: &[f64], places: &[usize]) -> Vec<ExactOutput> {
        if self.constants.is_none() {
            self.constants = Consts::new().ok();
        }
        match &mut self.constants {
            Some(constants) => {
                let zeros = self.zeros.get_or_insert_with(|| zeros(self.function));
                precise::evaluate(self.function, inputs, places, zeros, constants)
            }
            // No memory for the digits of pi.
            None => vec![
                ExactOutput {
                    value: Double::from(f64::NAN),
                    bound: f64::INFINITY,
                    kind: ExactEvidence::Uncertain,
                };
                places.len()
            ],
        }
    }
}

/// The inputs of all lanes; lanes without a state repeat the first one.
fn gather<T>(batch: &[Vec<f64>], make: impl Fn([f64; LANES]) -> T) -> Vec<T> {
    let Some(first) = batch.first() else {
        return Vec::new();
    };
    (0..first.len())
        .map(|index| {
            make(array::from_fn(|lane| {
                batch.get(lane).map_or(first[index], |state| state[index])
            }))
        })
        .collect()
}

/// For each assignment whether it is zero at a random point of two prime
/// fields.
fn zeros(function: &Function) -> Vec<bool> {
    let mut zeros = vec![true; function.assignments.len()];
    for prime in Prime::pair(1) {
        let field = CircleField::at(prime, FieldPoint { seed: 2 });
        let point = field.point(function.input_len());
        let values = evaluate(function, &field, &point);
        for (zero, value) in zeros.iter_mut().zip(values) {
            *zero &= value.value == 0;
        }
    }
    zeros
}

/// Judges a double-double number with the radius of its error.
fn certify(value: Double, radius: f64) -> ExactOutput {
    let radius = radius * ball::SLACK;
    // Half the distance to the nearer neighbour; a power of two has its
    // lower neighbour at half the distance of the upper one.
    let size = value.high.abs();
    let half = (size - size.next_down()) / 2.0;
    let certain = if value.high == 0.0 {
        radius == 0.0
    } else {
        value.low.abs() + radius < half
    };
    ExactOutput {
        value,
        bound: if radius.is_nan() {
            f64::INFINITY
        } else {
            radius
        },
        kind: if certain && value.high.is_finite() {
            ExactEvidence::DoubleDouble
        } else {
            ExactEvidence::Uncertain
        },
    }
}

impl fmt::Display for ReferenceEffort {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            ReferenceEffort::DoubleDouble => "double-double",
            ReferenceEffort::Certified => "certified",
            ReferenceEffort::Audit => "audit",
        })
    }
}

impl FromStr for ReferenceEffort {
    type Err = String;

    fn from_str(text: &str) -> Result<ReferenceEffort, String> {
        let all = [
            ReferenceEffort::DoubleDouble,
            ReferenceEffort::Certified,
            ReferenceEffort::Audit,
        ];
        let found = all.into_iter().find(|effort| effort.to_string() == text);
        found.ok_or_else(|| "expected double-double, certified or audit".to_owned())
    }
}

#[cfg(test)]
mod tests;
