//! Accelerations from a mass matrix, in its format.

use super::super::linear::{factorise, substitute};
use super::super::numbers::{Wide, Work};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::Double;
use robovec_num::power::times_power_of_two;

/// A solution by Cholesky's factorisation; `None` without pivots.
///
/// Rows and columns are scaled by powers of two that bring the diagonal near
/// one (van der Sluis 1969): exact, and far from the ends of the range.
pub(super) struct Solution<'a> {
    pub(super) size: usize,
    pub(super) mass: &'a [Double],
    pub(super) right: &'a [f64],
}

impl Work for Solution<'_> {
    type Result = Option<Vec<f64>>;

    fn run<A: Arithmetic<Number: Wide>>(self, arithmetic: &A) -> Option<Vec<f64>> {
        let size = self.size;
        assert_eq!(self.mass.len(), size * size, "a square matrix");
        assert_eq!(self.right.len(), size, "one number per row");
        let scale: Vec<i32> = (0..size)
            .map(|i| -exponent(self.mass[i * size + i].high).div_euclid(2))
            .collect();
        let entry = |(place, number): (usize, &Double)| {
            let power = scale[place / size] + scale[place % size];
            arithmetic.literal(times_power_of_two(number.high, power))
        };
        let mut factor: Vec<A::Number> = self.mass.iter().enumerate().map(entry).collect();
        factorise(arithmetic, size, &mut factor).ok()?;
        let right = || self.right.iter().zip(&scale);
        let largest = right().map(|(x, &power)| exponent(times_power_of_two(*x, power)));
        let largest = largest.max().expect("a model has a joint");
        let right: Vec<A::Number> = right()
            .map(|(x, power)| arithmetic.literal(times_power_of_two(*x, power - largest)))
            .collect();
        let solution = substitute(arithmetic, &factor, &right);
        let solution = solution.iter().zip(&scale);
        Some(
            solution
                .map(|(x, power)| times_power_of_two(x.wide().high, power + largest))
                .collect(),
        )
    }
}

/// The exponent of a number, from its bits; 0 for zero.
fn exponent(number: f64) -> i32 {
    match (number.to_bits() >> 52) & 0x7ff {
        0 => 0,
        biased => biased as i32 - 1023,
    }
}
