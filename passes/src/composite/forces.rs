//! The forces of joints that are at rest against velocities, gravity and
//! loads, from composite bodies, over any ring.
//!
//! Seen from a joint, the bodies beyond it move as one rigid body would, plus
//! the motion that every joint k beyond adds to its own composite. With `BE =
//! ~OA + ~OM ~OM` (Robotran's names, ~ the matrix of the cross product) a point
//! r of a frame has the acceleration `AF + BE r`, and a composite of mass m,
//! first moment h and moments J needs
//!
//! ```text
//! force  = m AF + BE h        torque = h x AF + J OA + OM x J OM
//! ```
//!
//! A rotation about the axis a changes BE only in
//!
//! ```text
//! BE_ab += 2 OM_b qd    BE_ac += 2 OM_c qd    BE_bb, BE_cc -= (2 OM_a - qd) qd
//! ```
//!
//! with OM beyond the joint, so that joint k adds a wrench of ten products to
//! the wrench that the joints before it transmit. No step is a loop over
//! bodies. Whether that takes fewer operations than the recursion over bodies
//! depends on the tree: the caller has to compare both.

use super::bodies::{
    CompositeInertia, JointAxis, RingMatrix, RingVector, Stand, UnitWrench, cross,
};
use super::matrix::{BodySystem, JointPlacement};

/// A tree of bodies that moves, in the numbers of a ring.
pub(super) trait MovingSystem: BodySystem {
    /// The velocity of a joint.
    fn rate(&mut self, joint: usize) -> Self::Number;

    /// Its acceleration, if given.
    fn acceleration(&mut self, joint: usize) -> Self::Number;

    /// Gravity in the axes of the base.
    fn gravity(&mut self) -> RingVector<Self::Number>;

    /// External load on the body of a joint: a force at its centre of mass and
    /// a torque.
    fn loads(&mut self, joint: usize) -> UnitWrench<Self::Number>;
}

/// The motion of a frame.
#[derive(Clone, Copy)]
struct RingMotion<N> {
    /// Angular velocity, OM.
    velocity: RingVector<N>,
    /// Angular acceleration, OA.
    angular: RingVector<N>,
    /// Acceleration of the origin less gravity, AF.
    linear: RingVector<N>,
    /// BE, row by row.
    tilde: RingMatrix<N>,
    /// The squares of OM.
    squares: RingVector<N>,
}

/// The axes after an axis, cyclically.
fn others(axis: usize) -> (usize, usize) {
    ((axis + 1) % 3, (axis + 2) % 3)
}

/// The forces `c` of all joints, given the composite body of each.
pub(super) fn bias_forces<S: MovingSystem>(
    system: &mut S,
    places: &[JointPlacement],
    composites: &[CompositeInertia<S::Number>],
) -> Vec<S::Number> {
    let zero = system.zero();
    let gravity = system.gravity();
    let base = RingMotion {
        velocity: [zero; 3],
        angular: [zero; 3],
        linear: gravity.map(|part| system.sub(zero, part)),
        tilde: [[zero; 3]; 3],
        squares: [zero; 3],
    };
    let mut motions: Vec<RingMotion<S::Number>> = Vec::with_capacity(places.len());
    for (joint, place) in places.iter().enumerate() {
        system.enter(joint);
        let before = place.parent.map_or(base, |parent| motions[parent]);
        let motion = moved(system, joint, place, &before);
        motions.push(motion);
    }
    let nothing = UnitWrench {
        force: [zero; 3],
        torque: [zero; 3],
    };
    let mut carried = vec![nothing; places.len()];
    let mut forces = vec![zero; places.len()];
    for (joint, place) in places.iter().enumerate().rev() {
        system.enter(joint);
        let loads = external(system, joint, place);
        let behind = sum(system, carried[joint], loads);
        let before = place.parent.map_or(base, |parent| motions[parent]);
        let rigid = rigid(system, place.joint, &motions[joint], &composites[joint]);
        forces[joint] = system.add(rigid, behind.along(place.joint));
        let Some(parent) = place.parent else {
            continue;
        };
        let added = change(
            system,
            joint,
            place,
            (&before, &motions[joint]),
            &composites[joint],
        );
        let whole = sum(system, behind, added);
        let stand = system.stand(joint, place);
        let passed = stand.wrench(system, whole);
        carried[parent] = sum(system, carried[parent], passed);
    }
    forces
}

/// The sum of two wrenches about the same origin.
pub(super) fn sum<S: MovingSystem>(
    system: &mut S,
    first: UnitWrench<S::Number>,
    second: UnitWrench<S::Number>,
) -> UnitWrench<S::Number> {
    UnitWrench {
        force: [0, 1, 2].map(|i| system.add(first.force[i], second.force[i])),
        torque: [0, 1, 2].map(|i| system.add(first.torque[i], second.torque[i])),
    }
}

/// A sum of products with signs.
fn products<S: MovingSystem>(system: &mut S, terms: &[(bool, S::Number, S::Number)]) -> S::Number {
    let mut sum = system.zero();
    for &(negative, left, right) in terms {
        let product = system.mul(left, right);
        sum = if negative {
            system.sub(sum, product)
        } else {
            system.add(sum, product)
        };
    }
    sum
}

/// The motion of the frame of a joint, from that of the frame before it.
fn moved<S: MovingSystem>(
    system: &mut S,
    joint: usize,
    place: &JointPlacement,
    before: &RingMotion<S::Number>,
) -> RingMotion<S::Number> {
    let stand = system.stand(joint, place);
    let arm = stand.arm(system);
    let mut linear = before.linear;
    for (part, row) in linear.iter_mut().zip(&before.tilde) {
        for (&entry, &length) in row.iter().zip(&arm) {
            let product = system.mul(entry, length);
            *part = system.add(*part, product);
        }
    }
    let rate = system.rate(joint);
    let acceleration = system.acceleration(joint);
    let axis = match place.joint {
        JointAxis::Revolute(axis) => axis,
        JointAxis::Prismatic(axis) => {
            let (b, c) = others(axis);
            let [slide_b, slide_c] = slide(system, axis, rate, &before.velocity);
            linear[axis] = system.add(linear[axis], acceleration);
            linear[b] = system.add(linear[b], slide_b);
            linear[c] = system.add(linear[c], slide_c);
            return RingMotion { linear, ..*before };
        }
    };
    let (b, c) = others(axis);
    let mut velocity = turn_down(system, &stand, axis, before.velocity);
    velocity[axis] = system.add(velocity[axis], rate);
    let mut angular = turn_down(system, &stand, axis, before.angular);
    let (rate_b, rate_c) = (system.mul(velocity[b], rate), system.mul(velocity[c], rate));
    angular[axis] = system.add(angular[axis], acceleration);
    angular[b] = system.add(angular[b], rate_c);
    angular[c] = system.sub(angular[c], rate_b);
    let (tilde, squares) = tilde(system, &velocity, &angular);
    RingMotion {
        velocity,
        angular,
        linear: turn_down(system, &stand, axis, linear),
        tilde,
        squares,
    }
}

/// A vector of the frame before a joint in the axes beyond it.
fn turn_down<S: MovingSystem>(
    system: &mut S,
    stand: &Stand<S::Number>,
    axis: usize,
    v: RingVector<S::Number>,
) -> RingVector<S::Number> {
    let (b, c) = others(axis);
    let mut turned = v;
    turned[b] = products(
        system,
        &[(false, stand.cosine, v[b]), (false, stand.sine, v[c])],
    );
    turned[c] = products(
        system,
        &[(false, stand.cosine, v[c]), (true, stand.sine, v[b])],
    );
    turned
}

/// `2 OM x e qd` of a joint that slides along e: the components after the axis.
fn slide<S: MovingSystem>(
    system: &mut S,
    axis: usize,
    rate: S::Number,
    velocity: &RingVector<S::Number>,
) -> [S::Number; 2] {
    let (b, c) = others(axis);
    let mut twice = |component: usize| {
        let product = system.mul(velocity[component], rate);
        system.add(product, product)
    };
    let (twice_b, twice_c) = (twice(b), twice(c));
    let zero = system.zero();
    [twice_c, system.sub(zero, twice_b)]
}

/// BE and the squares of OM.
fn tilde<S: MovingSystem>(
    system: &mut S,
    velocity: &RingVector<S::Number>,
    angular: &RingVector<S::Number>,
) -> (RingMatrix<S::Number>, RingVector<S::Number>) {
    let squares = velocity.map(|part| system.mul(part, part));
    let zero = system.zero();
    let mut tilde = [[zero; 3]; 3];
    for axis in 0..3 {
        let (b, c) = others(axis);
        let both = system.add(squares[b], squares[c]);
        tilde[axis][axis] = system.sub(zero, both);
        let product = system.mul(velocity[b], velocity[c]);
        tilde[b][c] = system.sub(product, angular[axis]);
        tilde[c][b] = system.add(product, angular[axis]);
    }
    (tilde, squares)
}

/// External forces and torques on a body, which joints need not provide.
fn external<S: MovingSystem>(
    system: &mut S,
    joint: usize,
    place: &JointPlacement,
) -> UnitWrench<S::Number> {
    let loads = system.loads(joint);
    let centre = system.body(joint, place).centre;
    let moment = cross(system, centre, loads.force);
    let zero = system.zero();
    UnitWrench {
        force: loads.force.map(|part| system.sub(zero, part)),
        torque: [0, 1, 2].map(|i| {
            let both = system.add(loads.torque[i], moment[i]);
            system.sub(zero, both)
        }),
    }
}

/// Force that the rigid motion of a composite body needs along the axis of its
/// joint.
fn rigid<S: MovingSystem>(
    system: &mut S,
    joint: JointAxis,
    motion: &RingMotion<S::Number>,
    composite: &CompositeInertia<S::Number>,
) -> S::Number {
    let h = composite.first();
    let (axis, moments) = match joint {
        JointAxis::Revolute(axis) => (axis, &composite.d),
        JointAxis::Prismatic(axis) => {
            let row = motion.tilde[axis];
            return products(
                system,
                &[
                    (false, composite.a[axis][axis], motion.linear[axis]),
                    (false, row[0], h[0]),
                    (false, row[1], h[1]),
                    (false, row[2], h[2]),
                ],
            );
        }
    };
    let (b, c) = others(axis);
    let difference = system.sub(moments[c][c], moments[b][b]);
    let product = system.mul(motion.velocity[b], motion.velocity[c]);
    let squares = system.sub(motion.squares[b], motion.squares[c]);
    products(
        system,
        &[
            (false, h[b], motion.linear[c]),
            (true, h[c], motion.linear[b]),
            (false, moments[axis][axis], motion.angular[axis]),
            (false, difference, product),
            (false, moments[b][c], squares),
            (true, moments[axis][b], motion.tilde[c][axis]),
            (false, moments[axis][c], motion.tilde[b][axis]),
        ],
    )
}

/// The wrench that the velocity and the acceleration of a joint add to the
/// rigid motion of its composite body.
fn change<S: MovingSystem>(
    system: &mut S,
    joint: usize,
    place: &JointPlacement,
    (before, motion): (&RingMotion<S::Number>, &RingMotion<S::Number>),
    composite: &CompositeInertia<S::Number>,
) -> UnitWrench<S::Number> {
    let (rate, acceleration) = (system.rate(joint), system.acceleration(joint));
    let h = composite.first();
    let own = composite.wrench(place.joint);
    let mut force = own.force.map(|part| system.mul(part, acceleration));
    let mut torque = own.torque.map(|part| system.mul(part, acceleration));
    let add = |system: &mut S, part: &mut S::Number, terms: &[(bool, S::Number, S::Number)]| {
        let more = products(system, terms);
        *part = system.add(*part, more);
    };
    let axis = match place.joint {
        JointAxis::Revolute(axis) => axis,
        JointAxis::Prismatic(axis) => {
            let (b, c) = others(axis);
            let mass = composite.a[axis][axis];
            let [slide_b, slide_c] = slide(system, axis, rate, &motion.velocity);
            add(system, &mut force[b], &[(false, mass, slide_b)]);
            add(system, &mut force[c], &[(false, mass, slide_c)]);
            let about = [(false, h[b], slide_c), (true, h[c], slide_b)];
            add(system, &mut torque[axis], &about);
            add(system, &mut torque[b], &[(true, h[axis], slide_c)]);
            add(system, &mut torque[c], &[(false, h[axis], slide_b)]);
            return UnitWrench { force, torque };
        }
    };
    let (b, c) = others(axis);
    let moments = &composite.d;
    let rate_b = system.mul(motion.velocity[b], rate);
    let rate_c = system.mul(motion.velocity[c], rate);
    let (twice_b, twice_c) = (system.add(rate_b, rate_b), system.add(rate_c, rate_c));
    // What OM_a^2 grows by.
    let both = system.add(before.velocity[axis], motion.velocity[axis]);
    let square = system.mul(both, rate);
    add(
        system,
        &mut force[axis],
        &[(false, twice_b, h[b]), (false, twice_c, h[c])],
    );
    add(system, &mut force[b], &[(true, square, h[b])]);
    add(system, &mut force[c], &[(true, square, h[c])]);
    let difference = system.sub(moments[c][c], moments[b][b]);
    let minus = system.sub(moments[axis][axis], difference);
    let plus = system.add(moments[axis][axis], difference);
    let about_b = [
        (false, rate_c, minus),
        (true, twice_b, moments[b][c]),
        (true, square, moments[axis][c]),
    ];
    add(system, &mut torque[b], &about_b);
    let about_c = [
        (false, square, moments[axis][b]),
        (true, rate_b, plus),
        (false, twice_c, moments[b][c]),
    ];
    add(system, &mut torque[c], &about_c);
    UnitWrench { force, torque }
}
