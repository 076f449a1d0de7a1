//! Parts of a model that can be left out, one by one.

use crate::scene::{NeglectKind, NeglectWish};
use robovec_dynamics::motion::{Laws, Spring, Support};
use robovec_model::{Model, Nature};

/// One thing that is left out. Joints, bodies, links and external forces go
/// by their index in the model.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Omission {
    /// The velocity of a joint, in the equations of motion.
    Velocity(usize),
    /// The curvature of sine and cosine of a joint's angle.
    Angle(usize),
    /// The moments of inertia of a body.
    Inertia(usize),
    /// Mass and moments of inertia of a body.
    Mass(usize),
    /// The law of a joint.
    JointForce(usize),
    /// A link.
    Link(usize),
    /// An external force.
    External(usize),
    /// Gravity.
    Gravity,
    /// A joint, locked at its mean position.
    Joint(usize),
}

impl Omission {
    /// The kind of thing it is.
    pub fn kind(self) -> NeglectKind {
        match self {
            Omission::Velocity(_) => NeglectKind::Velocities,
            Omission::Angle(_) => NeglectKind::Angles,
            Omission::Inertia(_) => NeglectKind::Inertias,
            Omission::Mass(_) => NeglectKind::Masses,
            Omission::JointForce(_) => NeglectKind::JointForces,
            Omission::Link(_) => NeglectKind::Links,
            Omission::External(_) => NeglectKind::ExternalForces,
            Omission::Gravity => NeglectKind::Gravity,
            Omission::Joint(_) => NeglectKind::Joints,
        }
    }

    /// The larger thing that it goes with.
    pub(super) fn goes_with(self) -> Option<Omission> {
        match self {
            Omission::Velocity(joint) | Omission::Angle(joint) | Omission::JointForce(joint) => {
                Some(Omission::Joint(joint))
            }
            Omission::Inertia(body) => Some(Omission::Mass(body)),
            _ => None,
        }
    }

    /// The name of the joint, body, link or force it is about.
    fn name(self, model: &Model) -> &str {
        match self {
            Omission::Velocity(joint)
            | Omission::Angle(joint)
            | Omission::JointForce(joint)
            | Omission::Joint(joint) => &model.joints[joint].name,
            Omission::Inertia(body) | Omission::Mass(body) => &model.bodies[body].name,
            Omission::Link(link) => &model.links[link].name,
            Omission::External(force) => &model.forces[force].name,
            Omission::Gravity => "gravity",
        }
    }

    /// The thing in words.
    pub fn describe(self, model: &Model) -> String {
        let name = self.name(model);
        match self {
            Omission::Velocity(_) => format!("velocity of {name}"),
            Omission::Angle(_) => format!("curvature of {name}"),
            Omission::Inertia(_) => format!("moments of inertia of {name}"),
            Omission::Mass(_) => format!("mass and inertia of {name}"),
            Omission::JointForce(_) => format!("force on {name}"),
            Omission::Link(_) => format!("link {name}"),
            Omission::External(_) => format!("external force {name}"),
            Omission::Gravity => "gravity".to_owned(),
            Omission::Joint(_) => format!("joint {name}"),
        }
    }
}

/// Everything that can be left out of a model under laws, as a scene wishes,
/// in the order of kinds. `model` holds the joints that the scene holds;
/// watched joints stay.
pub(super) fn candidates(
    model: &Model,
    laws: &Laws,
    wish: &NeglectWish,
    watched: &[usize],
) -> Vec<Omission> {
    let mut all = Vec::new();
    for (index, joint) in model.joints.iter().enumerate() {
        if joint.has_velocity {
            all.push(Omission::Velocity(index));
        }
        let locked = joint.nature == Nature::Driven && !joint.has_velocity;
        if joint.kind.is_revolute() && !locked {
            all.push(Omission::Angle(index));
        }
        if joint.nature != Nature::Driven {
            if laws.joints[index].acts() {
                all.push(Omission::JointForce(index));
            }
            if !watched.contains(&index) {
                all.push(Omission::Joint(index));
            }
        }
    }
    for (index, body) in model.bodies.iter().enumerate() {
        let turns = body.inertia.iter().any(|&moment| moment != 0.0);
        if turns {
            all.push(Omission::Inertia(index));
        }
        if body.mass != 0.0 {
            all.push(Omission::Mass(index));
        }
    }
    let acting = |index: &usize| laws.links[*index].acts();
    all.extend((0..model.links.len()).filter(acting).map(Omission::Link));
    let acting = |index: &usize| laws.forces[*index].acts();
    all.extend(
        (0..model.forces.len())
            .filter(acting)
            .map(Omission::External),
    );
    if model.gravity != [0.0; 3] {
        all.push(Omission::Gravity);
    }
    all.retain(|one| wish.kinds.is_empty() || wish.kinds.contains(&one.kind()));
    all.retain(|one| wish.keep.iter().all(|name| name != one.name(model)));
    all.sort_unstable();
    all
}

/// The laws without those of omitted forces and of joints that are held;
/// links and external forces stay in their places.
pub(super) fn without_forces(laws: &Laws, omitted: &[Omission]) -> Laws {
    let mut laws = laws.clone();
    for one in omitted {
        match *one {
            Omission::JointForce(joint) => laws.joints[joint] = Spring::default(),
            Omission::Link(link) => laws.links[link] = Spring::default(),
            Omission::External(force) => laws.forces[force] = Support::default(),
            _ => {}
        }
    }
    laws
}
