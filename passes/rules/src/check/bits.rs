//! The effect of a rule on bits: equality in floating point, and the treatment
//! of zeros, infinities and NaN.
//!
//! By trials, not by proof: the values that have made rules of floating point
//! fail before (zeros of both signs, the smallest and largest numbers,
//! subnormals, infinities, NaN) in all combinations that a budget allows, and
//! numbers at random. A rule that is stated to be exact has passed all of them
//! in both binary formats.

use super::super::rule::Rule;
use super::counterexample;
use super::states::{RulePoints, numbers};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::random::Random;

/// A remark on special values, with an example.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Note {
    /// The kind of event.
    pub kind: NoteKind,
    /// The number format of the example: `binary32` or `binary64`.
    pub format: &'static str,
    /// An example of it: the variables and both sides.
    pub example: String,
}

/// An event that can happen at special values.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum NoteKind {
    /// The sides are zeros of different sign.
    SignedZero,
    /// The right side is not finite where the left side is.
    Overflow,
    /// The left side is not finite where the right side is.
    OverflowRemoved,
    /// The right side is zero where the left side is not.
    Underflow,
    /// The sides treat an infinity or NaN differently.
    NotANumber,
}

impl NoteKind {
    const COUNT: usize = 5;

    /// The event in one word.
    pub fn word(self) -> &'static str {
        match self {
            NoteKind::SignedZero => "zero",
            NoteKind::Overflow => "overflow",
            NoteKind::OverflowRemoved => "less-overflow",
            NoteKind::Underflow => "underflow",
            NoteKind::NotANumber => "nan",
        }
    }

    /// The event in words.
    pub fn describe(self) -> &'static str {
        match self {
            NoteKind::SignedZero => "the sign of a zero changes",
            NoteKind::Overflow => "the right side overflows where the left side does not",
            NoteKind::OverflowRemoved => "the left side overflows where the right side does not",
            NoteKind::Underflow => "the right side vanishes where the left side does not",
            NoteKind::NotANumber => "an infinity or NaN is treated differently",
        }
    }
}

/// The outcome of all trials.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Bits {
    /// True when no trial found a bit of a finite number changed.
    pub(super) exact: bool,
    /// The part of random trials in binary32 with equal bits, from 0 to 1.
    pub(super) equal: f64,
    pub(super) notes: Vec<Note>,
}

/// The values a format is hardest on, simple ones first.
struct HardFormat {
    name: &'static str,
    specials: Vec<f64>,
    /// Exponents of its normal numbers.
    exponents: (i32, i32),
}

fn formats() -> [HardFormat; 2] {
    let both = |name, tiny: f64, least: f64, most: f64, exponents| {
        let mut specials = vec![0.0, 1.0, 2.0, 3.0, 0.5, most, least, tiny, most / 2.0, 1e-3];
        specials.extend([f64::INFINITY]);
        let negative: Vec<f64> = specials.iter().map(|number| -number).collect();
        specials.extend(negative);
        specials.push(f64::NAN);
        HardFormat {
            name,
            specials,
            exponents,
        }
    };
    [
        both(
            "binary32",
            f32::from_bits(1).into(),
            f32::MIN_POSITIVE.into(),
            f32::MAX.into(),
            (-126, 127),
        ),
        both(
            "binary64",
            f64::from_bits(1),
            f64::MIN_POSITIVE,
            f64::MAX,
            (-1022, 1023),
        ),
    ]
}

/// A number for users: the ends of a format by name, others with at most five
/// digits.
fn number(format: &str, value: f64) -> String {
    let single = format == "binary32";
    let (most, least, tiny) = if single {
        (
            f32::MAX.into(),
            f32::MIN_POSITIVE.into(),
            f32::from_bits(1).into(),
        )
    } else {
        (f64::MAX, f64::MIN_POSITIVE, f64::from_bits(1))
    };
    let names = [
        ("max", most),
        ("max/2", most / 2.0),
        ("min", least),
        ("tiny", tiny),
    ];
    let sign = if value < 0.0 { "-" } else { "" };
    if let Some((name, _)) = names.iter().find(|(_, named)| *named == value.abs()) {
        return format!("{sign}{name}");
    }
    let plain = counterexample::number(value);
    if plain.len() > 9 {
        format!("{value:.4e}")
    } else {
        plain
    }
}

/// Random points for the part of equal bits at least, however few trials are
/// requested.
const FEWEST: usize = 2_000;

/// Tries a rule at special values and at this number of random points.
pub(super) fn try_bits(rule: &Rule, trials: usize) -> Bits {
    let [mut single, mut double] = formats();
    let mut bench = BitComparison {
        rule,
        exact: true,
        found: [const { None }; NoteKind::COUNT],
        equal: 0,
        compared: 0,
    };
    for format in [&mut single, &mut double] {
        // The numbers in the rule are as special as any.
        for number in numbers(&[&rule.left, &rule.right]).into_iter().take(4) {
            format
                .specials
                .extend([number, -number, number * 1.000_000_1]);
        }
    }
    bench.specials(&Binary32, &single, trials);
    bench.specials(&Binary64, &double, trials);
    let enough = trials.max(FEWEST);
    bench.start_counting();
    bench.random(&Binary32, &single, (-10, 9), enough);
    let mut equal = bench.part();
    bench.start_counting();
    bench.random(&Binary64, &double, (-10, 9), trials);
    // A number in the rule may be out of the reach of binary32, or next to
    // all others too large or too small.
    if equal == 0.0 {
        equal = bench.part();
    }
    if equal == 0.0 {
        bench.start_counting();
        bench.states(&Binary64, &double, enough);
        equal = bench.part();
    }
    bench.random(&Binary32, &single, single.exponents, trials / 4);
    bench.random(&Binary64, &double, double.exponents, trials / 4);
    Bits {
        exact: bench.exact,
        equal,
        notes: bench.found.into_iter().flatten().collect(),
    }
}

struct BitComparison<'a> {
    rule: &'a Rule,
    exact: bool,
    /// The first example of each kind.
    found: [Option<Note>; NoteKind::COUNT],
    equal: usize,
    compared: usize,
}

impl BitComparison<'_> {
    /// All combinations of special values when they fit into the budget, else
    /// random ones.
    fn specials<A>(&mut self, arithmetic: &A, format: &HardFormat, budget: usize)
    where
        A: Arithmetic<Number: Into<f64>>,
    {
        let (count, base) = (self.rule.variables.len() as u32, format.specials.len());
        let all = base.checked_pow(count).filter(|&all| all <= budget);
        let mut random = Random::new(2);
        for index in 0..all.unwrap_or(budget) {
            let mut rest = index;
            let values = (0..count).map(|_| {
                let choice = match all {
                    Some(_) => rest % base,
                    None => random.below(base),
                };
                rest /= base;
                format.specials[choice]
            });
            let values: Vec<f64> = values.collect();
            self.trial(arithmetic, format.name, &values);
        }
    }

    fn random<A>(&mut self, arithmetic: &A, format: &HardFormat, range: (i32, i32), trials: usize)
    where
        A: Arithmetic<Number: Into<f64>>,
    {
        let mut random = Random::new(3);
        for _ in 0..trials {
            let draw = |_| random.log_uniform(range.0, range.1);
            let values: Vec<f64> = self.rule.variables.iter().map(draw).collect();
            self.trial(arithmetic, format.name, &values);
        }
    }

    /// At the points at which rules are proved.
    fn states<A>(&mut self, arithmetic: &A, format: &HardFormat, trials: usize)
    where
        A: Arithmetic<Number: Into<f64>>,
    {
        let mut states = RulePoints::of(self.rule, 11);
        for _ in 0..trials {
            self.trial(arithmetic, format.name, &states.next());
        }
    }

    fn start_counting(&mut self) {
        (self.equal, self.compared) = (0, 0);
    }

    /// The part of trials with equal bits since counting started.
    fn part(&self) -> f64 {
        self.equal as f64 / self.compared.max(1) as f64
    }

    fn trial<A>(&mut self, arithmetic: &A, format: &'static str, values: &[f64])
    where
        A: Arithmetic<Number: Into<f64>>,
    {
        let inputs: Vec<A::Number> = values
            .iter()
            .map(|&value| arithmetic.literal(value))
            .collect();
        let meets = |(variable, input): (usize, &A::Number)| {
            let mut needed = self.rule.requirements(variable as u32);
            needed.all(|requirement| requirement.holds_for((*input).into()))
        };
        if !inputs.iter().enumerate().all(meets) {
            return;
        }
        let finite_inputs = inputs.iter().all(|&input| input.into().is_finite());
        let numbers = self.rule.left.evaluate_all(arithmetic, &inputs);
        let finite = numbers.iter().all(|&number| number.into().is_finite());
        let left: f64 = numbers[self.rule.left.root()].into();
        let right: f64 = self.rule.right.evaluate(arithmetic, &inputs).into();
        self.compared += usize::from(finite);
        self.equal += usize::from(finite && left == right);
        let kind = if finite {
            self.exact &= left == right;
            if !right.is_finite() {
                NoteKind::Overflow
            } else if left == 0.0
                && right == 0.0
                && left.is_sign_negative() != right.is_sign_negative()
            {
                NoteKind::SignedZero
            } else if right == 0.0 && left != 0.0 {
                NoteKind::Underflow
            } else {
                return;
            }
        } else if finite_inputs {
            // What was no number becomes one: that is not exact.
            self.exact &= left == right || left.is_nan() && right.is_nan();
            if left.is_finite() || !right.is_finite() {
                return;
            }
            NoteKind::OverflowRemoved
        } else if left == right || left.is_nan() && right.is_nan() {
            return;
        } else {
            NoteKind::NotANumber
        };
        self.note(kind, format, &inputs, (left, right));
    }

    fn note<N: Copy + Into<f64>>(
        &mut self,
        kind: NoteKind,
        format: &'static str,
        inputs: &[N],
        (left, right): (f64, f64),
    ) {
        let place = &mut self.found[kind as usize];
        if place.is_some() {
            return;
        }
        assert_eq!(
            inputs.len(),
            self.rule.variables.len(),
            "one number per variable"
        );
        let values: Vec<String> = self
            .rule
            .variables
            .iter()
            .zip(inputs)
            .map(|(name, &value)| format!("{name} = {}", number(format, value.into())))
            .collect();
        let (left, right) = (number(format, left), number(format, right));
        *place = Some(Note {
            kind,
            format,
            example: format!(
                "{}left {left}, right {right}",
                match values[..] {
                    [] => String::new(),
                    _ => values.join(", ") + ": ",
                }
            ),
        });
    }
}
