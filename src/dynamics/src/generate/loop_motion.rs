//! Changes of a motion that keep loops closed, by position and velocity of each
//! independent joint; [`super::sensitivity`] has the equations.

use super::algebra::{Scalar, Sum};
use super::equations::QuantityLabel;
use super::factor::{SparseRow, entry, find_entry};
use super::loop_rates::{JointRow, LoopRates};
use super::reactions;
use super::reduced::ReducedMotion;
use super::{GenerateError, Options};

/// Change of a motion by the position or the velocity of one joint.
pub(super) struct MotionSlope {
    pub(super) joint: usize,
    /// That of positions, by joint.
    pub(super) position: JointRow,
    /// That of velocities.
    pub(super) velocity: JointRow,
    /// `dqdd_v - B dqdd_u`, by place among the dependent joints.
    pub(super) rest: SparseRow,
}

impl ReducedMotion<'_, '_, '_> {
    /// Changes of the rows of loops that determine joints, by pivots.
    pub(super) fn loop_rates(&mut self, options: &Options) -> Result<LoopRates, GenerateError> {
        let ReducedMotion {
            reduction,
            roles,
            loops,
            balance,
            ..
        } = self;
        if roles.rows.is_empty() {
            return Ok(LoopRates::default());
        }
        let forces = reactions::of_loops(reduction, roles, loops, balance)?;
        let multiplier = |row: usize| {
            let place = roles.rows.iter().position(|&own| own == row);
            place.map_or(Scalar::ZERO, |place| forces[place])
        };
        let mut rates = LoopRates::new(
            reduction.equations,
            reduction.parameters,
            options,
            &balance.accelerations,
            multiplier,
        );
        for all in [&mut rates.first, &mut rates.second] {
            let rows = roles.rows.iter();
            *all = rows.map(|&row| std::mem::take(&mut all[row])).collect();
        }
        Ok(rates)
    }

    /// Changes of the motion by positions and velocities of independent joints.
    pub(super) fn changes(
        &mut self,
        rates: &LoopRates,
    ) -> Result<[Vec<MotionSlope>; 2], GenerateError> {
        let parameters = self.reduction.parameters;
        let joints = 0..parameters.joints();
        let joints = joints.filter(|&joint| !parameters.frames.is_constant(joint));
        let moving: Vec<usize> = joints
            .filter(|joint| !self.roles.dependent.contains(joint))
            .collect();
        let along = self.along(&moving)?;
        let columns = |row: &JointRow| along.iter().map(|along| product(row, along)).collect();
        let right = rates.first.iter().map(columns).collect();
        let first = self.solved(["Jelu", "Jel", "Jei", "Jex", "dqd"], right)?;
        let doubled = self.doubled(&first, &moving);
        let mut right: Vec<Vec<Sum>> = rates.second.iter().map(columns).collect();
        for (sums, row) in right.iter_mut().zip(&rates.first) {
            for (joint, doubled) in self.roles.dependent.iter().zip(&doubled) {
                let rate = find_entry(row, *joint);
                for &(column, value) in doubled {
                    sums[column].add(&[rate, value]);
                }
            }
        }
        let second = self.solved(["Jflu", "Jfl", "Jfi", "Jfx", "dqs"], right)?;
        let dependent = &self.roles.dependent;
        let column = |rows: &[SparseRow], column: usize| -> SparseRow {
            let places = rows.iter().map(|row| entry(row, column)).enumerate();
            places.filter(|(_, value)| !value.is_zero()).collect()
        };
        let by_joint = |places: &SparseRow| -> JointRow {
            places
                .iter()
                .map(|&(place, value)| (dependent[place], value))
                .collect()
        };
        let (mut by_position, mut by_velocity) = (Vec::new(), Vec::new());
        for (number, &joint) in moving.iter().enumerate() {
            by_position.push(MotionSlope {
                joint,
                position: along[number].clone(),
                velocity: by_joint(&column(&first, number)),
                rest: column(&second, number),
            });
            // Nothing depends on a velocity that has no symbol.
            if parameters.model.joints[joint].has_velocity {
                by_velocity.push(MotionSlope {
                    joint,
                    position: JointRow::new(),
                    velocity: along[number].clone(),
                    rest: column(&doubled, number),
                });
            }
        }
        Ok([by_position, by_velocity])
    }

    /// The change of all joints by each of some that do not depend on others.
    fn along(&mut self, moving: &[usize]) -> Result<Vec<JointRow>, GenerateError> {
        let mut along: Vec<JointRow> = moving
            .iter()
            .map(|&joint| vec![(joint, Scalar::ONE)])
            .collect();
        let free = &self.roles.free;
        let given: Vec<usize> = (0..moving.len())
            .filter(|&place| free.binary_search(&moving[place]).is_err())
            .collect();
        let right = self.loops.rows.iter().map(|row| {
            let entries = given.iter().map(|&place| row.entry(moving[place]));
            entries.map(Sum::of).collect()
        });
        let right = right.collect();
        let driven = self.solved(["Jglu", "Jgl", "Jgi", "Jgx", "dqc"], right)?;
        for (place, &joint) in self.roles.dependent.iter().enumerate() {
            for &(column, value) in &self.loops.matrix[place] {
                let column = moving.binary_search(&self.roles.free[column]);
                along[column.expect("free joints move")].push((joint, value));
            }
            for &(column, value) in &driven[place] {
                along[given[column]].push((joint, value));
            }
        }
        Ok(along)
    }

    /// `-Jv^-1 X`, for the columns of `X` in each row of the loops.
    fn solved(
        &mut self,
        names: [&'static str; 5],
        rows: Vec<Vec<Sum>>,
    ) -> Result<Vec<SparseRow>, GenerateError> {
        let columns = rows.first().map_or(0, Vec::len);
        let mut right = Vec::with_capacity(rows.len());
        for (number, sums) in (1..).zip(rows) {
            let values = sums.into_iter().enumerate().map(|(column, sum)| {
                let label = QuantityLabel::new(names[0], 0, number).column(column + 1);
                (column, self.reduction.equations.define(label, sum))
            });
            right.push(values.filter(|(_, value)| !value.is_zero()).collect());
        }
        let system = (&self.loops.rows[..], &self.roles.dependent[..]);
        let mut solution = self.reduction.solve_loops(names, system, &right, columns)?;
        for (_, value) in solution.iter_mut().flatten() {
            *value = -*value;
        }
        Ok(solution)
    }

    fn doubled(&mut self, rows: &[SparseRow], moving: &[usize]) -> Vec<SparseRow> {
        let equations = &mut *self.reduction.equations;
        let rows = rows.iter().zip(&self.roles.dependent);
        let doubled = rows.map(|(row, joint)| {
            let entries = row.iter().map(|&(column, value)| {
                let label = QuantityLabel::new("dqt", 0, joint + 1).column(moving[column] + 1);
                (column, equations.define(label, Sum::total(&[value, value])))
            });
            entries.collect()
        });
        doubled.collect()
    }
}

/// The product of two rows by joint.
pub(super) fn product(one: &[(usize, Scalar)], other: &[(usize, Scalar)]) -> Sum {
    let mut sum = Sum::new();
    for &(joint, value) in other {
        sum.add(&[find_entry(one, joint), value]);
    }
    sum
}
