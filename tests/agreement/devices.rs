//! Sensors, links and external forces.

use super::{Case, Outputs, PLAIN, each, requests};
use crate::reference::forces::{add_external, add_links, link_lengths};
use crate::reference::kinematics::{Point, anchor, frames, point};
use crate::reference::random::Recipe;
use crate::reference::spatial::zeros;
use robovec::model::{Anchor, Model};
use robovec::robotran::FunctionKind;
use robovec_num::double_double::Double;

const DEVICES: Recipe = Recipe {
    bodies: 2,
    devices: 3,
    ..PLAIN
};

/// The motion of a point of the model.
fn of_point(case: &Case, number: usize) -> Point<Double> {
    let (tree, state) = case.exact();
    let place = Anchor {
        body: case.model.points[number].body,
        point: Some(number),
    };
    let (joint, place) = anchor(&case.model, &place);
    point(&tree, &frames(&tree, &state, zeros()), joint, place)
}

/// Compares the arrays of a sensor, whose names have a prefix and a suffix;
/// only sensors have a Jacobian.
fn compare(
    case: &Case,
    outputs: &Outputs,
    names: (&str, &str),
    jacobian: bool,
    expected: &Point<Double>,
) {
    let arrays: [(&str, Vec<Double>); 7] = [
        ("P", expected.position.to_vec()),
        ("R", expected.rotation.concat()),
        ("V", expected.velocity.to_vec()),
        ("OM", expected.angular_velocity.to_vec()),
        ("A", expected.acceleration.to_vec()),
        ("OMP", expected.angular_acceleration.to_vec()),
        ("J", expected.jacobian.concat()),
    ];
    for (name, expected) in arrays {
        if name == "J" && !jacobian {
            continue;
        }
        let name = format!("{}{name}{}", names.0, names.1);
        let none = vec![0.0; expected.len()];
        case.compare(&name, outputs.array(&name).unwrap_or(&none), &expected);
    }
}

#[test]
fn sensors_agree_with_the_motion_of_their_points() {
    each(DEVICES, |case| {
        // The points of external forces count behind the sensors.
        let sensors = case.model.sensors.iter().chain(&case.model.forces);
        let points = sensors.map(|sensor| of_point(case, sensor.point));
        let points: Vec<Point<Double>> = points.collect();
        for request in requests(FunctionKind::Sensor) {
            let module = case.generate(&request);
            for (index, expected) in points.iter().enumerate() {
                let name = format!("sensor_{}", index + 1);
                let outputs = Outputs::of(case, &module, &name, &case.inputs());
                let jacobian = index < case.model.sensors.len();
                compare(case, &outputs, ("sens.", ""), jacobian, expected);
            }
        }
    });
}

#[test]
fn frames_agree_with_their_motion() {
    each(DEVICES, |case| {
        let (tree, state) = case.exact();
        let frames = frames(&tree, &state, zeros());
        let origin = |joint| point(&tree, &frames, Some(joint), zeros());
        let origins: Vec<Point<Double>> = (0..frames.len()).map(origin).collect();
        for request in requests(FunctionKind::Gensensor) {
            let module = case.generate(&request);
            for (joint, expected) in origins.iter().enumerate() {
                let name = format!("gensensor_{}", joint + 1);
                let outputs = Outputs::of(case, &module, &name, &case.inputs());
                compare(case, &outputs, ("sens.", ""), false, expected);
            }
        }
    });
}

/// The forces and torques that a function sets, by component and joint;
/// components that it does not set are unchanged.
fn loads(case: &Case, outputs: &Outputs, name: &str, before: &[[f64; 3]]) -> Vec<f64> {
    let joints = case.model.joints.len();
    let mut rows: Vec<f64> = (0..3 * joints)
        .map(|place| before[place % joints][place / joints])
        .collect();
    for (place, number) in outputs.assigned(name) {
        rows[place] = number;
    }
    rows
}

fn expected_loads(model: &Model, columns: &[[Double; 3]]) -> Vec<Double> {
    let joints = model.joints.len();
    let at = |place: usize| columns[place % joints][place / joints];
    (0..3 * joints).map(at).collect()
}

#[test]
fn links_agree_with_their_forces() {
    each(DEVICES, |case| {
        let (_, state) = case.exact();
        let strengths = [30.0, -20.0, 45.0];
        let mut inputs = case.inputs();
        inputs.links.copy_from_slice(&strengths);
        let lengths = link_lengths(&case.model, &state);
        // Two points with zero coordinates may coincide: there is no direction.
        if lengths.iter().any(|(length, _)| length.high == 0.0) {
            return;
        }
        for request in requests(FunctionKind::Link) {
            let module = case.generate(&request);
            let outputs = Outputs::of(case, &module, "link", &inputs);
            // Along one axis of the common frame a length has the sign of the
            // axis, and so has its rate and the direction of the force.
            let found = outputs.array("Z").unwrap_or(&[0.0; 3]);
            let sign = |index: usize| Double::from(found[index].signum());
            let signed = |numbers: Vec<Double>| -> Vec<Double> {
                let numbers = numbers.into_iter().enumerate();
                numbers
                    .map(|(index, number)| number * sign(index))
                    .collect()
            };
            let column = |pick: fn(&(Double, Double)) -> Double| lengths.iter().map(pick).collect();
            case.compare("Z", found, &signed(column(|pair| pair.0)));
            let rates = outputs.array("Zd").unwrap_or(&[0.0; 3]);
            case.compare("Zd", rates, &signed(column(|pair| pair.1)));
            let pulls = signed(strengths.map(Double::from).to_vec());
            let expected = add_links(&case.model, &state, &pulls);
            let frc = loads(case, &outputs, "frc", &inputs.frc);
            case.compare("frc", &frc, &expected_loads(&case.model, &expected.frc));
            let trq = loads(case, &outputs, "trq", &inputs.trq);
            case.compare("trq", &trq, &expected_loads(&case.model, &expected.trq));
        }
    });
}

#[test]
fn external_forces_agree_with_their_loads_and_their_points() {
    each(DEVICES, |case| {
        let (_, state) = case.exact();
        let given: [[f64; 9]; 3] = std::array::from_fn(|force| {
            std::array::from_fn(|k| ((7 * force + 3 * k) % 10) as f64 - 4.5)
        });
        let mut inputs = case.inputs();
        inputs.external.copy_from_slice(&given);
        let given = given.map(|numbers| numbers.map(Double::from));
        let expected = add_external(&case.model, &state, &given);
        let forces = case.model.forces.iter();
        let points = forces.map(|force| of_point(case, force.point));
        let points: Vec<Point<Double>> = points.collect();
        for request in requests(FunctionKind::Extforces) {
            let module = case.generate(&request);
            let outputs = Outputs::of(case, &module, "extforces", &inputs);
            let frc = loads(case, &outputs, "frc", &inputs.frc);
            case.compare("frc", &frc, &expected_loads(&case.model, &expected.frc));
            let trq = loads(case, &outputs, "trq", &inputs.trq);
            case.compare("trq", &trq, &expected_loads(&case.model, &expected.trq));
            for (index, expected) in points.iter().enumerate() {
                let suffix = format!("xF{}", index + 1);
                compare(case, &outputs, ("", &suffix), false, expected);
            }
        }
    });
}
