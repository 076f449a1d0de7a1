//! Derivatives along random directions.

use robovec_ir::Function;
use robovec_ir::plan::EvaluationPlan;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::random::mix;

/// The number of directions taken at a time: the estimate of one output in one
/// state is off by about a quarter, and that of its median over some states by
/// a few hundredths.
pub const DIRECTIONS: usize = 8;

/// Estimates for all outputs of a function how they react to relative changes
/// of the inputs.
///
/// If every input changes by its own random sign times one part, an output
/// changes by the sum of `± dy/dx x`; the mean square of that over the signs
/// is the sum of the squares. Forward derivatives along a few such directions
/// give an estimate for all outputs in one evaluation, where exact numbers
/// take a reverse sweep for each.
pub struct Sensitivities {
    plan: EvaluationPlan,
    memory: Vec<Dual>,
}

/// A value with its derivatives along the directions.
#[derive(Clone, Copy, Debug)]
struct Dual {
    value: f64,
    slopes: [f64; DIRECTIONS],
}

/// The arithmetic of [`Dual`].
struct Duals;

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
    /// When there is not one number per input element.
    pub fn at(&mut self, inputs: &[f64], state: u32) -> Vec<f64> {
        let direction = |(index, &value): (usize, &f64)| {
            let random = mix(mix(u64::from(state)) ^ index as u64);
            let mut slopes = [value; DIRECTIONS];
            for (direction, slope) in slopes.iter_mut().enumerate() {
                if random >> direction & 1 == 1 {
                    *slope = -value;
                }
            }
            Dual { value, slopes }
        };
        let inputs: Vec<Dual> = inputs.iter().enumerate().map(direction).collect();
        let outputs = self.plan.run(&Duals, &inputs, &mut self.memory);
        let mean_square = |dual: &Dual| {
            let squares = dual.slopes.iter().map(|slope| slope * slope);
            squares.sum::<f64>() / DIRECTIONS as f64
        };
        outputs
            .iter()
            .map(|dual| mean_square(dual).sqrt())
            .collect()
    }
}

impl Dual {
    /// The value with slopes that are a combination of two others.
    #[inline]
    fn combined(value: f64, (a, by_a): (&Dual, f64), (b, by_b): (&Dual, f64)) -> Dual {
        let mut slopes = [0.0; DIRECTIONS];
        for (direction, slope) in slopes.iter_mut().enumerate() {
            *slope = by_a * a.slopes[direction] + by_b * b.slopes[direction];
        }
        Dual { value, slopes }
    }

    /// The value with the slopes of another one times a factor.
    #[inline]
    fn scaled(value: f64, a: &Dual, factor: f64) -> Dual {
        Dual {
            value,
            slopes: a.slopes.map(|slope| factor * slope),
        }
    }
}

impl Arithmetic for Duals {
    type Number = Dual;

    fn literal(&self, number: f64) -> Dual {
        Dual {
            value: number,
            slopes: [0.0; DIRECTIONS],
        }
    }
    #[inline]
    fn neg(&self, a: Dual) -> Dual {
        Dual::scaled(-a.value, &a, -1.0)
    }
    #[inline]
    fn add(&self, a: Dual, b: Dual) -> Dual {
        Dual::combined(a.value + b.value, (&a, 1.0), (&b, 1.0))
    }
    #[inline]
    fn sub(&self, a: Dual, b: Dual) -> Dual {
        Dual::combined(a.value - b.value, (&a, 1.0), (&b, -1.0))
    }
    #[inline]
    fn mul(&self, a: Dual, b: Dual) -> Dual {
        Dual::combined(a.value * b.value, (&a, b.value), (&b, a.value))
    }
    fn div(&self, a: Dual, b: Dual) -> Dual {
        let value = a.value / b.value;
        Dual::combined(value, (&a, 1.0 / b.value), (&b, -value / b.value))
    }
    fn sin(&self, a: Dual) -> Dual {
        Dual::scaled(a.value.sin(), &a, a.value.cos())
    }
    fn cos(&self, a: Dual) -> Dual {
        Dual::scaled(a.value.cos(), &a, -a.value.sin())
    }
    fn sqrt(&self, a: Dual) -> Dual {
        let value = a.value.sqrt();
        Dual::scaled(value, &a, 0.5 / value)
    }
    fn fma(&self, a: Dual, b: Dual, c: Dual) -> Dual {
        self.add(self.mul(a, b), c)
    }
}
