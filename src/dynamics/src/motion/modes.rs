//! The modes of small motions: eigenvalues of `s^2 Mr + s D + K`.
//!
//! They are eigenvalues of the first-order system, in a unit of time that gives
//! stiffness and mass one size, then refined in the quadratic problem: with
//! right and left vectors x and y by inverse iteration, and Newton's step `y^H
//! Q(s) x / y^H Q'(s) x`. The same quotient with the possible rounding error of
//! `Q(s) x` as numerator is the error bound (Tisseur, "Backward error and
//! condition of polynomial eigenvalue problems", 2000, theorem 5).

use super::MotionError;
use super::linearise::SmallMotions;
use crate::kinematics::linear::DenseMatrix;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// A complex number.
pub type ComplexNumber = Complex<f64>;

/// A mode, or a pair of conjugate ones.
#[derive(Clone, PartialEq, Debug)]
pub struct Mode {
    /// The eigenvalue, 1/s; of a pair the one above the real axis.
    pub eigenvalue: ComplexNumber,
    /// Bound of its error by rounding, 1/s; `None` for one of several nearly
    /// equal eigenvalues, which depend on rounding more than linearly.
    pub error: Option<f64>,
    /// The motion of every joint, the largest one 1.
    pub shape: Vec<ComplexNumber>,
}

impl Mode {
    /// The frequency of the oscillation, Hz.
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.im / std::f64::consts::TAU
    }

    /// The share of critical damping: `-Re s / |s|`; zero at zero.
    pub fn damping_ratio(&self) -> f64 {
        match self.eigenvalue.norm() {
            0.0 => 0.0,
            size => -self.eigenvalue.re / size,
        }
    }
}

/// The maximum number of rounds of the eigenvalues' iteration, for each row.
const ROUNDS: usize = 100;

/// Part of the sum of a row's terms that may be rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Refinements larger than this share of an eigenvalue find another one.
const TRUST: f64 = 1e-5;

/// The modes of small motions, the slowest first.
///
/// # Errors
///
/// [`MotionError::Modes`] at a singular mass matrix or without eigenvalues.
pub fn modes(motions: &SmallMotions) -> Result<Vec<Mode>, MotionError> {
    let count = motions.joints.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    let problem = QuadraticProblem::new(motions);
    let mut found: Vec<Mode> = Vec::new();
    for start in problem.eigenvalues()? {
        // Real but for rounding is real.
        let start = if start.im.abs() <= ROUNDING * start.norm() {
            ComplexNumber::new(start.re, 0.0)
        } else {
            start
        };
        if start.im >= 0.0 {
            found.push(problem.mode(start, motions));
        }
    }
    let order = |mode: &Mode| (mode.eigenvalue.norm(), mode.eigenvalue.re);
    found.sort_by(|one, other| {
        let (one, other) = (order(one), order(other));
        one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
    });
    Ok(found)
}

/// `Q(s) = s^2 M + s D + K`.
struct QuadraticProblem {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

fn dense(matrix: &DenseMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.rows(), matrix.columns(), |row, column| {
        matrix[(row, column)]
    })
}

impl QuadraticProblem {
    fn new(motions: &SmallMotions) -> QuadraticProblem {
        let count = motions.joints.len();
        assert!(
            [&motions.mass, &motions.damping, &motions.stiffness]
                .iter()
                .all(|matrix| [matrix.rows(), matrix.columns()] == [count; 2]),
            "one row and one column per independent joint"
        );
        QuadraticProblem {
            mass: dense(&motions.mass),
            damping: dense(&motions.damping),
            stiffness: dense(&motions.stiffness),
        }
    }

    /// All eigenvalues, unrefined.
    fn eigenvalues(&self) -> Result<Vec<ComplexNumber>, MotionError> {
        let count = self.mass.nrows();
        let factors = self.mass.clone().cholesky().ok_or_else(|| {
            MotionError::Modes("the mass matrix is not positive definite".to_owned())
        })?;
        let (stiff, damped) = (factors.solve(&self.stiffness), factors.solve(&self.damping));
        // In units of this rate both halves of the matrix are of one size.
        let rate = match stiff.amax().sqrt() {
            0.0 => 1.0,
            rate => rate,
        };
        let mut matrix = DMatrix::zeros(2 * count, 2 * count);
        for row in 0..count {
            matrix[(row, count + row)] = 1.0;
            for column in 0..count {
                matrix[(count + row, column)] = -stiff[(row, column)] / rate / rate;
                matrix[(count + row, count + column)] = -damped[(row, column)] / rate;
            }
        }
        let schur = Schur::try_new(matrix, f64::EPSILON, ROUNDS * 2 * count).ok_or_else(|| {
            MotionError::Modes("the iteration of the eigenvalues does not end".to_owned())
        })?;
        let eigenvalues = schur.complex_eigenvalues();
        Ok(eigenvalues.iter().map(|&value| value * rate).collect())
    }

    /// `Q(s)`.
    fn at(&self, s: ComplexNumber) -> DMatrix<ComplexNumber> {
        let number = |matrix: &DMatrix<f64>, at| ComplexNumber::from(matrix[at]);
        let count = self.mass.nrows();
        DMatrix::from_fn(count, count, |row, column| {
            let at = (row, column);
            (number(&self.mass, at) * s + number(&self.damping, at)) * s
                + number(&self.stiffness, at)
        })
    }

    /// `Q'(s) x`.
    fn slope(&self, s: ComplexNumber, x: &DVector<ComplexNumber>) -> DVector<ComplexNumber> {
        let real = |matrix: &DMatrix<f64>| matrix.map(ComplexNumber::from) * x;
        real(&self.mass) * (s + s) + real(&self.damping)
    }

    /// The largest that `Q(s) x` may be by rounding of the matrices.
    fn rounding(&self, s: ComplexNumber, x: &DVector<ComplexNumber>) -> f64 {
        let sizes = x.map(|x| x.norm());
        let of = |matrix: &DMatrix<f64>| matrix.abs() * &sizes;
        let size = s.norm();
        let total = of(&self.mass) * (size * size) + of(&self.damping) * size + of(&self.stiffness);
        ROUNDING * total.norm()
    }

    /// A unit vector near the null space of a matrix, by inverse iteration.
    fn null_vector(matrix: DMatrix<ComplexNumber>) -> DVector<ComplexNumber> {
        let count = matrix.nrows();
        let size = matrix.iter().fold(0.0, |most: f64, x| most.max(x.norm()));
        // Any start that is orthogonal to none of the usual shapes.
        let mut vector = DVector::from_fn(count, |row, _| {
            ComplexNumber::new(1.0, 0.1 + 0.37 * row as f64 % 1.0)
        });
        // A matrix that is singular to the last digit is moved by one of them.
        let mut shift = 0.0;
        let factors = loop {
            let moved = match shift {
                0.0 => matrix.clone(),
                shift => &matrix + DMatrix::identity(count, count) * ComplexNumber::from(shift),
            };
            let factors = moved.lu();
            if factors.is_invertible() || shift > size {
                break factors;
            }
            shift = if shift == 0.0 {
                size.max(f64::MIN_POSITIVE) * f64::EPSILON
            } else {
                4.0 * shift
            };
        };
        for _ in 0..4 {
            let Some(next) = factors.solve(&vector) else {
                break;
            };
            let length = next.norm();
            if !(length.is_finite() && length > 0.0) {
                break;
            }
            vector = next / ComplexNumber::from(length);
        }
        vector
    }

    /// The mode near an eigenvalue.
    fn mode(&self, start: ComplexNumber, motions: &SmallMotions) -> Mode {
        let mut s = start;
        let (mut x, mut error) = (DVector::zeros(0), None);
        for _ in 0..3 {
            let matrix = self.at(s);
            x = QuadraticProblem::null_vector(matrix.clone());
            let y = QuadraticProblem::null_vector(matrix.adjoint());
            let slope = y.dotc(&self.slope(s, &x));
            let left = &matrix * &x;
            let step = y.dotc(&left) / slope;
            let bound = (self.rounding(s, &x) + left.norm()) / slope.norm();
            let near = TRUST * s.norm();
            error = Some(bound).filter(|bound| *bound <= near.max(f64::MIN_POSITIVE));
            if !step.is_finite() || step.norm() > near {
                break;
            }
            s -= step;
            if start.im == 0.0 {
                s.im = 0.0;
            }
        }
        Mode {
            eigenvalue: s,
            error,
            shape: shape(motions, &x),
        }
    }
}

/// The motion of all joints for one of the independent ones.
fn shape(motions: &SmallMotions, x: &DVector<ComplexNumber>) -> Vec<ComplexNumber> {
    let transform = dense(&motions.transform).map(ComplexNumber::from);
    let moved = transform * x;
    let most = moved.iter().fold(ComplexNumber::from(0.0), |most, &x| {
        // The first of those that are alike, whatever their last digits.
        if x.norm() > most.norm() * (1.0 + 1e-9) {
            x
        } else {
            most
        }
    });
    let one = if most.norm() > 0.0 {
        most
    } else {
        ComplexNumber::from(1.0)
    };
    moved.iter().map(|x| x / one).collect()
}
