//! Dense linear algebra for systems of a few hundred unknowns.

/// A dense matrix, row by row.
#[derive(Clone, PartialEq, Debug)]
pub struct DenseMatrix {
    rows: usize,
    columns: usize,
    entries: Vec<f64>,
}

impl DenseMatrix {
    /// A matrix of zeros.
    pub fn zeros(rows: usize, columns: usize) -> DenseMatrix {
        DenseMatrix {
            rows,
            columns,
            entries: vec![0.0; rows * columns],
        }
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// A row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.columns..][..self.columns]
    }

    /// The given rows and columns, in the given order.
    pub fn select(&self, rows: &[usize], columns: &[usize]) -> DenseMatrix {
        let entries = rows.iter().flat_map(|&row| {
            let row = self.row(row);
            columns.iter().map(move |&column| row[column])
        });
        DenseMatrix {
            rows: rows.len(),
            columns: columns.len(),
            entries: entries.collect(),
        }
    }

    /// Multiplies every entry.
    pub fn scale(&mut self, factor: f64) {
        for entry in &mut self.entries {
            *entry *= factor;
        }
    }

    /// Matrix times vector.
    pub fn times(&self, vector: &[f64]) -> Vec<f64> {
        assert_eq!(vector.len(), self.columns, "one number per column");
        (0..self.rows())
            .map(|row| dot(self.row(row), vector))
            .collect()
    }

    /// The transposed matrix times a vector.
    pub fn transposed_times(&self, vector: &[f64]) -> Vec<f64> {
        assert_eq!(vector.len(), self.rows, "one number per row");
        let mut result = vec![0.0; self.columns];
        for (row, &factor) in vector.iter().enumerate() {
            for (sum, entry) in result.iter_mut().zip(self.row(row)) {
                *sum += entry * factor;
            }
        }
        result
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> DenseMatrix {
        let mut result = DenseMatrix::zeros(self.columns, self.rows());
        for row in 0..self.rows() {
            for (column, &entry) in self.row(row).iter().enumerate() {
                result[(column, row)] = entry;
            }
        }
        result
    }

    /// Matrix times matrix.
    pub fn product(&self, other: &DenseMatrix) -> DenseMatrix {
        assert_eq!(self.columns, other.rows, "one row per column");
        let entries = (0..self.rows()).flat_map(|row| other.transposed_times(self.row(row)));
        DenseMatrix {
            rows: self.rows,
            columns: other.columns,
            entries: entries.collect(),
        }
    }
}

impl std::ops::Index<(usize, usize)> for DenseMatrix {
    type Output = f64;
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        debug_assert!(column < self.columns, "the column exists");
        &self.entries[row * self.columns + column]
    }
}

impl std::ops::IndexMut<(usize, usize)> for DenseMatrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.entries[row * self.columns + column]
    }
}

/// The sum of products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "vectors of one length");
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The largest magnitude; infinite where a number is undefined.
pub fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| {
        if x.is_nan() {
            f64::INFINITY
        } else {
            x.abs().max(most)
        }
    })
}

/// A matrix of one column.
pub fn column(numbers: &[f64]) -> DenseMatrix {
    let mut matrix = DenseMatrix::zeros(numbers.len(), 1);
    for (row, &number) in numbers.iter().enumerate() {
        matrix[(row, 0)] = number;
    }
    matrix
}

/// Solves a symmetric positive definite system; a pivot must keep more than
/// `threshold` of its entry on the diagonal.
///
/// # Errors
///
/// The index of the first pivot that does not: that unknown is determined by
/// those before it or by none.
pub fn solve_positive(
    mut matrix: DenseMatrix,
    mut right: Vec<f64>,
    threshold: f64,
) -> Result<Vec<f64>, usize> {
    let n = right.len();
    assert_eq!(
        (matrix.rows, matrix.columns),
        (n, n),
        "a square matrix with one number per row"
    );
    // A factorisation L D L', with D on the diagonal.
    for i in 0..n {
        let original = matrix[(i, i)];
        for j in 0..i {
            let known: f64 = (0..j)
                .map(|k| matrix[(i, k)] * matrix[(k, k)] * matrix[(j, k)])
                .sum();
            matrix[(i, j)] = (matrix[(i, j)] - known) / matrix[(j, j)];
        }
        let known: f64 = (0..i)
            .map(|k| matrix[(i, k)] * matrix[(i, k)] * matrix[(k, k)])
            .sum();
        let pivot = original - known;
        if pivot.is_nan() || pivot <= threshold * original.abs() {
            return Err(i);
        }
        matrix[(i, i)] = pivot;
    }
    for i in 0..n {
        let known: f64 = (0..i).map(|k| matrix[(i, k)] * right[k]).sum();
        right[i] -= known;
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| matrix[(k, i)] * right[k]).sum();
        right[i] = right[i] / matrix[(i, i)] - known;
    }
    Ok(right)
}

/// One step of an elimination: its row and column, and the size of the pivot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pivot {
    /// Row of the matrix.
    pub row: usize,
    /// Column of the matrix.
    pub column: usize,
    /// Magnitude, without the column's weight.
    pub size: f64,
}

/// Gaussian elimination with complete pivoting: the pivots in order, those of
/// the largest weighted size first, down to a fraction `threshold` of the
/// first. Their number is the rank. A column of weight 0 is left out.
pub fn eliminate(mut matrix: DenseMatrix, weights: &[f64], threshold: f64) -> Vec<Pivot> {
    let (rows, columns) = (matrix.rows(), matrix.columns());
    assert_eq!(weights.len(), columns, "one weight per column");
    let mut row_free = vec![true; rows];
    let mut column_free = vec![true; columns];
    let mut pivots: Vec<Pivot> = Vec::new();
    // The size of the first pivot.
    let mut first: Option<f64> = None;
    loop {
        let mut best: Option<(f64, Pivot)> = None;
        for row in (0..rows).filter(|&row| row_free[row]) {
            for column in (0..columns).filter(|&column| column_free[column]) {
                let size = matrix[(row, column)].abs();
                let weighted = size * weights[column];
                if weighted > 0.0 && best.is_none_or(|(most, _)| weighted > most) {
                    best = Some((weighted, Pivot { row, column, size }));
                }
            }
        }
        let Some((_, pivot)) = best else { break };
        if pivot.size <= threshold * *first.get_or_insert(pivot.size) {
            break;
        }
        row_free[pivot.row] = false;
        column_free[pivot.column] = false;
        for row in (0..rows).filter(|&row| row_free[row]) {
            let factor = matrix[(row, pivot.column)] / matrix[(pivot.row, pivot.column)];
            for column in 0..columns {
                let known = factor * matrix[(pivot.row, column)];
                matrix[(row, column)] -= known;
            }
        }
        pivots.push(pivot);
    }
    pivots
}

/// The sign of the determinant of a square matrix, by elimination with partial
/// pivoting: 1 or -1, and 0 where it is singular or not finite.
pub fn determinant_sign(mut matrix: DenseMatrix) -> i8 {
    let n = matrix.rows();
    assert_eq!(matrix.columns, n, "a square matrix");
    let mut sign = 1;
    for k in 0..n {
        let size = |row: &usize| matrix[(*row, k)].abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)));
        let pivot = pivot.expect("rows are left");
        let value = matrix[(pivot, k)];
        if value == 0.0 || !value.is_finite() {
            return 0;
        }
        if (pivot != k) != (value < 0.0) {
            sign = -sign;
        }
        for column in 0..n {
            let (upper, lower) = (matrix[(k, column)], matrix[(pivot, column)]);
            (matrix[(k, column)], matrix[(pivot, column)]) = (lower, upper);
        }
        for row in k + 1..n {
            let factor = matrix[(row, k)] / value;
            for column in k..n {
                let known = factor * matrix[(k, column)];
                matrix[(row, column)] -= known;
            }
        }
    }
    sign
}

/// Solves a square system for several right sides, the columns of `right`, by
/// elimination with partial pivoting. `None` when the matrix is singular.
pub fn solve_square(mut matrix: DenseMatrix, mut right: DenseMatrix) -> Option<DenseMatrix> {
    let n = matrix.rows();
    assert_eq!(matrix.columns, n, "a square matrix");
    assert_eq!(right.rows, n, "right sides of one length");
    let sides = right.columns();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| {
            let size = |row: usize| matrix[(row, k)].abs();
            size(a).total_cmp(&size(b))
        })?;
        let size = matrix[(pivot, k)];
        if size == 0.0 || !size.is_finite() {
            return None;
        }
        for column in 0..n {
            let (upper, lower) = (matrix[(k, column)], matrix[(pivot, column)]);
            (matrix[(k, column)], matrix[(pivot, column)]) = (lower, upper);
        }
        for column in 0..sides {
            let (upper, lower) = (right[(k, column)], right[(pivot, column)]);
            (right[(k, column)], right[(pivot, column)]) = (lower, upper);
        }
        for row in k + 1..n {
            let factor = matrix[(row, k)] / matrix[(k, k)];
            for column in k..n {
                let known = factor * matrix[(k, column)];
                matrix[(row, column)] -= known;
            }
            for column in 0..sides {
                let known = factor * right[(k, column)];
                right[(row, column)] -= known;
            }
        }
    }
    for side in 0..sides {
        for row in (0..n).rev() {
            let known: f64 = (row + 1..n)
                .map(|k| matrix[(row, k)] * right[(k, side)])
                .sum();
            right[(row, side)] = (right[(row, side)] - known) / matrix[(row, row)];
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(rows: usize, columns: usize) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                matrix[(i, j)] = ((3 * i + 5 * j + i * j * j) % 11) as f64 - 4.0;
            }
        }
        matrix
    }

    fn close(left: &[f64], right: &[f64]) {
        assert_eq!(left.len(), right.len());
        for (left, right) in left.iter().zip(right) {
            assert!((left - right).abs() < 1e-9, "{left} {right}");
        }
    }

    #[test]
    fn solutions_solve() {
        let square = sample(5, 5);
        let right = sample(5, 2);
        let solution = solve_square(square.clone(), right.clone()).expect("regular");
        let back = square.product(&solution);
        close(&back.entries, &right.entries);
        let mut positive = square.product(&square.transposed());
        for i in 0..5 {
            positive[(i, i)] += 1.0;
        }
        let right = vec![1.0, -2.0, 3.0, 0.5, 0.0];
        let solution = solve_positive(positive.clone(), right.clone(), 1e-14).expect("positive");
        close(&positive.times(&solution), &right);
        close(&positive.transposed_times(&solution), &right);
    }

    #[test]
    fn what_is_singular_is_told() {
        let mut matrix = DenseMatrix::zeros(3, 3);
        for i in [0, 1] {
            matrix[(i, i)] = 2.0;
        }
        assert_eq!(solve_positive(matrix.clone(), vec![1.0; 3], 1e-13), Err(2));
        assert!(solve_square(matrix.clone(), DenseMatrix::zeros(3, 1)).is_none());
        matrix[(0, 0)] = f64::NAN;
        assert_eq!(solve_positive(matrix.clone(), vec![1.0; 3], 1e-13), Err(0));
        assert!(solve_square(matrix, DenseMatrix::zeros(3, 1)).is_none());
    }

    #[test]
    fn determinants_have_signs() {
        let entries = |list: [f64; 9]| {
            let mut matrix = DenseMatrix::zeros(3, 3);
            for (place, number) in list.into_iter().enumerate() {
                matrix[(place / 3, place % 3)] = number;
            }
            matrix
        };
        // By Sarrus 1, -1, 0 and 23.
        let first = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let second = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let third = [1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 1.0, 5.0];
        let fourth = [2.0, -1.0, 0.0, 3.0, 1.0, -2.0, 1.0, 4.0, 1.0];
        let signs = [first, second, third, fourth].map(|list| determinant_sign(entries(list)));
        assert_eq!(signs, [1, -1, 0, 1]);
    }

    #[test]
    fn elimination_finds_the_rank_and_prefers_weights() {
        let mut matrix = DenseMatrix::zeros(3, 4);
        for j in 0..4 {
            matrix[(0, j)] = (j + 1) as f64;
            matrix[(1, j)] = 2.0 * (j + 1) as f64;
            matrix[(2, j)] = if j == 1 { 1.0 } else { 0.0 };
        }
        let pivots = eliminate(matrix.clone(), &[1.0; 4], 1e-9);
        assert_eq!(pivots.len(), 2);
        assert_eq!((pivots[0].row, pivots[0].column), (1, 3));
        let pivots = eliminate(matrix, &[0.0, 1.0, 100.0, 0.0], 1e-9);
        assert_eq!(pivots[0].column, 2);
        assert_eq!(pivots[1].column, 1);
    }
}
