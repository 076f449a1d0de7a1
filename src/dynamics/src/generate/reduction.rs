//! The reduction of accelerations to independent joints ([`super::reduced`]).

use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::constraints::{self, ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, Stop, entry, solve_symmetric, too_large};
use super::parameters::ModelParameters;
use super::roles::JointRoles;
use super::user_constraints::{self, BoundAccelerations, DependentJoints, ReducedRows};
use super::{GenerateError, Options};
use robovec_model::{Model, Nature};

pub(super) struct CoordinateReduction<'e, 'p, 'm> {
    pub(super) equations: &'e mut Equations,
    pub(super) parameters: &'p ModelParameters<'m>,
    /// Rows of the lower triangle of `M`.
    pub(super) masses: Vec<SparseRow>,
    /// Accelerations of driven joints, zero for others.
    pub(super) given: Vec<Scalar>,
}

/// Dependent accelerations: `B` by rows (a column per independent), and `b`.
pub(super) struct DependentAccelerations {
    /// The rows of the loops, in the order of pivots.
    pub(super) rows: Vec<ConstraintRow>,
    /// Number of rows, redundant ones included.
    pub(super) all: usize,
    pub(super) matrix: Vec<SparseRow>,
    rest: Vec<Scalar>,
}

/// Equations of the free joints, `Mr x = right`.
pub(super) struct ReducedSystem {
    /// The lower triangle of `Mr`.
    pub(super) rows: Vec<SparseRow>,
    pub(super) right: Vec<Scalar>,
    /// `Mvu + Mvv B`, a row for each dependent joint.
    pub(super) inner: Vec<Vec<Scalar>>,
}

impl ReducedSystem {
    /// Solves `Mr X = sides` for the free joints of a model.
    pub(super) fn solve(
        &self,
        equations: &mut Equations,
        (model, free): (&Model, &[usize]),
        sides: &[Vec<Scalar>],
    ) -> Result<Vec<Vec<Scalar>>, GenerateError> {
        solve_symmetric(equations, &self.rows, sides, free).map_err(|stop| match stop {
            Stop::NoPivot(place) => GenerateError::singular(model, [free[place]]),
            Stop::TooLarge => too_large(model),
        })
    }
}

impl CoordinateReduction<'_, '_, '_> {
    pub(super) fn mass(&self, i: usize, j: usize) -> Scalar {
        entry(&self.masses[i.max(j)], i.min(j))
    }

    /// `f`.
    pub(super) fn residual(&mut self, joint: usize, bias: Scalar) -> Scalar {
        if self.parameters.model.joints[joint].nature == Nature::Driven {
            return Scalar::ZERO;
        }
        let given: Vec<(Scalar, Scalar)> = (0..self.given.len())
            .filter(|&driven| !self.given[driven].is_zero())
            .map(|driven| (self.mass(joint, driven), self.given[driven]))
            .collect();
        residual_input(self.equations, joint, bias, &given)
    }

    /// Solves the loops for the dependent accelerations.
    pub(super) fn loops(
        &mut self,
        partition: &JointRoles,
        options: &Options,
    ) -> Result<DependentAccelerations, GenerateError> {
        let (u, v) = (&partition.free, &partition.dependent);
        if v.is_empty() {
            return Ok(DependentAccelerations {
                rows: Vec::new(),
                all: 0,
                matrix: Vec::new(),
                rest: Vec::new(),
            });
        }
        let constraints = constraints::rows(
            self.equations,
            self.parameters,
            options,
            ConstraintPart::Acceleration,
        );
        let rows: Vec<ConstraintRow> = partition
            .rows
            .iter()
            .map(|&row| constraints[row].clone())
            .collect();
        let mut right = Vec::with_capacity(v.len());
        for (constraint, &number) in rows.iter().zip(&partition.rows) {
            let mut rest = Sum::of(constraint.jdqd);
            let mut row = SparseRow::new();
            for &(joint, value) in &constraint.jacobian {
                rest.add(&[value, self.given[joint]]);
                if let Ok(place) = u.binary_search(&joint) {
                    row.push((place, value));
                }
            }
            let label = QuantityLabel::new("bp", 0, number + 1);
            row.push((u.len(), self.equations.define(label, rest)));
            right.push(row);
        }
        let names = ["Jvlu", "Jvl", "Jvi", "Jvx", "Bvx"];
        let solution = self.solve_loops(names, (&rows, v), &right, u.len() + 1)?;
        let rest = solution.iter().map(|row| -entry(row, u.len())).collect();
        let column =
            |&(column, value): &(usize, Scalar)| (column < u.len()).then_some((column, -value));
        let matrix = solution
            .iter()
            .map(|row| row.iter().filter_map(column).collect())
            .collect();
        Ok(DependentAccelerations {
            all: constraints.len(),
            rows,
            matrix,
            rest,
        })
    }

    /// The solution of `Jv X = right` for loops and their joints, by pivots.
    pub(super) fn solve_loops(
        &mut self,
        names: [&'static str; 5],
        (rows, dependent): (&[ConstraintRow], &[usize]),
        right: &[SparseRow],
        sides: usize,
    ) -> Result<Vec<SparseRow>, GenerateError> {
        let whole = rows.iter().zip(right).map(|(row, right)| {
            let mut whole = row.dependent_entries(dependent);
            whole.extend(
                right
                    .iter()
                    .map(|&(side, value)| (dependent.len() + side, value)),
            );
            sorted(&whole)
        });
        let whole: Vec<SparseRow> = whole.collect();
        solve_blocks(self.equations, names, &whole, sides)
            .map_err(|place| GenerateError::singular(self.parameters.model, [dependent[place]]))
    }

    /// The rows that the user computes, in accelerations of free joints.
    pub(super) fn user(
        &mut self,
        partition: &JointRoles,
        loops: &DependentAccelerations,
        options: &Options,
    ) -> BoundAccelerations {
        let rows = user_constraints::rows(self.equations, self.parameters.frames, options);
        let dependent = DependentJoints {
            joints: &partition.dependent,
            matrix: &loops.matrix,
            rest: &loops.rest,
        };
        let given = &self.given;
        let reduced = ReducedRows::new(
            self.equations,
            ["uA", "ug"],
            (&rows, &partition.free),
            &dependent,
            |_, row| {
                let mut sum = Sum::of(row.jdqd);
                for &(joint, value) in &row.jacobian {
                    sum.add(&[value, given[joint]]);
                }
                sum
            },
        );
        BoundAccelerations::of_user(rows, reduced)
    }

    /// The equations of the free joints.
    pub(super) fn reduced(
        &mut self,
        partition: &JointRoles,
        loops: &DependentAccelerations,
        forces: &[Scalar],
    ) -> ReducedSystem {
        let (u, v) = (&partition.free, &partition.dependent);
        // Mvu + Mvv B, and f_v - Mvv b.
        let mut inner: Vec<Vec<Scalar>> = Vec::with_capacity(v.len());
        let mut rest = Vec::with_capacity(v.len());
        for &row in v {
            let mut sums: Vec<Sum> = u.iter().map(|&j| Sum::of(self.mass(row, j))).collect();
            let mut force = Sum::of(forces[row]);
            for (place, &other) in v.iter().enumerate() {
                let mass = self.mass(row, other);
                force.subtract(&[mass, loops.rest[place]]);
                for &(column, value) in &loops.matrix[place] {
                    sums[column].add(&[mass, value]);
                }
            }
            let label = |name| QuantityLabel::new(name, 0, row + 1);
            rest.push(self.equations.define(label("FMv"), force));
            let named = sums.into_iter().enumerate().map(|(column, sum)| {
                self.equations
                    .define(label("MMB").column(u[column] + 1), sum)
            });
            inner.push(named.collect());
        }
        let mut rows = Vec::with_capacity(u.len());
        let mut right = Vec::with_capacity(u.len());
        for (i, &joint) in u.iter().enumerate() {
            let mut sums: Vec<Sum> = u[..=i]
                .iter()
                .map(|&j| Sum::of(self.mass(joint, j)))
                .collect();
            let mut force = Sum::of(forces[joint]);
            for (place, &other) in v.iter().enumerate() {
                let mass = self.mass(joint, other);
                let own = entry(&loops.matrix[place], i);
                force
                    .subtract(&[mass, loops.rest[place]])
                    .add(&[own, rest[place]]);
                for &(column, value) in loops.matrix[place].iter().take_while(|entry| entry.0 <= i)
                {
                    sums[column].add(&[mass, value]);
                }
                for (column, sum) in sums.iter_mut().enumerate() {
                    sum.add(&[own, inner[place][column]]);
                }
            }
            let label = |name| QuantityLabel::new(name, 0, joint + 1);
            right.push(self.equations.define(label("Fr"), force));
            let named = sums.into_iter().enumerate().map(|(column, sum)| {
                let label = label("Mr").column(u[column] + 1);
                (column, self.equations.define(label, sum))
            });
            let row: SparseRow = named.collect();
            rows.push(sorted(&row));
        }
        ReducedSystem { rows, right, inner }
    }

    pub(super) fn accelerations(
        &mut self,
        partition: &JointRoles,
        loops: &DependentAccelerations,
        solution: &[Scalar],
    ) -> Vec<Scalar> {
        let mut accelerations = self.given.clone();
        assert_eq!(
            solution.len(),
            partition.free.len(),
            "one solution per free joint"
        );
        for (&joint, &value) in partition.free.iter().zip(solution) {
            accelerations[joint] = value;
        }
        for (place, &joint) in partition.dependent.iter().enumerate() {
            let mut sum = Sum::of(loops.rest[place]);
            for &(column, value) in &loops.matrix[place] {
                sum.add(&[value, solution[column]]);
            }
            accelerations[joint] = self
                .equations
                .define(QuantityLabel::new("qppv", 0, joint + 1), sum);
        }
        accelerations
    }
}

/// `Qq - c` of a joint, minus the forces for given accelerations.
pub(super) fn residual_input(
    equations: &mut Equations,
    joint: usize,
    bias: Scalar,
    given: &[(Scalar, Scalar)],
) -> Scalar {
    let force = equations.input("Qq", &[joint + 1]);
    let mut sum = Sum::total(&[force, -bias]);
    for &(mass, acceleration) in given {
        sum.subtract(&[mass, acceleration]);
    }
    equations.define(QuantityLabel::new("FMB", 0, joint + 1), sum)
}

pub(super) fn sorted(row: &[(usize, Scalar)]) -> SparseRow {
    let mut row: SparseRow = row.to_vec();
    row.retain(|(_, value)| !value.is_zero());
    row.sort_unstable_by_key(|&(column, _)| column);
    row
}
