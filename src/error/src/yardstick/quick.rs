//! Errors of a program at many states, as fast as a search needs them.
//!
//! The exact results are those of binary64 for formats that are much narrower,
//! else of double-double. Results are not kept; a search measures its states
//! again by a [`Yardstick`], or by [`QuickYardstick::exactly`].

use super::{ExactPlace, LANES, Unmeasurable, Yardstick, distance, gathered, quotient, results};
use robovec_analysis::interval::{GivenData, between, exact_literal};
use robovec_framework::scene::Allowed;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::{Format, View};
use robovec_num::arithmetic::Binary64;
use robovec_num::batch::Batch;
use robovec_num::double_double::{Double, DoubleDoubleLanes, DoubleLanes};
use robovec_num::interval::Interval;
use robovec_num::random::{mix, unit};
use robovec_num::soft_float::{FormatArithmetic, FormatLanes};
use robovec_num::trigonometry::host::TrigonometricUnit;

/// Maximum number of bits of a format whose rounding errors are at least four
/// million times those of binary64.
const NARROW_BITS: u32 = 30;

/// A program in a format beside the function that it computes.
pub struct QuickYardstick<'a> {
    reference: EvaluationPlan,
    is_narrow: bool,
    pub(crate) program: View<'a>,
    pub(crate) format: Format,
    /// `None` for a program that fixes how its values are computed.
    plan: Option<EvaluationPlan>,
    /// The unit for sines and cosines that the program names, with its plan.
    unit: Option<(TrigonometricUnit, EvaluationPlan)>,
    /// For every input of the program its place in a state.
    pub(crate) inputs: Vec<usize>,
    rows: Vec<ExactPlace>,
    /// `None` where errors are absolute.
    allowed: Option<Allowed>,
    /// Numbers of the literals in exact results.
    literals: Vec<Double>,
    /// Kind and ranges of inputs, where the function is the program itself.
    own: Option<(GivenData, Vec<Interval>)>,
}

/// Memory of a [`QuickYardstick`], reused from one run to the next.
#[derive(Default, Debug)]
pub struct QuickMemory {
    narrow: Vec<[f64; LANES]>,
    wide: Vec<DoubleLanes<LANES>>,
}

impl<'a> QuickYardstick<'a> {
    /// Prepares a program; errors are ratios to `allowed`, which belongs to it.
    pub fn new(
        function: View<'_>,
        program: (View<'a>, Format),
        allowed: Allowed,
    ) -> Result<QuickYardstick<'a>, Unmeasurable> {
        let mut yardstick = QuickYardstick::of(function, program)?;
        yardstick.allowed = Some(allowed);
        Ok(yardstick)
    }

    /// Prepares a program whose absolute errors are those of rounding alone:
    /// of operations, and of inputs and literals that are real numbers. `ranges`
    /// has one for every input element.
    pub fn own(
        (program, format): (View<'a>, Format),
        data: GivenData,
        ranges: &[Interval],
    ) -> QuickYardstick<'a> {
        let yardstick = QuickYardstick::of(program, (program, format));
        let mut yardstick = yardstick.expect("a program has its own inputs and outputs");
        let literals = yardstick.reference.literals().iter();
        yardstick.literals = literals.map(|&one| exact_literal(one, data)).collect();
        yardstick.own = Some((data, ranges.to_vec()));
        yardstick
    }

    fn of(
        function: View<'_>,
        (program, format): (View<'a>, Format),
    ) -> Result<QuickYardstick<'a>, Unmeasurable> {
        let reference = EvaluationPlan::new(function.function);
        let literals = reference.literals().iter();
        let names = Yardstick::at(function, Vec::new());
        let is_mixed = program.function.formats.is_some();
        let unit = program
            .function
            .trigonometry_unit()
            .filter(|_| !is_mixed)
            .map(|unit| {
                let unit = unit.expect("the verifier accepts only names of units");
                (unit, EvaluationPlan::new(program.function))
            });
        let fixed = is_mixed || unit.is_some();
        let bits = match format {
            Format::Float(float) => float.mantissa,
            Format::Fixed(fixed) => fixed.integer + fixed.fraction,
        };
        Ok(QuickYardstick {
            literals: literals.copied().map(Double::from).collect(),
            reference,
            is_narrow: !fixed && bits <= NARROW_BITS,
            program,
            format,
            plan: (!fixed).then(|| EvaluationPlan::new(program.function)),
            unit,
            inputs: names.input_places(program)?,
            rows: names.rows(program)?,
            allowed: None,
            own: None,
        })
    }

    /// The same with exact results in double-double, also for narrow formats.
    pub fn exactly(self) -> QuickYardstick<'a> {
        QuickYardstick {
            is_narrow: false,
            ..self
        }
    }

    /// True when inputs are numbers of the format.
    pub(crate) fn is_held(&self) -> bool {
        matches!(self.own, Some((GivenData::Held, _)))
    }

    /// Allowed errors of outputs with these values; 1 where they are absolute.
    pub(crate) fn allowed(&self, values: &[f64]) -> Vec<f64> {
        match &self.allowed {
            Some(allowed) => allowed.of(values),
            None => vec![1.0; values.len()],
        }
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
        let exact = self.exact(states, memory);
        let computed = self.computed(states, &mut memory.narrow);
        let mut shares = vec![[0.0; LANES]; self.rows.len()];
        for lane in 0..LANES {
            let of = |row: &ExactPlace| {
                let place = row.exact.map(|place| exact[place].lane(lane));
                place.unwrap_or(Double::from(0.0))
            };
            let exact: Vec<Double> = self.rows.iter().map(of).collect();
            let values: Vec<f64> = exact.iter().map(|value| value.high).collect();
            let allowed = self.allowed(&values);
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

    /// The exact results of the function.
    fn exact(&self, states: &[Vec<f64>], memory: &mut QuickMemory) -> Vec<DoubleLanes<LANES>> {
        let literals = self.literals.iter();
        if self.is_narrow {
            let lanes = Batch([Binary64; LANES]);
            let single = FormatArithmetic::new(self.format);
            let held = self.is_held();
            let given = |number| if held { single.convert(number) } else { number };
            let inputs = gathered(states, given);
            let literals = literals.map(|literal| [literal.high; LANES]);
            let plan = &self.reference;
            let results = plan.run_numbers(&lanes, &inputs, literals, &mut memory.narrow);
            return results.into_iter().map(DoubleLanes::new).collect();
        }
        let given = |place: usize| {
            let number = |lane| states.get(lane).unwrap_or(&states[0])[place];
            DoubleLanes::from_lanes(|lane| self.exact_input(place, number(lane)))
        };
        let inputs: Vec<_> = (0..states[0].len()).map(given).collect();
        let literals = literals.map(|&literal| DoubleLanes::from_lanes(|_| literal));
        let lanes = DoubleDoubleLanes::<LANES>;
        self.reference
            .run_numbers(&lanes, &inputs, literals, &mut memory.wide)
    }

    /// The exact number of an input that is given as a binary64 number.
    fn exact_input(&self, place: usize, number: f64) -> Double {
        match &self.own {
            Some((GivenData::Held, _)) => {
                Double::from(FormatArithmetic::new(self.format).convert(number))
            }
            // The rest beyond binary64 belongs to the number, so that what a
            // search finds is found again.
            Some((GivenData::Real, ranges)) => {
                let end = unit(mix(number.to_bits())).round();
                between(self.format, number, ranges[place], end)
            }
            None => Double::from(number),
        }
    }

    fn computed(&self, states: &[Vec<f64>], memory: &mut Vec<[f64; LANES]>) -> Vec<[f64; LANES]> {
        let pick = |state: &Vec<f64>| self.inputs.iter().map(|&place| state[place]).collect();
        let states: Vec<Vec<f64>> = states.iter().map(pick).collect();
        let single = FormatArithmetic::new(self.format);
        if let Some((unit, plan)) = &self.unit {
            let inputs = gathered(&states, |number| single.convert(number));
            return plan.run(&Batch([unit.within(single); LANES]), &inputs, memory);
        }
        let Some(plan) = &self.plan else {
            let rows = results(self.program, self.format, &states);
            let outputs = 0..self.rows.len();
            return outputs
                .map(|output| {
                    std::array::from_fn(|lane| rows.get(lane).unwrap_or(&rows[0])[output])
                })
                .collect();
        };
        let inputs = gathered(&states, |number| single.convert(number));
        plan.run(&FormatLanes::<LANES>(single), &inputs, memory)
    }
}
