//! Forces of constraints and drives: multipliers, and forces of driven joints.
//!
//! With accelerations known, `M qdd + c = Qq + Qc + J^T lambda` holds joint by
//! joint. Dependent joints give the multipliers of the loops, `Jv^T lambda = Mv
//! qdd + c_v - Qq_v`, driven joints the forces `Qc` that move them.

use super::GenerateError;
use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::reduction::{CoordinateReduction, DependentAccelerations};

use super::constraints::ConstraintRow;
use super::equations::QuantityLabel;
use super::factor::{SparseRow, entry};

use super::roles::JointRoles;
use robovec_model::Nature;

/// Balance that the forces at each joint follow from.
pub(super) struct ForceBalance {
    /// `c` of all joints.
    pub(super) bias: Vec<Scalar>,
    /// `Qq - c` of joints not driven, minus forces for given accelerations.
    pub(super) forces: Vec<Scalar>,
    /// `qdd` of all joints.
    pub(super) accelerations: Vec<Scalar>,
    /// The user's rows with their multipliers.
    pub(super) user: Vec<(ConstraintRow, Scalar)>,
}

/// Writes the multipliers, and the forces of driven joints.
pub(super) fn write(
    reduction: &mut CoordinateReduction<'_, '_, '_>,
    roles: &JointRoles,
    loops: &DependentAccelerations,
    balance: &ForceBalance,
) -> Result<(), GenerateError> {
    let solution = of_loops(reduction, roles, loops, balance)?;
    assert_eq!(solution.len(), roles.rows.len(), "one multiplier per row");
    for (&multiplier, &number) in solution.iter().zip(&roles.rows) {
        reduction
            .equations
            .output("Lambda", &[number + 1], multiplier);
    }
    let behind = loops.all;
    for (number, (_, multiplier)) in balance.user.iter().enumerate() {
        reduction
            .equations
            .output("Lambda", &[behind + number + 1], *multiplier);
    }
    let rows = loops.rows.iter().zip(solution);
    let rows: Vec<(&ConstraintRow, Scalar)> = rows
        .chain(
            balance
                .user
                .iter()
                .map(|(row, multiplier)| (row, *multiplier)),
        )
        .collect();
    for joint in 0..balance.bias.len() {
        if reduction.parameters.model.joints[joint].nature != Nature::Driven {
            continue;
        }
        let mut sum = Sum::of(balance.bias[joint]);
        for (other, &acceleration) in balance.accelerations.iter().enumerate() {
            sum.add(&[reduction.mass(joint, other), acceleration]);
        }
        let force = reduction.equations.input("Qq", &[joint + 1]);
        sum.subtract(&[force]);
        for &(row, multiplier) in &rows {
            sum.subtract(&[row.entry(joint), multiplier]);
        }
        let label = QuantityLabel::new("Qcd", 0, joint + 1);
        let value = reduction.equations.define(label, sum);
        reduction.equations.output("Qc", &[joint + 1], value);
    }
    Ok(())
}

/// The multipliers of the loops, in the order of their pivots.
pub(super) fn of_loops(
    reduction: &mut CoordinateReduction<'_, '_, '_>,
    roles: &JointRoles,
    loops: &DependentAccelerations,
    balance: &ForceBalance,
) -> Result<Vec<Scalar>, GenerateError> {
    let v = &roles.dependent;
    let mut rows: Vec<SparseRow> = vec![SparseRow::new(); v.len()];
    for (number, row) in loops.rows.iter().enumerate() {
        for (column, value) in row.dependent_entries(v) {
            rows[column].push((number, value));
        }
    }
    for (place, &joint) in v.iter().enumerate() {
        let mut sum = Sum::new();
        for (other, &acceleration) in balance.accelerations.iter().enumerate() {
            // Given accelerations are in the force already.
            if reduction.parameters.model.joints[other].nature != Nature::Driven {
                sum.add(&[reduction.mass(joint, other), acceleration]);
            }
        }
        sum.subtract(&[balance.forces[joint]]);
        for (row, multiplier) in &balance.user {
            sum.subtract(&[row.entry(joint), *multiplier]);
        }
        let label = QuantityLabel::new("FMl", 0, joint + 1);
        let value = reduction.equations.define(label, sum);
        if !value.is_zero() {
            rows[place].push((v.len(), value));
        }
    }
    let names = ["Jtlu", "Jtl", "Jti", "Jtx", "lam"];
    let solution = solve_blocks(reduction.equations, names, &rows, 1)
        .map_err(|place| GenerateError::singular(reduction.parameters.model, [v[place]]))?;
    Ok(solution.iter().map(|row| entry(row, 0)).collect())
}
