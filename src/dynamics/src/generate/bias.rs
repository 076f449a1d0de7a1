//! The bias force `c`, with composites instead of single bodies.
//!
//! Seen from joint i, the bodies beyond it move as one rigid body would, plus
//! the motion that each joint k beyond adds to its own composite. The matrix
//! `BE = ~OA + ~OM ~OM`, which gives the acceleration `AF + BE r` of a point r,
//! changes at a rotation about axis a only in
//!
//! ```text
//! BE_ab += 2 OM_b qd    BE_ac += 2 OM_c qd    BE_bb, BE_cc -= (2 OM_a - qd) qd
//! ```
//!
//! with `OM` beyond the joint. So joint k adds a wrench of ten products to the
//! wrench that the joints before it transmit (`FW`, `NW`), and `c_i` is one
//! component of a rigid wrench plus one of that sum. No step is a loop over
//! bodies, and fictitious bodies are no special case.

use super::algebra::{Scalar, Sum, given};
use super::equations::{Equations, QuantityLabel};
use super::inertia::{SumWrench, Wrench};
use super::parameters::ModelParameters;
use super::vector::{Inertia, Matrix, SumVector, Vector, ZERO, add_cross, cyclic, define};

/// The motion of a frame without joint accelerations.
#[derive(Clone, Copy)]
pub(super) struct BiasMotion {
    pub(super) velocity: Vector,
    pub(super) angular: Vector,
    /// Acceleration of the origin, minus gravity.
    pub(super) linear: Vector,
    /// `BE`, row by row.
    pub(super) tilde: Matrix,
    /// `OM_k^2`.
    pub(super) squares: Vector,
}

impl BiasMotion {
    pub(super) const REST: BiasMotion = BiasMotion {
        velocity: ZERO,
        angular: ZERO,
        linear: ZERO,
        tilde: [ZERO; 3],
        squares: ZERO,
    };
}

/// Inputs of the recursion.
pub(super) struct Bias<'a, 'm> {
    parameters: &'a ModelParameters<'m>,
    offsets: &'a [Vector],
    composites: &'a [Inertia],
    /// Accelerations of the joints; none at all when empty.
    accelerations: &'a [Scalar],
}

impl<'a, 'm> Bias<'a, 'm> {
    pub(super) fn new(
        parameters: &'a ModelParameters<'m>,
        offsets: &'a [Vector],
        composites: &'a [Inertia],
    ) -> Self {
        Bias {
            parameters,
            offsets,
            composites,
            accelerations: &parameters.resting,
        }
    }

    /// The same with accelerations of the joints, for inverse dynamics.
    pub(super) fn accelerated(self, accelerations: &'a [Scalar]) -> Self {
        Bias {
            accelerations,
            ..self
        }
    }

    fn acceleration(&self, joint: usize) -> Scalar {
        given(self.accelerations, joint)
    }

    /// `c` of every joint.
    pub(super) fn forces(&self, equations: &mut Equations) -> Vec<Scalar> {
        let joints = self.parameters.joints();
        let mut motions: Vec<BiasMotion> = Vec::with_capacity(joints);
        for joint in 0..joints {
            let parent = self.parameters.parent(joint);
            let before = self.before(&motions, parent);
            motions.push(self.motion(equations, joint, &before));
        }
        let children = self.parameters.children();
        let mut carried = vec![Wrench::ZERO; joints];
        let mut forces = vec![Scalar::ZERO; joints];
        for joint in (0..joints).rev() {
            let mut wrench = self.external(joint);
            for &child in &children[joint] {
                let turn = &self.parameters.turns[child];
                let offset = &self.offsets[child];
                let up = carried[child].to_parent(equations, "FU", (child, 0), turn, offset);
                wrench.add(&up);
            }
            let parent = self.parameters.parent(joint);
            let before = parent.map_or(ZERO, |parent| motions[parent].velocity);
            forces[joint] = self.force(equations, joint, &motions[joint], &wrench);
            wrench.add(&self.change(equations, joint, &motions[joint], &before));
            carried[joint] = wrench.define(equations, ("FW", "NW"), joint, 0);
        }
        forces
    }

    /// The base is at rest; its acceleration is minus gravity.
    pub(super) fn base(&self) -> BiasMotion {
        BiasMotion {
            linear: self.parameters.gravity.map(|component| -component),
            ..BiasMotion::REST
        }
    }

    /// The motion of the frame before one, of which the base has none.
    pub(super) fn before(&self, motions: &[BiasMotion], parent: Option<usize>) -> BiasMotion {
        match parent {
            Some(parent) => motions[parent],
            None => self.base(),
        }
    }

    pub(super) fn motion(
        &self,
        equations: &mut Equations,
        joint: usize,
        before: &BiasMotion,
    ) -> BiasMotion {
        let parameters = self.parameters;
        let turn = &parameters.turns[joint];
        let rate = parameters.qd[joint];
        let a = parameters.axis(joint);
        let (b, c) = cyclic(a);
        let mut velocity = turn.down(&before.velocity);
        let mut angular = turn.down(&before.angular);
        let mut linear = self.attachment(joint, before);
        if !parameters.is_revolute(joint) {
            let velocity = before.velocity;
            let [_, slide_b, slide_c] = self.slide(equations, joint, &velocity);
            linear[a].add(&[self.acceleration(joint)]);
            linear[b].add(&[slide_b]);
            linear[c].add(&[slide_c]);
            return BiasMotion {
                linear: define(equations, "AF", joint, 0, linear),
                ..*before
            };
        }
        velocity[a].add(&[rate]);
        let velocity = define(equations, "OM", joint, 0, velocity);
        let [_, rate_b, rate_c] = self.rates(equations, joint, &velocity);
        angular[a].add(&[self.acceleration(joint)]);
        angular[b].add(&[rate_c]);
        angular[c].subtract(&[rate_b]);
        let angular = define(equations, "OA", joint, 0, angular);
        let linear = define(equations, "AH", joint, 0, linear);
        let linear = define(equations, "AF", joint, 0, turn.down(&linear));
        let (tilde, squares) = tilde(equations, joint, &velocity, &angular);
        BiasMotion {
            velocity,
            angular,
            linear,
            tilde,
            squares,
        }
    }

    /// `AF + BE d` of the frame before a joint.
    fn attachment(&self, joint: usize, before: &BiasMotion) -> SumVector {
        let mut linear = before.linear.map(Sum::of);
        for (component, row) in linear.iter_mut().zip(&before.tilde) {
            for (entry, length) in row.iter().zip(&self.offsets[joint]) {
                component.add(&[*entry, *length]);
            }
        }
        linear
    }

    /// `OM_b qd` and `OM_c qd`, at the places 1 and 2.
    fn rates(&self, equations: &mut Equations, joint: usize, velocity: &Vector) -> Vector {
        let (b, c) = cyclic(self.parameters.axis(joint));
        let mut rate = |component: usize, axis: usize| {
            let sum = Sum::product(&[velocity[axis], self.parameters.qd[joint]]);
            equations.define(QuantityLabel::new("OQ", component, joint + 1), sum)
        };
        [Scalar::ZERO, rate(b + 1, b), rate(c + 1, c)]
    }

    /// The same, doubled.
    fn doubled(&self, equations: &mut Equations, joint: usize, rates: &Vector) -> Vector {
        let (b, c) = cyclic(self.parameters.axis(joint));
        let mut double = |component: usize, rate: Scalar| {
            let sum = Sum::total(&[rate, rate]);
            equations.define(QuantityLabel::new("PQ", component, joint + 1), sum)
        };
        [
            Scalar::ZERO,
            double(b + 1, rates[1]),
            double(c + 1, rates[2]),
        ]
    }

    /// `2 OM x e_a qd` of a translation: its components b and c.
    fn slide(&self, equations: &mut Equations, joint: usize, velocity: &Vector) -> Vector {
        let rates = self.rates(equations, joint, velocity);
        let [zero, b, c] = self.doubled(equations, joint, &rates);
        [zero, c, -b]
    }

    /// External loads, which a joint need not provide.
    fn external(&self, joint: usize) -> SumWrench {
        let parameters = self.parameters;
        let mut wrench = SumWrench::new();
        for axis in 0..3 {
            wrench.force[axis].subtract(&[parameters.forces[joint][axis]]);
            wrench.torque[axis].subtract(&[parameters.torques[joint][axis]]);
        }
        let (center, force) = (&parameters.centers[joint], &parameters.forces[joint]);
        add_cross(&mut wrench.torque, center, force, true);
        wrench
    }

    /// `c`: the composite's rigid motion and the joints beyond, along the axis.
    fn force(
        &self,
        equations: &mut Equations,
        joint: usize,
        motion: &BiasMotion,
        carried: &SumWrench,
    ) -> Scalar {
        let composite = &self.composites[joint];
        let a = self.parameters.axis(joint);
        let (b, c) = cyclic(a);
        let label = QuantityLabel::new("c", 0, joint + 1);
        if !self.parameters.is_revolute(joint) {
            let mut sum = Sum::product(&[composite.mass, motion.linear[a]]);
            for (entry, first) in motion.tilde[a].iter().zip(&composite.first) {
                sum.add(&[*entry, *first]);
            }
            sum.add_sum(&carried.force[a]);
            return equations.define(label, sum);
        }
        let moments = &composite.moments;
        let velocity = &motion.velocity;
        let difference = self.difference(equations, joint);
        let product = Sum::product(&[velocity[b], velocity[c]]);
        let (low, high) = (b.min(c), b.max(c));
        let product = equations.define(
            QuantityLabel::new("BS", 3 * low + high + 1, joint + 1),
            product,
        );
        let squares = Sum::total(&[motion.squares[b], -motion.squares[c]]);
        let squares = equations.define(QuantityLabel::new("BD", 0, joint + 1), squares);
        let mut sum = Sum::product(&[composite.first[b], motion.linear[c]]);
        sum.subtract(&[composite.first[c], motion.linear[b]])
            .add(&[moments[a][a], motion.angular[a]])
            .add(&[difference, product])
            .add(&[moments[b][c], squares])
            .subtract(&[moments[a][b], motion.tilde[c][a]])
            .add(&[moments[a][c], motion.tilde[b][a]])
            .add_sum(&carried.torque[a]);
        equations.define(label, sum)
    }

    /// `J_cc - J_bb`.
    fn difference(&self, equations: &mut Equations, joint: usize) -> Scalar {
        let moments = &self.composites[joint].moments;
        let (b, c) = cyclic(self.parameters.axis(joint));
        let sum = Sum::total(&[moments[c][c], -moments[b][b]]);
        equations.define(QuantityLabel::new("JE", 0, joint + 1), sum)
    }

    /// The wrench that a joint's velocity and acceleration add to the rigid
    /// motion of its composite; the velocity's has no component along the axis.
    /// `before` is the angular velocity of the frame before the joint.
    fn change(
        &self,
        equations: &mut Equations,
        joint: usize,
        motion: &BiasMotion,
        before: &Vector,
    ) -> SumWrench {
        let composite = &self.composites[joint];
        let first = &composite.first;
        let a = self.parameters.axis(joint);
        let (b, c) = cyclic(a);
        let mut wrench = SumWrench::new();
        let column = composite.column(a, self.parameters.is_revolute(joint));
        wrench.add_scaled(&column, self.acceleration(joint));
        if !self.parameters.is_revolute(joint) {
            let [_, slide_b, slide_c] = self.slide(equations, joint, &motion.velocity);
            wrench.force[b].add(&[composite.mass, slide_b]);
            wrench.force[c].add(&[composite.mass, slide_c]);
            wrench.torque[a]
                .add(&[first[b], slide_c])
                .subtract(&[first[c], slide_b]);
            wrench.torque[b].subtract(&[first[a], slide_c]);
            wrench.torque[c].add(&[first[a], slide_b]);
            return wrench;
        }
        let moments = &composite.moments;
        let [_, rate_b, rate_c] = self.rates(equations, joint, &motion.velocity);
        let [_, twice_b, twice_c] = self.doubled(equations, joint, &[Scalar::ZERO, rate_b, rate_c]);
        let square = self.square(equations, joint, motion, before);
        wrench.force[a]
            .add(&[twice_b, first[b]])
            .add(&[twice_c, first[c]]);
        wrench.force[b].subtract(&[square, first[b]]);
        wrench.force[c].subtract(&[square, first[c]]);
        let difference = self.difference(equations, joint);
        let mut with = |component: usize, negative: bool| {
            let sum = Sum::total(&[moments[a][a], difference.negated_if(negative)]);
            equations.define(QuantityLabel::new("JS", component + 1, joint + 1), sum)
        };
        let (minus, plus) = (with(b, true), with(c, false));
        wrench.torque[b]
            .add(&[rate_c, minus])
            .subtract(&[twice_b, moments[b][c]])
            .subtract(&[square, moments[a][c]]);
        wrench.torque[c]
            .add(&[square, moments[a][b]])
            .subtract(&[rate_b, plus])
            .add(&[twice_c, moments[b][c]]);
        wrench
    }

    /// Growth of `OM_a^2`: its sum before and after the joint, times `qd`.
    fn square(
        &self,
        equations: &mut Equations,
        joint: usize,
        motion: &BiasMotion,
        before: &Vector,
    ) -> Scalar {
        let a = self.parameters.axis(joint);
        let both = Sum::total(&[before[a], motion.velocity[a]]);
        let group = equations.group(both);
        let mut sum = Sum::new();
        sum.add_term(group.and_then(|group| group.times(&[self.parameters.qd[joint]])));
        equations.define(QuantityLabel::new("QQ", 0, joint + 1), sum)
    }
}

/// `~OA + ~OM ~OM`, row by row, and the squares of `OM`.
pub(super) fn tilde(
    equations: &mut Equations,
    joint: usize,
    velocity: &Vector,
    angular: &Vector,
) -> (Matrix, Vector) {
    let mut tilde = [ZERO; 3];
    let mut component = 0;
    let squares = velocity.map(|value| {
        component += 1;
        let square = Sum::product(&[value, value]);
        equations.define(QuantityLabel::new("OO", component, joint + 1), square)
    });
    for row in 0..3 {
        let (next, last) = cyclic(row);
        let entry = |row: usize, column: usize| 3 * row + column + 1;
        let mut diagonal = Sum::new();
        diagonal
            .subtract(&[squares[next]])
            .subtract(&[squares[last]]);
        let label = QuantityLabel::new("BS", entry(row, row), joint + 1);
        tilde[row][row] = equations.define(label, diagonal);
        let product = Sum::product(&[velocity[next], velocity[last]]);
        let (low, high) = (next.min(last), next.max(last));
        let product = equations.define(
            QuantityLabel::new("BS", entry(low, high), joint + 1),
            product,
        );
        for (r, c, negative) in [(next, last, true), (last, next, false)] {
            let sum = Sum::total(&[product, angular[row].negated_if(negative)]);
            let label = QuantityLabel::new("BEF", entry(r, c), joint + 1);
            tilde[r][c] = equations.define(label, sum);
        }
    }
    (tilde, squares)
}
