//! Tyre of a wheel on a plane: the spring and damper of a contact at the lowest
//! point of the wheel, and a force against the slip of that point.
//!
//! The axis of the wheel and the normal of the plane give the directions along
//! and across: `t = a x n / |a x n|` and `l = n x t`. With the velocity `w` of
//! the material point at the ground and the velocity of rolling `v = t.w + r
//! (a.spin)`, the slips are `-t.w / V` and `-l.w / V` with `V = sqrt(v^2 +
//! slip^2)`: from standstill on slip is finite; a damper holds a wheel.
//!
//! The law `bakker` is the magic formula of Bakker, Nyborg and Pacejka (*Tyre
//! modelling for use in vehicle dynamics studies*, SAE 870421, 1987). Both
//! slips at once follow the similarity method (Pacejka, *Tyre and vehicle
//! dynamics*, chapter 4), with slips normalised by the slopes of their curves:
//! `s_x = B C k` of the one along, `s_y` of the one across, `s` their length;
//! each curve is read where its normalised slip is `s`, and gives the share
//! `s_x / s` or `s_y / s` of its force. Either slip alone gives its curve, and
//! forces stay in the ellipse of the two `D`.

use super::contact::{Contact, GroundForce, direction};
use super::varied::{PointMotion, Varied, VariedVector, inner, outer};
use robovec_model::Model;
use serde::{Deserialize, Serialize};
use std::array::from_fn;

/// Default velocity of rolling below which slip is regularised, m/s.
pub const ROLLING_VELOCITY: f64 = 0.1;

/// Smallest sine of the angle between axis and normal of a rolling wheel.
pub(super) const FLAT: f64 = 1e-6;

/// Tyre of a wheel whose centre is the point of an external force.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(try_from = "super::tyre_entry::TyreEntry")]
pub struct Tyre {
    /// The contact of its lowest point, without friction.
    pub contact: Contact,
    /// Radius of the wheel, m.
    pub radius: f64,
    /// Axis of the wheel in the frame of its body, of any length but zero.
    pub axis: [f64; 3],
    /// Force against slip.
    pub law: SlipLaw,
    /// Velocity below which slip is regularised, m/s ([`ROLLING_VELOCITY`]).
    pub slip: Option<f64>,
}

/// Force of a tyre against slip.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SlipLaw {
    /// In proportion to slip, up to friction.
    Linear {
        /// Largest force, as a share of the pressure.
        friction: f64,
        /// Force per slip along the wheel, N.
        longitudinal: f64,
        /// Force per slip across the wheel, N.
        lateral: f64,
    },
    /// The magic formula.
    Bakker {
        /// Curve of slip along the wheel.
        longitudinal: MagicFormula,
        /// Curve of slip across the wheel.
        lateral: MagicFormula,
    },
}

/// Coefficients of the magic formula `D sin(C atan(B k - E (B k - atan(B k))))`.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MagicFormula {
    /// Stiffness factor.
    #[serde(rename = "B")]
    pub stiffness: f64,
    /// Shape factor.
    #[serde(rename = "C")]
    pub shape: f64,
    /// Peak, as a share of the pressure.
    #[serde(rename = "D")]
    pub peak: f64,
    /// Curvature factor.
    #[serde(rename = "E", default)]
    pub curvature: f64,
}

impl MagicFormula {
    /// Normalised slip: the slope of the curve for a peak of one is one.
    fn normalised(&self, slip: Varied) -> Varied {
        slip * (self.stiffness * self.shape)
    }

    /// Force at a normalised slip, as a share of the pressure.
    fn share(&self, normalised: Varied) -> Varied {
        // A curve without slope or shape has no force, and B k is s / C.
        if self.stiffness == 0.0 || self.shape == 0.0 {
            return Varied::default();
        }
        let x = normalised * (1.0 / self.shape);
        let bent = x - (x - x.atan()) * self.curvature;
        (bent.atan() * self.shape).sin() * self.peak
    }
}

impl SlipLaw {
    /// The forces along and across the wheel, at the slips along and across, N.
    fn force(&self, slips: [Varied; 2], pressure: Varied) -> [Varied; 2] {
        match self {
            SlipLaw::Linear {
                friction,
                longitudinal,
                lateral,
            } => {
                let [along, across] = [slips[0] * *longitudinal, slips[1] * *lateral];
                let most = pressure * *friction;
                let size = along.value.hypot(across.value);
                if size <= most.value {
                    return [along, across];
                }
                let share = most / along.hypot(across);
                [along * share, across * share]
            }
            SlipLaw::Bakker {
                longitudinal,
                lateral,
            } => {
                let curves = [longitudinal, lateral];
                let [along, across] = [0, 1].map(|place| curves[place].normalised(slips[place]));
                if along.value == 0.0 && across.value == 0.0 {
                    // The limit, with its slope.
                    let peaks = curves.map(|curve| pressure * curve.peak);
                    return [peaks[0] * along, peaks[1] * across];
                }
                let size = along.hypot(across);
                let of = |curve: &MagicFormula, part: Varied| {
                    curve.share(size) * (part / size) * pressure
                };
                [of(longitudinal, along), of(lateral, across)]
            }
        }
    }
}

/// Place of a tyre at the ground.
struct Footprint {
    /// From the centre of the wheel.
    arm: VariedVector,
    /// Height of the lowest point above the plane and its rate.
    gap: [Varied; 2],
    velocity: VariedVector,
    axis: VariedVector,
    /// The direction in which the wheel rolls; `None` for one that lies flat.
    heading: Option<VariedVector>,
}

impl Tyre {
    /// True when the last joint of the body of an external force turns it about
    /// the axis. A wheel on another body slides as if it were locked.
    pub fn turns(&self, model: &Model, force: usize) -> bool {
        let body = model.points[model.forces[force].point].body;
        let joint = model.last_joint(body).map(|joint| &model.joints[joint]);
        let axis = direction(self.axis);
        joint.is_some_and(|joint| {
            joint.kind.is_revolute() && axis[joint.kind.axis().index()].abs() > 0.99
        })
    }

    /// The axis of the wheel along the axes of the base.
    fn spin_axis(&self, motion: &PointMotion<Varied>) -> VariedVector {
        let axis = direction(self.axis);
        from_fn(|k| {
            motion.axes[0][k] * axis[0] + motion.axes[1][k] * axis[1] + motion.axes[2][k] * axis[2]
        })
    }

    /// True when the wheel lies on the plane and has no direction.
    pub(super) fn lies_flat(&self, motion: &PointMotion) -> bool {
        self.footprint(&motion.fixed()).heading.is_none()
    }

    /// The rim's point nearest to the ground, as a point of the body.
    fn footprint(&self, motion: &PointMotion<Varied>) -> Footprint {
        let normal = self.contact.unit_normal();
        let axis = self.spin_axis(motion);
        let forward = outer(axis, normal);
        let square = inner(forward, forward);
        let upright = (square.value > FLAT * FLAT).then(|| square.sqrt());
        let along = inner(normal, axis);
        let arm = match upright {
            Some(sine) => from_fn(|k| (normal[k] - along * axis[k]) / sine * -self.radius),
            None => VariedVector::default(),
        };
        let carried = outer(motion.spin, arm);
        let velocity = from_fn(|k| motion.velocity[k] + carried[k]);
        let place = from_fn(|k| motion.place[k] + arm[k]);
        Footprint {
            arm,
            gap: self.contact.gap(place, velocity),
            velocity,
            axis,
            heading: upright.map(|sine| forward.map(|part| part / sine)),
        }
    }

    /// Height of the lowest point above the plane, m, and its rate, m/s.
    pub(super) fn gap(&self, motion: &PointMotion<Varied>) -> [Varied; 2] {
        self.footprint(motion).gap
    }

    pub(super) fn force(&self, motion: &PointMotion<Varied>) -> GroundForce {
        let print = self.footprint(motion);
        let Some(pressure) = self.contact.pressure(print.gap) else {
            return GroundForce::default();
        };
        let normal = self.contact.unit_normal();
        let mut force = normal.map(|part| part * pressure.size);
        let mut power = pressure.power;
        if let Some(heading) = print.heading {
            let directions = [heading, outer(normal, heading)];
            let slipping = directions.map(|direction| inner(direction, print.velocity));
            let rolling = slipping[0] + inner(print.axis, motion.spin) * self.radius;
            let slowest = self.slip.unwrap_or(ROLLING_VELOCITY);
            let rolling = rolling.hypot(Varied::fixed(slowest));
            let slips = slipping.map(|velocity| -velocity / rolling);
            let against = self.law.force(slips, pressure.size);
            for (direction, part) in directions.iter().zip(against) {
                for (sum, component) in force.iter_mut().zip(direction) {
                    *sum = *sum + *component * part;
                }
            }
            power += against[0].value * slipping[0].value + against[1].value * slipping[1].value;
        }
        GroundForce {
            force,
            torque: outer(print.arm, force),
            power,
        }
    }
}

#[cfg(test)]
#[path = "tyre_tests.rs"]
mod tests;
