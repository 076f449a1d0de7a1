//! Linear equations solved with symbols.
//!
//! A mass matrix is eliminated from the leaves to the base: `L^T D L` with unit
//! triangular `L`. In this order two joints get an entry only where one is an
//! ancestor of the other, so a tree's zeros stay zeros. Every entry is one
//! sum over the joints eliminated before, which later passes may balance.

use super::GenerateError;
use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};
use robovec_model::Model;
use std::collections::BTreeMap;

/// A row of a sparse matrix: columns in ascending order, no zeros.
pub(super) type SparseRow = Vec<(usize, Scalar)>;

pub(super) fn entry(row: &[(usize, Scalar)], column: usize) -> Scalar {
    debug_assert!(
        row.is_sorted_by(|one, next| one.0 < next.0),
        "columns ascend"
    );
    row.binary_search_by_key(&column, |&(column, _)| column)
        .map_or(Scalar::ZERO, |place| row[place].1)
}

/// The entry of a row whose columns are in any order.
pub(super) fn find_entry(row: &[(usize, Scalar)], column: usize) -> Scalar {
    let found = row.iter().find(|(other, _)| *other == column);
    found.map_or(Scalar::ZERO, |&(_, value)| value)
}

/// Maximum number of products of an elimination: those of 230 dense rows.
pub(super) const LIMIT: usize = 2_000_000;

/// Products of the elimination of a tree's mass matrix, without loops.
pub(super) fn products(model: &Model) -> usize {
    let pairs = |depth: &usize| depth.saturating_mul(depth - 1) / 2;
    let depths = model.depths();
    depths.iter().map(pairs).fold(0, usize::saturating_add)
}

/// Reason why an elimination stopped.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Stop {
    /// The row of this number has no pivot.
    NoPivot(usize),
    /// It takes more than [`LIMIT`] products.
    TooLarge,
}

/// The error of a mass matrix whose elimination is too long.
pub(super) fn too_large(model: &Model) -> GenerateError {
    GenerateError::Elimination {
        model: model.name.clone(),
        limit: LIMIT,
    }
}

/// Solves `M X = B` for a symmetric matrix by its lower triangle.
pub(super) fn solve_symmetric(
    equations: &mut Equations,
    rows: &[SparseRow],
    sides: &[Vec<Scalar>],
    joints: &[usize],
) -> Result<Vec<Vec<Scalar>>, Stop> {
    let count = rows.len();
    assert_eq!(joints.len(), count, "every row has its joint");
    assert!(
        sides.iter().all(|side| side.len() == count),
        "one number per row"
    );
    debug_assert!(
        (0..count).all(|i| rows[i].iter().all(|&(column, _)| column <= i)),
        "rows are those of the lower triangle"
    );
    let mut work = 0;
    let mut factors: Vec<SparseRow> = vec![Vec::new(); count];
    let mut entries: Vec<SparseRow> = vec![Vec::new(); count];
    let mut behind: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut halves = vec![vec![Scalar::ZERO; sides.len()]; count];
    let mut middle = halves.clone();
    for i in (0..count).rev() {
        let label = |name: &'static str| QuantityLabel::new(name, 0, joints[i] + 1);
        let mut row: BTreeMap<usize, Sum> = BTreeMap::new();
        for &(column, value) in &rows[i] {
            row.entry(column).or_default().add(&[value]);
        }
        let mut half: Vec<Sum> = sides.iter().map(|right| Sum::of(right[i])).collect();
        for &k in &behind[i] {
            let factor = entry(&factors[k], i);
            for (half, &behind) in half.iter_mut().zip(&halves[k]) {
                half.subtract(&[factor, behind]);
            }
            work += entries[k].partition_point(|&(column, _)| column <= i) + sides.len() - 1;
            for &(column, value) in entries[k].iter().take_while(|&&(column, _)| column <= i) {
                row.entry(column).or_default().subtract(&[factor, value]);
            }
        }
        if work > LIMIT {
            return Err(Stop::TooLarge);
        }
        for (side, half) in half.into_iter().enumerate() {
            halves[i][side] = equations.define(label("qppb").column(side), half);
        }
        for (column, sum) in row {
            let value = equations.define(label("Mrd").column(joints[column] + 1), sum);
            if !value.is_zero() {
                entries[i].push((column, value));
            }
        }
        let pivot = entry(&entries[i], i);
        if pivot.is_zero() {
            return Err(Stop::NoPivot(i));
        }
        let inverse = equations.quotient(label("Mri"), Scalar::ONE, pivot);
        for side in 0..sides.len() {
            let label = label("qppd").column(side);
            middle[i][side] = product(equations, label, halves[i][side], inverse);
        }
        for &(column, value) in entries[i].iter().filter(|&&(column, _)| column < i) {
            let label = label("Mrlu").column(joints[column] + 1);
            factors[i].push((column, product(equations, label, value, inverse)));
            behind[column].push(i);
        }
    }
    let mut solutions = vec![Vec::with_capacity(count); sides.len()];
    for (side, solution) in solutions.iter_mut().enumerate() {
        for i in 0..count {
            let mut sum = Sum::of(middle[i][side]);
            for &(column, factor) in &factors[i] {
                sum.subtract(&[factor, solution[column]]);
            }
            let label = QuantityLabel::new("qppu", 0, joints[i] + 1).column(side);
            solution.push(equations.define(label, sum));
        }
    }
    Ok(solutions)
}

pub(super) fn product(
    equations: &mut Equations,
    label: QuantityLabel,
    one: Scalar,
    other: Scalar,
) -> Scalar {
    let sum = Sum::product(&[one, other]);
    equations.define(label, sum)
}

/// Solves `A X = B` for a square matrix with rows and columns in the order of
/// pivots. A row holds its columns, then those of the right sides. The names
/// are those of the triangular factors, of the pivots' inverses, and of the
/// solution before and after its division. Gives the solution and those
/// inverses; the number of a row without a pivot is an error.
pub(super) fn solve_square(
    equations: &mut Equations,
    [upper_name, lower_name, inverse_name, half_name, name]: [&'static str; 5],
    rows: &[SparseRow],
    sides: usize,
) -> Result<(Vec<SparseRow>, Vec<Scalar>), usize> {
    let count = rows.len();
    debug_assert!(
        rows.iter()
            .flatten()
            .all(|&(column, _)| column < count + sides),
        "columns are those of the matrix and of the right sides"
    );
    let mut inverses = Vec::with_capacity(count);
    let mut upper: Vec<SparseRow> = Vec::with_capacity(count);
    for (i, given) in rows.iter().enumerate() {
        let label = |column: usize| QuantityLabel::new(upper_name, 0, i + 1).column(column + 1);
        let mut row: BTreeMap<usize, Sum> = BTreeMap::new();
        for &(column, value) in given {
            row.entry(column).or_default().add(&[value]);
        }
        for k in 0..i {
            let Some(sum) = row.remove(&k) else { continue };
            let value = equations.define(label(k), sum);
            let name = QuantityLabel::new(lower_name, 0, i + 1).column(k + 1);
            let factor = product(equations, name, value, inverses[k]);
            for &(column, value) in upper[k].iter().filter(|&&(column, _)| column > k) {
                row.entry(column).or_default().subtract(&[factor, value]);
            }
        }
        let mut named = SparseRow::new();
        for (column, sum) in row {
            let value = equations.define(label(column), sum);
            if !value.is_zero() {
                named.push((column, value));
            }
        }
        let pivot = entry(&named, i);
        if pivot.is_zero() {
            return Err(i);
        }
        inverses.push(equations.quotient(
            QuantityLabel::new(inverse_name, 0, i + 1),
            Scalar::ONE,
            pivot,
        ));
        upper.push(named);
    }
    let mut solution: Vec<SparseRow> = vec![SparseRow::new(); count];
    for i in (0..count).rev() {
        for column in count..count + sides {
            let mut sum = Sum::of(entry(&upper[i], column));
            for &(k, value) in upper[i].iter().filter(|&&(k, _)| k > i && k < count) {
                sum.subtract(&[value, entry(&solution[k], column - count)]);
            }
            let label = |name| QuantityLabel::new(name, 0, i + 1).column(column - count + 1);
            let value = equations.define(label(half_name), sum);
            let value = product(equations, label(name), value, inverses[i]);
            if !value.is_zero() {
                solution[i].push((column - count, value));
            }
        }
    }
    Ok((solution, inverses))
}
