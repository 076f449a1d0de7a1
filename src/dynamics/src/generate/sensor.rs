//! Sensors: position, rotation (the axes of the body as rows), velocities,
//! accelerations and Jacobian of a point, all in the base frame.

use super::Options;
use super::algebra::Scalar;
use super::chain::{Chain, ChainMotion};
use super::equations::Equations;
use super::parameters::{ModelParameters, ParameterSource};
use super::vector::{Vector, ZERO};
use robovec_model::{Asks, Model, Sensor};

pub(super) struct SensorNames {
    position: String,
    rotation: String,
    velocity: String,
    angular_velocity: String,
    acceleration: String,
    angular_acceleration: String,
    jacobian: String,
}

impl SensorNames {
    fn new(name: impl Fn(&str) -> String) -> SensorNames {
        SensorNames {
            position: name("P"),
            rotation: name("R"),
            velocity: name("V"),
            angular_velocity: name("OM"),
            acceleration: name("A"),
            angular_acceleration: name("OMP"),
            jacobian: name("J"),
        }
    }

    /// The fields of Robotran's structure of sensors.
    pub(super) fn of_sensor() -> SensorNames {
        SensorNames::new(|field| format!("sens.{field}"))
    }

    /// The arguments of the user's law of an external force.
    pub(super) fn of_force(number: usize) -> SensorNames {
        SensorNames::new(|field| format!("{field}xF{number}"))
    }
}

/// Everything that can be requested.
pub(super) const ALL: Asks = Asks {
    position: true,
    rotation: true,
    velocity: true,
    angular_velocity: true,
    acceleration: true,
    angular_acceleration: true,
    jacobian: true,
};

/// Joint accelerations, if the model has symbols for them.
pub(super) fn accelerations(equations: &mut Equations, model: &Model) -> Vec<Scalar> {
    let joints = model.joints.iter().enumerate();
    joints
        .map(|(index, joint)| {
            if joint.has_acceleration {
                equations.input("qdd", &[index + 1])
            } else {
                Scalar::ZERO
            }
        })
        .collect()
}

/// The chain from the base to a sensor's point.
pub(super) fn chain(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    names: (&'static str, usize),
    sensor: &Sensor,
) -> Chain {
    let model = parameters.model;
    let last = model.last_joint(model.points[sensor.point].body);
    let path = parameters.path(last);
    let place = ParameterSource { options, equations }.point(model, sensor.point);
    Chain::new(equations, parameters, names, &path, &place)
}

/// Writes one sensor (from 0); points of external forces follow sensors.
pub(super) fn sensor(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    options: &Options,
    number: usize,
) {
    let model = parameters.model;
    let Some(sensor) = model.sensors.iter().chain(&model.forces).nth(number) else {
        return;
    };
    let chain = chain(equations, parameters, options, ("cp", number + 1), sensor);
    let names = SensorNames::of_sensor();
    outputs(equations, parameters, &chain, sensor.asks, &names);
}

/// Writes the motion of the frame of one joint (number from 0).
pub(super) fn frame(equations: &mut Equations, parameters: &ModelParameters<'_>, joint: usize) {
    let path = parameters.path(Some(joint));
    let chain = Chain::new(equations, parameters, ("cp", joint + 1), &path, &ZERO);
    outputs(
        equations,
        parameters,
        &chain,
        ALL,
        &SensorNames::of_sensor(),
    );
}

/// Sets the outputs that are requested.
pub(super) fn outputs(
    equations: &mut Equations,
    parameters: &ModelParameters<'_>,
    chain: &Chain,
    asks: Asks,
    names: &SensorNames,
) {
    let accelerations = accelerations(equations, parameters.model);
    let ChainMotion {
        velocity,
        angular_velocity,
        acceleration,
        angular_acceleration,
    } = chain.motion(equations, parameters, &accelerations);
    let vector = |asked: bool, name: &str, vector: &Vector, equations: &mut Equations| {
        for (k, &component) in vector.iter().enumerate().filter(|_| asked) {
            equations.output(name, &[k + 1], component);
        }
    };
    let position = chain.position(equations);
    vector(asks.position, &names.position, &position, equations);
    if asks.rotation {
        for (row, axis) in chain.axes().iter().enumerate() {
            for (column, &entry) in axis.iter().enumerate() {
                equations.output(&names.rotation, &[row + 1, column + 1], entry);
            }
        }
    }
    for (asked, name, value) in [
        (asks.velocity, &names.velocity, &velocity),
        (
            asks.angular_velocity,
            &names.angular_velocity,
            &angular_velocity,
        ),
        (asks.acceleration, &names.acceleration, &acceleration),
        (
            asks.angular_acceleration,
            &names.angular_acceleration,
            &angular_acceleration,
        ),
    ] {
        vector(asked, name, value, equations);
    }
    if asks.jacobian {
        for (joint, linear, angular) in chain.jacobian(equations, parameters) {
            for (row, &entry) in linear.iter().chain(&angular).enumerate() {
                if !entry.is_zero() {
                    equations.output(&names.jacobian, &[row + 1, joint + 1], entry);
                }
            }
        }
    }
}
