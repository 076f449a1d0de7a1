//! Parts of a model that can be left out, one by one.

use crate::scene::NeglectKind::{
    Angles, ExternalForces, Gravity, Inertias, JointForces, Joints, Links, Masses, Velocities,
};
use crate::scene::{NeglectKind, NeglectWish};
use robovec_dynamics::motion::{Laws, Spring, Support};
use robovec_model::{Model, Nature};

/// One omission: its kind, and the index of its part in the model.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Omission(pub NeglectKind, pub usize);

impl Omission {
    /// The larger omission that contains it.
    pub(super) fn goes_with(self) -> Option<Omission> {
        match self.0 {
            Velocities | Angles | JointForces => Some(Omission(Joints, self.1)),
            Inertias => Some(Omission(Masses, self.1)),
            _ => None,
        }
    }

    /// The name of the joint, body, link or force it is about.
    fn name(self, model: &Model) -> &str {
        match self.0 {
            Velocities | Angles | JointForces | Joints => &model.joints[self.1].name,
            Inertias | Masses => &model.bodies[self.1].name,
            Links => &model.links[self.1].name,
            ExternalForces => &model.forces[self.1].name,
            Gravity => "gravity",
        }
    }

    /// The thing in words.
    pub fn describe(self, model: &Model) -> String {
        let what = match self.0 {
            Velocities => "velocity of ",
            Angles => "curvature of ",
            Inertias => "moments of inertia of ",
            Masses => "mass and inertia of ",
            JointForces => "force on ",
            Links => "link ",
            ExternalForces => "external force ",
            Gravity => "",
            Joints => "joint ",
        };
        format!("{what}{}", self.name(model))
    }
}

/// All parts of a model under laws that a scene lets go, in the order of kinds.
/// `model` holds the joints that the scene holds; watched joints stay.
pub(super) fn candidates(
    model: &Model,
    laws: &Laws,
    wish: &NeglectWish,
    watched: &[usize],
) -> Vec<Omission> {
    let mut all = Vec::new();
    for (index, joint) in model.joints.iter().enumerate() {
        if joint.has_velocity {
            all.push(Omission(Velocities, index));
        }
        let locked = joint.nature == Nature::Driven && !joint.has_velocity;
        if joint.kind.is_revolute() && !locked {
            all.push(Omission(Angles, index));
        }
        if joint.nature != Nature::Driven {
            if laws.joints[index].acts() {
                all.push(Omission(JointForces, index));
            }
            if !watched.contains(&index) {
                all.push(Omission(Joints, index));
            }
        }
    }
    for (index, body) in model.bodies.iter().enumerate() {
        let turns = body.inertia.iter().any(|&moment| moment != 0.0);
        if turns {
            all.push(Omission(Inertias, index));
        }
        if body.mass != 0.0 {
            all.push(Omission(Masses, index));
        }
    }
    let links = (0..model.links.len()).filter(|&link| laws.links[link].acts());
    all.extend(links.map(|link| Omission(Links, link)));
    let forces = (0..model.forces.len()).filter(|&force| laws.forces[force].acts());
    all.extend(forces.map(|force| Omission(ExternalForces, force)));
    if model.gravity != [0.0; 3] {
        all.push(Omission(Gravity, 0));
    }
    all.retain(|one| wish.kinds.is_empty() || wish.kinds.contains(&one.0));
    all.retain(|one| wish.keep.iter().all(|name| name != one.name(model)));
    all.sort_unstable();
    all
}

/// The laws without those of omitted forces and of joints that are held.
pub(super) fn without_forces(laws: &Laws, omitted: &[Omission]) -> Laws {
    let mut laws = laws.clone();
    for one in omitted {
        match *one {
            Omission(JointForces, joint) => laws.joints[joint] = Spring::default(),
            Omission(Links, link) => laws.links[link] = Spring::default(),
            Omission(ExternalForces, force) => laws.forces[force] = Support::default(),
            _ => {}
        }
    }
    laws
}
