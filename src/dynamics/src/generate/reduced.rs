//! Reduced accelerations: `qdd` from `M`, `c` and the loops.
//!
//! The constraints of loops give the accelerations of dependent joints v by
//! those of independent joints u: `qdd_v = B qdd_u + b` with `B = -Jv^-1 Ju` and
//! `b = -Jv^-1 (jdqd + Jc qdd_c)`. Put into `M qdd + c = Qq + J^T lambda`, the
//! multipliers drop out (coordinate partitioning):
//!
//! ```text
//! Mr = Muu + Muv B + (Muv B)^T + B^T Mvv B
//! Mr qdd_u = f_u - Muv b + B^T (f_v - Mvv b),    f = Qq - c - M_c qdd_c
//! ```
//!
//! Rows `A qdd_u + g = 0` that the user computes are satisfied by multipliers
//! of their own, `(A Mr^-1 A^T) mu = -g - A Mr^-1 f_r`: their Jacobian is not
//! known before, and this matrix is positive definite whatever it is.
//!
//! The accelerations of driven joints c are inputs. Positions and velocities
//! must satisfy the loops. Which joints depend and which rows are redundant are
//! decided when the equations are made, at the closed initial state of the model;
//! where the joints chosen do not determine the others, the equations fail. How
//! loops are solved, and where that needs pivots: [`super::blocks`].

use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::closing::dependent_entries;
use super::composite::MassAndBias;
use super::constraints::{self, ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{LIMIT, SparseRow, Stop, entry, solve_symmetric};
use super::parameters::ModelParameters;
use super::reactions::{self, ForceBalance};
use super::roles::JointRoles;
use super::user_constraints::{self, BoundAccelerations, DependentJoints, ReducedRows};
use super::{GenerateError, Options};
use robovec_model::{Model, Nature};

/// `Qq - c` of a joint, less what given accelerations take.
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

/// Writes `qdd`.
pub(super) fn accelerations(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    dynamics: &MassAndBias,
) -> Result<(), GenerateError> {
    let model = parameters.model;
    let mut reduction = CoordinateReduction {
        equations,
        parameters,
        masses: dynamics.mass.iter().map(|row| sorted(row)).collect(),
        given: vec![Scalar::ZERO; model.joints.len()],
    };
    let partition = JointRoles::of_frames(parameters.frames, options)?;
    for joint in 0..model.joints.len() {
        if model.joints[joint].nature == Nature::Driven {
            reduction.given[joint] = parameters.acceleration(reduction.equations, joint);
        }
    }
    let loops = reduction.loops(&partition, options)?;
    let forces: Vec<Scalar> = (0..model.joints.len())
        .map(|joint| reduction.residual(joint, dynamics.bias[joint]))
        .collect();
    let (rows, right) = reduction.reduced(&partition, &loops, &forces);
    let user = reduction.user(&partition, &loops, options);
    let mut sides = vec![right];
    sides.extend(user.reduced.matrix.iter().cloned());
    let joints = &partition.free;
    let mut solutions =
        solve_symmetric(reduction.equations, &rows, &sides, joints).map_err(|stop| match stop {
            Stop::NoPivot(place) => singular(model, joints[place]),
            Stop::TooLarge => too_large(model),
        })?;
    let forced = solutions.split_off(1);
    let unbound = solutions.pop().expect("the forces are the first side");
    let multipliers = user.multipliers(reduction.equations, &unbound, &forced);
    let solution = BoundAccelerations::bound(reduction.equations, &unbound, &forced, &multipliers);
    let accelerations = reduction.output(&partition, &loops, &solution);
    if options.multipliers {
        let balance = ForceBalance {
            bias: &dynamics.bias,
            forces: &forces,
            accelerations: &accelerations,
            user: (&user.rows, &multipliers),
        };
        reactions::write(&mut reduction, &partition, &loops, &balance)?;
    }
    Ok(())
}

/// The error of a joint that forces cannot move in a determined way.
pub(super) fn singular(model: &Model, joint: usize) -> GenerateError {
    GenerateError::Singular(model.joints[joint].name.clone())
}

/// The error of a mass matrix whose elimination is too long.
pub(super) fn too_large(model: &Model) -> GenerateError {
    GenerateError::Elimination {
        model: model.name.clone(),
        limit: LIMIT,
    }
}

fn sorted(row: &[(usize, Scalar)]) -> SparseRow {
    let mut row: SparseRow = row.to_vec();
    row.retain(|(_, value)| !value.is_zero());
    row.sort_unstable_by_key(|&(column, _)| column);
    row
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

pub(super) struct CoordinateReduction<'e, 'p, 'm> {
    pub(super) equations: &'e mut Equations,
    pub(super) parameters: &'p ModelParameters<'m>,
    /// Rows of the lower triangle of `M`.
    masses: Vec<SparseRow>,
    /// Accelerations of driven joints, zero for others.
    given: Vec<Scalar>,
}

impl CoordinateReduction<'_, '_, '_> {
    pub(super) fn mass(&self, i: usize, j: usize) -> Scalar {
        entry(&self.masses[i.max(j)], i.min(j))
    }

    /// `f`.
    fn residual(&mut self, joint: usize, bias: Scalar) -> Scalar {
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
    fn loops(
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
            let mut row = dependent_entries(constraint, v);
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
            .map_err(|place| singular(self.parameters.model, v[place]))?;
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
    fn user(
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
        BoundAccelerations { rows, reduced }
    }

    /// The lower triangle of `Mr`, and the right side.
    fn reduced(
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
    fn output(
        &mut self,
        partition: &JointRoles,
        loops: &DependentAccelerations,
        solution: &[Scalar],
    ) -> Vec<Scalar> {
        let mut accelerations = self.given.clone();
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
