//! Contact of a point with a plane: a pushing spring and damper, and friction.

use super::energy::{CartesianVector, dot};
use super::varied::{Varied, VariedVector, inner};
use serde::{Deserialize, Serialize};
use std::array::from_fn;

/// Velocity around which friction turns over by default, m/s or rad/s.
pub const SLIP_VELOCITY: f64 = 0.01;

/// The share of dry friction that acts at a velocity: with its sign, smooth,
/// and 0.7 at `slip`. At rest it lets a load creep instead of holding it.
pub fn friction_share(velocity: f64, slip: Option<f64>) -> f64 {
    velocity / velocity.hypot(turning_velocity(slip))
}

/// The velocity around which friction turns over.
pub(super) fn turning_velocity(slip: Option<f64>) -> f64 {
    slip.unwrap_or(SLIP_VELOCITY)
}

/// Contact of the point of an external force with a plane.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// A point of the plane, m.
    pub place: [f64; 3],
    /// Out of the ground, of any length but zero.
    pub normal: [f64; 3],
    /// Force per way into the ground, N/m.
    pub stiffness: f64,
    /// Force per velocity there, N s/m.
    pub damping: f64,
    /// The share of the pressure that acts against slip.
    pub friction: f64,
    /// Velocity around which friction turns over, m/s; else [`SLIP_VELOCITY`].
    pub slip: Option<f64>,
}

impl Default for Contact {
    fn default() -> Contact {
        Contact {
            place: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            stiffness: 0.0,
            damping: 0.0,
            friction: 0.0,
            slip: None,
        }
    }
}

/// Force of the ground on a body.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(super) struct GroundForce {
    /// Along the axes of the base, N.
    pub(super) force: VariedVector,
    /// About the point of the external force, N m.
    pub(super) torque: VariedVector,
    /// The power of what its spring does not keep and give back, W.
    pub(super) power: f64,
}

/// Force of a contact along its normal.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ContactPressure {
    /// Size of the force, N.
    pub(super) size: Varied,
    /// The power of its damper, W.
    pub(super) power: f64,
}

/// A vector of length one in the direction of another.
pub(super) fn direction(vector: CartesianVector) -> CartesianVector {
    // Scaled first, so that no square leaves the range.
    let most = vector.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let scaled = vector.map(|x| x / most);
    let length = dot(scaled, scaled).sqrt();
    scaled.map(|x| x / length)
}

impl Contact {
    /// True where it can give a force.
    pub fn acts(&self) -> bool {
        self.stiffness != 0.0 || self.damping != 0.0
    }

    /// Height of a point above the plane, m, and its rate, m/s.
    pub(super) fn gap(&self, place: VariedVector, velocity: VariedVector) -> [Varied; 2] {
        let normal = self.unit_normal();
        let arm = from_fn(|k| place[k] - Varied::fixed(self.place[k]));
        [inner(normal, arm), inner(normal, velocity)]
    }

    /// The normal of length one.
    pub(super) fn unit_normal(&self) -> VariedVector {
        direction(self.normal).map(Varied::fixed)
    }

    /// The energy of the spring at a height above the plane, J.
    pub(super) fn energy(&self, gap: Varied) -> f64 {
        let way = (-gap.value).max(0.0);
        0.5 * self.stiffness * way * way
    }

    /// Force along the normal; `None` in the air, also where it just touches.
    pub(super) fn pressure(&self, [gap, rate]: [Varied; 2]) -> Option<ContactPressure> {
        if gap.value >= 0.0 {
            return None;
        }
        let spring = gap * -self.stiffness;
        let pushed = spring - rate * self.damping;
        let size = if pushed.value > 0.0 {
            pushed
        } else {
            Varied::default()
        };
        Some(ContactPressure {
            size,
            power: (size.value - spring.value) * rate.value,
        })
    }

    pub(super) fn force(&self, place: VariedVector, velocity: VariedVector) -> GroundForce {
        let [gap, rate] = self.gap(place, velocity);
        let Some(pressure) = self.pressure([gap, rate]) else {
            return GroundForce::default();
        };
        let normal = self.unit_normal();
        let slip: VariedVector = from_fn(|k| velocity[k] - rate * normal[k]);
        let around = Varied::fixed(turning_velocity(self.slip));
        let square = inner(slip, slip);
        let speed = (square + around * around).sqrt();
        let share = pressure.size * self.friction / speed;
        GroundForce {
            force: from_fn(|k| pressure.size * normal[k] - share * slip[k]),
            torque: VariedVector::default(),
            power: pressure.power - share.value * square.value,
        }
    }
}
