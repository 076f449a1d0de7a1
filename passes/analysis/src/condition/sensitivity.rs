//! Derivatives along random directions.

use robovec_ir::Function;
use robovec_ir::plan::EvaluationPlan;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::random::mix;

/// The number of directions taken at a time: the estimate of one output in one
/// state is off by about a quarter, and that of its median over some states by
/// a few hundredths.
pub const DIRECTIONS: usize = 8;

/// Estimates the sensitivity of all outputs of a function to relative changes
/// of the inputs.
///
/// If every input changes by its own random sign times one part, an output
/// changes by the sum of `± dy/dx x`; the mean square of that over the signs
/// is the sum of the squares. Forward derivatives along a few such directions
/// give an estimate for all outputs in one evaluation, where exact numbers
/// take a reverse sweep for each.
pub struct Sensitivities {
    plan: EvaluationPlan,
    memory: Vec<SlopedNumber>,
}

/// A value with its derivatives along the directions.
#[derive(Clone, Copy, Debug)]
struct SlopedNumber {
    value: f64,
    slopes: [f64; DIRECTIONS],
}

/// The arithmetic of [`SlopedNumber`].
struct SlopedArithmetic;

impl Sensitivities {
    /// Makes a function ready.
    pub fn new(function: &Function) -> Sensitivities {
        Sensitivities {
            plan: EvaluationPlan::new(function),
            memory: Vec::new(),
        }
    }

    /// For every assignment the estimated root of the sum of the squares of
    /// `dy/dx x` over the inputs, at a state of a number, from which the signs
    /// are drawn. Divided by the size of the output it is a condition number
    /// for errors that are independent of each other.
    ///
    /// # Panics
    ///
    /// Panics when there is not one number per input element.
    pub fn at(&mut self, inputs: &[f64], state: u32) -> Vec<f64> {
        let direction = |(index, &value): (usize, &f64)| {
            let random = mix(mix(u64::from(state)) ^ index as u64);
            let mut slopes = [value; DIRECTIONS];
            for (direction, slope) in slopes.iter_mut().enumerate() {
                if random >> direction & 1 == 1 {
                    *slope = -value;
                }
            }
            SlopedNumber { value, slopes }
        };
        let inputs: Vec<SlopedNumber> = inputs.iter().enumerate().map(direction).collect();
        let outputs = self.plan.run(&SlopedArithmetic, &inputs, &mut self.memory);
        let mean_square = |sloped: &SlopedNumber| {
            let squares = sloped.slopes.iter().map(|slope| slope * slope);
            squares.sum::<f64>() / DIRECTIONS as f64
        };
        outputs
            .iter()
            .map(|sloped| mean_square(sloped).sqrt())
            .collect()
    }
}

impl SlopedNumber {
    /// The value with slopes that are a combination of two others.
    #[inline]
    fn combined(
        value: f64,
        (a, by_a): (&SlopedNumber, f64),
        (b, by_b): (&SlopedNumber, f64),
    ) -> SlopedNumber {
        let mut slopes = [0.0; DIRECTIONS];
        for (direction, slope) in slopes.iter_mut().enumerate() {
            *slope = by_a * a.slopes[direction] + by_b * b.slopes[direction];
        }
        SlopedNumber { value, slopes }
    }

    /// The value with the slopes of another one times a factor.
    #[inline]
    fn scaled(value: f64, a: &SlopedNumber, factor: f64) -> SlopedNumber {
        SlopedNumber {
            value,
            slopes: a.slopes.map(|slope| factor * slope),
        }
    }
}

impl Arithmetic for SlopedArithmetic {
    type Number = SlopedNumber;

    fn literal(&self, number: f64) -> SlopedNumber {
        SlopedNumber {
            value: number,
            slopes: [0.0; DIRECTIONS],
        }
    }
    #[inline]
    fn neg(&self, a: SlopedNumber) -> SlopedNumber {
        SlopedNumber::scaled(-a.value, &a, -1.0)
    }
    #[inline]
    fn add(&self, a: SlopedNumber, b: SlopedNumber) -> SlopedNumber {
        SlopedNumber::combined(a.value + b.value, (&a, 1.0), (&b, 1.0))
    }
    #[inline]
    fn sub(&self, a: SlopedNumber, b: SlopedNumber) -> SlopedNumber {
        SlopedNumber::combined(a.value - b.value, (&a, 1.0), (&b, -1.0))
    }
    #[inline]
    fn mul(&self, a: SlopedNumber, b: SlopedNumber) -> SlopedNumber {
        SlopedNumber::combined(a.value * b.value, (&a, b.value), (&b, a.value))
    }
    fn div(&self, a: SlopedNumber, b: SlopedNumber) -> SlopedNumber {
        let value = a.value / b.value;
        SlopedNumber::combined(value, (&a, 1.0 / b.value), (&b, -value / b.value))
    }
    fn sin(&self, a: SlopedNumber) -> SlopedNumber {
        SlopedNumber::scaled(a.value.sin(), &a, a.value.cos())
    }
    fn cos(&self, a: SlopedNumber) -> SlopedNumber {
        SlopedNumber::scaled(a.value.cos(), &a, -a.value.sin())
    }
    fn sqrt(&self, a: SlopedNumber) -> SlopedNumber {
        let value = a.value.sqrt();
        SlopedNumber::scaled(value, &a, 0.5 / value)
    }
    fn fma(&self, a: SlopedNumber, b: SlopedNumber, c: SlopedNumber) -> SlopedNumber {
        self.add(self.mul(a, b), c)
    }
}
