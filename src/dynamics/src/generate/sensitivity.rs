//! Change of accelerations: the inverse of the mass matrix, and the derivatives
//! of forward dynamics, with closed loops or without.
//!
//! With `Jd` and `Jdd` the derivatives of `J` by time, `M qdd + c = Qq + J^T lambda`
//! and `J qdd + Jd qd = 0` hold for all changes `dq`, `dqd`, `dqdd` of the motion
//! that keep loops closed, `J dq = 0`. The derivatives of this by time are
//!
//! ```text
//! J dqd + Jd dq = 0        J dqdd + 2 Jd dqd + Jdd dq = 0
//! ```
//!
//! so that a change of the independent joints (u) and of the driven joints gives
//! those of the dependent joints (v), and all of `dqdd_v` but `B dqdd_u`. With the
//! derivatives `Qq_q` and `Qq_qd` of inverse dynamics at these accelerations, and
//! with `T = [1; B]`, the multipliers drop out:
//!
//! ```text
//! r = (Qq_q - (J^T lambda)_q) dq + Qq_qd dqd
//! Mr dqdd_u = -T^T (r + M [0; dqdd_v - B dqdd_u])      qdd_Qq = T Mr^-1 T^T
//! ```
//!
//! `Mr` is eliminated once, in the order that keeps a tree's zeros, and solved
//! for every column: an inverse that is multiplied would take no fewer
//! operations for a chain and more for a tree. Driven joints move as prescribed:
//! they have columns, and the changes of their accelerations are zero.

use super::algebra::{Scalar, Sum};
use super::derivative::{ForceDerivatives, JointEntry, output};
use super::equations::{Equations, QuantityLabel};
use super::factor::{SparseRow, entry};
use super::frames::ModelFrames;
use super::loop_motion::{MotionSlope, product};
use super::massless::massless_joints;
use super::parameters::ModelParameters;
use super::reduced::ReducedMotion;
use super::roles::JointRoles;
use super::{GenerateError, GenerationRequest, Options, composite, independent_joints};
use robovec_model::Model;
use std::collections::BTreeMap;

/// The derivatives of all accelerations (rows).
pub(super) struct AccelerationDerivatives {
    pub(super) by_position: Vec<JointEntry>,
    pub(super) by_velocity: Vec<JointEntry>,
    pub(super) by_force: Vec<JointEntry>,
}

impl AccelerationDerivatives {
    /// Writes the derivatives with closed loops, for independent joints.
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        request: &GenerationRequest,
    ) -> Result<AccelerationDerivatives, GenerateError> {
        let (source, options) = (parameters.frames.source, &request.options);
        if options.user_constraints > 0 {
            return Err(GenerateError::UserDerivatives {
                function: request.function.name(),
            });
        }
        let roles = JointRoles::of_loops(source)?;
        // Without rows of the user, a joint that needs one is an error.
        massless_joints(source, &roles, options)?;
        AccelerationDerivatives::at(equations, parameters, options, roles)
    }

    fn at(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        options: &Options,
        roles: JointRoles,
    ) -> Result<AccelerationDerivatives, GenerateError> {
        let dynamics = composite::dynamics(equations, parameters, options);
        let roles = (roles, &[][..]);
        let mut motion = ReducedMotion::new(equations, parameters, options, dynamics, roles)?;
        let rates = motion.loop_rates(options)?;
        let mut accelerations = motion.balance.accelerations.clone();
        for &joint in motion.roles.free.iter().chain(&motion.roles.dependent) {
            let own = accelerations[joint];
            accelerations[joint] = parameters.with_resting(motion.reduction.equations, joint, own);
        }
        let equations = &mut *motion.reduction.equations;
        let found = ForceDerivatives::new(equations, parameters, options, &accelerations);
        let against = rates.stiffness.iter();
        let against = against.map(|&(row, column, value)| (row, column, -value));
        let by_position = found.by_position.iter().copied().chain(against);
        let slopes = [
            ("RQ", by_position.collect::<Vec<JointEntry>>()),
            ("RV", found.by_velocity),
        ];
        let slopes = slopes.map(|(name, entries)| added(equations, name, &entries));
        let [by_position, by_velocity] = motion.changes(&rates)?;
        Ok(AccelerationDerivatives {
            by_position: motion.answer(["RP", "FP"], &slopes, &by_position)?,
            by_velocity: motion.answer(["RW", "FW"], &slopes, &by_velocity)?,
            by_force: motion.inverse()?,
        })
    }

    /// Sets `qdd_q`, `qdd_qd` and `qdd_Qq`.
    pub(super) fn output(&self, equations: &mut Equations) {
        output(equations, "qdd_q", &self.by_position);
        output(equations, "qdd_qd", &self.by_velocity);
        output(equations, "qdd_Qq", &self.by_force);
    }
}

/// Entries by row, those of one place added.
fn added(
    equations: &mut Equations,
    name: &'static str,
    entries: &[JointEntry],
) -> BTreeMap<usize, SparseRow> {
    let mut sums: BTreeMap<(usize, usize), Sum> = BTreeMap::new();
    for &(row, column, value) in entries {
        sums.entry((row, column)).or_default().add(&[value]);
    }
    let mut rows: BTreeMap<usize, SparseRow> = BTreeMap::new();
    for ((row, column), sum) in sums {
        let label = QuantityLabel::new(name, 0, row + 1).column(column + 1);
        let value = equations.define(label, sum);
        rows.entry(row).or_default().push((column, value));
    }
    rows
}

impl ReducedMotion<'_, '_, '_> {
    /// Changes of accelerations with the motion, by derivatives of forces.
    fn answer(
        &mut self,
        [force, side]: [&'static str; 2],
        slopes: &[BTreeMap<usize, SparseRow>; 2],
        changes: &[MotionSlope],
    ) -> Result<Vec<JointEntry>, GenerateError> {
        let (free, dependent) = (&self.roles.free, &self.roles.dependent);
        let equations = &mut *self.reduction.equations;
        let empty = SparseRow::new();
        let mut sides = Vec::with_capacity(changes.len());
        for change in changes {
            let mut forced = |joint: usize| {
                let [position, velocity] =
                    [0, 1].map(|kind: usize| slopes[kind].get(&joint).unwrap_or(&empty));
                let mut sum = product(position, &change.position);
                sum.add_sum(&product(velocity, &change.velocity));
                let label = QuantityLabel::new(force, 0, joint + 1).column(change.joint + 1);
                equations.define(label, sum)
            };
            let mut sums: Vec<Sum> = free.iter().map(|&joint| Sum::of(-forced(joint))).collect();
            for (place, &joint) in dependent.iter().enumerate() {
                let value = forced(joint);
                for &(column, slope) in &self.loops.matrix[place] {
                    sums[column].subtract(&[slope, value]);
                }
                let rest = entry(&change.rest, place);
                for (sum, &inner) in sums.iter_mut().zip(&self.system.inner[place]) {
                    sum.subtract(&[inner, rest]);
                }
            }
            let named = sums.into_iter().zip(free).map(|(sum, joint)| {
                let label = QuantityLabel::new(side, 0, joint + 1).column(change.joint + 1);
                equations.define(label, sum)
            });
            sides.push(named.collect::<Vec<Scalar>>());
        }
        let moved = |side: &Vec<Scalar>| side.iter().any(|value| !value.is_zero());
        let kept: Vec<bool> = sides.iter().map(moved).collect();
        sides.retain(moved);
        let joints = (self.reduction.parameters.model, &free[..]);
        let mut solutions = self.system.solve(equations, joints, &sides)?.into_iter();
        let mut entries = Vec::new();
        for (change, kept) in changes.iter().zip(kept) {
            let solution = if kept {
                solutions.next().expect("one solution per side")
            } else {
                vec![Scalar::ZERO; free.len()]
            };
            let rows = free.iter().copied().zip(solution.iter().copied());
            entries.extend(rows.map(|(row, value)| (row, change.joint, value)));
            for (place, &joint) in dependent.iter().enumerate() {
                let mut sum = Sum::of(entry(&change.rest, place));
                for &(column, slope) in &self.loops.matrix[place] {
                    sum.add(&[slope, solution[column]]);
                }
                let label = QuantityLabel::new("dqp", 0, joint + 1).column(change.joint + 1);
                entries.push((joint, change.joint, equations.define(label, sum)));
            }
        }
        entries.retain(|(_, _, value)| !value.is_zero());
        Ok(entries)
    }

    /// `T Mr^-1 T^T`.
    fn inverse(&mut self) -> Result<Vec<JointEntry>, GenerateError> {
        let (free, dependent) = (&self.roles.free, &self.roles.dependent);
        let equations = &mut *self.reduction.equations;
        let side = |place: usize| {
            let mut side = vec![Scalar::ZERO; free.len()];
            side[place] = Scalar::ONE;
            side
        };
        let sides: Vec<Vec<Scalar>> = (0..free.len()).map(side).collect();
        let joints = (self.reduction.parameters.model, &free[..]);
        let columns = self.system.solve(equations, joints, &sides)?;
        // The solution begins where the side does: below is the less work.
        let own = |row: usize, column: usize| columns[row.min(column)][row.max(column)];
        let mut entries = Vec::new();
        for (row, &joint) in free.iter().enumerate() {
            for (column, &other) in free.iter().enumerate() {
                entries.push((joint, other, own(row, column)));
            }
        }
        // The columns of dependent joints in the rows of free ones, and beyond.
        for (place, &joint) in dependent.iter().enumerate() {
            let mut tied = Vec::with_capacity(free.len());
            for (row, &other) in free.iter().enumerate() {
                let mut sum = Sum::new();
                for &(column, slope) in &self.loops.matrix[place] {
                    sum.add(&[slope, own(row, column)]);
                }
                let label = QuantityLabel::new("Mrt", 0, other + 1).column(joint + 1);
                let value = equations.define(label, sum);
                entries.extend([(other, joint, value), (joint, other, value)]);
                tied.push(value);
            }
            for (before, &other) in dependent[..=place].iter().enumerate() {
                let mut sum = Sum::new();
                for &(column, slope) in &self.loops.matrix[before] {
                    sum.add(&[slope, tied[column]]);
                }
                let label = QuantityLabel::new("Mrt", 0, other + 1).column(joint + 1);
                let value = equations.define(label, sum);
                entries.push((other, joint, value));
                if other != joint {
                    entries.push((joint, other, value));
                }
            }
        }
        entries.retain(|(_, _, value)| !value.is_zero());
        Ok(entries)
    }
}

/// Options without constraints of the user.
fn unbound(options: &Options) -> Options {
    Options {
        user_constraints: 0,
        ..options.clone()
    }
}

/// Writes `Minv`.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let dynamics = composite::dynamics(equations, parameters, options);
    let roles = (JointRoles::open(parameters.frames.source), &[][..]);
    let options = &unbound(options);
    let mut motion = ReducedMotion::new(equations, parameters, options, dynamics, roles)?;
    let entries = motion.inverse()?;
    output(equations, "Minv", &entries);
    Ok(())
}

/// Writes `qdd_q`, `qdd_qd` and `qdd_Qq` with open loops.
pub(super) fn forward(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), GenerateError> {
    let roles = JointRoles::open(parameters.frames.source);
    let options = &unbound(options);
    AccelerationDerivatives::at(equations, parameters, options, roles)?.output(equations);
    Ok(())
}

pub(super) fn write(
    equations: &mut Equations,
    frames: &ModelFrames<'_>,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let free = free_joints(frames.source, request)?;
    let derivatives = AccelerationDerivatives::new(equations, parameters, request)?;
    let count = free.len();
    let joint = |frame: usize| frames.joint(frame).expect("only joints have derivatives");
    let place = |frame: usize| free.binary_search(&joint(frame)).ok();
    let signed = |&(row, column, value): &JointEntry| {
        value.negated_if(frames.is_reversed(row) ^ frames.is_reversed(column))
    };
    // Velocities are the derivatives of positions.
    for state in 1..=count {
        equations.output("A", &[state, count + state], Scalar::ONE);
    }
    // The last element shows a reader how large an array is.
    let mut is_open = [true; 2];
    for (first, entries) in [
        (0, &derivatives.by_position),
        (count, &derivatives.by_velocity),
    ] {
        for entry in entries {
            if let (Some(row), Some(column)) = (place(entry.0), place(entry.1)) {
                let indices = [count + row + 1, first + column + 1];
                is_open[0] &= indices != [2 * count; 2];
                equations.output("A", &indices, signed(entry));
            }
        }
    }
    let joints = frames.source.joints.len();
    for entry in &derivatives.by_force {
        if let Some(row) = place(entry.0) {
            let indices = [count + row + 1, joint(entry.1) + 1];
            is_open[1] &= indices != [2 * count, joints];
            equations.output("B", &indices, signed(entry));
        }
    }
    for (array, columns, is_open) in [("A", 2 * count, is_open[0]), ("B", joints, is_open[1])] {
        if is_open {
            equations.output(array, &[2 * count, columns], Scalar::ZERO);
        }
    }
    Ok(())
}

/// Numbers from 1 of the joints whose positions and velocities are the state.
pub(super) fn state(model: &Model, request: &GenerationRequest) -> Result<String, GenerateError> {
    let free = free_joints(model, request)?;
    let numbers: Vec<String> = free.iter().map(|joint| (joint + 1).to_string()).collect();
    Ok(numbers.join(" "))
}

fn free_joints(model: &Model, request: &GenerationRequest) -> Result<Vec<usize>, GenerateError> {
    let free = independent_joints(model, &request.options)?;
    if free.is_empty() {
        return Err(GenerateError::Motionless(model.name.clone()));
    }
    Ok(free)
}
