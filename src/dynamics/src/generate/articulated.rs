//! Articulated bodies: accelerations in operations proportional to joints.
//!
//! A joint that is free to move hides part of the inertia beyond it. From the
//! leaves to the base, every joint's share is taken out of the inertia it
//! carries: `I - U U^T / D` with `U = I s` and `D = s.U`. What is left, the
//! *articulated* inertia, is a full matrix in its three blocks:
//!
//! ```text
//! torque = KA alpha + KB a        force = KB^T alpha + KD a
//! ```
//!
//! The forces left after the bias, `Qq - c`, are propagated in the same manner,
//! and the accelerations follow from the base to the leaves. Driven joints hide
//! nothing; their accelerations are inputs. The bias is that of
//! [`super::recursive`], so that nothing here depends on velocities.
//!
//! Needs one division for each joint, and `sin^2 + cos^2 = 1`.

use super::algebra::{Scalar, Sum};
use super::equations::{Equations, QuantityLabel};
use super::inertia::{SumInertia, SumWrench, Wrench, turn_general, turn_symmetric};
use super::parameters::ModelParameters;
use super::reduction::residual_input;
use super::vector::{
    AxisRotation, Inertia, Matrix, SumVector, Vector, ZERO, add_cross, cyclic, define, sums,
};
use super::{Options, recursive};
use robovec_model::Nature;

/// Writes `qdd`; the first joint that moves nothing is an error.
pub(super) fn accelerations(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Result<(), usize> {
    let offsets = parameters.named_offsets(equations);
    let bias = recursive::bias(equations, parameters, options);
    let mut bodies = Articulated {
        equations,
        parameters,
        offsets: &offsets,
        children: parameters.children(),
    };
    let joints = bodies.inward(&bias)?;
    bodies.outward(&joints);
    Ok(())
}

/// Names of the quantities that turn the coupling block.
const COUPLING_NAMES: [&str; 5] = ["YD", "YS", "YW", "YV", "YU"];

#[derive(Clone, Copy)]
struct Blocks {
    /// Torque for angular acceleration; symmetric.
    angular: Matrix,
    /// Torque for acceleration.
    coupling: Matrix,
    /// Force for acceleration; symmetric.
    linear: Matrix,
}

/// Blocks that are not named yet; of the symmetric ones the upper triangles.
struct SumBlocks {
    angular: [SumVector; 3],
    coupling: [SumVector; 3],
    linear: [SumVector; 3],
}

/// Quantities of a joint in the recursion from the base.
#[derive(Clone, Copy)]
struct Share {
    /// `U / D` of a free joint, one along the joint.
    torque: Vector,
    force: Vector,
    /// Its acceleration if the frame before did not accelerate, or if driven.
    alone: Scalar,
}

struct Articulated<'e, 'p, 'm> {
    equations: &'e mut Equations,
    parameters: &'p ModelParameters<'m>,
    offsets: &'p [Vector],
    children: Vec<Vec<usize>>,
}

impl Articulated<'_, '_, '_> {
    fn is_driven(&self, joint: usize) -> bool {
        self.parameters.model.joints[joint].nature == Nature::Driven
    }

    /// From the leaves to the base.
    fn inward(&mut self, bias: &[Scalar]) -> Result<Vec<Share>, usize> {
        let parameters = self.parameters;
        let count = parameters.joints();
        let mut carried = vec![(Blocks::NONE, Wrench::ZERO); count];
        let mut shares = vec![
            Share {
                torque: ZERO,
                force: ZERO,
                alone: Scalar::ZERO,
            };
            count
        ];
        for joint in (0..count).rev() {
            let label = |name| QuantityLabel::new(name, 0, joint + 1);
            let (blocks, wrench) = self.collect(joint, &carried);
            let unit = blocks.column(parameters.axis(joint), parameters.is_revolute(joint));
            if self.is_driven(joint) {
                let alone = parameters.acceleration(self.equations, joint);
                shares[joint].alone = alone;
                let wrench = self.moved(joint, &wrench, &unit, alone);
                carried[joint] = (blocks, wrench);
                continue;
            }
            let armature = parameters.armature(self.equations, joint);
            let moved = Sum::total(&[unit.along(parameters, joint), armature]);
            let pivot = self.equations.define(label("DR"), moved);
            if pivot.is_zero() {
                return Err(joint);
            }
            let residual = residual_input(self.equations, joint, bias[joint], &[]);
            let mut rest = Sum::of(residual);
            rest.subtract(&[wrench.along(parameters, joint)]);
            let rest = self.equations.define(label("QU"), rest);
            let inverse = self.equations.quotient(label("DI"), Scalar::ONE, pivot);
            let share = self.share(joint, &unit, inverse);
            let mut wrench = self.moved(joint, &wrench, &share, rest);
            if armature.is_zero() {
                // Along the joint the wrench is what its force leaves.
                *component(parameters, joint, &mut wrench) = residual;
            }
            let alone = Sum::product(&[rest, inverse]);
            shares[joint] = Share {
                torque: share.torque,
                force: share.force,
                alone: self.equations.define(label("QA"), alone),
            };
            let left = self.left(joint, &blocks, &unit, &share);
            carried[joint] = (left, wrench);
        }
        Ok(shares)
    }

    /// The inertia of a joint's own body and of its children's contributions.
    fn collect(&mut self, joint: usize, carried: &[(Blocks, Wrench)]) -> (Blocks, Wrench) {
        let parameters = self.parameters;
        let mut own = SumInertia::new();
        own.add_own(self.equations, parameters, joint);
        let own = own.define(self.equations, ["MA", "HA", "JA"], joint, 0);
        let mut blocks = SumBlocks::of(&own);
        let mut wrench = SumWrench::new();
        for index in 0..self.children[joint].len() {
            let child = self.children[joint][index];
            let (turn, offset) = (&parameters.turns[child], &self.offsets[child]);
            let (behind, load) = &carried[child];
            let turned = behind.turned(self.equations, child, turn);
            blocks.add_moved(self.equations, child, &turned, offset);
            wrench.add(&load.to_parent(self.equations, "FR", (child, 0), turn, offset));
        }
        (
            blocks.define(self.equations, ["KA", "KB", "KD"], joint),
            wrench.define(self.equations, ("FP", "NP"), joint, 0),
        )
    }

    /// A wrench and a multiple of another.
    fn moved(&mut self, joint: usize, wrench: &Wrench, unit: &Wrench, factor: Scalar) -> Wrench {
        let mut sum = wrench.sums();
        sum.add_scaled(unit, factor);
        sum.define(self.equations, ("FQ", "NQ"), joint, 0)
    }

    /// `U / D`.
    fn share(&mut self, joint: usize, unit: &Wrench, inverse: Scalar) -> Wrench {
        let scaled = |vector: &Vector| vector.map(|component| Sum::product(&[component, inverse]));
        let mut share = SumWrench {
            force: scaled(&unit.force),
            torque: scaled(&unit.torque),
        };
        if let Some((axis, revolute)) = self.hidden(joint) {
            let along = match revolute {
                true => &mut share.torque[axis],
                false => &mut share.force[axis],
            };
            *along = Sum::of(Scalar::ONE);
        }
        share.define(self.equations, ("FV", "NV"), joint, 0)
    }

    /// Axis and kind in which a joint hides inertia; one with a rotor does not.
    fn hidden(&self, joint: usize) -> Option<(usize, bool)> {
        let parameters = self.parameters;
        let direction = (parameters.axis(joint), parameters.is_revolute(joint));
        (parameters.model.joints[joint].armature == 0.0).then_some(direction)
    }

    /// `I - U U^T / D`: without a rotor no inertia remains along the joint.
    fn left(&mut self, joint: usize, blocks: &Blocks, unit: &Wrench, share: &Wrench) -> Blocks {
        let hidden = |revolute| {
            let direction = self.hidden(joint);
            direction.and_then(|(axis, turns)| (turns == revolute).then_some(axis))
        };
        let (turns, slides) = (hidden(true), hidden(false));
        let block = |matrix: &Matrix, unit: &Vector, share: &Vector, row, column, triangle| {
            let mut left = [sums(), sums(), sums()];
            for r in (0..3).filter(|&r| Some(r) != row) {
                let first = if triangle { r } else { 0 };
                for c in (first..3).filter(|&c| Some(c) != column) {
                    left[r][c]
                        .add(&[matrix[r][c]])
                        .subtract(&[unit[r], share[c]]);
                }
            }
            left
        };
        SumBlocks {
            angular: block(
                &blocks.angular,
                &unit.torque,
                &share.torque,
                turns,
                turns,
                true,
            ),
            coupling: block(
                &blocks.coupling,
                &unit.torque,
                &share.force,
                turns,
                slides,
                false,
            ),
            linear: block(
                &blocks.linear,
                &unit.force,
                &share.force,
                slides,
                slides,
                true,
            ),
        }
        .define(self.equations, ["LA", "LB", "LD"], joint)
    }

    /// From the base to the leaves; sets the outputs.
    fn outward(&mut self, shares: &[Share]) {
        let parameters = self.parameters;
        let mut accelerations: Vec<(Vector, Vector)> = Vec::with_capacity(shares.len());
        for (joint, share) in shares.iter().enumerate() {
            let parent = parameters.parent(joint);
            let (angular, linear) = parent.map_or((ZERO, ZERO), |parent| accelerations[parent]);
            let turn = &parameters.turns[joint];
            let mut moved = linear.map(Sum::of);
            add_cross(&mut moved, &angular, &self.offsets[joint], false);
            let moved = define(self.equations, "AM", joint, 0, moved);
            let mut angular = define(self.equations, "OB", joint, 0, turn.down(&angular));
            let mut linear = define(self.equations, "AB", joint, 0, turn.down(&moved));
            let revolute = parameters.is_revolute(joint);
            let axis = parameters.axis(joint);
            let before = if revolute {
                angular[axis]
            } else {
                linear[axis]
            };
            let mut total = Sum::of(share.alone);
            let mut own = Sum::new();
            if self.is_driven(joint) {
                total.add(&[before]);
                own.add(&[share.alone]);
            } else {
                // A share of one along the joint cancels the motion before it.
                let hidden = self.hidden(joint);
                for k in 0..3 {
                    if hidden != Some((k, true)) {
                        total.subtract(&[share.torque[k], angular[k]]);
                    }
                    if hidden != Some((k, false)) {
                        total.subtract(&[share.force[k], linear[k]]);
                    }
                }
                if hidden.is_none() {
                    total.add(&[before]);
                }
            }
            let total = self
                .equations
                .define(QuantityLabel::new("QT", 0, joint + 1), total);
            if !self.is_driven(joint) {
                own.add(&[total]).subtract(&[before]);
            }
            if revolute {
                angular[axis] = total;
            } else {
                linear[axis] = total;
            }
            accelerations.push((angular, linear));
            let own = self
                .equations
                .define(QuantityLabel::new("qpp", 0, joint + 1), own);
            self.equations.output("qdd", &[joint + 1], own);
        }
    }
}

fn component<'w>(
    parameters: &ModelParameters<'_>,
    joint: usize,
    wrench: &'w mut Wrench,
) -> &'w mut Scalar {
    let axis = parameters.axis(joint);
    if parameters.is_revolute(joint) {
        &mut wrench.torque[axis]
    } else {
        &mut wrench.force[axis]
    }
}

impl Blocks {
    const NONE: Blocks = Blocks {
        angular: [ZERO; 3],
        coupling: [ZERO; 3],
        linear: [ZERO; 3],
    };

    /// The wrench of a unit of acceleration along an axis.
    fn column(&self, axis: usize, revolute: bool) -> Wrench {
        if revolute {
            Wrench {
                torque: self.angular[axis],
                force: self.coupling[axis],
            }
        } else {
            Wrench {
                torque: self.coupling.map(|row| row[axis]),
                force: self.linear[axis],
            }
        }
    }

    /// The blocks in the axes of the frame before a joint.
    fn turned(&self, equations: &mut Equations, joint: usize, turn: &AxisRotation) -> Blocks {
        let names = ["XD", "XW", "XV"];
        let angular = turn_symmetric(equations, names, joint, turn, &self.angular);
        let names = ["ZD", "ZW", "ZV"];
        let linear = turn_symmetric(equations, names, joint, turn, &self.linear);
        SumBlocks {
            angular,
            coupling: turn_general(equations, COUPLING_NAMES, joint, turn, &self.coupling),
            linear,
        }
        .define(equations, ["TA", "TB", "TD"], joint)
    }
}

impl SumBlocks {
    /// The blocks of a rigid body: `J`, `~h` and `m E`.
    fn of(inertia: &Inertia) -> SumBlocks {
        let mut blocks = SumBlocks {
            angular: inertia.moments.map(|row| row.map(Sum::of)),
            coupling: [sums(), sums(), sums()],
            linear: [sums(), sums(), sums()],
        };
        for axis in 0..3 {
            let (next, last) = cyclic(axis);
            blocks.coupling[axis][next].add(&[-inertia.first[last]]);
            blocks.coupling[next][axis].add(&[inertia.first[last]]);
            blocks.linear[axis][axis].add(&[inertia.mass]);
        }
        blocks
    }

    /// Adds blocks about an origin `offset` beyond. With `H` the coupling and
    /// `H' = H + ~d KD` after it, the angular block grows by `~d H'^T - H ~d`.
    fn add_moved(
        &mut self,
        equations: &mut Equations,
        joint: usize,
        blocks: &Blocks,
        offset: &Vector,
    ) {
        let mut moved = blocks.coupling.map(|row| row.map(Sum::of));
        for (column, vector) in blocks.linear.iter().enumerate() {
            let mut cross = sums();
            add_cross(&mut cross, offset, vector, false);
            for (row, cross) in moved.iter_mut().zip(&cross) {
                row[column].add_sum(cross);
            }
        }
        let mut row = 0;
        let moved = moved.map(|sums| {
            row += 1;
            let mut column = 0;
            sums.map(|sum| {
                column += 1;
                let label = QuantityLabel::new("TC", 3 * (row - 1) + column, joint + 1);
                equations.define(label, sum)
            })
        });
        for x in 0..3 {
            let mut before = sums();
            add_cross(&mut before, offset, &blocks.coupling[x], false);
            for y in 0..3 {
                self.coupling[x][y].add(&[moved[x][y]]);
                if y < x {
                    continue;
                }
                let mut after = sums();
                add_cross(&mut after, offset, &moved[y], false);
                self.linear[x][y].add(&[blocks.linear[x][y]]);
                self.angular[x][y]
                    .add(&[blocks.angular[x][y]])
                    .add_sum(&before[y])
                    .add_sum(&after[x]);
            }
        }
    }

    fn define(self, equations: &mut Equations, names: [&'static str; 3], joint: usize) -> Blocks {
        let [angular, coupling, linear] = names;
        let mut name = |name, block: [SumVector; 3], triangle: bool| {
            let mut named = [ZERO; 3];
            for (row, sums) in block.into_iter().enumerate() {
                let first = if triangle { row } else { 0 };
                for (column, sum) in sums.into_iter().enumerate().skip(first) {
                    let label = QuantityLabel::new(name, 3 * row + column + 1, joint + 1);
                    named[row][column] = equations.define(label, sum);
                    if triangle {
                        named[column][row] = named[row][column];
                    }
                }
            }
            named
        };
        Blocks {
            angular: name(angular, self.angular, true),
            coupling: name(coupling, self.coupling, false),
            linear: name(linear, self.linear, true),
        }
    }
}
