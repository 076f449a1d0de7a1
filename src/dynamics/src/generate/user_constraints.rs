//! Constraints of the user: rows that the project computes when it runs.
//!
//! Values, Jacobian and quadratic terms are inputs, so that nothing is known of
//! their structure: any joint may appear in any row, and no order of pivots is
//! known to be a good one. They are therefore solved without pivoting: the
//! multipliers of accelerations have a symmetric positive definite matrix, and
//! dependent joints follow from a solution of least length ([`solve_unknown`]).
//!
//! With the joints of loops eliminated, `x_v = rest + B x`, a row
//! `A x + A_v x_v + a = 0` becomes `(A + A_v B) x + (a + A_v rest) = 0`.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::constraints::ConstraintRow;
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry, product, solve_square};
use super::frames::ModelFrames;
use super::massless::MasslessJoint;

/// The rows, all joints in each.
pub(super) fn rows(
    equations: &mut Equations,
    frames: &ModelFrames<'_>,
    options: &Options,
) -> Vec<ConstraintRow> {
    (1..=options.user_constraints)
        .map(|row| ConstraintRow {
            h: equations.input("huserc", &[row]),
            jacobian: (frames.places().iter())
                .map(|&joint| (joint, equations.input("Juserc", &[row, joint + 1])))
                .collect(),
            jdqd: equations.input("jdqduserc", &[row]),
        })
        .collect()
}

/// Dependence of the joints of loops on others: `x_v = rest + B x`.
pub(super) struct DependentJoints<'a> {
    pub(super) joints: &'a [usize],
    /// `B`, a row for each of them; its columns are places among the others.
    pub(super) matrix: &'a [SparseRow],
    /// `rest`.
    pub(super) rest: &'a [Scalar],
}

/// Rows `matrix x + rest = 0` in joints that the loops do not determine.
pub(super) struct ReducedRows {
    pub(super) matrix: Vec<Vec<Scalar>>,
    pub(super) rest: Vec<Scalar>,
}

impl ReducedRows {
    /// Eliminates the joints of loops from rows. `columns`: joints of `x`;
    /// `given`: part of a row that depends on neither.
    pub(super) fn new(
        equations: &mut Equations,
        names: [&'static str; 2],
        (rows, columns): (&[ConstraintRow], &[usize]),
        dependent: &DependentJoints<'_>,
        given: impl Fn(&mut Equations, &ConstraintRow) -> Sum,
    ) -> ReducedRows {
        let mut reduced = ReducedRows {
            matrix: Vec::with_capacity(rows.len()),
            rest: Vec::with_capacity(rows.len()),
        };
        for (number, row) in rows.iter().enumerate() {
            let own = |&joint: &usize| Sum::of(row.entry(joint));
            let mut sums: Vec<Sum> = columns.iter().map(own).collect();
            let mut rest = given(equations, row);
            for (place, &joint) in dependent.joints.iter().enumerate() {
                let value = row.entry(joint);
                rest.add(&[value, dependent.rest[place]]);
                for &(column, ratio) in &dependent.matrix[place] {
                    sums[column].add(&[value, ratio]);
                }
            }
            let [matrix_name, rest_name] = names;
            let label = |name| QuantityLabel::new(name, 0, number + 1);
            reduced.rest.push(equations.define(label(rest_name), rest));
            let entries = sums.into_iter().enumerate();
            let row = entries.map(|(column, sum)| {
                let label = label(matrix_name).column(columns[column] + 1);
                equations.define(label, sum)
            });
            reduced.matrix.push(row.collect());
        }
        reduced
    }
}

/// The rows in accelerations: the user's, then those of [`super::massless`].
pub(super) struct BoundAccelerations {
    pub(super) rows: Vec<ConstraintRow>,
    pub(super) reduced: ReducedRows,
    /// `-1/s` of each row of a joint without mass.
    compliances: Vec<Scalar>,
}

impl BoundAccelerations {
    pub(super) fn of_user(rows: Vec<ConstraintRow>, reduced: ReducedRows) -> BoundAccelerations {
        BoundAccelerations {
            rows,
            reduced,
            compliances: Vec::new(),
        }
    }

    /// Adds the rows of massless joints, and their inertia to the mass matrix.
    pub(super) fn add_massless(
        &mut self,
        equations: &mut Equations,
        joints: &[MasslessJoint],
        masses: &mut [SparseRow],
    ) {
        for &MasslessJoint { place, inertia } in joints {
            let mut unit = vec![Scalar::ZERO; masses.len()];
            unit[place] = Scalar::ONE;
            self.reduced.matrix.push(unit);
            self.reduced.rest.push(Scalar::ZERO);
            self.compliances.push(equations.number(-1.0 / inertia));
            let inertia = equations.number(inertia);
            add_diagonal(equations, "Mrs", (masses, place), inertia);
        }
    }

    /// The multipliers of the rows, from accelerations without them and the
    /// effect of each row's column on accelerations. With `growth`, writes for
    /// every row the factor by which its elimination enlarges rounding: the
    /// entry on the diagonal, or what is added to it, over the pivot.
    pub(super) fn multipliers(
        &self,
        equations: &mut Equations,
        unbound: &[Scalar],
        forced: &[Vec<Scalar>],
        growth: bool,
    ) -> Vec<Scalar> {
        let matrix = &self.reduced.matrix;
        if matrix.is_empty() {
            return Vec::new();
        }
        assert_eq!(
            self.reduced.rest.len(),
            matrix.len(),
            "every row has a rest"
        );
        let mut square = products(equations, "us", matrix, forced);
        let rows = self.rows.len();
        let mut sizes: Vec<Scalar> = (0..rows).map(|row| entry(&square[row], row)).collect();
        for (number, &compliance) in (rows..).zip(&self.compliances) {
            add_diagonal(equations, "usz", (&mut square, number), compliance);
            sizes.push(compliance);
        }
        let mut right = Vec::with_capacity(matrix.len());
        for (number, (row, &rest)) in matrix.iter().zip(&self.reduced.rest).enumerate() {
            let mut sum = Sum::of(-rest);
            for (&value, &acceleration) in row.iter().zip(unbound) {
                sum.subtract(&[value, acceleration]);
            }
            right.push(equations.define(QuantityLabel::new("ut", 0, number + 1), sum));
        }
        let names = ["usu", "usl", "usi", "ush", "um"];
        let (multipliers, inverses) = solve_positive(equations, names, square, &right);
        for (number, (size, inverse)) in sizes.into_iter().zip(inverses).enumerate() {
            if growth {
                let label = QuantityLabel::new("ugrow", 0, number + 1);
                let growth = product(equations, label, size, inverse);
                equations.output("Growth", &[number + 1], growth);
            }
        }
        multipliers
    }

    /// Accelerations with the multipliers.
    pub(super) fn bound(
        equations: &mut Equations,
        unbound: &[Scalar],
        forced: &[Vec<Scalar>],
        multipliers: &[Scalar],
    ) -> Vec<Scalar> {
        assert_eq!(
            forced.len(),
            multipliers.len(),
            "every multiplier has its column"
        );
        let places = unbound.iter().enumerate();
        let sums = places.map(|(place, &acceleration)| {
            let mut sum = Sum::of(acceleration);
            for (column, &multiplier) in forced.iter().zip(multipliers) {
                sum.add(&[column[place], multiplier]);
            }
            equations.define(QuantityLabel::new("ud", 0, place + 1), sum)
        });
        sums.collect()
    }
}

/// Solves `A x = -rest` for a square matrix of which nothing is known, without
/// pivots: `A A^T y = -rest`, `x = A^T y`. The matrix of `y` is positive
/// definite, but its condition is that of `A` squared, so that the residual is
/// solved for once more. A singular `A` gives no numbers.
pub(super) fn solve_unknown(equations: &mut Equations, system: &ReducedRows) -> Vec<Scalar> {
    let matrix = &system.matrix;
    assert!(
        matrix.iter().all(|row| row.len() == matrix.len()),
        "a square matrix"
    );
    let right: Vec<Scalar> = system.rest.iter().map(|&rest| -rest).collect();
    if let ([row], [right]) = (&matrix[..], &right[..]) {
        let inverse = equations.quotient(QuantityLabel::new("uq", 0, 1), Scalar::ONE, row[0]);
        let label = QuantityLabel::new("ux", 0, 1);
        return vec![product(equations, label, *right, inverse)];
    }
    let first = least(equations, matrix, &right, ["ub", "uy", "ux"]);
    let mut left = Vec::with_capacity(right.len());
    for (number, (row, &right)) in matrix.iter().zip(&right).enumerate() {
        let mut sum = Sum::of(right);
        for (&value, &x) in row.iter().zip(&first) {
            sum.subtract(&[value, x]);
        }
        left.push(equations.define(QuantityLabel::new("ul", 0, number + 1), sum));
    }
    let second = least(equations, matrix, &left, ["uc", "uv", "uw"]);
    let pairs = first.into_iter().zip(second).enumerate();
    let sums = pairs.map(|(place, (one, other))| {
        let sum = Sum::total(&[one, other]);
        equations.define(QuantityLabel::new("uz", 0, place + 1), sum)
    });
    sums.collect()
}

/// `A^T (A A^T)^-1 b`; names of intermediate values and of the result.
fn least(
    equations: &mut Equations,
    matrix: &[Vec<Scalar>],
    right: &[Scalar],
    [half_name, multiplier_name, name]: [&'static str; 3],
) -> Vec<Scalar> {
    let square = products(equations, "ug", matrix, matrix);
    let names = ["ugu", "ugl", "ugi", half_name, multiplier_name];
    let (multipliers, _) = solve_positive(equations, names, square, right);
    let columns = 0..matrix.len();
    let sums = columns.map(|column| {
        let mut sum = Sum::new();
        for (row, &multiplier) in matrix.iter().zip(&multipliers) {
            sum.add(&[row[column], multiplier]);
        }
        equations.define(QuantityLabel::new(name, 0, column + 1), sum)
    });
    sums.collect()
}

/// `A B^T` by rows.
pub(super) fn products(
    equations: &mut Equations,
    name: &'static str,
    one: &[Vec<Scalar>],
    other: &[Vec<Scalar>],
) -> Vec<SparseRow> {
    let mut rows = Vec::with_capacity(one.len());
    for (i, a) in one.iter().enumerate() {
        let mut row = SparseRow::new();
        for (j, b) in other.iter().enumerate() {
            assert_eq!(a.len(), b.len(), "rows of one length");
            let mut sum = Sum::new();
            for (&a, &b) in a.iter().zip(b) {
                sum.add(&[a, b]);
            }
            let label = QuantityLabel::new(name, 0, i + 1).column(j + 1);
            row.push((j, equations.define(label, sum)));
        }
        row.retain(|(_, value)| !value.is_zero());
        rows.push(row);
    }
    rows
}

/// Adds a value to the entry of a row on the diagonal.
fn add_diagonal(
    equations: &mut Equations,
    name: &'static str,
    (rows, number): (&mut [SparseRow], usize),
    value: Scalar,
) {
    let row = &mut rows[number];
    let sum = Sum::total(&[entry(row, number), value]);
    let diagonal = equations.define(QuantityLabel::new(name, 0, number + 1), sum);
    row.retain(|&(column, _)| column != number);
    let place = row.partition_point(|&(column, _)| column < number);
    row.insert(place, (number, diagonal));
}

/// Solves with a quasi-definite matrix, in its order; also inverse pivots.
pub(super) fn solve_positive(
    equations: &mut Equations,
    names: [&'static str; 5],
    mut rows: Vec<SparseRow>,
    right: &[Scalar],
) -> (Vec<Scalar>, Vec<Scalar>) {
    let count = rows.len();
    assert_eq!(right.len(), count, "one right side per row");
    for (row, &right) in rows.iter_mut().zip(right) {
        if !right.is_zero() {
            row.push((count, right));
        }
    }
    let (solution, inverses) = solve_square(equations, names, &rows, 1)
        .expect("rows of the user have entries of all joints");
    let solution = solution.iter().map(|row| entry(row, 0));
    (solution.collect(), inverses)
}
