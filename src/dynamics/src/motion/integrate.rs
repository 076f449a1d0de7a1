//! Integrators of ordinary differential equations.
//!
//! Both take the right-hand side as a function that may fail; a failure ends
//! the step.

/// One step of the classical fourth-order Runge-Kutta method.
///
/// # Errors
///
/// Errors of the right-hand side.
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

/// One step of the fifth-order method of Dormand and Prince: the result, and
/// an estimate of its error.
///
/// # Errors
///
/// Errors of the right-hand side.
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

/// Factor by which the next step may grow (or must shrink) after an error that
/// is `ratio` times the tolerance.
pub fn growth(ratio: f64) -> f64 {
    // A step that failed outright is quartered.
    if !ratio.is_finite() {
        return 0.25;
    }
    (0.9 * ratio.max(1e-10).powf(-0.2)).clamp(0.2, 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
