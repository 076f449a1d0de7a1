//! Numbers to measure with: random ones, any format, and the reference.

use robovec_ir::evaluate::evaluate;
use robovec_ir::{Format, Function};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::random::Random;
use robovec_num::soft_float::FormatArithmetic;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum WorkingPrecision {
    In(Format),
    /// Double-double numbers, some 106 bits.
    Reference,
}

/// A number that the reference holds exactly.
pub(super) trait Wide: Copy {
    /// The number as one of the reference.
    fn wide(self) -> Double;
}

impl Wide for f32 {
    fn wide(self) -> Double {
        Double::from(f64::from(self))
    }
}

impl Wide for f64 {
    fn wide(self) -> Double {
        Double::from(self)
    }
}

impl Wide for Double {
    fn wide(self) -> Double {
        self
    }
}

/// Work that can be done in any arithmetic.
pub(super) trait Work {
    type Result;

    fn run<A: Arithmetic<Number: Wide>>(self, arithmetic: &A) -> Self::Result;
}

impl WorkingPrecision {
    /// Does work in these numbers.
    pub(super) fn work<W: Work>(self, work: W) -> W::Result {
        match self {
            WorkingPrecision::Reference => work.run(&DoubleDouble),
            WorkingPrecision::In(Format::BINARY32) => work.run(&Binary32),
            WorkingPrecision::In(Format::BINARY64) => work.run(&Binary64),
            WorkingPrecision::In(format) => work.run(&FormatArithmetic::new(format)),
        }
    }
}

pub(super) struct Evaluation<'a> {
    pub(super) function: &'a Function,
    pub(super) inputs: &'a [f64],
}

impl Work for Evaluation<'_> {
    /// The flattened outputs; zero where the function assigns nothing.
    type Result = Vec<Double>;

    fn run<A: Arithmetic<Number: Wide>>(self, arithmetic: &A) -> Vec<Double> {
        let inputs: Vec<A::Number> = self
            .inputs
            .iter()
            .map(|&number| arithmetic.literal(number))
            .collect();
        flattened(self.function, evaluate(self.function, arithmetic, &inputs))
    }
}

/// Flattened outputs of the results of assignments; zero without any.
pub(super) fn flattened(function: &Function, results: Vec<impl Wide>) -> Vec<Double> {
    let mut flat = vec![Double::from(0.0); function.output_len()];
    for (assignment, number) in function.assignments.iter().zip(results) {
        flat[assignment.output.index()] = number.wide();
    }
    flat
}

/// A number rounded once to a format, subnormal or infinite if required.
pub(super) fn rounded(number: f64, format: Format) -> f64 {
    match format {
        Format::BINARY64 => number,
        Format::BINARY32 => f64::from(number as f32),
        format => FormatArithmetic::new(format).convert(number),
    }
}

/// A sequence of such numbers.
#[derive(Clone, Debug)]
pub(super) struct Draw(Random);

impl Draw {
    pub(super) fn new(seed: u64) -> Draw {
        Draw(Random::new(seed))
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// A number between two, which binary32 holds when they are of its size.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        f64::from((low + (high - low) * self.0.unit()) as f32)
    }

    /// A number between `-bound` and `bound`.
    pub(super) fn within(&mut self, bound: f64) -> f64 {
        self.between(-bound, bound)
    }
}
