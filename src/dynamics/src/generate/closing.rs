//! Closing loops: positions and velocities of dependent joints from others.
//!
//! With `h(q) = 0` and its Jacobian `J = [Ju Jc Jv]` (independent, driven and
//! dependent joints), one iteration of Newton's method and the velocities are
//!
//! ```text
//! q_v  := q_v - Jv^-1 h
//! qd_v  = -Jv^-1 (Ju qd_u + Jc qd_c)
//! ```
//!
//! Rows that the user computes come on top, with their own joints that follow
//! from them ([`super::user_constraints`]).
//!
//! An iteration is straight-line code; the caller, who receives `h` before the
//! iteration, decides the number of iterations. Which joints depend and the
//! order of pivots are those of the reduced accelerations ([`super::reduced`]),
//! so that the functions fit together.

use super::algebra::{Scalar, Sum};
use super::blocks::solve_blocks;
use super::constraints::{self, ConstraintPart, ConstraintRow};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry};
use super::parameters::ModelParameters;

use super::roles::JointRoles;
use super::user_constraints::{self, DependentJoints, ReducedRows, solve_unknown};
use super::{GenerateError, Options};

/// Writes `h` of independent rows, and `q` of dependent joints after a round.
pub(super) fn positions(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let closing = Closing::new(equations, parameters, options, ConstraintPart::Position)?;
    for &number in &closing.roles.rows {
        equations.output("h", &[number + 1], closing.constraints[number].h);
    }
    for (joint, value) in closing.positions(equations)? {
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
    let closing = Closing::new(equations, parameters, options, ConstraintPart::Position)?;
    for (joint, velocity) in closing.velocities(equations)? {
        equations.output("qd", &[joint + 1], velocity);
    }
    Ok(())
}

/// The constraints of a model, and who depends on whom.
pub(super) struct Closing<'p, 'm> {
    pub(super) parameters: &'p ModelParameters<'m>,
    pub(super) roles: JointRoles,
    /// All rows of the loops, redundant ones included.
    pub(super) constraints: Vec<ConstraintRow>,
    /// Rows that the user computes.
    pub(super) user: Vec<ConstraintRow>,
}

impl<'p, 'm> Closing<'p, 'm> {
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &'p ModelParameters<'m>,
        options: &Options,
        part: ConstraintPart,
    ) -> Result<Closing<'p, 'm>, GenerateError> {
        Ok(Closing {
            parameters,
            roles: JointRoles::new(parameters.frames.source, options)?.framed(parameters.frames),
            constraints: constraints::rows(equations, parameters, options, part),
            user: user_constraints::rows(equations, parameters.frames, options),
        })
    }

    /// The positions of the joints that follow, after one round.
    pub(super) fn positions(
        &self,
        equations: &mut Equations,
    ) -> Result<Vec<(usize, Scalar)>, GenerateError> {
        let names = ["Jplu", "Jpl", "Jpi", "Jpx", "dqv"];
        let changes = self.solve(equations, names, |_, row| Sum::of(row.h))?;
        let changed = changes.into_iter().map(|(joint, change)| {
            let sum = Sum::total(&[equations.input("q", &[joint + 1]), change]);
            let label = QuantityLabel::new("qv", 0, joint + 1);
            (joint, equations.define(label, sum))
        });
        Ok(changed.collect())
    }

    /// The velocities of the joints that follow.
    pub(super) fn velocities(
        &self,
        equations: &mut Equations,
    ) -> Result<Vec<(usize, Scalar)>, GenerateError> {
        let names = ["Jdlu", "Jdl", "Jdi", "Jdx", "qdv"];
        self.solve(equations, names, |equations, row| {
            let mut sum = Sum::new();
            for &(joint, value) in &row.jacobian {
                if !self.roles.follows(joint) {
                    let velocity = equations.input("qd", &[joint + 1]);
                    sum.add(&[value, velocity]);
                }
            }
            sum
        })
    }

    /// The solution of `J x + b = 0` for the joints that follow, with numbers.
    pub(super) fn solve(
        &self,
        equations: &mut Equations,
        names: [&'static str; 5],
        given: impl Fn(&mut Equations, &ConstraintRow) -> Sum,
    ) -> Result<Vec<(usize, Scalar)>, GenerateError> {
        let JointRoles {
            dependent, bound, ..
        } = &self.roles;
        let mut rows = Vec::with_capacity(dependent.len());
        for &number in &self.roles.rows {
            let constraint = &self.constraints[number];
            let mut row = constraint.dependent_entries(dependent);
            let sum = given(equations, constraint);
            let label = QuantityLabel::new("bv", 0, number + 1);
            row.push((dependent.len(), equations.define(label, sum)));
            for (place, &joint) in bound.iter().enumerate() {
                row.push((dependent.len() + 1 + place, constraint.entry(joint)));
            }
            row.retain(|(_, value)| !value.is_zero());
            rows.push(row);
        }
        let solution = solve_blocks(equations, names, &rows, 1 + bound.len())
            .map_err(|place| GenerateError::singular(self.parameters.model, [dependent[place]]))?;
        // x_v = rest + B x_w, with w for the joints that the user's rows bind.
        let rest: Vec<Scalar> = solution.iter().map(|row| -entry(row, 0)).collect();
        let behind =
            |&(column, value): &(usize, Scalar)| (column > 0).then(|| (column - 1, -value));
        let matrix: Vec<SparseRow> = solution
            .iter()
            .map(|row| row.iter().filter_map(behind).collect())
            .collect();
        let relation = DependentJoints {
            joints: dependent,
            matrix: &matrix,
            rest: &rest,
        };
        let found = if bound.is_empty() {
            Vec::new()
        } else {
            let rows = (&self.user[..], &bound[..]);
            let system = ReducedRows::new(equations, ["ua", "ur"], rows, &relation, given);
            solve_unknown(equations, &system)
        };
        let mut all: Vec<(usize, Scalar)> = bound.iter().copied().zip(found.clone()).collect();
        for (place, &joint) in dependent.iter().enumerate() {
            let mut sum = Sum::of(rest[place]);
            for &(column, value) in &matrix[place] {
                sum.add(&[value, found[column]]);
            }
            let label = QuantityLabel::new("xv", 0, joint + 1);
            all.push((joint, equations.define(label, sum)));
        }
        Ok(all)
    }
}
