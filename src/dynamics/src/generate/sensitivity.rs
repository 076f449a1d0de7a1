//! Change of accelerations: the inverse of the mass matrix, and the derivatives
//! of forward dynamics.
//!
//! `M(q) qdd + c(q, qd) = Qq` holds for all changes, so that with the
//! derivatives of the forces of inverse dynamics at these accelerations
//!
//! ```text
//! qdd_q = -M^-1 Qq_q      qdd_qd = -M^-1 Qq_qd      qdd_Qq = M^-1
//! ```
//!
//! `M` is eliminated once, in the order that keeps a tree's zeros, and solved
//! for every column: an inverse that is multiplied would take no fewer
//! operations for a chain and more for a tree. Driven joints move as
//! prescribed: they have columns, and the changes of their accelerations
//! are zero. Loops are not closed here.

use super::algebra::Scalar;
use super::composite::{self, MassAndBias};
use super::derivative::{ForceDerivatives, JointEntry, output};
use super::equations::Equations;
use super::factor::find_entry;
use super::factor::{SparseRow, Stop, solve_symmetric};
use super::parameters::ModelParameters;
use super::reduced::too_large;
use super::reduction::residual_input;
use super::{GenerateError, Options};
use robovec_model::Nature;

/// The mass matrix of the joints that are not driven.
struct FreeMasses {
    /// These joints, ascending.
    joints: Vec<usize>,
    /// The lower triangle, by rows; columns are places in the list.
    rows: Vec<SparseRow>,
}

impl FreeMasses {
    fn new(parameters: &ModelParameters<'_>, dynamics: &MassAndBias) -> FreeMasses {
        let all = &parameters.model.joints;
        let joints: Vec<usize> = (0..all.len())
            .filter(|&joint| all[joint].nature != Nature::Driven)
            .collect();
        let row = |&joint: &usize| {
            let entries = dynamics.mass[joint].iter();
            let mut row: SparseRow = entries
                .filter(|(_, value)| !value.is_zero())
                .filter_map(|&(column, value)| Some((joints.binary_search(&column).ok()?, value)))
                .collect();
            row.sort_unstable_by_key(|&(column, _)| column);
            row
        };
        FreeMasses {
            rows: joints.iter().map(row).collect(),
            joints,
        }
    }

    fn solve(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        sides: &[Vec<Scalar>],
    ) -> Result<Vec<Vec<Scalar>>, GenerateError> {
        let model = parameters.model;
        solve_symmetric(equations, &self.rows, sides, &self.joints).map_err(|stop| match stop {
            Stop::NoPivot(place) => GenerateError::singular(model, [self.joints[place]]),
            Stop::TooLarge => too_large(model),
        })
    }

    /// `M^-1`.
    fn inverse(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
    ) -> Result<Vec<JointEntry>, GenerateError> {
        let count = self.joints.len();
        let side = |place: usize| {
            let mut side = vec![Scalar::ZERO; count];
            side[place] = Scalar::ONE;
            side
        };
        let sides: Vec<Vec<Scalar>> = (0..count).map(side).collect();
        let columns = self.solve(equations, parameters, &sides)?;
        let mut entries = Vec::new();
        for (row, &joint) in self.joints.iter().enumerate() {
            for (column, &other) in self.joints.iter().enumerate() {
                // The solution begins where the side does: below is the less work.
                let value = columns[row.min(column)][row.max(column)];
                if !value.is_zero() {
                    entries.push((joint, other, value));
                }
            }
        }
        Ok(entries)
    }

    /// `-M^-1` times the derivatives of forces.
    fn accelerations(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        forces: &[JointEntry],
    ) -> Result<Vec<JointEntry>, GenerateError> {
        let mut columns: Vec<usize> = forces.iter().map(|&(_, column, _)| column).collect();
        columns.sort_unstable();
        columns.dedup();
        let mut sides = vec![vec![Scalar::ZERO; self.joints.len()]; columns.len()];
        for &(row, column, value) in forces {
            if let Ok(row) = self.joints.binary_search(&row) {
                let side = columns.partition_point(|&other| other < column);
                sides[side][row] = -value;
            }
        }
        let solutions = self.solve(equations, parameters, &sides)?;
        let mut entries = Vec::new();
        for (solution, &column) in solutions.iter().zip(&columns) {
            for (&value, &joint) in solution.iter().zip(&self.joints) {
                if !value.is_zero() {
                    entries.push((joint, column, value));
                }
            }
        }
        Ok(entries)
    }
}

/// Writes `Minv`.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let dynamics = composite::dynamics(equations, parameters, options);
    let masses = FreeMasses::new(parameters, &dynamics);
    let entries = masses.inverse(equations, parameters)?;
    output(equations, "Minv", &entries);
    Ok(())
}

/// Writes `qdd_q`, `qdd_qd` and `qdd_Qq`.
pub(super) fn forward(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let dynamics = composite::dynamics(equations, parameters, options);
    let masses = FreeMasses::new(parameters, &dynamics);
    let mut accelerations: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| match parameters.model.joints[joint].nature {
            Nature::Driven => parameters.acceleration(equations, joint),
            Nature::Independent | Nature::Dependent => Scalar::ZERO,
        })
        .collect();
    let forces = masses.joints.iter().map(|&joint| {
        let driven = |other: usize| !accelerations[other].is_zero();
        let mass = |other: usize| find_entry(&dynamics.mass[joint.max(other)], joint.min(other));
        let given: Vec<(Scalar, Scalar)> = (0..parameters.joints())
            .filter(|&other| driven(other))
            .map(|other| (mass(other), accelerations[other]))
            .collect();
        residual_input(equations, joint, dynamics.bias[joint], &given)
    });
    let forces: Vec<Scalar> = forces.collect();
    let solution = masses.solve(equations, parameters, &[forces])?;
    for (&joint, &value) in masses.joints.iter().zip(&solution[0]) {
        accelerations[joint] = parameters.with_resting(equations, joint, value);
    }
    let found = ForceDerivatives::new(equations, parameters, options, &accelerations);
    let by_position = masses.accelerations(equations, parameters, &found.by_position)?;
    let by_velocity = masses.accelerations(equations, parameters, &found.by_velocity)?;
    let by_force = masses.inverse(equations, parameters)?;
    output(equations, "qdd_q", &by_position);
    output(equations, "qdd_qd", &by_velocity);
    output(equations, "qdd_Qq", &by_force);
    Ok(())
}
