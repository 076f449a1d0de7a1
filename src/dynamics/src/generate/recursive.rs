//! Robotran's recursive Newton-Euler: `M` and `c`, or `Qq`, in body frames.
//!
//! Forward from the base: angular velocity `OM`, angular acceleration without
//! joint accelerations `OA`, `BE = ~OA + ~OM ~OM`, acceleration of the frame
//! origin minus gravity `AF`, and for every ancestor k their derivatives with
//! respect to its acceleration, `OB_k` and `AM_k`. Backward from the leaves:
//! the force `FF` and the torque `CF` a joint carries, and their derivatives
//! `FM_k` and `CM_k`. The joint's own component of these is `c` and a column of
//! `M`. The number of operations grows with the sum of depths over all bodies.

use super::algebra::{Scalar, Sum, given};
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{
    Matrix, SumVector, Vector, ZERO, add_cross, add_cross_of_sums, add_matrix_product, add_sums,
    add_vector, cyclic, define, sums,
};
use super::{Options, TermOrder};

/// The motion of a joint's frame, or its derivative.
#[derive(Clone, Copy)]
pub(super) struct FrameMotion {
    /// Angular acceleration.
    pub(super) angular: Vector,
    /// Acceleration of the origin.
    pub(super) linear: Vector,
}

#[derive(Clone, Copy)]
pub(super) struct JointLoad {
    pub(super) force: Vector,
    pub(super) torque: Vector,
}

/// The names of the quantities of a function.
pub(super) struct RecursionNames {
    angular: &'static str,
    linear: &'static str,
    tilde: &'static str,
    own: &'static str,
    force: &'static str,
    turned: &'static str,
    torque: &'static str,
}

pub(super) const DIRECT: RecursionNames = RecursionNames {
    angular: "OA",
    linear: "AF",
    tilde: "BEF",
    own: "FA",
    force: "FF",
    turned: "FFR",
    torque: "CF",
};

const INVERSE: RecursionNames = RecursionNames {
    angular: "OMp",
    linear: "ALPHA",
    tilde: "BETA",
    own: "Fs",
    force: "Fq",
    turned: "FqR",
    torque: "Cq",
};

/// The bias force `c` alone.
pub(super) fn bias(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) -> Vec<Scalar> {
    let mut recursion = Recursion::new(equations, parameters, options, &DIRECT);
    recursion.forward(&parameters.resting);
    recursion.backward()
}

/// Joint forces for given accelerations of the joints.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    accelerations: &[Scalar],
) -> Vec<Scalar> {
    Recursion::moving(equations, parameters, options, accelerations).backward()
}

pub(super) struct Recursion<'e, 'p, 'm> {
    pub(super) equations: &'e mut Equations,
    pub(super) parameters: &'p ModelParameters<'m>,
    names: &'p RecursionNames,
    order: TermOrder,
    /// Products are multiplied out, as Robotran prints them.
    expanded: bool,
    pub(super) children: Vec<Vec<usize>>,
    pub(super) offsets: Vec<Vector>,
    /// `OM`, by joint.
    pub(super) velocities: Vec<Vector>,
    /// By joint, the acceleration of the origin minus gravity.
    pub(super) motions: Vec<FrameMotion>,
    /// `~OA + ~OM ~OM`, by joint.
    pub(super) tildes: Vec<Matrix>,
}

impl<'e, 'p, 'm> Recursion<'e, 'p, 'm> {
    pub(super) fn new(
        equations: &'e mut Equations,
        parameters: &'p ModelParameters<'m>,
        options: &Options,
        names: &'p RecursionNames,
    ) -> Self {
        let offsets = (0..parameters.joints())
            .map(|joint| parameters.named_offset(equations, joint))
            .collect();
        Recursion {
            equations,
            parameters,
            names,
            order: options.order,
            expanded: options.expanded,
            children: parameters.children(),
            offsets,
            velocities: Vec::new(),
            motions: Vec::new(),
            tildes: Vec::new(),
        }
    }

    /// A recursion whose frames move with given accelerations of the joints.
    pub(super) fn moving(
        equations: &'e mut Equations,
        parameters: &'p ModelParameters<'m>,
        options: &Options,
        accelerations: &[Scalar],
    ) -> Self {
        let mut recursion = Recursion::new(equations, parameters, options, &INVERSE);
        recursion.forward(accelerations);
        recursion
    }

    /// Velocities and accelerations from base to leaves, perhaps without `qdd`.
    pub(super) fn forward(&mut self, accelerations: &[Scalar]) {
        for joint in 0..self.parameters.joints() {
            let acceleration = given(accelerations, joint);
            let velocity = self.velocity(joint);
            let angular = self.angular(joint, &velocity, acceleration);
            let linear = self.linear(joint, acceleration);
            self.velocities.push(velocity);
            self.motions.push(FrameMotion { angular, linear });
            let tilde = self.tilde(joint, &velocity, &angular);
            self.tildes.push(tilde);
        }
    }

    /// `OM_i = R OM_h + phi qd_i`.
    fn velocity(&mut self, joint: usize) -> Vector {
        let parameters = self.parameters;
        let mut sum = match parameters.parent(joint) {
            Some(parent) => parameters.turns[joint].down(&self.velocities[parent]),
            None => sums(),
        };
        if parameters.is_revolute(joint) {
            let axis = parameters.axis(joint);
            sum[axis].add(&[parameters.qd[joint]]);
        }
        define(self.equations, "OM", joint, 0, sum)
    }

    /// `OA_i = R OA_h + OM_i x phi qd_i`, and `phi qdd_i` with accelerations.
    fn angular(&mut self, joint: usize, velocity: &Vector, acceleration: Scalar) -> Vector {
        let parameters = self.parameters;
        let mut sum = match parameters.parent(joint) {
            Some(parent) => parameters.turns[joint].down(&self.motions[parent].angular),
            None => sums(),
        };
        if parameters.is_revolute(joint) {
            let axis = parameters.axis(joint);
            let (b, c) = cyclic(axis);
            let rate = parameters.qd[joint];
            sum[b].add(&[velocity[c], rate]);
            sum[c].subtract(&[velocity[b], rate]);
            sum[axis].add(&[acceleration]);
        }
        define(self.equations, self.names.angular, joint, 0, sum)
    }

    /// `AF_i = R (AF_h + BE_h d_i + 2 OM_h x psi qd_i)`, minus gravity at the
    /// base, and `psi qdd_i` with accelerations.
    fn linear(&mut self, joint: usize, acceleration: Scalar) -> Vector {
        let parameters = self.parameters;
        let mut before = sums();
        match parameters.parent(joint) {
            None => {
                for (component, &gravity) in before.iter_mut().zip(&parameters.gravity) {
                    component.subtract(&[gravity]);
                }
            }
            Some(parent) => {
                add_vector(&mut before, &self.motions[parent].linear);
                add_matrix_product(&mut before, &self.tildes[parent], &self.offsets[joint]);
                if !parameters.is_revolute(joint) {
                    let (b, c) = cyclic(parameters.axis(joint));
                    let two = self.equations.number(2.0);
                    let rate = parameters.qd[joint];
                    let velocity = self.velocities[parent];
                    before[b].add(&[two, velocity[c], rate]);
                    before[c].subtract(&[two, velocity[b], rate]);
                }
            }
        }
        if !parameters.is_revolute(joint) {
            before[parameters.axis(joint)].add(&[acceleration]);
            return define(self.equations, self.names.linear, joint, 0, before);
        }
        // Each component is used twice by the rotation.
        let before = define(self.equations, "AH", joint, 0, before);
        let turned = parameters.turns[joint].down(&before);
        define(self.equations, self.names.linear, joint, 0, turned)
    }

    /// `~OA + ~OM ~OM`, row by row.
    fn tilde(&mut self, joint: usize, velocity: &Vector, angular: &Vector) -> Matrix {
        let mut tilde = [ZERO; 3];
        for row in 0..3 {
            let (next, last) = cyclic(row);
            let mut diagonal = Sum::new();
            diagonal
                .subtract(&[velocity[next], velocity[next]])
                .subtract(&[velocity[last], velocity[last]]);
            let label = |row: usize, column: usize| 3 * row + column + 1;
            tilde[row][row] = self.equations.define(
                QuantityLabel::new("BS", label(row, row), joint + 1),
                diagonal,
            );
            let product = Sum::product(&[velocity[next], velocity[last]]);
            let square = self.equations.define(
                QuantityLabel::new("BS", label(next.min(last), next.max(last)), joint + 1),
                product,
            );
            for (r, c, sign) in [(next, last, true), (last, next, false)] {
                let entry = Sum::total(&[square, angular[row].negated_if(sign)]);
                tilde[r][c] = self.equations.define(
                    QuantityLabel::new(self.names.tilde, label(r, c), joint + 1),
                    entry,
                );
            }
        }
        tilde
    }

    /// Forces and torques from leaves to base; the joints' own components.
    pub(super) fn backward(&mut self) -> Vec<Scalar> {
        let loads = self.loads();
        let each = loads.iter().enumerate();
        each.map(|(joint, load)| self.component(joint, load))
            .collect()
    }

    pub(super) fn loads(&mut self) -> Vec<JointLoad> {
        let count = self.parameters.joints();
        let mut loads = vec![
            JointLoad {
                force: ZERO,
                torque: ZERO
            };
            count
        ];
        for joint in (0..count).rev() {
            let own = self.own_force(joint);
            let inertia = self.own_torque(joint, &own);
            loads[joint] = self.collect(joint, 0, &own, inertia, &loads);
        }
        loads
    }

    /// `FA_i = m (AF_i + BE_i l_i) - frc_i`.
    fn own_force(&mut self, joint: usize) -> Vector {
        let parameters = self.parameters;
        if let Some(grouped) = &parameters.grouped {
            // About the origin: `m AF + BE h - frc`.
            let own = &grouped[joint].inertia;
            let mut force = parameters.forces[joint].map(|external| Sum::of(-external));
            for (component, &value) in force.iter_mut().zip(&self.motions[joint].linear) {
                component.add(&[own.mass, value]);
            }
            add_matrix_product(&mut force, &self.tildes[joint], &own.first);
            return define(self.equations, self.names.own, joint, 0, force);
        }
        let mut acceleration = self.motions[joint].linear.map(Sum::of);
        add_matrix_product(
            &mut acceleration,
            &self.tildes[joint],
            &parameters.centers[joint],
        );
        let mass = parameters.masses[joint];
        let mut force = sums();
        for ((component, acceleration), &external) in force
            .iter_mut()
            .zip(acceleration)
            .zip(&parameters.forces[joint])
        {
            let group = self.equations.group(acceleration);
            component.add_term(group.and_then(|group| group.times(&[mass])));
            component.subtract(&[external]);
        }
        define(self.equations, self.names.own, joint, 0, force)
    }

    /// `l x FA + I OA + OM x (I OM) - trq`.
    fn own_torque(&mut self, joint: usize, own: &Vector) -> SumVector {
        let parameters = self.parameters;
        let mut torque = sums();
        for (component, &external) in torque.iter_mut().zip(&parameters.torques[joint]) {
            component.subtract(&[external]);
        }
        if let Some(grouped) = &parameters.grouped {
            // `h x AF + J OA + OM x (J OM)`, and the moment of central loads.
            let own = &grouped[joint].inertia;
            let (center, external) = (&parameters.centers[joint], &parameters.forces[joint]);
            add_cross(&mut torque, center, external, true);
            add_cross(&mut torque, &own.first, &self.motions[joint].linear, false);
            self.add_rotation(&mut torque, joint, &own.moments);
            return torque;
        }
        add_cross(&mut torque, &parameters.centers[joint], own, false);
        if self.expanded {
            self.add_expanded_rotation(&mut torque, joint);
        } else {
            self.add_rotation(&mut torque, joint, &parameters.inertias[joint]);
        }
        torque
    }

    /// `I OA + OM x (I OM)` multiplied out, as Robotran prints it.
    fn add_expanded_rotation(&mut self, torque: &mut SumVector, joint: usize) {
        let velocity = &self.velocities[joint];
        let inertia = &self.parameters.inertias[joint];
        add_matrix_product(torque, inertia, &self.motions[joint].angular);
        for axis in 0..3 {
            let (next, last) = cyclic(axis);
            for k in 0..3 {
                torque[axis].add(&[inertia[last][k], velocity[next], velocity[k]]);
            }
            for k in 0..3 {
                torque[axis].subtract(&[inertia[next][k], velocity[last], velocity[k]]);
            }
        }
    }

    /// `I OA + OM x (I OM)` by the products of velocities in `BE`, which the
    /// accelerations need anyway. With (a, b, c) cyclic, component a is
    /// `I_aa OA_a + (I_cc - I_bb) OM_b OM_c + I_ab (OA_b - OM_a OM_c)
    /// + I_ac (OA_c + OM_a OM_b) + I_bc (OM_b^2 - OM_c^2)`.
    fn add_rotation(&mut self, torque: &mut SumVector, joint: usize, inertia: &Matrix) {
        let tilde = &self.tildes[joint];
        let velocity = &self.velocities[joint];
        for a in 0..3 {
            let (b, c) = cyclic(a);
            let component = &mut torque[a];
            component.add(&[inertia[a][a], self.motions[joint].angular[a]]);
            let product = Sum::product(&[velocity[b], velocity[c]]);
            let product = self.equations.define(
                QuantityLabel::new("BS", 3 * b.min(c) + b.max(c) + 1, joint + 1),
                product,
            );
            let difference = Sum::total(&[inertia[c][c], -inertia[b][b]]);
            let difference = self.equations.group(difference);
            component.add_term(difference.and_then(|group| group.times(&[product])));
            component.subtract(&[inertia[a][b], tilde[c][a]]);
            component.add(&[inertia[a][c], tilde[b][a]]);
            if !inertia[b][c].is_zero() {
                let squares = Sum::total(&[tilde[b][b], -tilde[c][c]]);
                let squares = self.equations.group(squares);
                component.add_term(squares.and_then(|group| group.times(&[inertia[b][c]])));
            }
        }
    }

    /// Load of a joint: its own and its children's, levers multiplied out.
    pub(super) fn collect(
        &mut self,
        joint: usize,
        column: usize,
        own_force: &Vector,
        own_torque: SumVector,
        loads: &[JointLoad],
    ) -> JointLoad {
        let (force_name, force_turned, torque_name) = if column > 0 {
            ("FM", "FMR", "CM")
        } else {
            (self.names.force, self.names.turned, self.names.torque)
        };
        let (mut force, mut torque) = (sums(), sums());
        for &child in &self.children[joint] {
            let turn = &self.parameters.turns[child];
            let mut up = turn.up(&loads[child].force);
            if !self.expanded && self.offsets[child] != ZERO {
                // Force and lever arm both use the turned force.
                up = define(self.equations, force_turned, child, column, up).map(Sum::of);
            }
            add_sums(&mut force, &up);
            add_sums(&mut torque, &turn.up(&loads[child].torque));
            add_cross_of_sums(&mut torque, &self.offsets[child], &up);
        }
        let own_force = own_force.map(Sum::of);
        JointLoad {
            force: self.ordered(force_name, joint, column, own_force, force),
            torque: self.ordered(torque_name, joint, column, own_torque, torque),
        }
    }

    fn ordered(
        &mut self,
        name: &'static str,
        joint: usize,
        column: usize,
        own: SumVector,
        children: SumVector,
    ) -> Vector {
        let (mut first, second) = match self.order {
            TermOrder::OwnFirst => (own, children),
            TermOrder::ChildFirst => (children, own),
        };
        add_sums(&mut first, &second);
        define(self.equations, name, joint, column, first)
    }

    pub(super) fn component(&self, joint: usize, load: &JointLoad) -> Scalar {
        let axis = self.parameters.axis(joint);
        if self.parameters.is_revolute(joint) {
            load.torque[axis]
        } else {
            load.force[axis]
        }
    }
}
