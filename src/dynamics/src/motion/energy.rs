//! Energies, from plain kinematics in the base frame and not from equations.

use super::varied::PointMotion;
use crate::kinematics::MotionState;
use robovec_model::{Axis, Model};
use std::array::from_fn;

/// A vector along the axes of the base, or of a body.
pub(super) type CartesianVector = [f64; 3];
type Rotation = [CartesianVector; 3];

/// The motion of the frame beyond a joint.
#[derive(Clone, Copy)]
struct JointFrame {
    /// Columns are the frame's axes in the base frame.
    rotation: Rotation,
    origin: CartesianVector,
    velocity: CartesianVector,
    spin: CartesianVector,
}

const BASE: JointFrame = JointFrame {
    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    origin: [0.0; 3],
    velocity: [0.0; 3],
    spin: [0.0; 3],
};

impl JointFrame {
    /// A vector of the frame in the base frame.
    fn outward(&self, v: CartesianVector) -> CartesianVector {
        from_fn(|i| (0..3).map(|k| self.rotation[i][k] * v[k]).sum())
    }

    /// A vector of the base frame in the frame.
    fn inward(&self, v: CartesianVector) -> CartesianVector {
        from_fn(|k| (0..3).map(|i| self.rotation[i][k] * v[i]).sum())
    }

    /// Position and velocity of a point of the frame.
    fn point(&self, place: CartesianVector) -> (CartesianVector, CartesianVector) {
        let arm = self.outward(place);
        (
            add(self.origin, arm),
            add(self.velocity, cross(self.spin, arm)),
        )
    }
}

fn add(a: CartesianVector, b: CartesianVector) -> CartesianVector {
    from_fn(|i| a[i] + b[i])
}

fn scaled(a: CartesianVector, factor: f64) -> CartesianVector {
    a.map(|x| x * factor)
}

fn cross(a: CartesianVector, b: CartesianVector) -> CartesianVector {
    from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

pub(super) fn dot(a: CartesianVector, b: CartesianVector) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// The motion of a joint's frame, or of the base.
fn frame(frames: &[JointFrame], joint: Option<usize>) -> JointFrame {
    joint.map_or(BASE, |joint| frames[joint])
}

fn frames(model: &Model, state: &MotionState) -> Vec<JointFrame> {
    assert_eq!(state.q.len(), model.joints.len(), "one position per joint");
    assert_eq!(state.qd.len(), model.joints.len(), "one velocity per joint");
    let mut frames: Vec<JointFrame> = Vec::with_capacity(model.joints.len());
    for (index, joint) in model.joints.iter().enumerate() {
        let parent = frame(&frames, joint.parent);
        let place = model.coordinates(joint.point);
        let (origin, velocity) = parent.point(place);
        let axis = joint.kind.axis();
        let turns = joint.mounting.turns.iter();
        let before = turns.fold(parent.rotation, |rotation, turn| {
            turned(&rotation, turn.axis, turn.angle)
        });
        let sign = joint.mounting.sign();
        let direction: CartesianVector = from_fn(|i| before[i][axis.index()]);
        let (q, rate) = (
            sign * state.q[index],
            scaled(direction, sign * state.qd[index]),
        );
        frames.push(if joint.kind.is_revolute() {
            JointFrame {
                rotation: turned(&before, axis, q),
                origin,
                velocity,
                spin: add(parent.spin, rate),
            }
        } else {
            let slide = scaled(direction, q);
            let carried = add(velocity, cross(parent.spin, slide));
            JointFrame {
                rotation: before,
                origin: add(origin, slide),
                velocity: add(carried, rate),
                spin: parent.spin,
            }
        });
    }
    frames
}

fn turned(rotation: &Rotation, axis: Axis, angle: f64) -> Rotation {
    let (sine, cosine) = angle.sin_cos();
    let (b, c) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
    rotation.map(|row| {
        let mut turned = row;
        turned[b] = cosine * row[b] + sine * row[c];
        turned[c] = cosine * row[c] - sine * row[b];
        turned
    })
}

/// Kinetic energy, and potential energy in gravity from the base, J.
pub(super) fn energies(model: &Model, state: &MotionState) -> (f64, f64) {
    let frames = frames(model, state);
    let rotors = model.joints.iter().zip(&state.qd);
    let mut kinetic: f64 = rotors
        .map(|(joint, speed)| 0.5 * joint.armature * speed * speed)
        .sum();
    let mut potential = 0.0;
    for body in &model.bodies {
        let frame = &frames[body.joints.end - 1];
        let (center, velocity) = frame.point(body.center);
        let spin = frame.inward(frame.spin);
        let matrix = body.inertia_matrix();
        let moment: CartesianVector =
            from_fn(|i| (0..3).map(|k| matrix[3 * i + k] * spin[k]).sum());
        kinetic += 0.5 * (body.mass * dot(velocity, velocity) + dot(spin, moment));
        potential -= body.mass * dot(model.gravity, center);
    }
    (kinetic, potential)
}

/// Linear and angular momentum about the base's origin, kg m/s, kg m^2/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Momenta {
    linear: CartesianVector,
    angular: CartesianVector,
    /// The sums of their sizes over all bodies.
    sizes: [f64; 2],
}

impl Momenta {
    /// The larger difference of both, relative to the sizes.
    pub(super) fn distance(&self, other: &Momenta) -> f64 {
        let apart = |a: CartesianVector, b: CartesianVector| {
            let difference = add(a, scaled(b, -1.0));
            dot(difference, difference).sqrt()
        };
        let relative = |change: f64, place: usize| {
            let size = self.sizes[place].max(other.sizes[place]);
            if size > 0.0 { change / size } else { 0.0 }
        };
        let linear = relative(apart(self.linear, other.linear), 0);
        linear.max(relative(apart(self.angular, other.angular), 1))
    }
}

pub(super) fn momenta(model: &Model, state: &MotionState) -> Momenta {
    let frames = frames(model, state);
    let size = |v: CartesianVector| dot(v, v).sqrt();
    let mut sum = Momenta {
        linear: [0.0; 3],
        angular: [0.0; 3],
        sizes: [0.0; 2],
    };
    for body in &model.bodies {
        let frame = &frames[body.joints.end - 1];
        let (center, velocity) = frame.point(body.center);
        let spin = frame.inward(frame.spin);
        let matrix = body.inertia_matrix();
        let own: CartesianVector = from_fn(|i| (0..3).map(|k| matrix[3 * i + k] * spin[k]).sum());
        let linear = scaled(velocity, body.mass);
        let angular = add(cross(center, linear), frame.outward(own));
        sum.linear = add(sum.linear, linear);
        sum.angular = add(sum.angular, angular);
        sum.sizes[0] += size(linear);
        sum.sizes[1] += size(angular);
    }
    sum
}

pub(super) fn lengths(model: &Model, state: &MotionState) -> Vec<f64> {
    let frames = frames(model, state);
    let lengths = model.links.iter().map(|link| {
        let [from, to] = link.ends.map(|end| {
            let frame = frame(&frames, model.last_joint(end.body));
            frame.point(model.coordinates(end.point)).0
        });
        let span = add(to, scaled(from, -1.0));
        dot(span, span).sqrt()
    });
    lengths.collect()
}

pub(super) fn point_motions(model: &Model, state: &MotionState) -> Vec<PointMotion> {
    let frames = frames(model, state);
    let motions = model.forces.iter().map(|force| {
        let frame = frame(&frames, model.last_joint(model.points[force.point].body));
        let (place, velocity) = frame.point(model.coordinates(Some(force.point)));
        PointMotion {
            place,
            velocity,
            spin: frame.spin,
            axes: from_fn(|axis| from_fn(|k| frame.rotation[k][axis])),
        }
    });
    motions.collect()
}
