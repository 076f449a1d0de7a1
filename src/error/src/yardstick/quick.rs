//! Errors of a program at many states, as fast as a search needs them.
//!
//! The exact results are those of binary64 for formats that are much narrower,
//! else of double-double. Results are not kept; a caller that needs them beyond
//! doubt measures the states of a search again by a [`Yardstick`].

use super::{ExactPlace, LANES, Unmeasurable, Yardstick, distance, gathered, quotient, results};
use robovec_framework::scene::Allowed;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::{Format, View};
use robovec_num::arithmetic::Binary64;
use robovec_num::batch::Batch;
use robovec_num::double_double::{Double, DoubleDoubleLanes, DoubleLanes};
use robovec_num::soft_float::{FormatArithmetic, FormatLanes};

/// Maximum number of bits of a format whose rounding errors are at least four
/// million times those of binary64.
const NARROW_BITS: u32 = 30;

/// A program in a format beside the function that it computes.
pub struct QuickYardstick<'a> {
    reference: EvaluationPlan,
    is_narrow: bool,
    program: View<'a>,
    format: Format,
    /// `None` for a program that fixes how its values are computed.
    plan: Option<EvaluationPlan>,
    inputs: Vec<usize>,
    rows: Vec<ExactPlace>,
    allowed: Allowed,
}

/// Memory of a [`QuickYardstick`], reused from one run to the next.
#[derive(Default, Debug)]
pub struct QuickMemory {
    narrow: Vec<[f64; LANES]>,
    wide: Vec<DoubleLanes<LANES>>,
}

impl<'a> QuickYardstick<'a> {
    /// Prepares a program; `allowed` belongs to it.
    ///
    /// # Errors
    ///
    /// See [`Unmeasurable`].
    pub fn new(
        function: View<'_>,
        (program, format): (View<'a>, Format),
        allowed: Allowed,
    ) -> Result<QuickYardstick<'a>, Unmeasurable> {
        let names = Yardstick::at(function, Vec::new());
        let fixed =
            program.function.formats.is_some() || program.function.trigonometry_unit().is_some();
        let bits = match format {
            Format::Float(float) => float.mantissa,
            Format::Fixed(fixed) => fixed.integer + fixed.fraction,
        };
        Ok(QuickYardstick {
            reference: EvaluationPlan::new(function.function),
            is_narrow: !fixed && bits <= NARROW_BITS,
            program,
            format,
            plan: (!fixed).then(|| EvaluationPlan::new(program.function)),
            inputs: names.input_places(program)?,
            rows: names.rows(program)?,
            allowed,
        })
    }

    /// Number of outputs of the program.
    pub fn outputs(&self) -> usize {
        self.rows.len()
    }

    /// Number of states that take this number of operations.
    pub fn states_of(&self, operations: u64) -> u64 {
        // An operation in double-double takes five times as long as others.
        let weight = if self.is_narrow { 1 } else { 5 };
        let program = self.plan.as_ref().unwrap_or(&self.reference);
        operations / (weight * self.reference.len() + program.len() + 1) as u64
    }

    /// For each output of the program, in the order of its assignments, its
    /// ratio of the error to the allowed one in each of the states, of which
    /// there are 1 to [`LANES`]; further lanes repeat the first state.
    pub fn shares(&self, states: &[Vec<f64>], memory: &mut QuickMemory) -> Vec<[f64; LANES]> {
        let inputs = gathered(states, |number| number);
        let exact: Vec<DoubleLanes<LANES>> = if self.is_narrow {
            let lanes = Batch([Binary64; LANES]);
            let results = self.reference.run(&lanes, &inputs, &mut memory.narrow);
            results.into_iter().map(DoubleLanes::new).collect()
        } else {
            let inputs: Vec<_> = inputs.into_iter().map(DoubleLanes::new).collect();
            self.reference
                .run(&DoubleDoubleLanes::<LANES>, &inputs, &mut memory.wide)
        };
        let computed = self.computed(states, &mut memory.narrow);
        let mut shares = vec![[0.0; LANES]; self.rows.len()];
        for lane in 0..LANES {
            let of = |row: &ExactPlace| {
                let place = row.exact.map(|place| exact[place].lane(lane));
                place.unwrap_or(Double::from(0.0))
            };
            let exact: Vec<Double> = self.rows.iter().map(of).collect();
            let values: Vec<f64> = exact.iter().map(|value| value.high).collect();
            let allowed = self.allowed.of(&values);
            for (output, share) in shares.iter_mut().enumerate() {
                // Nothing is known of a state without an exact result.
                if values[output].is_finite() {
                    let error = distance(exact[output], computed[output][lane]);
                    share[lane] = quotient(error, allowed[output]);
                }
            }
        }
        shares
    }

    /// The outputs of the program.
    fn computed(&self, states: &[Vec<f64>], memory: &mut Vec<[f64; LANES]>) -> Vec<[f64; LANES]> {
        let pick = |state: &Vec<f64>| self.inputs.iter().map(|&place| state[place]).collect();
        let states: Vec<Vec<f64>> = states.iter().map(pick).collect();
        let Some(plan) = &self.plan else {
            let rows = results(self.program, self.format, &states);
            let outputs = 0..self.rows.len();
            return outputs
                .map(|output| {
                    std::array::from_fn(|lane| rows.get(lane).unwrap_or(&rows[0])[output])
                })
                .collect();
        };
        let single = FormatArithmetic::new(self.format);
        let inputs = gathered(&states, |number| single.convert(number));
        plan.run(&FormatLanes::<LANES>(single), &inputs, memory)
    }
}
