//! The motion of points along chains of joints, for sensors, forces and loops.
//!
//! Everything is in the axes of the reference. A frame's rotation is kept as
//! its three axes (rows). Levers are kept joint by joint, and the vector from a
//! joint to the end of the chain is summed from the end, which positions and
//! Jacobians share, without differences of large positions. Joints in a row
//! that turn about the same axis are one rotation by the sum of their angles.

use super::algebra::{Scalar, Sum, given};
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{
    AxisRotation, Matrix, SumVector, Vector, ZERO, add_cross, add_vector, cyclic, define_as, sums,
    unit,
};

#[derive(Clone, Copy)]
pub(super) struct ChainJoint {
    pub(super) joint: usize,
    /// The joint's axis.
    pub(super) axis: Vector,
    /// From the frame before to this frame's origin.
    pub(super) lever: Vector,
    /// The axes of the frame beyond the joint.
    pub(super) axes: Matrix,
}

/// Column of the Jacobian of a chain's end, or a derivative of one: the joint,
/// and the velocity and angular velocity for a unit of its velocity.
pub(super) type JacobianColumn = (usize, Vector, Vector);

/// A run of rotations about one axis.
#[derive(Clone, Copy)]
struct RotationRun {
    first: usize,
    turn: AxisRotation,
    /// The axes before the run.
    before: Matrix,
}

/// A chain of joints from a reference frame to a place on the last body.
pub(super) struct Chain {
    /// The number of the chain, after its names.
    number: u32,
    suffix: &'static str,
    pub(super) steps: Vec<ChainJoint>,
    /// From the reference's origin to the first joint's, or else to the place.
    start: SumVector,
    /// From the last frame's origin to the place.
    pub(super) end: Vector,
}

/// Velocities and accelerations at the end of a chain.
#[derive(Clone, Copy)]
pub(super) struct ChainMotion {
    pub(super) velocity: Vector,
    pub(super) angular_velocity: Vector,
    pub(super) acceleration: Vector,
    pub(super) angular_acceleration: Vector,
}

impl Chain {
    /// The chain over the joints of a path, which starts after the reference,
    /// to a place given in the frame of the last joint (or of the reference).
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        (suffix, number): (&'static str, usize),
        path: &[usize],
        place: &Vector,
    ) -> Chain {
        let mut chain = Chain {
            number: number as u32,
            suffix,
            steps: Vec::with_capacity(path.len()),
            start: match path.first() {
                Some(&joint) => parameters.offset(joint),
                None => place.map(Sum::of),
            },
            end: ZERO,
        };
        let mut axes = [unit(0), unit(1), unit(2)];
        let mut run: Option<RotationRun> = None;
        for &joint in path {
            let offset = parameters.offset(joint);
            let lever = chain.lever(equations, &axes, offset, joint + 1);
            let axis = axes[parameters.axis(joint)];
            if parameters.is_revolute(joint) {
                (axes, run) = chain.turn(equations, parameters, joint, &axes, run);
            }
            chain.steps.push(ChainJoint {
                joint,
                axis,
                lever,
                axes,
            });
        }
        chain.end = chain.lever(equations, &axes, place.map(Sum::of), 0);
        chain
    }

    pub(super) fn label(
        &self,
        prefix: &'static str,
        component: usize,
        joint: usize,
    ) -> QuantityLabel {
        QuantityLabel {
            group: Some((self.suffix, self.number)),
            ..QuantityLabel::new(prefix, component, joint)
        }
    }

    pub(super) fn define(
        &self,
        equations: &mut Equations,
        prefix: &'static str,
        joint: usize,
        column: usize,
        vector: SumVector,
    ) -> Vector {
        let label = |component| self.label(prefix, component, joint).column(column);
        define_as(equations, label, vector)
    }

    /// A vector given in a frame, in the axes of the reference.
    fn lever(
        &self,
        equations: &mut Equations,
        axes: &Matrix,
        offset: SumVector,
        joint: usize,
    ) -> Vector {
        let label = |component| QuantityLabel::new("Dz", 0, 10 * joint + component);
        let offset = define_as(equations, label, offset);
        let mut lever = sums();
        for (component, sum) in lever.iter_mut().enumerate() {
            for (axis, length) in axes.iter().zip(&offset) {
                sum.add(&[axis[component], *length]);
            }
        }
        self.define(equations, "RL", joint, 0, lever)
    }

    fn turn(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        joint: usize,
        axes: &Matrix,
        run: Option<RotationRun>,
    ) -> (Matrix, Option<RotationRun>) {
        let turn = parameters.turns[joint];
        let run = match run {
            Some(run) if run.turn.axis == turn.axis => RotationRun {
                turn: sum_of_angles(equations, &run.turn, &turn, joint, run.first),
                ..run
            },
            _ => RotationRun {
                first: joint,
                turn,
                before: *axes,
            },
        };
        let mut turned = run.before;
        let (b, c) = cyclic(turn.axis);
        for component in 0..3 {
            let column = [0, 1, 2].map(|row| run.before[row][component]);
            let [x, y, z] = run.turn.down(&column);
            let down = [x, y, z];
            for row in [b, c] {
                let label = self.label("RO", 3 * row + component + 1, joint + 1);
                turned[row][component] = equations.define(label, down[row].clone());
            }
        }
        (turned, Some(run))
    }

    /// The vectors from every joint's origin to the end of the chain.
    pub(super) fn arms(&self, equations: &mut Equations) -> Vec<Vector> {
        let mut arms = vec![ZERO; self.steps.len()];
        let mut arm = self.end;
        for place in (0..self.steps.len()).rev() {
            arms[place] = arm;
            let step = &self.steps[place];
            let mut sum = step.lever.map(Sum::of);
            add_vector(&mut sum, &arm);
            arm = self.define(equations, "PO", step.joint + 1, 0, sum);
        }
        arms
    }

    /// From the reference to the end, as terms that differences cancel.
    pub(super) fn position_terms(&self, equations: &mut Equations) -> SumVector {
        let arms = self.arms(equations);
        let mut position = self.start.clone();
        if let Some(arm) = arms.first() {
            add_vector(&mut position, arm);
        }
        position
    }

    /// From the origin of the reference to the end of the chain.
    pub(super) fn position(&self, equations: &mut Equations) -> Vector {
        let joint = robovec_model::number(self.steps.first().map(|step| step.joint));
        let position = self.position_terms(equations);
        self.define(equations, "PO", joint, 0, position)
    }

    pub(super) fn axes(&self) -> Matrix {
        let identity = [unit(0), unit(1), unit(2)];
        self.steps.last().map_or(identity, |step| step.axes)
    }

    /// The columns of joints that move.
    pub(super) fn jacobian(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
    ) -> Vec<JacobianColumn> {
        let arms = self.arms(equations);
        let column = |(step, arm): (&ChainJoint, &Vector)| {
            if !parameters.is_revolute(step.joint) {
                return (step.joint, step.axis, ZERO);
            }
            let mut cross = sums();
            add_cross(&mut cross, &step.axis, arm, false);
            let linear = self.define(equations, "JT", 0, step.joint + 1, cross);
            (step.joint, linear, step.axis)
        };
        // Nothing moves a constant rotation.
        let moves = |step: &ChainJoint| !parameters.frames.is_constant(step.joint);
        let pairs = self.steps.iter().zip(&arms);
        pairs.filter(|(step, _)| moves(step)).map(column).collect()
    }

    /// Velocities and accelerations of the end; the reference is at rest.
    pub(super) fn motion(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        accelerations: &[Scalar],
    ) -> ChainMotion {
        let mut motion = ChainMotion {
            velocity: ZERO,
            angular_velocity: ZERO,
            acceleration: ZERO,
            angular_acceleration: ZERO,
        };
        for step in &self.steps {
            let joint = step.joint;
            let rate = parameters.qd[joint];
            let acceleration = given(accelerations, joint);
            self.carry(
                equations,
                &mut motion,
                &step.lever,
                joint + 1,
                |sums| {
                    if !parameters.is_revolute(joint) {
                        let [velocity, second] = sums;
                        for k in 0..3 {
                            velocity[k].add(&[step.axis[k], rate]);
                            second[k].add(&[step.axis[k], acceleration]);
                        }
                    }
                },
                (!parameters.is_revolute(joint)).then_some((&step.axis, rate)),
            );
            if parameters.is_revolute(joint) {
                let before = motion.angular_velocity;
                let spin = self.define(
                    equations,
                    "OS",
                    joint + 1,
                    0,
                    step.axis.map(|component| Sum::product(&[component, rate])),
                );
                let mut angular = before.map(Sum::of);
                let mut second = motion.angular_acceleration.map(Sum::of);
                add_cross(&mut second, &before, &spin, false);
                for k in 0..3 {
                    angular[k].add(&[spin[k]]);
                    second[k].add(&[step.axis[k], acceleration]);
                }
                motion.angular_velocity = self.define(equations, "OM", joint + 1, 0, angular);
                motion.angular_acceleration = self.define(equations, "OP", joint + 1, 0, second);
            }
        }
        self.carry(equations, &mut motion, &self.end, 0, |_| {}, None);
        motion
    }

    /// From a frame's origin to a place at a lever, perhaps sliding on an axis.
    fn carry(
        &self,
        equations: &mut Equations,
        motion: &mut ChainMotion,
        lever: &Vector,
        joint: usize,
        own: impl FnOnce([&mut SumVector; 2]),
        slide: Option<(&Vector, Scalar)>,
    ) {
        let mut swing = sums();
        add_cross(&mut swing, &motion.angular_velocity, lever, false);
        let swing = self.define(equations, "OR", joint, 0, swing);
        let mut velocity = motion.velocity.map(Sum::of);
        let mut acceleration = motion.acceleration.map(Sum::of);
        add_vector(&mut velocity, &swing);
        add_cross(
            &mut acceleration,
            &motion.angular_acceleration,
            lever,
            false,
        );
        // w x (w x r) and, for a slide, 2 w x e qd share their first factor.
        let mut inner = swing.map(Sum::of);
        if let Some((axis, rate)) = slide {
            let two = equations.number(2.0);
            for (component, &value) in inner.iter_mut().zip(axis) {
                component.add(&[two, value, rate]);
            }
        }
        let inner = self.define(equations, "OT", joint, 0, inner);
        add_cross(&mut acceleration, &motion.angular_velocity, &inner, false);
        own([&mut velocity, &mut acceleration]);
        motion.velocity = self.define(equations, "VI", joint, 0, velocity);
        motion.acceleration = self.define(equations, "AC", joint, 0, acceleration);
    }
}

/// The rotation by the sum of the angles of two rotations about one axis.
fn sum_of_angles(
    equations: &mut Equations,
    run: &AxisRotation,
    turn: &AxisRotation,
    joint: usize,
    first: usize,
) -> AxisRotation {
    let (mut cos, mut sin) = (Sum::new(), Sum::new());
    cos.add(&[run.cos, turn.cos]).subtract(&[run.sin, turn.sin]);
    sin.add(&[run.cos, turn.sin]).add(&[run.sin, turn.cos]);
    AxisRotation {
        axis: turn.axis,
        cos: equations.define(
            QuantityLabel::new("Cp", 0, joint + 1).column(first + 1),
            cos,
        ),
        sin: equations.define(
            QuantityLabel::new("Sp", 0, joint + 1).column(first + 1),
            sin,
        ),
    }
}
