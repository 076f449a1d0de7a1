//! Condition numbers: the part of an error that is due to the problem.
//!
//! A result that is a small difference of large terms cannot be computed well
//! in any order: rounding the inputs alone would move it as much. The
//! componentwise condition number of an output,
//!
//! ```text
//! cond = sum over the inputs of |dy/dx x| / |y|,
//! ```
//!
//! is the factor by which the relative error of the result is expected to
//! exceed that of the inputs (Higham, *Accuracy and Stability of Numerical
//! Algorithms*, 2002, section 1.6). An error of about `cond u` is that of a
//! hard problem; one far above it is made by the code ([`Judgement`]).
//!
//! Two ways to it:
//!
//! - [`conditions`]: exact, by reverse sweeps
//!   ([`adjoint`](super::adjoint)), for some outputs;
//! - [`Sensitivities`]: estimated for all outputs at once, by derivatives
//!   along a few random directions.
//!
//! [`spectral`] has the condition number of a symmetric matrix, which gives
//! the factor by which solving with it can increase an error.

mod sensitivity;
pub mod spectral;

pub use sensitivity::{DIRECTIONS, Sensitivities};

use super::adjoint::{Adjoint, LANES, Tape, TapeSlot, Workspace};

/// The sums over the inputs of `|dy/dx x|` of some assignments, by their places
/// in [`robovec_ir::Function::assignments`], at one state: the largest effect
/// of a relative error of 1 in every input, to first order. Divided by the size
/// of the output it is the componentwise condition number.
///
/// Literals count as known.
///
/// # Panics
///
/// Panics when the number of inputs is not that of the function, or an output
/// does not exist.
pub fn conditions(tape: &Tape, inputs: &[f64], places: &[usize]) -> Vec<f64> {
    let adjoint = Adjoint::new(tape, inputs);
    let mut workspace = Workspace::default();
    let mut sums = vec![0.0; places.len()];
    for (group, sums) in places.chunks(LANES).zip(sums.chunks_mut(LANES)) {
        adjoint.sweep_lanes(&mut workspace, group, |slot, gradients| {
            if let TapeSlot::Input(input) = tape.slot(slot) {
                for (sum, gradient) in sums.iter_mut().zip(&gradients.0) {
                    *sum += (gradient * inputs[input.index()]).abs();
                }
            }
        });
    }
    sums
}

/// Errors up to this many units of rounding are normal for a sum or product of
/// some dozens of terms.
pub const ORDINARY: f64 = 64.0;

robovec_num::named! {
    /// The origin of an error.
    #[derive(Clone, Copy, PartialEq, Eq, Debug)]
    pub enum Judgement {
        /// It is ordinary: at most [`ORDINARY`] roundings.
        Accurate = "accurate",
        /// It is large because the problem is ill-conditioned: at most [`ORDINARY`]
        /// times the effect of rounding the inputs.
        HardProblem = "hard problem",
        /// It is larger than the problem explains: another order or form of the
        /// equations could do better.
        UnstableCode = "unstable code",
    }
}

impl Judgement {
    /// Judges a relative error in a format of the given unit roundoff by the
    /// condition number of the output. An error that is not a number is not
    /// explained.
    pub fn of(relative: f64, condition: f64, unit: f64) -> Judgement {
        if relative <= ORDINARY * unit {
            Judgement::Accurate
        } else if relative <= ORDINARY * condition.max(1.0) * unit {
            Judgement::HardProblem
        } else {
            Judgement::UnstableCode
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse::parse_module;

    const TEXT: &str = "function f atomic {
      in x[1..3]
      out y[1..4]
      %a = x[1]*x[2]
      %b = %a-x[3]
      %c = sin(x[1])
      %d = %c/x[2]
      %e = %b*%d
      y[1] = %a
      y[2] = %b
      y[3] = %d
      y[4] = %e
    }";

    const INPUTS: [f64; 3] = [0.75, 2.0, 1.5 - 1e-6];

    /// By hand.
    fn expected() -> [[f64; 3]; 4] {
        let [x, y, z] = INPUTS;
        let (b, d) = (x * y - z, x.sin() / y);
        let of_b = [x * y, x * y, -z];
        let of_d = [x.cos() * x / y, -d, 0.0];
        let of_e = [0, 1, 2].map(|i| of_b[i] * d + of_d[i] * b);
        [[x * y, x * y, 0.0], of_b, of_d, of_e]
    }

    #[test]
    fn conditions_are_those_found_by_hand() {
        let module = parse_module("f", TEXT).expect("it is well formed");
        let tape = Tape::new(&module.functions[0]);
        let found = conditions(&tape, &INPUTS, &[0, 1, 2, 3]);
        for (found, terms) in found.iter().zip(expected()) {
            let sum: f64 = terms.iter().map(|term| term.abs()).sum();
            assert!((found / sum - 1.0).abs() < 1e-9, "{found} {sum}");
        }
        // The difference is a millionth of its terms.
        let condition = found[1] / (INPUTS[0] * INPUTS[1] - INPUTS[2]);
        assert!((condition / 4.5e6 - 1.0).abs() < 1e-3, "{condition}");
    }

    #[test]
    fn sensitivities_estimate_the_root_of_the_squares() {
        let module = parse_module("f", TEXT).expect("it is well formed");
        let mut sensitivities = Sensitivities::new(&module.functions[0]);
        let states = 400;
        let mut squares = [0.0; 4];
        for state in 0..states {
            let found = sensitivities.at(&INPUTS, state);
            for (sum, found) in squares.iter_mut().zip(found) {
                *sum += found * found / f64::from(states);
            }
        }
        for (square, terms) in squares.iter().zip(expected()) {
            let exact: f64 = terms.iter().map(|term| term * term).sum();
            assert!((square / exact - 1.0).abs() < 0.1, "{square} {exact}");
        }
    }

    #[test]
    fn judgements_tell_the_problem_from_the_code() {
        let unit = 2f64.powi(-24);
        assert_eq!(Judgement::of(unit, 1e9, unit), Judgement::Accurate);
        assert_eq!(Judgement::of(1e4 * unit, 1e4, unit), Judgement::HardProblem);
        assert_eq!(
            Judgement::of(1e4 * unit, 2.0, unit),
            Judgement::UnstableCode
        );
        assert_eq!(Judgement::of(f64::NAN, 1e9, unit), Judgement::UnstableCode);
    }
}
