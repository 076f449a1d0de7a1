//! Steps of time in any arithmetic: classical Runge-Kutta of fourth order.

use robovec_ir::cost::OperationWork;
use robovec_num::arithmetic::Arithmetic;

/// Numbers that are integrated.
pub struct IntegratedState<N> {
    /// Present values.
    pub numbers: Vec<N>,
    /// Rounding errors of additions so far.
    rest: Vec<N>,
}

/// Way in which they are integrated.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TimeStep {
    /// s.
    pub step: f64,
    /// Keep for each number the rounding error of its last addition, and add it
    /// to the next change (Kahan, "Further remarks on reducing truncation
    /// errors", 1965).
    pub compensated: bool,
}

impl<N: Copy> IntegratedState<N> {
    /// Numbers at their start.
    pub fn new<A: Arithmetic<Number = N>>(a: &A, start: &[f64]) -> IntegratedState<N> {
        IntegratedState {
            numbers: start.iter().map(|&number| a.literal(number)).collect(),
            rest: vec![a.literal(0.0); start.len()],
        }
    }

    /// One step.
    pub fn step<A: Arithmetic<Number = N>>(
        &mut self,
        a: &A,
        how: TimeStep,
        slope: &mut dyn FnMut(&[N]) -> Vec<N>,
    ) {
        let [half, whole, sixth, third] =
            [0.5, 1.0, 1.0 / 6.0, 1.0 / 3.0].map(|part| a.literal(part * how.step));
        let moved = |numbers: &[N], slope: &[N], factor: N| -> Vec<N> {
            assert_eq!(numbers.len(), slope.len(), "one slope per number");
            let pairs = numbers.iter().zip(slope);
            pairs.map(|(&y, &k)| a.add(y, a.mul(factor, k))).collect()
        };
        let first = slope(&self.numbers);
        let second = slope(&moved(&self.numbers, &first, half));
        let middle = slope(&moved(&self.numbers, &second, half));
        let fourth = slope(&moved(&self.numbers, &middle, whole));
        for index in 0..self.numbers.len() {
            let ends = a.mul(sixth, a.add(first[index], fourth[index]));
            let middles = a.mul(third, a.add(second[index], middle[index]));
            let change = a.add(ends, middles);
            let old = self.numbers[index];
            if !how.compensated {
                self.numbers[index] = a.add(old, change);
                continue;
            }
            let change = a.sub(change, self.rest[index]);
            let new = a.add(old, change);
            self.rest[index] = a.sub(a.sub(new, old), change);
            self.numbers[index] = new;
        }
    }
}

/// The operations of one step of Runge-Kutta besides its slopes: four stages
/// of a product and a sum, four more sums and two products for the change;
/// three sums more to compensate.
pub fn change_work(numbers: usize, compensated: bool) -> OperationWork {
    let sums = if compensated { 11.0 } else { 8.0 };
    OperationWork::new(6.0, sums) * numbers as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::arithmetic::Binary64;

    #[test]
    fn an_oscillator_is_multiplied_by_the_polynomial_of_the_method() {
        // x' = i w x as two numbers: each step multiplies by
        // 1 + z + z^2/2 + z^3/6 + z^4/24 with z = i w h.
        let how = TimeStep {
            step: 0.1,
            compensated: true,
        };
        let mut state = IntegratedState::new(&Binary64, &[1.0, 0.0]);
        for _ in 0..100 {
            state.step(&Binary64, how, &mut |x| vec![-3.0 * x[1], 3.0 * x[0]]);
        }
        let z: f64 = 0.3;
        let (real, imaginary) = (1.0 - z * z / 2.0 + z.powi(4) / 24.0, z - z.powi(3) / 6.0);
        let size = real.hypot(imaginary).powi(100);
        let angle = 100.0 * imaginary.atan2(real);
        assert!((state.numbers[0] - size * angle.cos()).abs() < 1e-13);
        assert!((state.numbers[1] - size * angle.sin()).abs() < 1e-13);
    }
}
