//! Contact of a point with a plane: a spring and a damper that push and never
//! pull, and dry friction along the plane.

use super::energy::{CartesianVector, dot};
use serde::Deserialize;

/// The velocity around which friction turns over when a law does not specify it, m/s
/// or rad/s.
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
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
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
    /// The velocity around which friction turns over, m/s; `None`:
    /// [`SLIP_VELOCITY`].
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

/// Force of a contact on its point.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(super) struct ContactForce {
    /// On the point, along the axes of the base, N.
    pub(super) force: CartesianVector,
    /// The part of it that its spring keeps and gives back, N.
    pub(super) spring: CartesianVector,
}

impl Contact {
    /// True where it can give a force.
    pub fn acts(&self) -> bool {
        self.stiffness != 0.0 || self.damping != 0.0
    }

    /// The normal of length one.
    fn direction(&self) -> CartesianVector {
        // Scaled first, so that no square leaves the range.
        let most = self.normal.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let scaled = self.normal.map(|x| x / most);
        let length = dot(scaled, scaled).sqrt();
        scaled.map(|x| x / length)
    }

    /// Height of a point above the plane, m, and its rate, m/s.
    pub fn gap(&self, place: [f64; 3], velocity: [f64; 3]) -> [f64; 2] {
        let normal = self.direction();
        let arm: CartesianVector = std::array::from_fn(|k| place[k] - self.place[k]);
        [dot(normal, arm), dot(normal, velocity)]
    }

    /// The energy of the spring, J.
    pub(super) fn energy(&self, place: CartesianVector) -> f64 {
        let [gap, _] = self.gap(place, [0.0; 3]);
        let way = (-gap).max(0.0);
        0.5 * self.stiffness * way * way
    }

    /// The derivative of the force on a point along a direction of its place
    /// and its velocity. Where the point just touches, that of being in the air.
    pub(super) fn force_along(
        &self,
        [place, velocity]: [CartesianVector; 2],
        [place_slope, velocity_slope]: [CartesianVector; 2],
    ) -> CartesianVector {
        let [gap, rate] = self.gap(place, velocity);
        let normal = self.direction();
        let (gap_slope, rate_slope) = (dot(normal, place_slope), dot(normal, velocity_slope));
        let pressure = -self.stiffness * gap - self.damping * rate;
        if gap >= 0.0 || pressure <= 0.0 {
            return [0.0; 3];
        }
        let slope = -self.stiffness * gap_slope - self.damping * rate_slope;
        let slip: CartesianVector = std::array::from_fn(|k| velocity[k] - rate * normal[k]);
        let moved: CartesianVector =
            std::array::from_fn(|k| velocity_slope[k] - rate_slope * normal[k]);
        let around = turning_velocity(self.slip);
        let speed = dot(slip, slip).sqrt().hypot(around);
        std::array::from_fn(|k| {
            let turned = moved[k] - slip[k] * dot(slip, moved) / (speed * speed);
            let along = (slope * slip[k] + pressure * turned) / speed;
            slope * normal[k] - self.friction * along
        })
    }

    /// The force on a point.
    pub(super) fn force(&self, place: CartesianVector, velocity: CartesianVector) -> ContactForce {
        let [gap, rate] = self.gap(place, velocity);
        if gap >= 0.0 {
            return ContactForce::default();
        }
        let spring = -self.stiffness * gap;
        let pressure = (spring - self.damping * rate).max(0.0);
        let normal = self.direction();
        let slip: CartesianVector = std::array::from_fn(|k| velocity[k] - rate * normal[k]);
        let speed = dot(slip, slip).sqrt();
        let share = self.friction * pressure * friction_share(speed, self.slip);
        let along = |k: usize| {
            if speed > 0.0 {
                share * slip[k] / speed
            } else {
                0.0
            }
        };
        ContactForce {
            force: std::array::from_fn(|k| pressure * normal[k] - along(k)),
            spring: normal.map(|part| spring * part),
        }
    }
}
