//! The condition number of a symmetric matrix in the 2-norm.
//!
//! The largest over the smallest absolute eigenvalue. The matrix is reduced to
//! tridiagonal form by Householder reflections and the three eigenvalues that
//! matter are bisected by counting signs (Golub and Van Loan, *Matrix
//! Computations*, 2013, sections 8.3.1 and 8.4.1). Eigenvalues come out with
//! an absolute error of some rounding errors of the largest, so condition
//! numbers beyond 10¹⁵ state only that they are that large.

use std::iter::once;

/// Halvings of the interval of an eigenvalue; its end points are then
/// neighbours, or as near as the norm's rounding.
const HALVINGS: usize = 80;

/// The condition number of a symmetric matrix, row by row; infinite for one
/// that is singular, NaN for one that holds a NaN or infinity, 1 for one of no
/// rows.
///
/// # Panics
///
/// Panics when the matrix has not `order` squared elements.
pub fn condition(matrix: &[f64], order: usize) -> f64 {
    assert_eq!(matrix.len(), order * order, "a square matrix");
    if order == 0 {
        return 1.0;
    }
    if matrix.iter().any(|element| !element.is_finite()) {
        return f64::NAN;
    }
    let tridiagonal = Tridiagonal::of(matrix.to_vec(), order);
    let negative = tridiagonal.below(0.0);
    // The ends of the spectrum, and the eigenvalues on both sides of zero.
    let ends = [0, order - 1].map(|index| tridiagonal.eigenvalue(index).abs());
    let inner = [negative.checked_sub(1), Some(negative)];
    let inner = inner.into_iter().flatten().filter(|index| *index < order);
    let smallest = inner
        .map(|index| tridiagonal.eigenvalue(index).abs())
        .fold(f64::INFINITY, f64::min);
    ends[0].max(ends[1]) / smallest
}

/// A symmetric tridiagonal matrix.
struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Squares of the elements beside the diagonal.
    squares: Vec<f64>,
    /// No eigenvalue is larger in size.
    bound: f64,
}

impl Tridiagonal {
    /// Reduces a symmetric matrix.
    fn of(mut matrix: Vec<f64>, order: usize) -> Tridiagonal {
        let mut beside = Vec::with_capacity(order.saturating_sub(1));
        for column in 0..order.saturating_sub(1) {
            let below = column + 1..order;
            let mut normal: Vec<f64> = below
                .clone()
                .map(|row| matrix[row * order + column])
                .collect();
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let reflected = if normal[0] > 0.0 { -length } else { length };
            beside.push(reflected);
            normal[0] -= reflected;
            let norm = normal.iter().map(|x| x * x).sum::<f64>();
            if norm == 0.0 {
                continue;
            }
            // A - n w' - w n' with w = p - (n'p / n'n) n, p = 2 A n / n'n.
            let mut change: Vec<f64> = below
                .clone()
                .map(|row| {
                    let row = &matrix[row * order + column + 1..(row + 1) * order];
                    let products = row.iter().zip(&normal).map(|(a, n)| a * n);
                    2.0 * products.sum::<f64>() / norm
                })
                .collect();
            let along: f64 = change.iter().zip(&normal).map(|(p, n)| p * n).sum();
            for (change, n) in change.iter_mut().zip(&normal) {
                *change -= along / norm * n;
            }
            for (i, row) in below.enumerate() {
                let row = &mut matrix[row * order + column + 1..(row + 1) * order];
                for (j, element) in row.iter_mut().enumerate() {
                    *element -= normal[i] * change[j] + change[i] * normal[j];
                }
            }
        }
        let diagonal: Vec<f64> = (0..order).map(|row| matrix[row * order + row]).collect();
        assert_eq!(
            beside.len() + 1,
            order,
            "an element lies between two of the diagonal"
        );
        // Zeros lie before the first row and after the last.
        let beside: Vec<f64> = once(0.0).chain(beside).chain([0.0]).collect();
        let radius = |row: usize| diagonal[row].abs() + beside[row].abs() + beside[row + 1].abs();
        Tridiagonal {
            bound: (0..order).map(radius).fold(0.0, f64::max),
            squares: beside.iter().map(|element| element * element).collect(),
            diagonal,
        }
    }

    /// The number of eigenvalues below a number (Sylvester's law of inertia).
    fn below(&self, number: f64) -> usize {
        let mut count = 0;
        let mut pivot = 1.0;
        for (diagonal, &square) in self.diagonal.iter().zip(&self.squares) {
            pivot = diagonal - number - if square == 0.0 { 0.0 } else { square / pivot };
            if pivot == 0.0 {
                // On an eigenvalue of a leading block: as if just beside it.
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    }

    /// The eigenvalue of a number, from 0 for the smallest.
    fn eigenvalue(&self, index: usize) -> f64 {
        let (mut low, mut high) = (-self.bound, self.bound.next_up());
        for _ in 0..HALVINGS {
            let middle = low + (high - low) / 2.0;
            if self.below(middle) > index {
                high = middle;
            } else {
                low = middle;
            }
        }
        low + (high - low) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found} {expected}"
        );
    }

    #[test]
    fn known_matrices_have_known_conditions() {
        close(condition(&[3.0], 1), 1.0, 1e-12);
        close(condition(&[2.0, 0.0, 0.0, -8.0], 2), 4.0, 1e-12);
        // Eigenvalues 1 and 3.
        close(condition(&[2.0, 1.0, 1.0, 2.0], 2), 3.0, 1e-12);
        // Hilbert's matrix of order 6 (Higham 2002, table 28.1).
        let hilbert: Vec<f64> = (0..36)
            .map(|place| 1.0 / f64::from(place / 6 + place % 6 + 1))
            .collect();
        close(condition(&hilbert, 6), 1.4951e7, 1e-4);
        // Second differences: 2 - 2 cos(k pi / (n + 1)).
        let order = 40;
        let differences: Vec<f64> = (0..order * order)
            .map(
                |place: usize| match (place / order).abs_diff(place % order) {
                    0 => 2.0,
                    1 => -1.0,
                    _ => 0.0,
                },
            )
            .collect();
        let angle = std::f64::consts::PI / 41.0;
        let expected = (1.0 + angle.cos()) / (1.0 - angle.cos());
        close(condition(&differences, order), expected, 1e-10);
    }

    #[test]
    fn singular_and_undefined_matrices_are_told() {
        assert!(condition(&[1.0, 1.0, 1.0, 1.0], 2) > 1e15);
        assert!(condition(&[1.0, f64::NAN, 0.0, 1.0], 2).is_nan());
        assert_eq!(condition(&[], 0), 1.0);
        assert!(condition(&[0.0; 9], 3).is_nan() || condition(&[0.0; 9], 3) > 1e15);
    }
}
