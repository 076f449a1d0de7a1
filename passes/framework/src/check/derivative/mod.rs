//! The check of derivatives against dual numbers.
//!
//! The function before is evaluated once along a random direction `v` of the
//! inputs that it is differentiated by, the program after once. Then for every
//! output `F`, with its derivative `F'` along `v`:
//!
//! - of a Jacobian `J`, `F' = Σ J_k v_k` over the columns;
//! - of a direction, `F'` is the output, `v` being an input of the program;
//! - of a gradient `g` for weights `w`, `Σ w F' = Σ g_k v_k`: one equation for
//!   all outputs.
//!
//! In a prime field both sides are polynomials in the point and in `v`, so a
//! wrong element is met with the probability that holds for other passes. In
//! numbers both sides carry a bound of their error. The element to blame is
//! found afterwards, along the directions of the single inputs.

mod equations;

use super::failure::{Failure, FailureKind, Values};
use super::numbers::{LANES, MAX_PRECISE, every_scale, is_lost};
use super::pairing::{Unpaired, described, primes, same_arrays, sizes};
use super::states::{self, StatePlace, StateScale};
use super::{CheckVerdict, nth_seed};
use crate::differentiation::{DerivativeResult, Differentiation};
use equations::{DerivativeEquation, DerivativePoint, Factor, equations};
use robovec_analysis::slice::slice;
use robovec_ir::evaluate::evaluate;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Output, View};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};
use robovec_num::dual::{Dual, Duals};
use robovec_num::field::{Field, FieldPoint, Prime, PrimeField};
use robovec_num::random::mix;
use std::array;

/// The function before, the program after, and the conditions of the check.
struct DerivativeCheck<'a> {
    before: View<'a>,
    after: View<'a>,
    result: DerivativeResult,
    /// The inputs before by which it is differentiated.
    columns: Vec<u32>,
    /// The number of outputs that are differentiated.
    rows: usize,
    equations: Vec<DerivativeEquation>,
    /// Of the constants of both.
    sizes: Vec<f64>,
}

/// Judges a program for a derivative.
pub(super) fn judge(
    before: View<'_>,
    after: View<'_>,
    differentiation: &Differentiation,
    source: &States,
    verdict: &mut CheckVerdict,
) {
    let check = match DerivativeCheck::new(before, after, differentiation) {
        Ok(check) => check,
        Err(unpaired) => {
            verdict.failure = Some(unpaired.failure(after, after));
            return;
        }
    };
    verdict.failure = match check.in_fields(verdict) {
        // Numbers tell more than residues, where they show the difference.
        Some((equation, field)) => {
            let shown = check.in_numbers(source, verdict, Some(equation));
            shown.or_else(|| Some(check.field_failure(equation, &field)))
        }
        None => check.in_numbers(source, verdict, None),
    };
}

impl<'a> DerivativeCheck<'a> {
    fn new(
        before: View<'a>,
        after: View<'a>,
        differentiation: &Differentiation,
    ) -> Result<DerivativeCheck<'a>, Unpaired> {
        let arrays = differentiation.arrays(before).map_err(|error| Unpaired {
            output: None,
            reason: error.to_string(),
        })?;
        let function = after.function;
        for (what, old, new, found) in [
            (
                "input",
                before.function.inputs(),
                &arrays.inputs,
                function.inputs(),
            ),
            (
                "output",
                arrays.kept.as_slice(),
                &arrays.outputs,
                function.outputs(),
            ),
        ] {
            let mut wanted = described(before, old);
            wanted.extend(new.iter().cloned());
            let found = described(after, found);
            same_arrays(what, &wanted, &found, "is not that of the derivative")?;
        }
        Ok(DerivativeCheck {
            equations: equations(before, after, differentiation.result, &arrays)?,
            result: differentiation.result,
            columns: arrays.columns(),
            rows: arrays.rows().len(),
            sizes: sizes([before.function, after.function]),
            before,
            after,
        })
    }

    /// The dual numbers of the inputs before, along the direction of a sample
    /// or along one of its columns alone.
    fn duals<N: Copy>(
        &self,
        sample: &DerivativePoint<N>,
        only: Option<(usize, N)>,
    ) -> Vec<Dual<N>> {
        let mut duals: Vec<Dual<N>> = sample.inputs.iter().copied().map(Dual::fixed).collect();
        for (column, &input) in self.columns.iter().enumerate() {
            duals[input as usize].slope = match only {
                None => Some(sample.direction[column]),
                Some((wanted, slope)) => (wanted == column).then_some(slope),
            };
        }
        duals
    }

    fn inputs<N: Copy>(&self, sample: &DerivativePoint<N>) -> Vec<N> {
        let more = match self.result {
            DerivativeResult::Jacobian => &[],
            DerivativeResult::Direction => sample.direction.as_slice(),
            DerivativeResult::Gradient => sample.weights.as_slice(),
        };
        [sample.inputs.as_slice(), more].concat()
    }

    /// Compares in two prime fields, until both sides of every equation were
    /// defined at the requested number of points; returns the equation that
    /// does not hold, and the point.
    fn in_fields(&self, verdict: &mut CheckVerdict) -> Option<(usize, PrimeField)> {
        /// Points beyond those requested when some are undefined.
        const EXTRA_POINTS: u32 = 4;
        let functions = [self.before.function, self.after.function];
        let primes = primes(functions, &self.sizes, verdict.seed);
        let mut defined = vec![[0u32; 2]; self.equations.len()];
        for point in 0..verdict.points.saturating_add(EXTRA_POINTS) {
            let enough = |[_, both]: &[u32; 2]| *both >= 2 * verdict.points;
            if point > 0 && defined.iter().all(enough) {
                break;
            }
            for prime in primes {
                let seed = nth_seed(verdict.seed, point);
                let field = PrimeField::at(prime, FieldPoint { seed });
                if let Some(index) = self.at_point(&field, &mut defined) {
                    return Some((index, field));
                }
            }
        }
        // What could never be compared was undefined before, or is a failure.
        let seed = verdict.seed;
        for (index, [known, both]) in defined.into_iter().enumerate() {
            match (known, both) {
                (0, 0) => {
                    verdict.undefined += 1;
                    let found = self.in_single_columns(index, primes, verdict);
                    if found.is_some() {
                        return found;
                    }
                }
                (_, 0) => {
                    return Some((index, PrimeField::at(primes[0], FieldPoint { seed })));
                }
                _ => {}
            }
        }
        None
    }

    /// A sum is undefined with one of its terms, where the others may have a
    /// value along their own columns: returns one of them that differs.
    fn in_single_columns(
        &self,
        index: usize,
        primes: [Prime; 2],
        verdict: &CheckVerdict,
    ) -> Option<(usize, PrimeField)> {
        let points = (0..verdict.points).flat_map(|point| primes.map(|prime| (point, prime)));
        let mut fields = points.map(|(point, prime)| {
            let seed = nth_seed(verdict.seed, point);
            PrimeField::at(prime, FieldPoint { seed })
        });
        fields.find_map(|field| {
            let equation = &self.equations[index];
            let sample = self.field_sample(&field);
            let after = evaluate(self.after.function, &field, &self.inputs(&sample));
            let differs = |left: &u64, right: &u64| {
                let sides = [left, right].map(|side| PrimeField::is_undefined(*side));
                sides == [false, false] && left != right
            };
            let found = self.first_element(&field, equation, &sample, &after, differs);
            found.map(|_| (index, field))
        })
    }

    /// The first equation that does not hold at a point; counts, by equation,
    /// the points at which the left side and both sides were defined.
    fn at_point(&self, field: &PrimeField, defined: &mut [[u32; 2]]) -> Option<usize> {
        assert_eq!(
            defined.len(),
            self.equations.len(),
            "every equation is counted"
        );
        let sample = self.field_sample(field);
        let duals = self.duals(&sample, None);
        let before = evaluate(self.before.function, &Duals(*field), &duals);
        let after = evaluate(self.after.function, field, &self.inputs(&sample));
        let mut equations = self.equations.iter().zip(defined);
        equations.position(|(equation, defined)| {
            let [left, right] = equation.sides(field, &before, &after, &sample);
            let [known, both] = [left, right].map(|side| !PrimeField::is_undefined(side));
            defined[0] += u32::from(known);
            defined[1] += u32::from(known && both);
            known && both && left != right
        })
    }

    fn field_sample(&self, field: &PrimeField) -> DerivativePoint<u64> {
        let inputs = self.before.function.input_len();
        let columns = self.columns.len();
        let drawn = |first: usize, count: usize| {
            let places = first..first + count;
            places.map(|index| field.input(index as u64)).collect()
        };
        DerivativePoint {
            inputs: drawn(0, inputs),
            direction: drawn(inputs, columns),
            weights: drawn(inputs + columns, self.rows),
        }
    }

    /// Compares in double-double with bounds, one equation or all.
    fn in_numbers(
        &self,
        source: &States,
        verdict: &mut CheckVerdict,
        only: Option<usize>,
    ) -> Option<Failure> {
        let before = EvaluationPlan::new(self.before.function);
        let after = EvaluationPlan::new(self.after.function);
        let (mut old_memory, mut new_memory) = (Vec::new(), Vec::new());
        let mut precise = MAX_PRECISE;
        for round in 0..verdict.points {
            let places = every_scale(round);
            let sample = self.sample(source, places);
            let duals = self.duals(&sample, None);
            let old = before.run(&Duals(Balls::<LANES>), &duals, &mut old_memory);
            let new = after.run(&Balls::<LANES>, &self.inputs(&sample), &mut new_memory);
            let mut norms = vec![[(0.0f64, 0.0f64); LANES]; self.before.function.outputs().len()];
            for (index, equation) in self.equations.iter().enumerate() {
                if only.is_some_and(|only| only != index) {
                    continue;
                }
                let [left, right] = equation.sides(&Balls::<LANES>, &old, &new, &sample);
                for (lane, &place) in places.iter().enumerate() {
                    let differs = match (left.is_known(lane), right.is_known(lane)) {
                        (true, true) => !left.touches(&right, lane),
                        (true, false) if precise > 0 => {
                            precise -= 1;
                            self.is_lost(equation, &sample, &left, &new, lane)
                        }
                        _ => continue,
                    };
                    if differs {
                        let sides = [&left, &right];
                        return Some(self.located(equation, &sample, (lane, place), sides, &new));
                    }
                    if !right.is_known(lane) {
                        continue;
                    }
                    let (apart, size) = &mut norms[equation.array][lane];
                    *apart = apart.max(left.distance(&right, lane));
                    *size = size.max(left.value.high[lane].abs());
                }
            }
            verdict.states += LANES as u32;
            let apart = norms
                .as_flattened()
                .iter()
                .filter(|(apart, _)| *apart > 0.0);
            let distance = apart.map(|(apart, size)| apart / size).fold(0.0, f64::max);
            verdict.distance = verdict.distance.max(distance);
        }
        None
    }

    /// Tests whether an output on the right of an equation is NaN where the
    /// exact derivative is a number within the range of binary64.
    fn is_lost(
        &self,
        equation: &DerivativeEquation,
        sample: &DerivativePoint<Ball<LANES>>,
        left: &Ball<LANES>,
        after: &[Ball<LANES>],
        lane: usize,
    ) -> bool {
        let unknown = equation.after.iter();
        let unknown = unknown.filter(|&&(_, place)| !after[place].is_known(lane));
        let inputs = self.inputs(sample);
        let inputs: Vec<f64> = inputs.iter().map(|ball| ball.value.high[lane]).collect();
        unknown.take(MAX_PRECISE as usize).any(|&(factor, place)| {
            let wanted = match factor {
                Factor::Direction(column) => self.along(&Balls, equation, sample, column),
                Factor::One | Factor::Weight(_) => *left,
            };
            wanted.is_known(lane)
                && wanted.reach(lane).is_finite()
                && is_lost(self.after.function, &[place], &inputs)
        })
    }

    /// The left side of an equation along one column alone.
    fn along<A>(
        &self,
        arithmetic: &A,
        equation: &DerivativeEquation,
        sample: &DerivativePoint<A::Number>,
        column: usize,
    ) -> A::Number
    where
        A: Arithmetic + Clone,
    {
        let inputs = self.duals(sample, Some((column, arithmetic.literal(1.0))));
        let before = evaluate(self.before.function, &Duals(arithmetic.clone()), &inputs);
        equation.left(arithmetic, &before, sample)
    }

    /// One state of every scale, with directions and weights within ±2.
    fn sample(&self, source: &States, places: [StatePlace; LANES]) -> DerivativePoint<Ball<LANES>> {
        let count = self.before.function.input_len();
        let inputs = places.map(|place| match place.scale {
            StateScale::Usual => source.draw(self.before, 2 * place.number),
            StateScale::UsualAgain => source.draw(self.before, 2 * place.number + 1),
            _ => states::draw(&self.sizes, source.seed(), place, count),
        });
        let near = |salt: u64, count: usize| {
            let seed = mix(source.seed() ^ salt);
            places.map(|place| {
                let number = place.number * LANES as u32 + place.scale as u32;
                let scale = StateScale::Near;
                states::draw(&[], seed, StatePlace { scale, number }, count)
            })
        };
        let balls = |lanes: [Vec<f64>; LANES]| -> Vec<Ball<LANES>> {
            (0..lanes[0].len())
                .map(|index| Ball::exact(array::from_fn(|lane| lanes[lane][index])))
                .collect()
        };
        DerivativePoint {
            inputs: balls(inputs),
            direction: balls(near(1, self.columns.len())),
            weights: balls(near(2, self.rows)),
        }
    }

    /// The failure of an equation at one state: the first of its elements
    /// that differs along the direction of its input alone, or the equation
    /// as a whole.
    fn located(
        &self,
        equation: &DerivativeEquation,
        sample: &DerivativePoint<Ball<LANES>>,
        (lane, state): (usize, StatePlace),
        sides: [&Ball<LANES>; 2],
        after: &[Ball<LANES>],
    ) -> Failure {
        let values = |[left, right]: [&Ball<LANES>; 2]| Values {
            state,
            before: left.value.high[lane],
            after: right.value.high[lane],
            allowed: left.radius[lane] + right.radius[lane],
        };
        let apart = |[left, right]: [&Ball<LANES>; 2]| {
            left.is_known(lane) && (!right.is_known(lane) || !left.touches(right, lane))
        };
        let arithmetic = Balls::<LANES>;
        let found = self.first_element(&arithmetic, equation, sample, after, |left, right| {
            apart([left, right])
        });
        match found {
            Some((element, [left, right])) => {
                let kind = FailureKind::Derivative(values([&left, &right]));
                self.failure(equation, element, kind)
            }
            None => {
                let kind = if equation.is_value {
                    FailureKind::Numbers(values(sides))
                } else {
                    FailureKind::Derivative(values(sides))
                };
                self.failure(equation, equation.element, kind)
            }
        }
    }

    /// The first element of an equation that differs along its own column, by
    /// its place among the outputs after, with both numbers.
    fn first_element<A>(
        &self,
        arithmetic: &A,
        equation: &DerivativeEquation,
        sample: &DerivativePoint<A::Number>,
        after: &[A::Number],
        differs: impl Fn(&A::Number, &A::Number) -> bool,
    ) -> Option<(u32, [A::Number; 2])>
    where
        A: Arithmetic + Clone,
    {
        let elements = equation.elements.iter().enumerate();
        elements.into_iter().find_map(|(column, &element)| {
            let left = self.along(arithmetic, equation, sample, column);
            let own = |(factor, _): &&(Factor, usize)| *factor == Factor::Direction(column);
            let set = equation.after.iter().find(own);
            let right = match set {
                Some(&(_, place)) => after[place],
                None => arithmetic.literal(0.0),
            };
            differs(&left, &right).then_some((element, [left, right]))
        })
    }

    /// The failure of an equation that only residues show.
    fn field_failure(&self, index: usize, field: &PrimeField) -> Failure {
        let equation = &self.equations[index];
        let sample = self.field_sample(field);
        let duals = self.duals(&sample, None);
        let before = evaluate(self.before.function, &Duals(*field), &duals);
        let after = evaluate(self.after.function, field, &self.inputs(&sample));
        let sides = equation.sides(field, &before, &after, &sample);
        let found = self.first_element(field, equation, &sample, &after, |left, right| {
            !PrimeField::is_undefined(*left) && left != right
        });
        let (element, sides) = found.unwrap_or((equation.element, sides));
        let [before, after] = sides.map(|side| field.residue(side));
        let kind = FailureKind::Field {
            prime: field.prime().modulus(),
            before,
            after,
        };
        self.failure(equation, element, kind)
    }

    fn failure(&self, equation: &DerivativeEquation, element: u32, kind: FailureKind) -> Failure {
        let cut = |view: View<'_>, set: &[(Factor, usize)]| {
            let operands = set.iter();
            let operands = operands.map(|&(_, place)| view.function.assignments[place].operand);
            slice(view.function, &operands.collect::<Vec<_>>())
        };
        let assignments = &self.after.function.assignments;
        let own = |&&(_, place): &&(Factor, usize)| assignments[place].output.0 == element;
        let own: Vec<(Factor, usize)> = equation.after.iter().filter(own).copied().collect();
        Failure {
            name: print_output(self.after, Output(element)),
            slice_before: cut(self.before, &equation.before),
            slice_after: cut(self.after, &own),
            ..Failure::about(kind, self.after)
        }
    }
}
