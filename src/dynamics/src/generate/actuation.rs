//! Forces of actuators: inverse dynamics of models with constraints.
//!
//! Given accelerations of independent and driven joints, those of dependent
//! ones follow from the constraints, and from all of them the forces `phi = M
//! qdd + c - Qq` that the tree without constraints requires. At joints w
//! without actuators or drives, the constraints exert them, `J_w^T lambda =
//! phi_w`; the remaining forces at the others are for actuators a and drives c:
//!
//! ```text
//! Qa = phi_a - J_a^T lambda,    Qc = phi_c - J_c^T lambda
//! ```
//!
//! The number of actuators must equal the number of independent joints. Any
//! joints may have them, by default the independent ones.

use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::closing::Closing;
use super::constraints::{ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry};
use super::parameters::ModelParameters;

use super::roles::ReactionRoles;
use super::user_constraints::{ReducedRows, solve_unknown};
use super::{GenerateError, GenerationRequest, formulation};
use robovec_model::Nature;

/// Writes `qdd` of dependent joints, `Qa` and `Qc`.
pub(super) fn write(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let model = parameters.model;
    let closing = Closing::new(
        equations,
        parameters,
        &request.options,
        ConstraintPart::Acceleration,
    )?;
    let given: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| {
            if closing.roles.follows(joint) {
                Scalar::ZERO
            } else {
                parameters.acceleration(equations, joint)
            }
        })
        .collect();
    let names = ["Jalu", "Jal", "Jai", "Jax", "qddv"];
    let found = closing.solve(equations, names, |_, row| {
        let mut sum = Sum::of(row.jdqd);
        for &(joint, value) in &row.jacobian {
            sum.add(&[value, given[joint]]);
        }
        sum
    })?;
    let mut accelerations = given;
    for (joint, acceleration) in found {
        accelerations[joint] = acceleration;
        equations.output("qdd", &[joint + 1], acceleration);
    }
    let forces = formulation::inverse_forces(equations, parameters, request, &accelerations);
    let needed: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| {
            let mut sum = Sum::of(forces[joint]);
            let applied = equations.input("Qq", &[joint + 1]);
            sum.subtract(&[applied]);
            equations.define(QuantityLabel::new("phi", 0, joint + 1), sum)
        })
        .collect();
    let roles = ReactionRoles::new(parameters.frames, &closing.roles)?;
    let multipliers = multipliers(equations, &closing, &roles, &needed)?;
    for (joint, &needed) in needed.iter().enumerate() {
        let name = match model.joints[joint].nature {
            Nature::Driven => "Qc",
            _ if roles.actuated.contains(&joint) => "Qa",
            _ => continue,
        };
        let mut sum = Sum::of(needed);
        for (row, multiplier) in &multipliers {
            sum.subtract(&[row.entry(joint), *multiplier]);
        }
        let value = equations.define(QuantityLabel::new("Qr", 0, joint + 1), sum);
        equations.output(name, &[joint + 1], value);
    }
    Ok(())
}

fn multipliers<'c>(
    equations: &mut Equations,
    closing: &'c Closing<'_, '_>,
    roles: &ReactionRoles,
    needed: &[Scalar],
) -> Result<Vec<(&'c ConstraintRow, Scalar)>, GenerateError> {
    let loops: Vec<&ConstraintRow> = roles
        .rows
        .iter()
        .map(|&row| &closing.constraints[row])
        .collect();
    let count = loops.len();
    let user = &closing.user;
    // J_w^T lambda = phi_w - U_w^T mu: a side for phi, and one for each mu.
    let mut rows: Vec<SparseRow> = vec![SparseRow::new(); count];
    for (number, row) in loops.iter().enumerate() {
        for (place, value) in row.dependent_entries(&roles.of_loops) {
            rows[place].push((number, value));
        }
    }
    for (row, &joint) in rows.iter_mut().zip(&roles.of_loops) {
        row.push((count, needed[joint]));
        let columns = user.iter().enumerate();
        row.extend(columns.map(|(column, user)| (count + 1 + column, user.entry(joint))));
        row.retain(|(_, value)| !value.is_zero());
    }
    let names = ["Jwlu", "Jwl", "Jwi", "Jwx", "lamw"];
    let solution = solve_blocks(equations, names, &rows, 1 + user.len()).map_err(|place| {
        GenerateError::singular(closing.parameters.model, [roles.of_loops[place]])
    })?;
    // At the joints left: (U^T - J^T L) mu = phi - J^T lambda_0.
    let mut left = ReducedRows {
        matrix: Vec::new(),
        rest: Vec::new(),
    };
    for (number, &joint) in roles.of_user.iter().enumerate() {
        let mut rest = Sum::of(-needed[joint]);
        let mut sums: Vec<Sum> = user.iter().map(|row| Sum::of(row.entry(joint))).collect();
        for (row, solved) in loops.iter().zip(&solution) {
            let value = row.entry(joint);
            rest.add(&[value, entry(solved, 0)]);
            for (column, sum) in sums.iter_mut().enumerate() {
                sum.subtract(&[value, entry(solved, 1 + column)]);
            }
        }
        let label = |name| QuantityLabel::new(name, 0, number + 1);
        left.rest.push(equations.define(label("uf"), rest));
        let named = sums.into_iter().enumerate();
        let named =
            named.map(|(column, sum)| equations.define(label("uF").column(column + 1), sum));
        left.matrix.push(named.collect());
    }
    let of_user = if user.is_empty() {
        Vec::new()
    } else {
        solve_unknown(equations, &left)
    };
    let mut all = Vec::with_capacity(count + user.len());
    for (number, (row, solved)) in loops.into_iter().zip(&solution).enumerate() {
        let mut sum = Sum::of(entry(solved, 0));
        for (column, &multiplier) in of_user.iter().enumerate() {
            sum.subtract(&[entry(solved, 1 + column), multiplier]);
        }
        let label = QuantityLabel::new("lamr", 0, number + 1);
        all.push((row, equations.define(label, sum)));
    }
    all.extend(user.iter().zip(of_user));
    Ok(all)
}
