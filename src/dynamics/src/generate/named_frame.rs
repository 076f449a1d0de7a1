//! Frames by name: pose, motion and Jacobian of a link's frame, in base axes.
//!
//! | output | |
//! |---|---|
//! | `position` | of the origin, m |
//! | `rotation` | takes components in the frame to those in the base; its columns are the axes of the frame |
//! | `velocity`, `acceleration` | of the origin |
//! | `angular_velocity`, `angular_acceleration` | of the frame |
//! | `jacobian` | rows: velocity, angular velocity; columns: joints |
//! | `jacobian_rate` | its derivative by time |

use super::algebra::{Scalar, Sum};
use super::chain::Chain;
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::sensor;
use super::vector::{Vector, define_as};
use robovec_model::{Model, NamedFrame};

/// The name of the function of a frame (number from 0): `frame_` and the name of
/// the link, `_` for what a name of C cannot have.
pub(super) fn function_name(model: &Model, number: usize) -> String {
    let word = |frame: &NamedFrame| {
        let letters = frame.name.chars();
        let kept = letters.map(|letter| {
            if letter.is_ascii_alphanumeric() {
                letter
            } else {
                '_'
            }
        });
        format!("frame_{}", kept.collect::<String>())
    };
    let name = word(&model.frames[number]);
    match model.frames[..number]
        .iter()
        .filter(|frame| word(frame) == name)
        .count()
    {
        0 => name,
        others => format!("{name}__{}", others + 1),
    }
}

/// Writes one frame of the model (number from 0).
pub(super) fn write(equations: &mut Equations, parameters: &ModelParameters<'_>, number: usize) {
    let frame = &parameters.model.frames[number];
    let path = parameters.path(parameters.model.last_joint(frame.body));
    let place = frame.origin.map(|number| constant(equations, number));
    let chain = Chain::new(equations, parameters, ("cp", number + 1), &path, &place);
    let accelerations = sensor::accelerations(equations, parameters.model);
    let motion = chain.motion(equations, parameters, &accelerations);
    let rotation = rotation(equations, &chain, frame);
    let position = chain.position(equations);
    for (name, vector) in [
        ("position", &position),
        ("velocity", &motion.velocity),
        ("angular_velocity", &motion.angular_velocity),
        ("acceleration", &motion.acceleration),
        ("angular_acceleration", &motion.angular_acceleration),
    ] {
        for (row, &component) in vector.iter().enumerate() {
            equations.output(name, &[row + 1], component);
        }
    }
    for (column, axis) in rotation.iter().enumerate() {
        for (row, &entry) in axis.iter().enumerate() {
            equations.output("rotation", &[row + 1, column + 1], entry);
        }
    }
    let columns = [
        ("jacobian", chain.jacobian(equations, parameters)),
        ("jacobian_rate", chain.jacobian_rate(equations, parameters)),
    ];
    let joints = 0..parameters.model.joints.len();
    let first = joints
        .into_iter()
        .find(|&joint| !parameters.frames.is_constant(joint));
    for (name, columns) in columns {
        let mut is_declared = false;
        for (joint, linear, angular) in columns {
            for (row, &entry) in linear.iter().chain(&angular).enumerate() {
                if !entry.is_zero() {
                    equations.output(name, &[row + 1, joint + 1], entry);
                    is_declared = true;
                }
            }
        }
        // The array is there also for a frame that no joint moves.
        if let (false, Some(joint)) = (is_declared, first) {
            equations.output(name, &[1, joint + 1], Scalar::ZERO);
        }
    }
}

/// The axes of the frame in the base.
fn rotation(equations: &mut Equations, chain: &Chain, frame: &NamedFrame) -> [Vector; 3] {
    let axes = chain.axes();
    [0, 1, 2].map(|column| {
        let weights = [0, 1, 2].map(|k| constant(equations, frame.rotation[k][column]));
        let mut sums = [Sum::new(), Sum::new(), Sum::new()];
        for (row, sum) in sums.iter_mut().enumerate() {
            for (axis, &weight) in axes.iter().zip(&weights) {
                sum.add(&[axis[row], weight]);
            }
        }
        define_as(
            equations,
            |component| QuantityLabel::new("RF", component, column + 1),
            sums,
        )
    })
}

/// A number, without an equation where it is 0, 1 or -1.
fn constant(equations: &mut Equations, number: f64) -> Scalar {
    match number {
        0.0 => Scalar::ZERO,
        1.0 => Scalar::ONE,
        -1.0 => -Scalar::ONE,
        _ => equations.number(number),
    }
}
