//! Derivatives of inverse dynamics by positions and velocities, with composites
//! in body frames: the effect of a change of joint j on the force of joint i
//! costs one change of frame, as an element of `M` does.
//!
//! Let joint j change by a little, and look at the bodies beyond it from the
//! frame beyond it. They see their base move otherwise: where joint j turns
//! about `s`, its angular velocity changes by `OM x s`, its angular acceleration
//! with all centrifugal terms by a column of `BE = ~OA + ~OM ~OM`, and the
//! acceleration `AF` of the origin by `AF x s`. All of that is known already.
//! Bodies that are frozen in their joints answer to it by the composite inertia
//! (a wrench for an acceleration), and by the *moved moments*
//!
//! ```text
//! P = sum m v          N = sum m v r^T
//! ```
//!
//! of velocities `v` seen from the origin of the frame: an angular velocity `u`
//! adds the accelerations `2 u x v`, and so the force `2 u x P` and the torque
//! `2 (tr N - N) u`. `P` and `N` are carried like first and second moments of
//! mass, all doubled here (`VP`, `VN`), which spares the factor.
//!
//! The same in the frames of spatial vectors is Singh, Russell and Wensing,
//! "Efficient analytical derivatives of rigid-body dynamics using spatial vector
//! algebra", IEEE RA-L 7 (2022); point accelerations need no velocity of origins.
//! External forces turn with their bodies. A free base that a quaternion describes
//! changes otherwise ([`super::free_base`]). Needs `sin^2 + cos^2 = 1`, which also
//! states that the derivative of the sine is the cosine.

use super::Options;
use super::algebra::{Scalar, Sum};
use super::composite::carry;
use super::equations::{Equations, QuantityLabel};
use super::free_base;
use super::inertia::{SumWrench, Wrench, turn_general};
use super::parameters::ModelParameters;
use super::recursive::{JointLoad, Recursion};
use super::vector::{
    Inertia, Matrix, SumVector, Vector, ZERO, add_cross, add_matrix_product, add_sums, add_vector,
    cyclic, define, sums, unit,
};

/// An entry of a matrix of joints: the row, the column and the value.
pub(super) type JointEntry = (usize, usize, Scalar);

/// Derivatives of forces `Qq` (rows) by joints (columns), without zeros.
#[derive(Default)]
pub(super) struct ForceDerivatives {
    pub(super) by_position: Vec<JointEntry>,
    pub(super) by_velocity: Vec<JointEntry>,
}

impl ForceDerivatives {
    /// Writes the derivatives at given accelerations of all joints.
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        options: &Options,
        accelerations: &[Scalar],
    ) -> ForceDerivatives {
        let mut recursion = Recursion::moving(equations, parameters, options, accelerations);
        let loads = recursion.loads();
        let composites = Inertia::composites(recursion.equations, parameters, &recursion.offsets);
        let mut derivative = Derivative::new(recursion, composites, loads);
        derivative.carry_moments();
        for joint in 0..parameters.joints() {
            if !parameters.frames.is_constant(joint) {
                derivative.joint(joint);
            }
        }
        derivative.found
    }
}

/// Sets a matrix of joints as outputs; one zero where all entries are.
pub(super) fn output(equations: &mut Equations, array: &str, entries: &[JointEntry]) {
    if entries.is_empty() {
        equations.output(array, &[1, 1], Scalar::ZERO);
    }
    for &(row, column, value) in entries {
        equations.output(array, &[row + 1, column + 1], value);
    }
}

/// Writes `Qq_q` and `Qq_qd`.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let accelerations: Vec<Scalar> = (0..parameters.joints())
        .map(|joint| parameters.acceleration(equations, joint))
        .collect();
    let found = ForceDerivatives::new(equations, parameters, options, &accelerations);
    output(equations, "Qq_q", &found.by_position);
    output(equations, "Qq_qd", &found.by_velocity);
}

/// Twice the momentum, and `m v r^T`, of bodies beyond a joint, from it.
#[derive(Clone, Copy)]
struct MovedMoments {
    momentum: Vector,
    /// `N`.
    moments: Matrix,
    /// `tr N - N`.
    turning: Matrix,
}

/// Change of the motion of a frame.
#[derive(Clone, Copy)]
pub(super) struct MotionChange {
    /// That of its angular acceleration, with all centrifugal terms.
    pub(super) angular: Vector,
    /// That of the acceleration of its origin.
    pub(super) linear: Vector,
    /// That of its angular velocity, for bodies that move as seen from it.
    pub(super) velocity: Vector,
}

impl MotionChange {
    pub(super) fn of_origin(linear: Vector) -> MotionChange {
        MotionChange {
            angular: ZERO,
            linear,
            velocity: ZERO,
        }
    }
}

struct Derivative<'e, 'p, 'm> {
    recursion: Recursion<'e, 'p, 'm>,
    composites: Vec<Inertia>,
    loads: Vec<JointLoad>,
    /// Twice the angular velocities.
    doubled: Vec<Vector>,
    moved: Vec<MovedMoments>,
    /// By joint, twice the velocity of its origin seen from its parent's.
    swings: Vec<Vector>,
    found: ForceDerivatives,
}

impl<'e, 'p, 'm> Derivative<'e, 'p, 'm> {
    fn new(
        recursion: Recursion<'e, 'p, 'm>,
        composites: Vec<Inertia>,
        loads: Vec<JointLoad>,
    ) -> Self {
        let parameters = recursion.parameters;
        let rest = MovedMoments {
            momentum: ZERO,
            moments: [ZERO; 3],
            turning: [ZERO; 3],
        };
        let mut derivative = Derivative {
            recursion,
            composites,
            loads,
            doubled: Vec::new(),
            moved: vec![rest; parameters.joints()],
            swings: Vec::new(),
            found: ForceDerivatives::default(),
        };
        for joint in 0..parameters.joints() {
            let doubled = derivative.recursion.velocities[joint].map(twice);
            let doubled = define(derivative.equations(), "VO", joint, 0, doubled);
            derivative.doubled.push(doubled);
            let swing = derivative.swing(joint);
            derivative.swings.push(swing);
        }
        derivative
    }

    fn equations(&mut self) -> &mut Equations {
        self.recursion.equations
    }

    fn swing(&mut self, joint: usize) -> Vector {
        let parameters = self.recursion.parameters;
        let Some(parent) = parameters.parent(joint) else {
            return ZERO;
        };
        let mut swing = sums();
        let offset = &self.recursion.offsets[joint];
        add_cross(&mut swing, &self.doubled[parent], offset, false);
        if !parameters.is_revolute(joint) {
            let rate = parameters.qd[joint];
            swing[parameters.axis(joint)].add(&[rate]).add(&[rate]);
        }
        define(self.equations(), "VS", joint, 0, swing)
    }

    /// From the leaves to the base.
    fn carry_moments(&mut self) {
        for joint in (0..self.moved.len()).rev() {
            let (mut momentum, mut moments) = self.own_moments(joint);
            for index in 0..self.recursion.children[joint].len() {
                let child = self.recursion.children[joint][index];
                self.add_child(child, &mut momentum, &mut moments);
            }
            let equations = self.equations();
            let moments = name_matrix(equations, "VN", joint, moments);
            let mut turning = moments.map(|row| row.map(|entry| -entry));
            for axis in 0..3 {
                let (next, last) = cyclic(axis);
                let sum = Sum::total(&[moments[next][next], moments[last][last]]);
                let label = QuantityLabel::new("VM", axis + 1, joint + 1);
                turning[axis][axis] = equations.define(label, sum);
            }
            self.moved[joint] = MovedMoments {
                momentum: define(equations, "VP", joint, 0, momentum),
                moments,
                turning,
            };
        }
    }

    /// `2 OM x m l`, and `~OM 2 E + P l^T` with central `2 E = tr I - 2 I`.
    fn own_moments(&mut self, joint: usize) -> (SumVector, [SumVector; 3]) {
        let parameters = self.recursion.parameters;
        if let Some(grouped) = &parameters.grouped {
            let own = &grouped[joint];
            let mut momentum = sums();
            add_cross(
                &mut momentum,
                &self.doubled[joint],
                &own.inertia.first,
                false,
            );
            return (momentum, self.turned_second(joint, &own.second));
        }
        let (mass, center) = (parameters.masses[joint], &parameters.centers[joint]);
        let first = center.map(|length| Sum::product(&[mass, length]));
        let first = define(self.equations(), "ML", joint, 0, first);
        let mut momentum = sums();
        add_cross(&mut momentum, &self.doubled[joint], &first, false);
        let own = define(self.equations(), "VL", joint, 0, momentum);
        let inertia = &parameters.inertias[joint];
        let mut second = inertia.map(|row| row.map(|entry| twice(-entry)));
        for axis in 0..3 {
            let (next, last) = cyclic(axis);
            second[axis][axis] = Sum::of(inertia[next][next]);
            second[axis][axis]
                .add(&[inertia[last][last]])
                .subtract(&[inertia[axis][axis]]);
        }
        let second = name_matrix(self.equations(), "VE", joint, second);
        let mut moments = self.turned_second(joint, &second);
        add_outer(&mut moments, &own, center);
        (own.map(Sum::of), moments)
    }

    /// `~OM E`.
    fn turned_second(&self, joint: usize, second: &Matrix) -> [SumVector; 3] {
        let velocity = self.recursion.velocities[joint];
        let mut moments = [sums(), sums(), sums()];
        for column in 0..3 {
            let mut cross = sums();
            add_cross(&mut cross, &velocity, &second[column], false);
            for (row, cross) in moments.iter_mut().zip(&cross) {
                row[column].add_sum(cross);
            }
        }
        moments
    }

    /// Adds the load of a child, in its parent's frame: with `w` the child's
    /// velocity, `P + m w` and `N + (P + m w) d^T + w h^T`.
    fn add_child(&mut self, child: usize, momentum: &mut SumVector, moments: &mut [SumVector; 3]) {
        let turn = &self.recursion.parameters.turns[child];
        let (moved, swing) = (self.moved[child], self.swings[child]);
        let composite = self.composites[child];
        let offset = self.recursion.offsets[child];
        let equations = self.equations();
        let mut sum = turn.up(&moved.momentum);
        for (component, &velocity) in sum.iter_mut().zip(&swing) {
            component.add(&[composite.mass, velocity]);
        }
        let sum = define(equations, "VQ", child, 0, sum);
        let first = define(equations, "HT", child, 0, turn.up(&composite.first));
        let names = ["VD", "VT", "VW", "VV", "VU"];
        let turned = turn_general(equations, names, child, turn, &moved.moments);
        for (row, turned) in moments.iter_mut().zip(&turned) {
            add_sums(row, turned);
        }
        add_outer(moments, &sum, &offset);
        add_outer(moments, &swing, &first);
        add_vector(momentum, &sum);
    }

    /// The derivatives between a joint and all joints on its path to the base.
    fn joint(&mut self, joint: usize) {
        let parameters = self.recursion.parameters;
        let axis = parameters.axis(joint);
        let mut unit = self.composites[joint].column(axis, parameters.is_revolute(joint));
        let mut turning = self.turning(joint);
        let [mut by_position, mut by_velocity] = self.changed_loads(joint);
        self.keep(
            (joint, joint),
            by_position.along(parameters, joint),
            by_velocity.along(parameters, joint),
        );
        let mut below = joint;
        while let Some(parent) = parameters.parent(below) {
            let place = (below, joint);
            let offset = self.recursion.offsets[below];
            let swing = self.swings[below];
            let turn = &parameters.turns[below];
            let equations = self.equations();
            let carry = |equations: &mut Equations, wrench: &Wrench, names| {
                carry(equations, parameters, wrench, names, place, &offset)
            };
            unit = carry(equations, &unit, ("FT", "NT"));
            // Seen from the parent's origin, all bodies move faster by `w`.
            let mut turned = turn.up(&turning);
            add_cross(&mut turned, &swing, &unit.force, false);
            turning = define(equations, "VB", below, joint + 1, turned);
            by_position = carry(equations, &by_position, ("VF", "VC"));
            by_velocity = carry(equations, &by_velocity, ("VG", "VH"));
            below = parent;
            if parameters.frames.is_constant(parent) {
                continue;
            }
            self.keep(
                (parent, joint),
                by_position.along(parameters, parent),
                by_velocity.along(parameters, parent),
            );
            self.answer(joint, parent, &unit, &turning);
        }
    }

    /// Keeps the derivatives of a joint's force (the row) by a joint's motion.
    fn keep(&mut self, (row, column): (usize, usize), by_position: Scalar, by_velocity: Scalar) {
        if !by_position.is_zero() {
            self.found.by_position.push((row, column, by_position));
        }
        // Nothing depends on a velocity that has no symbol.
        let joint = &self.recursion.parameters.model.joints[column];
        if !by_velocity.is_zero() && joint.has_velocity {
            self.found.by_velocity.push((row, column, by_velocity));
        }
    }

    /// The force of a joint for each component of an angular velocity that is
    /// added: `2 (tr N - N^T) s`, or `2 P x s`.
    fn turning(&self, joint: usize) -> Vector {
        let parameters = self.recursion.parameters;
        let a = parameters.axis(joint);
        let moved = &self.moved[joint];
        if parameters.is_revolute(joint) {
            moved.turning[a]
        } else {
            across(a, &moved.momentum)
        }
    }

    /// Changes of the motion of the frame after a joint by its motion.
    fn changes(&self, joint: usize) -> [MotionChange; 2] {
        let parameters = self.recursion.parameters;
        let a = parameters.axis(joint);
        if joint < parameters.resting.len() {
            return free_base::changes(parameters, joint);
        }
        let column = self.recursion.tildes[joint].map(|row| row[a]);
        let doubled = across(a, &self.doubled[joint]);
        if !parameters.is_revolute(joint) {
            return [column, doubled].map(MotionChange::of_origin);
        }
        let by_position = MotionChange {
            angular: column,
            linear: across(a, &self.recursion.motions[joint].linear),
            // `OM x s` is added to the angular velocity.
            velocity: across(a, &self.recursion.velocities[joint]),
        };
        let by_velocity = MotionChange {
            angular: doubled,
            linear: ZERO,
            velocity: unit(a),
        };
        [by_position, by_velocity]
    }

    /// Changes, by the position and by the velocity of a joint, of the wrench it
    /// carries, in the frame after it: the answer of its composite to the other
    /// motion of its base, and the wrench itself as it turns or is moved.
    fn changed_loads(&mut self, joint: usize) -> [Wrench; 2] {
        let parameters = self.recursion.parameters;
        let (b, c) = cyclic(parameters.axis(joint));
        let load = self.loads[joint];
        let [mut by_position, by_velocity] = self
            .changes(joint)
            .map(|change| self.wrench(joint, &change));
        // The force on a free base has the axes of the base.
        if joint >= parameters.resting.len() {
            let turn = |sum: &mut SumVector, vector: &Vector| {
                sum[b].subtract(&[vector[c]]);
                sum[c].add(&[vector[b]]);
            };
            if parameters.is_revolute(joint) {
                turn(&mut by_position.force, &load.force);
                turn(&mut by_position.torque, &load.torque);
            } else {
                turn(&mut by_position.torque, &load.force);
            }
        }
        let equations = self.equations();
        [
            by_position.define(equations, ("VF", "VC"), joint, joint + 1),
            by_velocity.define(equations, ("VG", "VH"), joint, joint + 1),
        ]
    }

    /// The wrench that a composite takes for a change of its motion.
    fn wrench(&self, joint: usize, change: &MotionChange) -> SumWrench {
        let (composite, moved) = (&self.composites[joint], &self.moved[joint]);
        let mut wrench = SumWrench::new();
        let SumWrench { force, torque } = &mut wrench;
        for (component, &value) in force.iter_mut().zip(&change.linear) {
            component.add(&[composite.mass, value]);
        }
        add_cross(force, &change.angular, &composite.first, false);
        add_matrix_product(torque, &composite.moments, &change.angular);
        add_cross(torque, &composite.first, &change.linear, false);
        add_cross(force, &change.velocity, &moved.momentum, false);
        add_matrix_product(torque, &moved.turning, &change.velocity);
        wrench
    }

    /// Derivatives of the force of a joint by position and velocity of a joint
    /// before it, where a unit of acceleration of the former takes `taken`.
    fn answer(&mut self, joint: usize, before: usize, taken: &Wrench, turning: &Vector) {
        let [by_position, by_velocity] = self.changes(before).map(|change| {
            let mut sum = Sum::new();
            for (one, other) in [
                (&taken.torque, &change.angular),
                (&taken.force, &change.linear),
                (turning, &change.velocity),
            ] {
                for (&one, &other) in one.iter().zip(other) {
                    sum.add(&[one, other]);
                }
            }
            sum
        });
        let [by_position, by_velocity] =
            [("VX", by_position), ("VY", by_velocity)].map(|(prefix, sum)| {
                let label = QuantityLabel::new(prefix, 0, before + 1).column(joint + 1);
                self.equations().define(label, sum)
            });
        self.keep((joint, before), by_position, by_velocity);
    }
}

fn twice(scalar: Scalar) -> Sum {
    Sum::total(&[scalar, scalar])
}

/// A vector times the unit vector of an axis.
pub(super) fn across(axis: usize, vector: &Vector) -> Vector {
    let (b, c) = cyclic(axis);
    let mut across = ZERO;
    across[b] = vector[c];
    across[c] = -vector[b];
    across
}

/// Adds `one other^T`.
fn add_outer(sum: &mut [SumVector; 3], one: &Vector, other: &Vector) {
    for (row, &one) in sum.iter_mut().zip(one) {
        for (entry, &other) in row.iter_mut().zip(other) {
            entry.add(&[one, other]);
        }
    }
}

fn name_matrix(
    equations: &mut Equations,
    prefix: &'static str,
    joint: usize,
    matrix: [SumVector; 3],
) -> Matrix {
    let mut number = 0;
    matrix.map(|row| {
        row.map(|entry| {
            number += 1;
            equations.define(QuantityLabel::new(prefix, number, joint + 1), entry)
        })
    })
}
