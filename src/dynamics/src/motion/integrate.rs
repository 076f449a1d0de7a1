//! Integrators of ordinary differential equations, and steps of time in any
//! arithmetic by the classical Runge-Kutta method of fourth order.
//!
//! Both take the right-hand side as a function; its failure ends the step.

use robovec_ir::cost::OperationWork;
use robovec_num::arithmetic::Arithmetic;

/// One step of the classical fourth-order Runge-Kutta method.
pub fn runge_kutta<E>(
    time: f64,
    state: &[f64],
    step: f64,
    mut slope: impl FnMut(f64, &[f64]) -> Result<Vec<f64>, E>,
) -> Result<Vec<f64>, E> {
    let half = 0.5 * step;
    let k1 = slope(time, state)?;
    let k2 = slope(time + half, &advance(state, &[(half, &k1)]))?;
    let k3 = slope(time + half, &advance(state, &[(half, &k2)]))?;
    let k4 = slope(time + step, &advance(state, &[(step, &k3)]))?;
    let sixth = step / 6.0;
    Ok(advance(
        state,
        &[
            (sixth, &k1),
            (2.0 * sixth, &k2),
            (2.0 * sixth, &k3),
            (sixth, &k4),
        ],
    ))
}

/// `state` plus multiples of slopes.
fn advance(state: &[f64], slopes: &[(f64, &Vec<f64>)]) -> Vec<f64> {
    assert!(
        slopes.iter().all(|(_, slope)| slope.len() == state.len()),
        "one slope per number"
    );
    let moved = |(index, &start): (usize, &f64)| {
        let terms = slopes.iter().map(|(factor, slope)| factor * slope[index]);
        start + terms.sum::<f64>()
    };
    state.iter().enumerate().map(moved).collect()
}

/// The nodes of Dormand and Prince's pair of orders 5 and 4 ("A family of
/// embedded Runge-Kutta formulae", 1980, Table 2).
const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// The coefficients of its stages; the last row is the fifth-order result.
const STAGES: [&[f64]; 7] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
    ],
    &[
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
    &[
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// The difference between the results of fifth and fourth order.
const ERRORS: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// One step of Dormand and Prince's fifth order: the result and its error.
pub fn dormand_prince<E>(
    time: f64,
    state: &[f64],
    step: f64,
    mut slope: impl FnMut(f64, &[f64]) -> Result<Vec<f64>, E>,
) -> Result<(Vec<f64>, Vec<f64>), E> {
    let mut slopes: Vec<Vec<f64>> = Vec::with_capacity(NODES.len());
    let mut place = state.to_vec();
    for (node, stage) in NODES.iter().zip(STAGES) {
        let terms: Vec<(f64, &Vec<f64>)> = stage.iter().map(|a| a * step).zip(&slopes).collect();
        place = advance(state, &terms);
        slopes.push(slope(time + node * step, &place)?);
    }
    let terms: Vec<(f64, &Vec<f64>)> = ERRORS.iter().map(|e| e * step).zip(&slopes).collect();
    let error = advance(&vec![0.0; state.len()], &terms);
    Ok((place, error))
}

/// Factor of the next step after an error of `ratio` times the tolerance.
pub fn growth(ratio: f64) -> f64 {
    // A step that failed outright is quartered.
    if !ratio.is_finite() {
        return 0.25;
    }
    (0.9 * ratio.max(1e-10).powf(-0.2)).clamp(0.2, 5.0)
}

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
    /// Keep each number's rounding error of the last addition for the next
    /// (Kahan, "Further remarks on reducing truncation errors", 1965).
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

/// The operations of one step of Runge-Kutta besides its slopes: four products
/// and eight sums, two products for the change, three sums to compensate.
pub fn change_work(numbers: usize, compensated: bool) -> OperationWork {
    let sums = if compensated { 11.0 } else { 8.0 };
    OperationWork::new(6.0, sums) * numbers as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::arithmetic::Binary64;
    use std::convert::Infallible;

    /// A forced oscillator whose solution is `sin t + t^2`.
    fn slope(time: f64, state: &[f64]) -> Result<Vec<f64>, Infallible> {
        Ok(vec![state[1], -state[0] + time * time + 2.0])
    }

    /// The largest error on the way; at a single instant the errors of two
    /// steps may happen to cancel.
    fn error(step: f64, method: impl Fn(f64, &[f64]) -> Vec<f64>) -> f64 {
        let mut state = vec![0.0, 1.0];
        let mut largest = 0.0f64;
        for k in 0..(2.0 / step).round() as usize {
            state = method(k as f64 * step, &state);
            let time = (k + 1) as f64 * step;
            largest = largest.max((state[0] - (time.sin() + time * time)).abs());
        }
        largest
    }

    #[test]
    fn methods_have_their_orders() {
        let fourth = |step: f64| {
            error(step, |time, state| {
                let Ok(next) = runge_kutta(time, state, step, slope);
                next
            })
        };
        let order = (fourth(0.1) / fourth(0.05)).log2();
        assert!((3.8..4.3).contains(&order), "{order}");
        let fifth = |step: f64| {
            error(step, |time, state| {
                let Ok((next, _)) = dormand_prince(time, state, step, slope);
                next
            })
        };
        let order = (fifth(0.2) / fifth(0.1)).log2();
        assert!((4.7..5.6).contains(&order), "{order}");
    }

    #[test]
    fn the_estimate_has_the_size_of_the_error_of_fourth_order() {
        let estimate = |step: f64| {
            let Ok((_, error)) = dormand_prince(0.3, &[0.5, -1.0], step, slope);
            error[0].abs().max(error[1].abs())
        };
        let order = (estimate(0.2) / estimate(0.1)).log2();
        assert!((4.5..5.6).contains(&order), "{order}");
    }

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
