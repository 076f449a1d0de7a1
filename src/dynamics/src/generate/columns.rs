//! The mass matrix of the recursive Newton-Euler family, column by column.
//!
//! Column k holds the load of every joint when joint k alone accelerates by
//! one. A revolute joint's column is accumulated from the leaves, body by body.
//! When a prismatic joint accelerates, all bodies beyond it have the same
//! acceleration, for any orientation: the load of joint i is then the mass
//! `MS_i` beyond it times `AM_i,k`, with the first moment `MD_i` as its lever.
//! This holds for true sines and cosines only (`sin^2 + cos^2 = 1`).

use super::Options;
use super::algebra::{Scalar, Sum};
use super::composite::with_armature;
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::recursive::{DIRECT, FrameMotion, JointLoad, Recursion};
use super::vector::{SumVector, Vector, ZERO, add_cross, add_matrix_product, define, sums, unit};

/// Mass and first moment, in the joint's frame, of all bodies beyond it.
struct MassAndMoment {
    mass: Scalar,
    moment: Vector,
}

/// Writes `M` and `c`.
pub(super) fn direct(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
) {
    let mut recursion = Recursion::new(equations, parameters, options, &DIRECT);
    recursion.forward(&parameters.resting);
    let bias = recursion.backward();
    let mut columns = Columns {
        recursion: &mut recursion,
        composites: None,
    };
    columns.write(options.true_angles);
    for (joint, value) in bias.into_iter().enumerate() {
        recursion.equations.output("c", &[joint + 1], value);
    }
}

struct Columns<'r, 'e, 'p, 'm> {
    recursion: &'r mut Recursion<'e, 'p, 'm>,
    composites: Option<Vec<MassAndMoment>>,
}

impl Columns<'_, '_, '_, '_> {
    /// `M`: column by column of the accelerations.
    fn write(&mut self, true_angles: bool) {
        let count = self.recursion.parameters.joints();
        // Forward: the derivatives by every ancestor, the joint itself last.
        let mut paths: Vec<Vec<usize>> = Vec::with_capacity(count);
        let mut motions: Vec<Vec<FrameMotion>> = Vec::with_capacity(count);
        for joint in 0..count {
            let (path, own) = match self.recursion.parameters.parent(joint) {
                None => (Vec::new(), Vec::new()),
                Some(parent) => {
                    let path = paths[parent].clone();
                    let turned = (0..path.len())
                        .map(|place| self.derivative(joint, path[place], &motions[parent][place]))
                        .collect();
                    (path, turned)
                }
            };
            let (mut path, mut own): (Vec<usize>, Vec<FrameMotion>) = (path, own);
            path.push(joint);
            own.push(self.own_derivative(joint));
            paths.push(path);
            motions.push(own);
        }
        let parameters = self.recursion.parameters;
        let slides = (0..count).any(|joint| !parameters.is_revolute(joint));
        if true_angles && slides {
            self.composites = Some(self.composites());
        }
        for ancestor in 0..count {
            match self.composites.take() {
                Some(composites) if !parameters.is_revolute(ancestor) => {
                    self.slide(ancestor, &paths, &motions, &composites);
                    self.composites = Some(composites);
                }
                composites => {
                    self.composites = composites;
                    self.column(ancestor, &paths, &motions);
                }
            }
        }
    }

    /// Composite of every joint, from the leaves on.
    fn composites(&mut self) -> Vec<MassAndMoment> {
        let parameters = self.recursion.parameters;
        let equations = &mut *self.recursion.equations;
        let mut composites: Vec<MassAndMoment> = Vec::new();
        composites.resize_with(parameters.joints(), || MassAndMoment {
            mass: Scalar::ZERO,
            moment: ZERO,
        });
        for joint in (0..parameters.joints()).rev() {
            let own = parameters.masses[joint];
            let mut mass = Sum::of(own);
            let mut moment = sums();
            for (component, &center) in moment.iter_mut().zip(&parameters.centers[joint]) {
                component.add(&[own, center]);
            }
            for &child in &self.recursion.children[joint] {
                let behind = &composites[child];
                mass.add(&[behind.mass]);
                let turned = parameters.turns[child].up(&behind.moment);
                for k in 0..3 {
                    moment[k].add_sum(&turned[k]);
                    moment[k].add(&[behind.mass, self.recursion.offsets[child][k]]);
                }
            }
            composites[joint] = MassAndMoment {
                mass: equations.define(QuantityLabel::new("MS", 0, joint + 1), mass),
                moment: define(equations, "MD", joint, 0, moment),
            };
        }
        composites
    }

    /// The column of a prismatic joint.
    fn slide(
        &mut self,
        ancestor: usize,
        paths: &[Vec<usize>],
        motions: &[Vec<FrameMotion>],
        composites: &[MassAndMoment],
    ) {
        let parameters = self.recursion.parameters;
        for joint in ancestor..parameters.joints() {
            let Ok(place) = paths[joint].binary_search(&ancestor) else {
                continue;
            };
            let acceleration = &motions[joint][place].linear;
            let axis = parameters.axis(joint);
            let composite = &composites[joint];
            let (name, sum) = if parameters.is_revolute(joint) {
                let mut torque = sums();
                add_cross(&mut torque, &composite.moment, acceleration, false);
                ("CM", std::mem::take(&mut torque[axis]))
            } else {
                let force = Sum::product(&[composite.mass, acceleration[axis]]);
                ("FM", force)
            };
            let label = QuantityLabel::new(name, axis + 1, joint + 1).column(ancestor + 1);
            let entry = self.recursion.equations.define(label, sum);
            self.entry(joint, ancestor, entry);
        }
    }

    fn entry(&mut self, joint: usize, ancestor: usize, entry: Scalar) {
        let equations = &mut *self.recursion.equations;
        let entry = match joint == ancestor {
            true => with_armature(equations, self.recursion.parameters, joint, entry),
            false => entry,
        };
        if entry.is_zero() {
            return;
        }
        equations.output("M", &[joint + 1, ancestor + 1], entry);
        if joint != ancestor {
            equations.output("M", &[ancestor + 1, joint + 1], entry);
        }
    }

    /// `OB_i,i = phi`, `AM_i,i = psi`.
    fn own_derivative(&self, joint: usize) -> FrameMotion {
        let axis = unit(self.recursion.parameters.axis(joint));
        let (angular, linear) = if self.recursion.parameters.is_revolute(joint) {
            (axis, ZERO)
        } else {
            (ZERO, axis)
        };
        FrameMotion { angular, linear }
    }

    /// `OB_i,k = R OB_h,k` and `AM_i,k = R (AM_h,k + OB_h,k x d_i)`.
    fn derivative(&mut self, joint: usize, ancestor: usize, before: &FrameMotion) -> FrameMotion {
        let turn = &self.recursion.parameters.turns[joint];
        let angular = define(
            self.recursion.equations,
            "OB",
            joint,
            ancestor + 1,
            turn.down(&before.angular),
        );
        let mut moved = before.linear.map(Sum::of);
        add_cross(
            &mut moved,
            &before.angular,
            &self.recursion.offsets[joint],
            false,
        );
        if !self.recursion.parameters.is_revolute(joint) {
            let linear = define(self.recursion.equations, "AM", joint, ancestor + 1, moved);
            return FrameMotion { angular, linear };
        }
        let moved = define(self.recursion.equations, "AMH", joint, ancestor + 1, moved);
        let linear = define(
            self.recursion.equations,
            "AM",
            joint,
            ancestor + 1,
            turn.down(&moved),
        );
        FrameMotion { angular, linear }
    }

    /// The column of any joint: `FM` and `CM` from the leaves to the base.
    fn column(&mut self, ancestor: usize, paths: &[Vec<usize>], motions: &[Vec<FrameMotion>]) {
        let count = self.recursion.parameters.joints();
        let nothing = JointLoad {
            force: ZERO,
            torque: ZERO,
        };
        let mut loads = vec![nothing; count];
        for joint in (ancestor..count).rev() {
            let Ok(place) = paths[joint].binary_search(&ancestor) else {
                continue;
            };
            let own = self.own_column(joint, ancestor, &motions[joint][place]);
            loads[joint] = self
                .recursion
                .collect(joint, ancestor + 1, &own.0, own.1, &loads);
            let entry = self.recursion.component(joint, &loads[joint]);
            self.entry(joint, ancestor, entry);
        }
    }

    /// `FB_i,k = m (AM_i,k + OB_i,k x l)` and `l x FB_i,k + I OB_i,k`.
    fn own_column(
        &mut self,
        joint: usize,
        ancestor: usize,
        motion: &FrameMotion,
    ) -> (Vector, SumVector) {
        let parameters = self.recursion.parameters;
        let center = &parameters.centers[joint];
        let mut acceleration = motion.linear.map(Sum::of);
        add_cross(&mut acceleration, &motion.angular, center, false);
        let mass = parameters.masses[joint];
        let force = acceleration.map(|sum| {
            let mut force = Sum::new();
            let group = self.recursion.equations.group(sum);
            force.add_term(group.and_then(|group| group.times(&[mass])));
            force
        });
        let force = define(self.recursion.equations, "FB", joint, ancestor + 1, force);
        let mut torque = sums();
        add_cross(&mut torque, center, &force, false);
        add_matrix_product(&mut torque, &parameters.inertias[joint], &motion.angular);
        (force, torque)
    }
}
