//! Laws of forces and driven motions, as a user gives them beside a model.
//!
//! A model contains no forces: loads and driven motions are in a TOML file.
//!
//! ```toml
//! [[joint]]
//! name = "knee"        # or "*": every joint without an entry; in
//!                      # place of damping and friction that a robot's file has
//! stiffness = 200.0    # N/m or N m/rad
//! damping = 2.0        # N s/m or N m s/rad
//! neutral = 0.1        # where the spring is slack; default: initial position
//! force = 0.0          # constant, N or N m
//! friction = 0.0       # dry friction, N or N m, turned over at velocities
//! slip = 0.01          # around this one, m/s or rad/s; links alike
//!
//! [[link]]
//! name = "strut"       # or "*"
//! stiffness = 2e4
//! damping = 1e3
//! neutral = 0.35       # free length, m; default: initial length
//! force = 0.0          # constant pull, N
//!
//! [[force]]
//! name = "tyre"        # an external force of the model, or "*"; all along the
//! force = [0, 0, 3e3]  # axes of the base: constant, N
//! torque = [0, 0, 0]   # constant, N m
//! stiffness = [0, 0, 2e5]  # against the way from the initial place, N/m
//! damping = [0, 0, 5e2]    # against the velocity, N s/m
//! place = [1.2, 0, 0.3]    # where the springs hold it; default: initial place
//! amplitude = [0, 0, 0.01] # that place moves: amplitude sin(frequency t + phase), m
//! frequency = 6.28         # rad/s
//! phase = 0.0              # rad
//!
//! [[contact]]
//! name = "tyre"        # the point of an external force, or "*", and a plane:
//! place = [0, 0, 0]    # a point of it, m
//! normal = [0, 0, 1]   # out of the ground, of any length
//! stiffness = 2e5      # against the way into the ground, N/m
//! damping = 5e2        # against the velocity there, N s/m; it never pulls
//! friction = 0.7       # share of the pressure that acts against slip
//! slip = 0.01          # velocity around which friction turns over, m/s
//!
//! [[tyre]]
//! name = "tyre"        # the point of an external force is a wheel's centre
//! place = [0, 0, 0]    # a point of the ground, m, and its normal
//! normal = [0, 0, 1]
//! radius = 0.3         # of the wheel, m
//! axis = [0, 1, 0]     # of the wheel, in the frame of its body
//! stiffness = 2e5      # against the way into the ground, N/m
//! damping = 3e2        # against the velocity there, N s/m; it never pulls
//! law = "linear"       # force = number times slip, up to friction
//! longitudinal = 8e4   # N
//! lateral = 6e4        # N
//! friction = 0.9       # share of the pressure
//! slip = 0.1           # velocity below which slip is regularised, m/s
//! # law = "bakker"     # the magic formula
//! # longitudinal = { B = 12, C = 1.65, D = 1.0, E = 0.3 }
//! # lateral = { B = 10, C = 1.3, D = 0.9, E = -1 }
//!
//! [[event]]
//! name = "knee"        # a joint, or an external force with a contact or tyre
//! quantity = "position"    # "velocity", or "gap" of the contact
//! value = 0.0          # that it passes
//! direction = "both"   # "rising" or "falling"
//! stop = false         # true: the run ends there
//!
//! [[driven]]
//! name = "steering"    # position = offset + amplitude sin(frequency t + phase)
//! offset = 0.0         # default: initial position
//! amplitude = 0.05
//! frequency = 6.28     # rad/s
//! phase = 0.0          # rad
//! ```

use super::contact::{Contact, GroundForce, friction_share, turning_velocity};
use super::events::EventLaw;
use super::tyre::Tyre;
use super::varied::{PointMotion, Varied};
use robovec_model::Model;
use robovec_num::limits::NumberLimit;
use serde::{Deserialize, Serialize};

/// Numbers of laws, in SI units.
pub(super) const LAW: NumberLimit = NumberLimit::real(
    -1e15,
    1e15,
    "binary64 has no digits left for such stiff motions",
);

/// Amounts of friction: it takes energy and gives none.
const FRICTION: NumberLimit = NumberLimit::real(
    0.0,
    1e15,
    "binary64 has no digits left for such stiff motions, and friction gives no energy",
);
/// Velocities around which friction turns over.
const SLIP: NumberLimit = NumberLimit::real(
    1e-9,
    1e6,
    "friction that changes sign faster is a jump for an integrator",
);

const RADIUS: NumberLimit = NumberLimit::real(1e-6, 1e6, "a wheel has a rim, and rolls");
/// Shape factors of the magic formula.
const SHAPE: NumberLimit = NumberLimit::real(
    0.0,
    2.0,
    "the force of a larger one acts along with great slip and gives energy",
);
/// Curvature factors of the magic formula.
const CURVATURE: NumberLimit = NumberLimit::real(
    -1e6,
    1.0,
    "the force of a larger one acts along with great slip and gives energy",
);

/// The limits of the numbers of laws: name, limit, and the default.
pub const FIELDS: &[(&str, NumberLimit, &str)] = &[
    ("stiffness", LAW, "0"),
    ("damping", LAW, "0"),
    ("neutral", LAW, "initial"),
    ("force", LAW, "0"),
    ("friction", FRICTION, "0"),
    ("slip", SLIP, "0.01; of a tyre 0.1"),
    ("radius", RADIUS, ""),
    ("axis", LAW, "[0, 1, 0]"),
    ("longitudinal", FRICTION, ""),
    ("lateral", FRICTION, ""),
    ("B", FRICTION, ""),
    ("C", SHAPE, ""),
    ("D", FRICTION, ""),
    ("E", CURVATURE, "0"),
    ("normal", LAW, "[0, 0, 1]"),
    ("value", LAW, "0"),
    ("torque", LAW, "0"),
    ("place", LAW, "initial"),
    ("offset", LAW, "initial"),
    ("amplitude", LAW, "0"),
    ("frequency", LAW, "0"),
    ("phase", LAW, "0"),
];

/// A linear spring and damper with a constant force. On a joint it acts
/// against displacement and velocity; on a link it pulls the ends together.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Spring {
    /// Force per displacement.
    pub stiffness: f64,
    /// Force per velocity.
    pub damping: f64,
    /// Position or length without force of the spring; `None`: the initial one.
    pub neutral: Option<f64>,
    /// A constant force: in the direction of the joint, or as a pull.
    pub force: f64,
    /// Dry friction: its largest force.
    pub friction: f64,
    /// The velocity around which friction turns over; `None`:
    /// [`SLIP_VELOCITY`](super::contact::SLIP_VELOCITY).
    pub slip: Option<f64>,
}

/// An external force on a point, along the axes of the base: constant, and
/// springs and dampers between the point and a place, at rest or moving.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Support {
    /// Support force, N.
    pub force: [f64; 3],
    /// Support torque, N m.
    pub torque: [f64; 3],
    /// Force per displacement, N/m.
    pub stiffness: [f64; 3],
    /// Force per velocity, N s/m.
    pub damping: [f64; 3],
    /// Position at which springs hold the point, m; `None`: the initial one.
    pub place: Option<[f64; 3]>,
    /// Amplitude of the place's motion to each side, m: a road, rail or shaker.
    pub amplitude: [f64; 3],
    /// The angular frequency of its motion, rad/s.
    pub frequency: f64,
    /// Its phase, rad.
    pub phase: f64,
    /// Of the point with a plane; its own section in a file.
    #[serde(skip)]
    pub contact: Contact,
    /// Of a wheel whose centre the point is; its own section in a file.
    #[serde(skip)]
    pub tyre: Option<Tyre>,
}

impl Spring {
    /// True where it can give a force.
    pub fn acts(&self) -> bool {
        let parts = [self.stiffness, self.damping, self.force, self.friction];
        parts.iter().any(|&part| part != 0.0)
    }

    /// Position, or length, without force of a spring that starts somewhere.
    pub(super) fn neutral_or(&self, start: f64) -> f64 {
        self.neutral.unwrap_or(start)
    }

    /// The derivative of the dry friction by the velocity.
    pub fn dry_slope(&self, velocity: f64) -> f64 {
        let slip = turning_velocity(self.slip);
        let speed = velocity.hypot(slip);
        self.friction * (slip / speed) * (slip / speed) / speed
    }

    /// The dry friction at a velocity, against it.
    pub fn dry(&self, velocity: f64) -> f64 {
        self.friction * friction_share(velocity, self.slip)
    }
}

impl Support {
    /// True where it can give a force or a torque.
    pub fn acts(&self) -> bool {
        let parts = [self.force, self.torque, self.stiffness, self.damping];
        self.meets_ground() || parts.concat().iter().any(|&number| number != 0.0)
    }

    /// True where a contact or a tyre can give a force.
    pub(crate) fn meets_ground(&self) -> bool {
        self.contact.acts() || self.tyre.is_some()
    }

    /// Height of the point, or lowest point of a wheel, m, and its rate, m/s.
    pub(super) fn gap(&self, motion: &PointMotion<Varied>) -> [Varied; 2] {
        match &self.tyre {
            Some(tyre) => tyre.gap(motion),
            None => self.contact.gap(motion.place, motion.velocity),
        }
    }

    /// Force of contact or tyre.
    pub(super) fn ground_force(&self, motion: &PointMotion<Varied>) -> GroundForce {
        match &self.tyre {
            Some(tyre) => tyre.force(motion),
            None => self.contact.force(motion.place, motion.velocity),
        }
    }

    /// The energy in the spring of contact or tyre, J.
    pub(super) fn ground_energy(&self, motion: &PointMotion) -> f64 {
        let contact = self
            .tyre
            .as_ref()
            .map_or(&self.contact, |tyre| &tyre.contact);
        let [gap, _] = self.gap(&motion.fixed());
        contact.energy(gap)
    }

    /// Distance of the place from its mean at a time, m, and its velocity, m/s.
    pub fn ground(&self, time: f64) -> [[f64; 3]; 2] {
        let (sine, cosine) = (self.frequency * time + self.phase).sin_cos();
        let rate = self.frequency * cosine;
        [
            self.amplitude.map(|length| length * sine),
            self.amplitude.map(|length| length * rate),
        ]
    }
}

/// The motion of a driven joint.
#[derive(Clone, Copy, PartialEq, Default, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drive {
    /// Mean position; `None`: the initial one.
    pub offset: Option<f64>,
    /// Amplitude.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub frequency: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Drive {
    /// Position, velocity and acceleration at a time, around the initial one.
    pub fn at(&self, time: f64, initial: f64) -> [f64; 3] {
        let (sine, cosine) = (self.frequency * time + self.phase).sin_cos();
        let (a, w) = (self.amplitude, self.frequency);
        [
            self.offset.unwrap_or(initial) + a * sine,
            a * w * cosine,
            -a * w * w * sine,
        ]
    }
}

/// The laws of a model's joints and links.
#[derive(Clone, PartialEq, Debug)]
pub struct Laws {
    /// One for each joint.
    pub joints: Vec<Spring>,
    /// One for each link.
    pub links: Vec<Spring>,
    /// One for each external force.
    pub forces: Vec<Support>,
    /// One for each joint; only those of driven joints count.
    pub drives: Vec<Drive>,
    /// Events that a run watches for.
    pub events: Vec<EventLaw>,
}

impl Laws {
    /// Laws of the model itself: the losses of its joints, and driven joints at
    /// rest. An entry of a file for a joint replaces its losses.
    pub fn of_model(model: &Model) -> Laws {
        let losses = model.joints.iter().map(|joint| Spring {
            damping: joint.law.damping,
            friction: joint.law.friction,
            stiffness: joint.law.stiffness,
            neutral: Some(joint.law.neutral),
            ..Spring::default()
        });
        Laws {
            joints: losses.collect(),
            links: vec![Spring::default(); model.links.len()],
            forces: vec![Support::default(); model.forces.len()],
            drives: vec![Drive::default(); model.joints.len()],
            events: Vec::new(),
        }
    }

    /// The laws with all moved places and joints fixed at their means.
    pub fn at_rest(mut self) -> Laws {
        for law in &mut self.forces {
            law.amplitude = [0.0; 3];
        }
        for law in &mut self.drives {
            law.amplitude = 0.0;
        }
        self
    }
}
