//! The leg of a small humanoid robot.

use super::super::build::{BASE, ModelBuilder};
use super::super::{Asks, Model, Nature};
use super::{MOTION, R1, R2, R3, T1, T3, principal};

/// A swinging leg: a pelvis that walks as prescribed (forwards and up), a hip
/// of three joints, a knee, an ankle of two and toes. The lengths and masses
/// are those of a robot of 0.95 m.
pub fn leg() -> Model {
    let mut builder = ModelBuilder::new("leg");
    let pelvis = builder.body("Pelvis", BASE.origin(), &[T1, T3]);
    builder.mass(pelvis, 2.8, [0.0; 3], principal(0.02, 0.012, 0.02));
    for joint in 0..2 {
        builder.joint(pelvis, joint).nature = Nature::Driven;
    }
    builder.joint(pelvis, 1).initial[0] = 0.53;
    let hip = builder.point(pelvis, "Hip", [0.0, 0.07, -0.03]);
    let thigh = builder.body("Thigh", hip, &[R2, R1, R3]);
    builder.mass(
        thigh,
        3.1,
        [0.01, 0.015, -0.1],
        principal(0.018, 0.017, 0.005),
    );
    builder.joint(thigh, 0).initial[0] = -0.3;
    let knee = builder.point(thigh, "Knee", [0.0, 0.0, -0.226]);
    let shank = builder.body("Shank", knee, &[R2]);
    builder.mass(
        shank,
        1.6,
        [0.005, 0.003, -0.09],
        principal(0.009, 0.009, 0.002),
    );
    builder.joint(shank, 0).initial[0] = 0.6;
    let ankle = builder.point(shank, "Ankle", [0.0, 0.0, -0.201]);
    let foot = builder.body("Foot", ankle, &[R2, R1]);
    builder.mass(
        foot,
        0.75,
        [0.02, 0.0, -0.04],
        principal(0.0015, 0.002, 0.0018),
    );
    builder.joint(foot, 0).initial[0] = -0.3;
    let ball = builder.point(foot, "Ball", [0.09, 0.0, -0.06]);
    let toes = builder.body("Toes", ball, &[R2]);
    builder.mass(
        toes,
        0.12,
        [0.02, 0.0, 0.0],
        principal(0.0001, 0.0001, 0.00015),
    );
    let sole = builder.point(foot, "Sole", [0.0, 0.0, -0.07]);
    let all = Asks {
        acceleration: true,
        angular_acceleration: true,
        jacobian: true,
        ..MOTION
    };
    builder.force("Ground", sole, MOTION);
    builder.sensor("Sole", sole, all);
    builder.finish()
}
