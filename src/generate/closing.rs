//! Closing loops: positions and velocities of dependent joints from those of
//! the others.
//!
//! With `h(q) = 0` and its Jacobian `J = [Ju Jc Jv]` (independent, driven and
//! dependent joints), one round of Newton's method and the velocities are
//!
//! ```text
//! q_v  := q_v - Jv^-1 h
//! qd_v  = -Jv^-1 (Ju qd_u + Jc qd_c)
//! ```
//!
//! A round is straight-line code; how many rounds are needed is for the caller,
//! who sees `h` as it was before the round. Which joints depend and the order
//! of pivots are those of the reduced accelerations ([`super::reduced`]), so
//! that the functions fit together.

use super::algebra::{Scalar, Sum};
use super::constraints::{self, ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry, solve_square};
use super::parameters::ModelParameters;
use super::reduced::singular;
use super::roles::JointRoles;
use super::{GenerateError, Options};

/// Writes `h` of the independent rows, and `q` of dependent joints after one
/// round.
pub(super) fn positions(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let closing = Closing::new(equations, parameters, options)?;
    for &number in &closing.roles.rows {
        equations.output("h", &[number + 1], closing.constraints[number].h);
    }
    let names = ["Jplu", "Jpl", "Jpi", "Jpx", "dqv"];
    let change = closing.solve(equations, names, |_, row| Sum::of(row.h))?;
    for (&joint, &change) in closing.roles.dependent.iter().zip(&change) {
        let mut sum = Sum::of(equations.input("q", &[joint + 1]));
        sum.subtract(&[change]);
        let value = equations.define(QuantityLabel::new("qv", 0, joint + 1), sum);
        equations.output("q", &[joint + 1], value);
    }
    Ok(())
}

/// Writes `qd` of dependent joints.
pub(super) fn velocities(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let closing = Closing::new(equations, parameters, options)?;
    let names = ["Jdlu", "Jdl", "Jdi", "Jdx", "qdv"];
    let dependent = &closing.roles.dependent;
    let solution = closing.solve(equations, names, |equations, row| {
        let mut sum = Sum::new();
        for &(joint, value) in &row.jacobian {
            if !dependent.contains(&joint) {
                let velocity = equations.input("qd", &[joint + 1]);
                sum.subtract(&[value, velocity]);
            }
        }
        sum
    })?;
    for (&joint, &velocity) in dependent.iter().zip(&solution) {
        equations.output("qd", &[joint + 1], velocity);
    }
    Ok(())
}

/// The constraints of a model, and who depends on whom.
struct Closing<'p, 'm> {
    parameters: &'p ModelParameters<'m>,
    roles: JointRoles,
    constraints: Vec<ConstraintRow>,
}

impl<'p, 'm> Closing<'p, 'm> {
    fn new(
        equations: &mut Equations,
        parameters: &'p ModelParameters<'m>,
        options: &Options,
    ) -> Result<Closing<'p, 'm>, GenerateError> {
        Ok(Closing {
            parameters,
            roles: JointRoles::new(parameters.model)?,
            constraints: constraints::rows(
                equations,
                parameters,
                options,
                ConstraintPart::Position,
            ),
        })
    }

    /// The solution of `Jv x = b`, in the order of dependent joints; `b` is
    /// what the caller makes of each row.
    fn solve(
        &self,
        equations: &mut Equations,
        names: [&'static str; 5],
        right: impl Fn(&mut Equations, &ConstraintRow) -> Sum,
    ) -> Result<Vec<Scalar>, GenerateError> {
        let dependent = &self.roles.dependent;
        let mut rows = Vec::with_capacity(dependent.len());
        for &number in &self.roles.rows {
            let constraint = &self.constraints[number];
            let mut row = dependent_entries(constraint, dependent);
            let sum = right(equations, constraint);
            let label = QuantityLabel::new("bv", 0, number + 1);
            row.push((dependent.len(), equations.define(label, sum)));
            row.retain(|(_, value)| !value.is_zero());
            rows.push(row);
        }
        let solution = solve_square(equations, names, &rows, 1)
            .map_err(|place| singular(self.parameters.model, dependent[place]))?;
        Ok(solution.iter().map(|row| entry(row, 0)).collect())
    }
}

/// The entries of a row of `Jv`: places among the dependent joints, ascending.
pub(super) fn dependent_entries(constraint: &ConstraintRow, dependent: &[usize]) -> SparseRow {
    let place = |joint: &usize| dependent.iter().position(|other| other == joint);
    let entries = constraint.jacobian.iter();
    let mut row: SparseRow = entries
        .filter_map(|(joint, value)| Some((place(joint)?, *value)))
        .collect();
    row.sort_unstable_by_key(|&(column, _)| column);
    row
}
