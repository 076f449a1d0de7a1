//! Conditions that were not there before and are not proved: a search for
//! places where they do not hold and the version before is defined.
//!
//! Random points never meet a pole. So the zeros of every such divisor are
//! searched for on lines through random states; where one is found and no
//! divisor of the version before vanishes with it, the versions differ. On the
//! same lines numbers under roots are evaluated, which may be negative.

use super::domain::{DomainCondition, DomainRequirement, OpenCondition};
use super::failure::{Failed, Values};
use super::pairing::Pairs;
use super::states::{StatePlace, StateScale};
use robovec_analysis::slice::slice;
use robovec_ir::evaluate::{evaluate, evaluate_nodes};
use robovec_ir::states::States;
use robovec_ir::{Function, Operand, OperandKind, Operation};
use robovec_num::arithmetic::{Arithmetic, Binary64};
use robovec_num::ball::{Ball, Balls};
use robovec_num::double_double::{Double, DoubleDouble};

/// Operations of all evaluations of a check together.
const WORK: usize = 40_000_000;

/// Lines at most, and places tested on each before zeros are narrowed down.
const MAX_LINES: u32 = 6;
const STEPS: i32 = 32;

/// The parts of a line, in units of [`DISTANCE`], on which numbers under roots
/// are evaluated.
const REACHES: [f64; 3] = [1.0, 30.0, 1000.0];

/// The distance of places, in units of the distance of the two states.
const DISTANCE: f64 = 0.13;

/// Maximum number of steps that narrow a zero down, two evaluations each at
/// most.
const NARROWINGS: usize = 60;

/// Zeros that are narrowed down on a line.
const MAX_ZEROS: usize = 3;

/// Number of times the distance of the grid is halved to test both sides of a
/// zero.
const HALVINGS: i32 = 12;

/// Maximum number of divisors, and of numbers under roots, that are searched.
const MAX_DIVISORS: usize = 8;

/// A divisor is zero where it is less than this part of its largest value.
const ZERO: f64 = 1e-9;
/// A divisor of the version before vanishes too where it is less than this
/// part of its largest value: the new one may be its square or cube.
const NEARLY: f64 = 1e-3;

/// An output that loses its value where a new condition does not hold, and that
/// condition.
pub(super) fn first(
    pairs: &Pairs<'_>,
    source: &States,
    open: &[OpenCondition],
) -> Option<(Failed, DomainRequirement)> {
    let of = |requirement: DomainRequirement| {
        let conditions = open.iter().map(|open| open.condition);
        let wanted = conditions.filter(|condition| condition.requirement == requirement);
        let mut operands: Vec<Operand> = wanted.map(|condition| condition.operand).collect();
        operands.sort_unstable();
        operands.dedup();
        operands.truncate(MAX_DIVISORS);
        operands
    };
    let [divisors_after, radicands] =
        [DomainRequirement::Nonzero, DomainRequirement::NotNegative].map(of);
    let old = divisors(pairs.before.function);
    let size = pairs.before.function.nodes().len() + pairs.after.function.nodes().len() + 1;
    let of_radicands = REACHES.len() * (2 * STEPS as usize + 1);
    let evaluations = 2 * STEPS as usize
        + MAX_ZEROS * 2 * (NARROWINGS + HALVINGS as usize)
        + if radicands.is_empty() {
            0
        } else {
            of_radicands
        };
    let lines = (WORK / size / evaluations).clamp(1, MAX_LINES as usize);
    (0..lines as u32).find_map(|number| {
        let line = StateLine::new(pairs, source, number);
        let pole = line.search(pairs, &old, &divisors_after);
        pole.map(|failed| (failed, DomainRequirement::Nonzero))
            .or_else(|| {
                let hole = line.negative(pairs, &radicands)?;
                Some((hole, DomainRequirement::NotNegative))
            })
    })
}

/// The operands that something is divided by, literals aside.
fn divisors(function: &Function) -> Vec<Operand> {
    let quotients = function
        .nodes()
        .iter()
        .filter(|node| node.operation == Operation::Div);
    let mut found: Vec<Operand> = quotients
        .map(|node| node.operands[1])
        .filter(|operand| operand.constant().is_none())
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// The values of operands.
fn values<A: Arithmetic>(
    function: &Function,
    arithmetic: &A,
    inputs: &[A::Number],
    operands: &[Operand],
) -> Vec<A::Number> {
    let nodes = evaluate_nodes(function, arithmetic, inputs);
    let value = |operand: &Operand| match operand.kind() {
        OperandKind::Value(value) => nodes[value.index()],
        OperandKind::Input(input) => inputs[input.index()],
        OperandKind::Constant(constant) => arithmetic.literal(function.constant_number(constant)),
        OperandKind::None => arithmetic.literal(0.0),
    };
    operands.iter().map(value).collect()
}

/// A line through two states.
struct StateLine {
    /// Named in a failure.
    place: StatePlace,
    /// The inputs of both versions at its ends.
    ends: [[Vec<f64>; 2]; 2],
}

impl StateLine {
    fn new(pairs: &Pairs<'_>, source: &States, number: u32) -> StateLine {
        let scales = [
            [StateScale::Usual, StateScale::Near],
            [StateScale::Constants, StateScale::Special],
            [StateScale::Whole, StateScale::UsualAgain],
        ];
        let places =
            scales[number as usize % scales.len()].map(|scale| StatePlace { scale, number });
        StateLine {
            place: places[0],
            ends: places.map(|place| pairs.numbers(source, place)),
        }
    }

    /// The inputs of a version at a place of the line.
    fn at(&self, version: usize, t: f64) -> Vec<f64> {
        let [first, last] = &self.ends;
        let ends = first[version].iter().zip(&last[version]);
        // An end itself is met exactly.
        ends.map(|(a, b)| if a == b { *a } else { a * (1.0 - t) + b * t })
            .collect()
    }

    fn search(&self, pairs: &Pairs<'_>, old: &[Operand], new: &[Operand]) -> Option<Failed> {
        let grid: Vec<f64> = (0..=STEPS)
            .map(|step| f64::from(step - STEPS / 3) * DISTANCE)
            .collect();
        let after = |t: f64| values(pairs.after.function, &Binary64, &self.at(1, t), new);
        let before = |t: f64| values(pairs.before.function, &Binary64, &self.at(0, t), old);
        let samples: Vec<Vec<f64>> = grid.iter().map(|&t| after(t)).collect();
        let mut usual: Option<Vec<f64>> = None;
        let (mut left, mut divisors) = (MAX_ZEROS, (0..new.len()).cycle());
        // Every divisor has its turn before one is looked at again.
        for window in 0..(grid.len() - 2) * new.len() {
            let index = divisors.next().expect("there are divisors");
            let window = window / new.len();
            let [a, b, c] = [0, 1, 2].map(|step| samples[window + step][index]);
            let size = |t: f64| after(t)[index];
            let crosses = a * b <= 0.0;
            let dips = b.abs() <= a.abs() && b.abs() <= c.abs();
            if left == 0 || !crosses && !dips {
                continue;
            }
            left -= 1;
            let zero = if crosses {
                bisect(size, [grid[window], grid[window + 1]], a)
            } else {
                smallest(size, [grid[window], grid[window + 2]])
            };
            let most = largest(samples.iter().map(|sample| sample[index]));
            if size(zero).abs() > ZERO * most {
                continue;
            }
            // At the same places as the new ones: near a pole of its own a
            // divisor is so large that it seems to vanish everywhere else.
            let usual = usual
                .get_or_insert_with(|| sizes(grid.iter().map(|&t| before(t)), old.len()))
                .iter();
            // A root may leave a divisor without a value on most of the line.
            let beside = (0..HALVINGS).flat_map(|halving| {
                let distance = DISTANCE / f64::from(1 << halving);
                [zero - distance, zero + distance]
            });
            let beside = sizes(beside.map(&before), old.len());
            let usual: Vec<f64> = usual.zip(beside).map(|(a, b)| a.max(b)).collect();
            let mut here = before(zero).into_iter().zip(&usual);
            // A divisor that is no number there counts as vanishing.
            let vanishes =
                here.any(|(value, usual)| value.is_nan() || value.abs() <= NEARLY * usual);
            if !vanishes
                && self.is_confirmed(pairs, (old, &usual), (new[index], most), zero)
                && let Some(failed) =
                    self.failure(pairs, DomainRequirement::Nonzero, new[index], zero)
            {
                return Some(failed);
            }
        }
        None
    }

    /// Tests whether the zero is one in double-double too, at which no divisor
    /// of the version before vanishes: in binary64 sums of very different sizes
    /// are zero by rounding alone.
    fn is_confirmed(
        &self,
        pairs: &Pairs<'_>,
        (old, usual): (&[Operand], &[f64]),
        (new, most): (Operand, f64),
        zero: f64,
    ) -> bool {
        let long = |numbers: Vec<f64>| numbers.into_iter().map(Double::from).collect::<Vec<_>>();
        let [before, after] = [0, 1].map(|version| long(self.at(version, zero)));
        let old = values(pairs.before.function, &DoubleDouble, &before, old);
        let new = values(pairs.after.function, &DoubleDouble, &after, &[new])[0].high;
        let vanishes = |(value, usual): (Double, &f64)| {
            value.high.is_nan() || value.high.abs() <= NEARLY * usual
        };
        new.abs() <= ZERO * most && !old.into_iter().zip(usual).any(vanishes)
    }

    /// The inputs of a version at a place of the line, with bounds.
    fn balls(&self, version: usize, t: f64) -> Vec<Ball<1>> {
        let inputs = self.at(version, t).into_iter();
        inputs.map(|number| Ball::exact([number])).collect()
    }

    /// A point at which a radicand is certainly negative and an output that
    /// depends on it has a value before.
    fn negative(&self, pairs: &Pairs<'_>, radicands: &[Operand]) -> Option<Failed> {
        if radicands.is_empty() {
            return None;
        }
        let places = REACHES
            .into_iter()
            .flat_map(|reach| (-STEPS..=STEPS).map(move |step| f64::from(step) * DISTANCE * reach));
        places.into_iter().find_map(|t| {
            let numbers = values(
                pairs.after.function,
                &Balls::<1>,
                &self.balls(1, t),
                radicands,
            );
            let is_negative = |ball: &Ball<1>| ball.value.high[0] + ball.radius[0] < 0.0;
            let mut found = radicands.iter().zip(numbers);
            let (&radicand, _) = found.find(|(_, ball)| is_negative(ball))?;
            let before = evaluate(pairs.before.function, &Balls::<1>, &self.balls(0, t));
            let failed = self.failure(pairs, DomainRequirement::NotNegative, radicand, t)?;
            before[pairs.list[failed.pair].before]
                .is_known(0)
                .then_some(failed)
        })
    }

    /// The first output that a condition is set for and that has a value before.
    fn failure(
        &self,
        pairs: &Pairs<'_>,
        requirement: DomainRequirement,
        operand: Operand,
        zero: f64,
    ) -> Option<Failed> {
        let condition = DomainCondition {
            requirement,
            operand,
        };
        let before = evaluate(pairs.before.function, &Binary64, &self.at(0, zero));
        let after = evaluate(pairs.after.function, &Binary64, &self.at(1, zero));
        pairs.list.iter().enumerate().find_map(|(index, pair)| {
            let function = pairs.after.function;
            let root = function.assignments[pair.after].operand;
            let divides = slice(function, &[root]).into_iter().any(|value| {
                let node = function.node(value);
                DomainCondition::of(node.operation, node.operands) == Some(condition)
            });
            (divides && before[pair.before].is_finite()).then(|| Failed {
                pair: index,
                values: Values {
                    state: self.place,
                    before: before[pair.before],
                    after: after[pair.after],
                    allowed: 0.0,
                },
                inputs: Some(self.at(0, zero)),
            })
        })
    }
}

/// The largest size of each of the divisors over samples. A divisor that
/// overflows somewhere is infinite, so it counts as vanishing everywhere: small
/// terms beside it are lost. NaN is skipped.
fn sizes(samples: impl Iterator<Item = Vec<f64>>, count: usize) -> Vec<f64> {
    samples.fold(vec![0.0; count], |sizes, sample| {
        let both = sizes.into_iter().zip(sample);
        both.map(|(size, value): (f64, f64)| size.max(value.abs()))
            .collect()
    })
}

/// The largest size among numbers.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers
        .map(f64::abs)
        .filter(|size| size.is_finite())
        .fold(0.0, f64::max)
}

/// A zero between two places of different signs.
fn bisect(of: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], at_low: f64) -> f64 {
    if at_low == 0.0 {
        return low;
    }
    for _ in 0..NARROWINGS {
        let middle = low + (high - low) / 2.0;
        let value = of(middle);
        if value == 0.0 {
            return middle;
        }
        if (value < 0.0) == (at_low < 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// The place of the smallest size between two places around one minimum.
fn smallest(of: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    for _ in 0..NARROWINGS {
        let [left, right] = [1.0, 2.0].map(|third| low + (high - low) * third / 3.0);
        if of(left).abs() <= of(right).abs() {
            high = right;
        } else {
            low = left;
        }
    }
    low + (high - low) / 2.0
}
