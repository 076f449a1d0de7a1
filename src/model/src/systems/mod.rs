//! Models of machines that exist: the study's bogie and train, and small
//! closed mechanisms.
//!
//! All numbers are ours, of the size that such machines have; every parameter
//! is written with its meaning where it is given.

mod bogie;
mod car;
mod leg;
mod small;
mod train;
mod wishbone_car;

pub use bogie::bogie;
pub use car::car;
pub use leg::leg;
pub use small::{double_pendulum, four_bar, quarter_car, slider_crank};
pub use train::train;
pub use wishbone_car::wishbone_car;

use super::{Asks, Axis, JointKind};

/// The translation along an axis.
const T1: JointKind = JointKind::Prismatic(Axis::X);
const T2: JointKind = JointKind::Prismatic(Axis::Y);
const T3: JointKind = JointKind::Prismatic(Axis::Z);
/// The rotation about an axis.
const R1: JointKind = JointKind::Revolute(Axis::X);
const R2: JointKind = JointKind::Revolute(Axis::Y);
const R3: JointKind = JointKind::Revolute(Axis::Z);

/// A rigid body free in space: along the track, across, up; yaw, roll, pitch.
const FREE: [JointKind; 6] = [T1, T2, T3, R3, R1, R2];

/// What a contact law needs.
const MOTION: Asks = Asks {
    position: true,
    rotation: true,
    velocity: true,
    angular_velocity: true,
    acceleration: false,
    angular_acceleration: false,
    jacobian: false,
};

/// What an accelerometer with a gyroscope needs.
const RIDE: Asks = Asks {
    acceleration: true,
    angular_acceleration: true,
    ..MOTION
};

/// The principal moments of a body, as an inertia.
const fn principal(xx: f64, yy: f64, zz: f64) -> [f64; 6] {
    [xx, 0.0, 0.0, yy, 0.0, zz]
}

#[cfg(test)]
mod tests;
