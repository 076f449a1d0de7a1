//! The prefix form: `M` and `c` in logarithmic depth.
//!
//! In one common frame every recursion from joint to joint is a sum or a
//! product over the path, and the load of a joint is a sum over the joints
//! beyond; a network ([`super::network`]) combines them in any depth between
//! logarithmic and linear. With `z_i` the axis of joint i, `D_i` the lever to
//! its origin, both in the axes of the reference, and h the joint before it:
//!
//! ```text
//! RO_i = Q_i RO_h             PO_i = PO_h + D_i
//! OM_i = OM_h + z_i qd_i      OP_i = OP_h + OM_h x z_i qd_i
//! AO_i = AO_h + BE_h D_i      BE   = ~OP + ~OM ~OM        (translations: qd_i in D_i's place)
//! ```
//!
//! Every body gives a force, a torque, a mass, a first moment and moments of
//! inertia about the reference's origin; their sums over the bodies beyond a
//! joint give `c_i = z.N + v.F` with `v_i = PO_i x z_i`, the wrench of its
//! column, and `M_ij = z_j.n_i + v_j.f_i`.
//!
//! The reference is the base, or the hub of [`super::hub`]; the joints of its
//! stem are then worked off in body frames, one after another.

use super::algebra::{Scalar, Sum};
use super::bias::{Bias, BiasMotion, tilde};
use super::composite::{MassAndBias, carry};
use super::equations::{Equations, QuantityLabel};
use super::hub::{MomentOrigin, Pose, Twist, hubs, turned};
use super::inertia::{SumInertia, Wrench, euler, turned_moments};
use super::network::{PathBlock, PrefixNetwork, paths, subtrees};
use super::parameters::ModelParameters;
use super::vector::{
    Inertia, Matrix, SumVector, Vector, ZERO, add_cross, add_matrix_product, add_vector, define,
    sums,
};

/// `M` and `c`.
pub(super) fn dynamics(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    network: PrefixNetwork,
    origin: MomentOrigin,
) -> MassAndBias {
    let offsets = parameters.named_offsets(equations);
    let mut form = Prefix::new(
        equations,
        parameters,
        (network, origin),
        &offsets,
        &parameters.resting,
    );
    let (twists, loads) = form.loads();
    let bias = form.forces(&twists, &loads);
    let mass = (0..loads.len())
        .map(|joint| form.column(joint, &twists, &loads[joint].inertia))
        .collect();
    MassAndBias { mass, bias }.with_armatures(equations, parameters)
}

/// Joint forces for given accelerations of the joints.
pub(super) fn inverse(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    (network, origin): (PrefixNetwork, MomentOrigin),
    accelerations: &[Scalar],
) -> Vec<Scalar> {
    let offsets = parameters.named_offsets(equations);
    let form = (network, origin);
    let mut form = Prefix::new(equations, parameters, form, &offsets, accelerations);
    let (twists, loads) = form.loads();
    form.forces(&twists, &loads)
}

/// Sum over bodies: a wrench and an inertia about the reference.
#[derive(Clone, Copy)]
struct CompositeLoad {
    wrench: Wrench,
    inertia: Inertia,
}

/// The motion of the frames beyond the joints, in the axes of the reference.
struct Motions {
    poses: Vec<Pose>,
    motions: Vec<BiasMotion>,
}

struct Prefix<'e, 'p, 'm> {
    equations: &'e mut Equations,
    parameters: &'p ModelParameters<'m>,
    offsets: &'p [Vector],
    /// Accelerations of the joints; none at all when empty.
    accelerations: &'p [Scalar],
    network: PrefixNetwork,
    origin: MomentOrigin,
    /// True for joints that the networks combine, false for stems and hubs.
    behind: Vec<bool>,
}

impl<'e, 'p, 'm> Prefix<'e, 'p, 'm> {
    fn new(
        equations: &'e mut Equations,
        parameters: &'p ModelParameters<'m>,
        (network, origin): (PrefixNetwork, MomentOrigin),
        offsets: &'p [Vector],
        accelerations: &'p [Scalar],
    ) -> Self {
        let behind = match origin {
            MomentOrigin::Base => vec![true; parameters.joints()],
            MomentOrigin::Body => {
                let hubs = hubs(parameters);
                let is_behind =
                    |(joint, hub): (usize, &Option<usize>)| hub.is_some_and(|hub| hub != joint);
                hubs.iter().enumerate().map(is_behind).collect()
            }
        };
        Prefix {
            equations,
            parameters,
            offsets,
            accelerations,
            network,
            origin,
            behind,
        }
    }

    /// The twists of all joints, and their loads.
    fn loads(&mut self) -> (Vec<Twist>, Vec<CompositeLoad>) {
        let stem = self.stem();
        let Motions { poses, motions } = self.motions(&stem);
        let loads: Vec<CompositeLoad> = (0..self.behind.len())
            .map(|joint| self.own(joint, &poses[joint], &motions[joint]))
            .collect();
        let mut loads = self.sums(&loads);
        self.collect_stem(&mut loads);
        let twist = |(joint, pose)| Twist::new(self.equations, self.parameters, joint, pose);
        (poses.iter().enumerate().map(twist).collect(), loads)
    }

    /// The components of the joints' loads along their axes.
    fn forces(&mut self, twists: &[Twist], loads: &[CompositeLoad]) -> Vec<Scalar> {
        let force = |(joint, load): (usize, &CompositeLoad)| {
            if self.behind[joint] {
                let label = QuantityLabel::new("c", 0, joint + 1);
                product(self.equations, label, &twists[joint], &load.wrench)
            } else {
                load.wrench.along(self.parameters, joint)
            }
        };
        loads.iter().enumerate().map(force).collect()
    }

    /// A multiple of a joint's acceleration, zero without accelerations.
    fn accelerate(&self, joint: usize, axis: &Vector, step: &mut SumVector) {
        if let Some(&acceleration) = self.accelerations.get(joint) {
            for (component, &direction) in step.iter_mut().zip(axis) {
                component.add(&[direction, acceleration]);
            }
        }
    }

    /// Parents of the joints that networks combine; stems and hubs have none.
    fn forest(&self) -> Vec<Option<usize>> {
        (0..self.behind.len())
            .map(|joint| {
                let parent = self.parameters.parent(joint);
                parent.filter(|&parent| self.behind[joint] && self.behind[parent])
            })
            .collect()
    }

    /// The motions of stems and hubs, in their own frames.
    fn stem(&mut self) -> Vec<BiasMotion> {
        let bias = Bias::new(self.parameters, self.offsets, &[]).accelerated(self.accelerations);
        let mut motions: Vec<BiasMotion> = Vec::with_capacity(self.behind.len());
        for joint in 0..self.behind.len() {
            motions.push(if self.behind[joint] {
                BiasMotion::REST
            } else {
                let parent = self.parameters.parent(joint);
                let before = bias.before(&motions, parent);
                bias.motion(self.equations, joint, &before)
            });
        }
        motions
    }

    /// Poses and motions beyond all joints.
    fn motions(&mut self, stem: &[BiasMotion]) -> Motions {
        let parameters = self.parameters;
        let forest = self.forest();
        let joints = 0..self.behind.len();
        let axes = self.rotations(&forest);
        let levers: Vec<Vector> = joints
            .clone()
            .map(|joint| {
                let before = self.before(joint, &axes, Pose::HERE.axes);
                let pose = Pose {
                    axes: before,
                    ..Pose::HERE
                };
                let offset = if self.behind[joint] {
                    self.offsets[joint]
                } else {
                    ZERO
                };
                define(self.equations, "RL", joint, 0, pose.lever(&offset))
            })
            .collect();
        let origins = self.path_sums("PO", &forest, &levers, |_| ZERO);
        let mut poses = vec![Pose::HERE; self.behind.len()];
        for joint in joints.clone().filter(|&joint| self.behind[joint]) {
            poses[joint] = Pose {
                axes: axes[joint],
                origin: origins[joint],
            };
        }
        let spins: Vec<Vector> = joints
            .clone()
            .map(|joint| {
                let axis = axes[joint][parameters.axis(joint)];
                let spin = axis.map(|component| Sum::product(&[component, parameters.qd[joint]]));
                define(self.equations, "OS", joint, 0, spin)
            })
            .collect();
        let directions: Vec<Vector> = joints
            .map(|joint| axes[joint][parameters.axis(joint)])
            .collect();
        let motions = self.velocities(stem, &forest, &levers, [&spins, &directions]);
        Motions { poses, motions }
    }

    /// The value of the frame before a joint.
    fn before<T: Copy>(&self, joint: usize, values: &[T], reference: T) -> T {
        match self.parameters.parent(joint) {
            Some(parent) if self.behind[parent] => values[parent],
            _ => reference,
        }
    }

    /// `RO` of every joint: products of rotations over its path.
    fn rotations(&mut self, forest: &[Option<usize>]) -> Vec<Matrix> {
        let parameters = self.parameters;
        let equations = &mut *self.equations;
        let identity = Pose::HERE.axes;
        let turns: Vec<Matrix> = (0..forest.len())
            .map(|joint| {
                if self.behind[joint] {
                    turned(equations, "RO", joint, &identity, &parameters.turns[joint])
                } else {
                    identity
                }
            })
            .collect();
        paths(self.network, forest, &turns, |block, before, after| {
            let mut rows = [ZERO; 3];
            for (row, coefficients) in after.iter().enumerate() {
                for column in 0..3 {
                    let mut sum = Sum::new();
                    for (k, &coefficient) in coefficients.iter().enumerate() {
                        sum.add(&[coefficient, before[k][column]]);
                    }
                    let label = QuantityLabel::new("RO", 3 * row + column + 1, block.joint + 1);
                    rows[row][column] = equations.define(label.column(block.start), sum);
                }
            }
            rows
        })
    }

    /// Sums of vectors over paths, which begin with the value at the reference.
    fn path_sums(
        &mut self,
        name: &'static str,
        forest: &[Option<usize>],
        values: &[Vector],
        reference: impl Fn(usize) -> Vector,
    ) -> Vec<Vector> {
        let behind = &self.behind;
        let equations = &mut *self.equations;
        let mut add = |joint: usize, column: usize, one: Vector, other: Vector| {
            let mut sum = one.map(Sum::of);
            for (component, value) in sum.iter_mut().zip(other) {
                component.add(&[value]);
            }
            define(equations, name, joint, column, sum)
        };
        let values: Vec<Vector> = values
            .iter()
            .enumerate()
            .map(|(joint, &value)| {
                if behind[joint] && forest[joint].is_none() {
                    add(joint, 0, reference(joint), value)
                } else {
                    value
                }
            })
            .collect();
        paths(self.network, forest, &values, |block, before, after| {
            add(block.joint, block.start, before, after)
        })
    }

    /// Angular velocity, angular acceleration and acceleration of every frame.
    fn velocities(
        &mut self,
        stem: &[BiasMotion],
        forest: &[Option<usize>],
        levers: &[Vector],
        [spins, directions]: [&[Vector]; 2],
    ) -> Vec<BiasMotion> {
        let parameters = self.parameters;
        let count = self.behind.len();
        let base = Bias::new(parameters, self.offsets, &[]).base();
        let reference = |joint: usize| match (self.origin, parameters.parent(joint)) {
            (MomentOrigin::Body, Some(parent)) => stem[parent],
            _ => base,
        };
        let references: Vec<BiasMotion> = (0..count).map(reference).collect();
        let revolute = |joint| parameters.is_revolute(joint);
        let own: Vec<Vector> = (0..count)
            .map(|joint| if revolute(joint) { spins[joint] } else { ZERO })
            .collect();
        let velocities = self.path_sums("OM", forest, &own, |joint| references[joint].velocity);
        let before =
            |form: &Self, joint: usize, values: &[Vector], pick: fn(&BiasMotion) -> Vector| {
                form.before(joint, values, pick(&references[joint]))
            };
        let steps: Vec<Vector> = (0..count)
            .map(|joint| {
                let mut cross = sums();
                let velocity = before(self, joint, &velocities, |motion| motion.velocity);
                add_cross(&mut cross, &velocity, &own[joint], false);
                if revolute(joint) {
                    self.accelerate(joint, &directions[joint], &mut cross);
                }
                define(self.equations, "OX", joint, 0, cross)
            })
            .collect();
        let angulars = self.path_sums("OP", forest, &steps, |joint| references[joint].angular);
        let mut motions: Vec<BiasMotion> = (0..count)
            .map(|joint| {
                if !self.behind[joint] {
                    return stem[joint];
                }
                let (velocity, angular) = (velocities[joint], angulars[joint]);
                let (tilde, squares) = tilde(self.equations, joint, &velocity, &angular);
                BiasMotion {
                    velocity,
                    angular,
                    linear: ZERO,
                    tilde,
                    squares,
                }
            })
            .collect();
        let steps: Vec<Vector> = (0..count)
            .map(|joint| {
                let before = before(self, joint, &velocities, |motion| motion.velocity);
                let tilde = match parameters.parent(joint) {
                    Some(parent) => motions[parent].tilde,
                    None => base.tilde,
                };
                let axes = [&spins[joint], &directions[joint]];
                self.step(joint, &levers[joint], (&before, &tilde), axes)
            })
            .collect();
        let linears = self.path_sums("AO", forest, &steps, |joint| references[joint].linear);
        for joint in 0..count {
            if self.behind[joint] {
                motions[joint].linear = linears[joint];
            }
        }
        motions
    }

    /// Acceleration that a joint's lever and translation add to its parent's.
    fn step(
        &mut self,
        joint: usize,
        lever: &Vector,
        (velocity, tilde): (&Vector, &Matrix),
        [spin, direction]: [&Vector; 2],
    ) -> Vector {
        let mut step = sums();
        add_matrix_product(&mut step, tilde, lever);
        if !self.parameters.is_revolute(joint) {
            self.accelerate(joint, direction, &mut step);
            let two = self.equations.number(2.0);
            let mut cross = sums();
            add_cross(&mut cross, velocity, spin, false);
            for (component, cross) in step.iter_mut().zip(cross) {
                let group = self.equations.group(cross);
                component.add_term(group.and_then(|group| group.times(&[two])));
            }
        }
        define(self.equations, "AX", joint, 0, step)
    }

    /// Load of a joint's own body, about the reference's origin.
    fn own(&mut self, joint: usize, pose: &Pose, motion: &BiasMotion) -> CompositeLoad {
        let parameters = self.parameters;
        let equations = &mut *self.equations;
        let mass = parameters.masses[joint];
        let lever = define(
            equations,
            "LO",
            joint,
            0,
            pose.lever(&parameters.centers[joint]),
        );
        let mut acceleration = motion.linear.map(Sum::of);
        add_matrix_product(&mut acceleration, &motion.tilde, &lever);
        let mut force = pose.lever(&parameters.forces[joint]).map(|external| {
            let mut sum = Sum::new();
            sum.add_scaled(&[-Scalar::ONE], &external);
            sum
        });
        for (component, acceleration) in force.iter_mut().zip(acceleration) {
            let group = equations.group(acceleration);
            component.add_term(group.and_then(|group| group.times(&[mass])));
        }
        let force = define(equations, "FO", joint, 0, force);
        let mut center = pose.origin.map(Sum::of);
        add_vector(&mut center, &lever);
        let center = define(equations, "PC", joint, 0, center);
        let moments = turned_moments(equations, joint, &parameters.inertias[joint], pose);
        let mut torque = euler(equations, joint, &moments, motion);
        for (component, external) in torque
            .iter_mut()
            .zip(pose.lever(&parameters.torques[joint]))
        {
            component.add_scaled(&[-Scalar::ONE], &external);
        }
        add_cross(&mut torque, &center, &force, false);
        let mut inertia = SumInertia::new();
        inertia.add_body(equations, joint, mass, &moments, &center);
        CompositeLoad {
            wrench: Wrench {
                force,
                torque: define(equations, "NO", joint, 0, torque),
            },
            inertia: inertia.define(equations, ["MO", "HO", "JO"], joint, 0),
        }
    }

    /// Sums over the bodies beyond every joint; stems and hubs keep their own.
    fn sums(&mut self, loads: &[CompositeLoad]) -> Vec<CompositeLoad> {
        let parameters = self.parameters;
        // A hub takes what the joints behind it carry: the same frame.
        let parents: Vec<Option<usize>> = (0..loads.len())
            .map(|joint| parameters.parent(joint).filter(|_| self.behind[joint]))
            .collect();
        let equations = &mut *self.equations;
        subtrees(self.network, &parents, loads, |block, parts| {
            add_loads(equations, block, parts)
        })
    }

    /// The loads of the stems, from the hubs to the base.
    fn collect_stem(&mut self, loads: &mut [CompositeLoad]) {
        let parameters = self.parameters;
        for joint in (0..loads.len()).rev() {
            let Some(parent) = parameters.parent(joint).filter(|_| !self.behind[joint]) else {
                continue;
            };
            let equations = &mut *self.equations;
            let (turn, offset) = (&parameters.turns[joint], &self.offsets[joint]);
            let mut wrench =
                loads[joint]
                    .wrench
                    .to_parent(equations, "FT", (joint, 0), turn, offset);
            wrench.add(&loads[parent].wrench.sums());
            let mut inertia = SumInertia::new();
            inertia.add_child(equations, parameters, joint, &loads[joint].inertia, offset);
            inertia.add(&loads[parent].inertia);
            loads[parent] = CompositeLoad {
                wrench: wrench.define(equations, ("FS", "NS"), parent, 0),
                inertia: inertia.define(equations, ["MC", "HC", "JC"], parent, 0),
            };
        }
    }

    /// The entries of `M` of a joint with the joints on its path to the base.
    fn column(
        &mut self,
        joint: usize,
        twists: &[Twist],
        inertia: &Inertia,
    ) -> Vec<(usize, Scalar)> {
        let parameters = self.parameters;
        let mut entries = Vec::new();
        let mut place = Some(joint);
        let mut wrench = if self.behind[joint] {
            inertia.wrench(self.equations, ("FM", "NM"), joint, &twists[joint])
        } else {
            inertia.column(parameters.axis(joint), parameters.is_revolute(joint))
        };
        while let Some(ancestor) = place.filter(|&ancestor| self.behind[ancestor]) {
            let label = QuantityLabel::new("MO", 0, joint + 1).column(ancestor + 1);
            let entry = product(self.equations, label, &twists[ancestor], &wrench);
            entries.push((ancestor, entry));
            place = parameters.parent(ancestor);
        }
        // At the hub the wrench is in the hub's own frame.
        while let Some(ancestor) = place {
            entries.push((ancestor, wrench.along(parameters, ancestor)));
            let offset = &self.offsets[ancestor];
            let step = (ancestor, joint);
            wrench = carry(
                self.equations,
                parameters,
                &wrench,
                ("FT", "NT"),
                step,
                offset,
            );
            place = parameters.parent(ancestor);
        }
        entries
    }
}

/// The component of a wrench along a joint's twist.
fn product(
    equations: &mut Equations,
    label: QuantityLabel,
    twist: &Twist,
    wrench: &Wrench,
) -> Scalar {
    let mut sum = Sum::new();
    for (angular, torque) in twist.angular.iter().zip(&wrench.torque) {
        sum.add(&[*angular, *torque]);
    }
    for (linear, force) in twist.linear.iter().zip(&wrench.force) {
        sum.add(&[*linear, *force]);
    }
    equations.define(label, sum)
}

fn add_loads(
    equations: &mut Equations,
    block: PathBlock,
    parts: &[CompositeLoad],
) -> CompositeLoad {
    let mut wrench = super::inertia::SumWrench::new();
    let mut inertia = SumInertia::new();
    for part in parts {
        wrench.add(&part.wrench.sums());
        inertia.add(&part.inertia);
    }
    let (joint, column) = (block.joint, block.start);
    CompositeLoad {
        wrench: wrench.define(equations, ("FS", "NS"), joint, column),
        inertia: inertia.define(equations, ["MS", "HS", "JS"], joint, column),
    }
}
