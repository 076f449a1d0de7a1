//! The reduction of accelerations to those of independent joints
//! ([`super::reduced`] has the equations).

use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::constraints::{self, ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry};
use super::parameters::ModelParameters;
use super::roles::JointRoles;
use super::user_constraints::{self, BoundAccelerations, DependentJoints, ReducedRows};
use super::{GenerateError, Options};
use robovec_model::Nature;

pub(super) struct CoordinateReduction<'e, 'p, 'm> {
    pub(super) equations: &'e mut Equations,
    pub(super) parameters: &'p ModelParameters<'m>,
    /// Rows of the lower triangle of `M`.
    pub(super) masses: Vec<SparseRow>,
    /// Accelerations of driven joints, zero for others.
    pub(super) given: Vec<Scalar>,
}

/// Dependent accelerations: `B` by rows (columns count independent joints) and
/// `b`.
pub(super) struct DependentAccelerations {
    /// The rows of the loops, in the order of pivots.
    pub(super) rows: Vec<ConstraintRow>,
    /// Number of rows, redundant ones included.
    pub(super) all: usize,
    matrix: Vec<SparseRow>,
    rest: Vec<Scalar>,
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
        let mut rows = Vec::with_capacity(v.len());
        for &number in &partition.rows {
            let constraint = &constraints[number];
            let mut row = constraint.dependent_entries(v);
            let mut rest = Sum::of(constraint.jdqd);
            for &(joint, value) in &constraint.jacobian {
                rest.add(&[value, self.given[joint]]);
                if let Ok(place) = u.binary_search(&joint) {
                    row.push((v.len() + place, value));
                }
            }
            let label = QuantityLabel::new("bp", 0, number + 1);
            row.push((v.len() + u.len(), self.equations.define(label, rest)));
            row.retain(|(_, value)| !value.is_zero());
            row.sort_unstable_by_key(|&(column, _)| column);
            rows.push(row);
        }
        let names = ["Jvlu", "Jvl", "Jvi", "Jvx", "Bvx"];
        let solution = solve_blocks(self.equations, names, &rows, u.len() + 1)
            .map_err(|place| GenerateError::singular(self.parameters.model, [v[place]]))?;
        let rest = solution.iter().map(|row| -entry(row, u.len())).collect();
        let column =
            |&(column, value): &(usize, Scalar)| (column < u.len()).then_some((column, -value));
        let matrix = solution
            .iter()
            .map(|row| row.iter().filter_map(column).collect())
            .collect();
        Ok(DependentAccelerations {
            all: constraints.len(),
            rows: partition
                .rows
                .iter()
                .map(|&row| constraints[row].clone())
                .collect(),
            matrix,
            rest,
        })
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

    /// The lower triangle of `Mr`, and the right side.
    pub(super) fn reduced(
        &mut self,
        partition: &JointRoles,
        loops: &DependentAccelerations,
        forces: &[Scalar],
    ) -> (Vec<SparseRow>, Vec<Scalar>) {
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
        (rows, right)
    }

    /// Sets the accelerations of all joints.
    pub(super) fn output(
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
        for (joint, &value) in accelerations.iter().enumerate() {
            self.equations.output("qdd", &[joint + 1], value);
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
