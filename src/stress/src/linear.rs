//! Small dense linear algebra in any arithmetic, and condition numbers.

use super::numbers::Wide;
use robovec_dynamics::kinematics::linear::DenseMatrix;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};

/// The factor `L` of `M = L L'` (Cholesky), or its first pivot not positive.
pub(super) fn factorise<A: Arithmetic<Number: Wide>>(
    arithmetic: &A,
    size: usize,
    matrix: &mut [A::Number],
) -> Result<(), usize> {
    assert_eq!(matrix.len(), size * size, "a square matrix");
    for row in 0..size {
        for column in 0..=row {
            let mut rest = matrix[row * size + column];
            for k in 0..column {
                let product = arithmetic.mul(matrix[row * size + k], matrix[column * size + k]);
                rest = arithmetic.sub(rest, product);
            }
            matrix[row * size + column] = if column < row {
                arithmetic.div(rest, matrix[column * size + column])
            } else if rest.wide().high > 0.0 && rest.wide().high.is_finite() {
                arithmetic.sqrt(rest)
            } else {
                return Err(row);
            };
        }
    }
    Ok(())
}

/// Solves `L L' x = right` for a factor of [`factorise`].
pub(super) fn substitute<A: Arithmetic>(
    arithmetic: &A,
    factor: &[A::Number],
    right: &[A::Number],
) -> Vec<A::Number> {
    let size = right.len();
    assert_eq!(
        factor.len(),
        size * size,
        "a square factor with one number per row"
    );
    let mut x = right.to_vec();
    for row in 0..size {
        for k in 0..row {
            x[row] = arithmetic.sub(x[row], arithmetic.mul(factor[row * size + k], x[k]));
        }
        x[row] = arithmetic.div(x[row], factor[row * size + row]);
    }
    for row in (0..size).rev() {
        for k in row + 1..size {
            x[row] = arithmetic.sub(x[row], arithmetic.mul(factor[k * size + row], x[k]));
        }
        x[row] = arithmetic.div(x[row], factor[row * size + row]);
    }
    x
}

/// Solves a positive definite system, or another with pivots, exactly.
pub(super) fn solve(size: usize, matrix: &[Double], right: &[Double]) -> Option<Vec<Double>> {
    let mut factor = matrix.to_vec();
    match factorise(&DoubleDouble, size, &mut factor) {
        Ok(()) => Some(substitute(&DoubleDouble, &factor, right)),
        Err(_) => eliminate(&DoubleDouble, size, matrix.to_vec(), right.to_vec()),
    }
}

/// Gaussian elimination with partial pivoting; `None` when a pivot vanishes.
pub(super) fn eliminate<A: Arithmetic<Number: Wide>>(
    a: &A,
    size: usize,
    mut matrix: Vec<A::Number>,
    mut right: Vec<A::Number>,
) -> Option<Vec<A::Number>> {
    assert_eq!(matrix.len(), size * size, "a square matrix");
    assert_eq!(right.len(), size, "one number per row");
    for k in 0..size {
        let height = |matrix: &[A::Number], row: usize| matrix[row * size + k].wide().high.abs();
        let order = |&a: &usize, &b: &usize| height(&matrix, a).total_cmp(&height(&matrix, b));
        let pivot = (k..size).max_by(order)?;
        if height(&matrix, pivot) == 0.0 || !height(&matrix, pivot).is_finite() {
            return None;
        }
        for column in 0..size {
            matrix.swap(k * size + column, pivot * size + column);
        }
        right.swap(k, pivot);
        for row in k + 1..size {
            let factor = a.div(matrix[row * size + k], matrix[k * size + k]);
            if factor.wide().high == 0.0 {
                continue;
            }
            for column in k..size {
                let known = a.mul(factor, matrix[k * size + column]);
                matrix[row * size + column] = a.sub(matrix[row * size + column], known);
            }
            right[row] = a.sub(right[row], a.mul(factor, right[k]));
        }
    }
    for row in (0..size).rev() {
        for k in row + 1..size {
            right[row] = a.sub(right[row], a.mul(matrix[row * size + k], right[k]));
        }
        right[row] = a.div(right[row], matrix[row * size + row]);
    }
    Some(right)
}

/// Sweeps of Jacobi's method; it converges in fewer than ten.
const SWEEPS: usize = 40;

/// The eigenvalues of a symmetric matrix, by cyclic Jacobi rotations (Golub
/// and Van Loan, "Matrix Computations", 8.5).
pub(super) fn eigenvalues(mut matrix: DenseMatrix) -> Vec<f64> {
    let size = matrix.rows();
    assert_eq!(matrix.columns(), size, "a square matrix");
    debug_assert!(
        (0..size).all(|p| (0..p).all(|q| matrix[(p, q)].to_bits() == matrix[(q, p)].to_bits())),
        "a symmetric matrix"
    );
    let all = (0..size).flat_map(|row| matrix.row(row));
    let largest = all.fold(0.0f64, |most, x| most.max(x.abs()));
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..size {
            for q in p + 1..size {
                let off = matrix[(p, q)];
                let (a, b) = (matrix[(p, p)], matrix[(q, q)]);
                // Relative to the geometric mean, so that graded matrices
                // keep their small eigenvalues; what is nothing beside the
                // whole matrix ends the method where a diagonal is zero.
                let small = (1e-17 * (a.abs() * b.abs()).sqrt()).max(1e-30 * largest);
                if off.abs() <= small {
                    continue;
                }
                rotated = true;
                let theta = (b - a) / (2.0 * off);
                let sign = if theta < 0.0 { -1.0 } else { 1.0 };
                let tangent = sign / (theta.abs() + theta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                rotate(&mut matrix, p, q, cosine, tangent * cosine);
                // What the rotation was to remove.
                matrix[(p, q)] = 0.0;
                matrix[(q, p)] = 0.0;
            }
        }
        if !rotated {
            break;
        }
    }
    (0..size).map(|i| matrix[(i, i)]).collect()
}

fn rotate(matrix: &mut DenseMatrix, p: usize, q: usize, cosine: f64, sine: f64) {
    for k in 0..matrix.rows() {
        let (x, y) = (matrix[(k, p)], matrix[(k, q)]);
        matrix[(k, p)] = cosine * x - sine * y;
        matrix[(k, q)] = sine * x + cosine * y;
    }
    for k in 0..matrix.rows() {
        let (x, y) = (matrix[(p, k)], matrix[(q, k)]);
        matrix[(p, k)] = cosine * x - sine * y;
        matrix[(q, k)] = sine * x + cosine * y;
    }
}

/// The condition number of a symmetric matrix in the spectral norm.
pub(super) fn condition(matrix: DenseMatrix) -> f64 {
    let sizes = eigenvalues(matrix).into_iter().map(f64::abs);
    let start = [0.0f64, f64::INFINITY];
    let [most, least] = sizes.fold(start, |[most, least], x| [most.max(x), least.min(x)]);
    most / least
}

/// Condition number of a positive definite matrix too large for Jacobi's
/// method, by power iterations; infinite when binary64 cannot factorise it.
pub(super) fn estimated_condition(size: usize, entries: &[f64]) -> f64 {
    assert_eq!(entries.len(), size * size, "a square matrix");
    use robovec_num::arithmetic::Binary64;
    const STEPS: usize = 60;
    let mut factor = entries.to_vec();
    if factorise(&Binary64, size, &mut factor).is_err() {
        return f64::INFINITY;
    }
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let growth = |next: &dyn Fn(&[f64]) -> Vec<f64>| {
        // No symmetry of the model is orthogonal to this.
        let mut x: Vec<f64> = (0..size).map(|i| 1.0 + (i * 7 % 11) as f64).collect();
        let mut growth = 0.0;
        for _ in 0..STEPS {
            let length = norm(&x);
            x.iter_mut().for_each(|x| *x /= length);
            x = next(&x);
            growth = norm(&x);
        }
        growth
    };
    let times = |x: &[f64]| -> Vec<f64> {
        let row = |row: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum();
        entries.chunks(size).map(row).collect()
    };
    let most = growth(&times);
    let inverse = growth(&|x: &[f64]| substitute(&Binary64, &factor, x));
    most * inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hilbert(size: usize) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(size, size);
        for row in 0..size {
            for column in 0..size {
                matrix[(row, column)] = 1.0 / (1 + row + column) as f64;
            }
        }
        matrix
    }

    #[test]
    fn condition_numbers_are_those_of_known_matrices() {
        // The Hilbert matrix of order 5 (Golub and Van Loan, 2.6.2).
        let exact = condition(hilbert(5));
        assert!((exact / 476_607.25 - 1.0).abs() < 1e-6, "{exact}");
        let entries: Vec<f64> = (0..5)
            .flat_map(|row| hilbert(5).row(row).to_vec())
            .collect();
        let estimate = estimated_condition(5, &entries);
        assert!((estimate / exact - 1.0).abs() < 1e-6, "{estimate}");
        // A graded matrix keeps its small eigenvalue.
        let mut graded = DenseMatrix::zeros(2, 2);
        graded[(0, 0)] = 1e20;
        (graded[(0, 1)], graded[(1, 0)]) = (1.0, 1.0);
        graded[(1, 1)] = 1.0;
        assert_eq!(condition(graded), 1e20);
    }

    #[test]
    fn solutions_solve_with_and_without_a_factor() {
        let size = 4;
        let numbers =
            |numbers: &[f64]| -> Vec<Double> { numbers.iter().map(|&x| Double::from(x)).collect() };
        let rows: Vec<f64> = (0..size)
            .flat_map(|i| hilbert(size).row(i).to_vec())
            .collect();
        let mut turned = rows.clone();
        turned[0] = -5.0;
        for entries in [rows, turned] {
            let matrix = numbers(&entries);
            let right = numbers(&[1.0, -2.0, 3.0, 0.5]);
            let x = solve(size, &matrix, &right).expect("it is regular");
            for row in 0..size {
                let sum = (0..size).fold(-right[row], |sum, k| sum + matrix[row * size + k] * x[k]);
                assert!(sum.high.abs() < 1e-25, "{sum:?}");
            }
        }
    }
}
