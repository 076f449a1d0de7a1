//! Sensors far from the origin: where something is beside a target when both
//! have travelled far.

use super::super::case::{CaseClass, StressCase};
use super::super::draw::Draw;
use super::super::equations::EquationsSubject;
use super::super::program::shared;
use super::super::verdict::StressVerdict;
use super::models::sphere;
use robovec_dynamics::generate::{GenerationRequest, generate};
use robovec_dynamics::kinematics::{InputSources, MotionState};
use robovec_ir::View;
use robovec_ir::print::print_function;
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::{Asks, Axis, JointKind, Model};
use robovec_robotran::FunctionKind;
use std::fmt::Write;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (2, StressVerdict::Fine),
        (4, StressVerdict::HardProblem),
        (6, StressVerdict::HardProblem),
    ] {
        cases.push(CaseClass::Far.case(
            format!("sensor-1e{power}"),
            format!(
                "an arm's sensor beside a target, the body that carries it 1e{power} m from the \
                 origin"
            ),
            "positions that the host has in binary64, before anything is computed",
            expected,
            sensor(10f64.powi(power), false),
        ));
    }
    cases.push(CaseClass::Far.case(
        "sensor-1e6-held",
        "the same at 1e6 m with positions that binary32 holds",
        "the arm, which is added to the far position before the target is subtracted",
        StressVerdict::BadCode,
        sensor(1e6, true),
    ));
    cases
}

/// The position and velocity of a sensor relative to those of a target a
/// metre or two away, from the generated equations of the sensor.
fn sensor(distance: f64, held: bool) -> EquationsSubject {
    let model = carrier();
    let (text, sources) = relative_equations(&model);
    let (mut far, mut near) = (Vec::new(), Vec::new());
    for seed in 1..=4 {
        let mut draw = Draw::new(seed);
        let mut state = MotionState::initial(&model);
        let mut target = Vec::new();
        for axis in 0..3 {
            // Away from the numbers of binary32, but for those to be held.
            let place = distance * (1.0 + 0.1 * f64::from(axis as u32)) + draw.within(1.0) / 3.0;
            state.q[axis] = if held { shared(place) } else { place };
            let beside = state.q[axis] + draw.between(1.0, 2.0);
            target.push(if held { shared(beside) } else { beside });
            state.qd[axis] = draw.within(20.0);
        }
        for joint in 3..state.q.len() {
            (state.q[joint], state.qd[joint]) = (draw.within(1.0), draw.within(1.0));
        }
        for axis in 0..3 {
            target.push(f64::from((state.qd[axis] + draw.between(2.0, 3.0)) as f32));
        }
        let inputs =
            |state: &MotionState, target: &[f64]| [&sources.gather(state), target].concat();
        far.push(inputs(&state, &target));
        // Whole metres away: the differences are exact.
        for (place, target) in state.q.iter_mut().zip(&mut target[..3]) {
            let origin = place.round();
            *place -= origin;
            *target -= origin;
        }
        near.push(inputs(&state, &target));
    }
    EquationsSubject::of_host(text.clone(), far)
        .of("distance")
        .or_prepared("origin moved", text, near)
}

/// A body that floats, with an arm of two joints and a sensor at its end.
fn carrier() -> Model {
    let mut builder = ModelBuilder::new("carrier");
    let body = builder.body("Body", BASE.origin(), &JointKind::ALL);
    builder.mass(body, 10.0, [0.0; 3], sphere(1.0));
    let mount = builder.point(body, "Mount", [0.5, 0.25, 0.125]);
    let turn = |axis| JointKind::Revolute(axis);
    let arm = builder.body("Arm", mount, &[turn(Axis::Y), turn(Axis::X)]);
    builder.mass(arm, 1.0, [0.0, 0.0, 0.25], sphere(0.1));
    let tip = builder.point(arm, "Tip", [0.125, 0.0, 0.75]);
    let asks = Asks {
        position: true,
        velocity: true,
        ..Asks::default()
    };
    builder.sensor("Tip", tip, asks);
    builder.finish()
}

/// The generated equations of the only sensor, less a target, as text; and
/// where the inputs before the target come from.
fn relative_equations(model: &Model) -> (String, InputSources) {
    let request = GenerationRequest::new(FunctionKind::Sensor);
    let module = generate(model, &request).expect("the sensor has equations");
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let sources = InputSources::new(model, view).expect("the model has what they read");
    let mut text = String::new();
    let mut written = false;
    for line in print_function(view).lines() {
        let output = line.trim_start();
        if output.starts_with("out ") {
            if !written {
                text += "  in target[1..6]\n  out relative[1..6]\n";
            }
            written = true;
            continue;
        }
        if !output.starts_with("sens.") {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{line}");
            continue;
        }
        for (array, first) in [("sens.P[", 0), ("sens.V[", 3)] {
            let Some((index, operand)) = output
                .strip_prefix(array)
                .and_then(|rest| rest.split_once("] = "))
            else {
                continue;
            };
            let place: usize = first + index.parse::<usize>().expect("an index");
            let _ = writeln!(text, "  relative[{place}] = {operand} - target[{place}]");
        }
    }
    (text, sources)
}

#[cfg(test)]
mod tests {
    use super::super::super::ProgramTreatment;
    use super::super::super::case::StressSubject;
    use super::*;

    type Matrix = [[f64; 3]; 3];

    fn turn(axis: usize, angle: f64) -> Matrix {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut matrix = [[0.0; 3]; 3];
        matrix[axis][axis] = 1.0;
        (matrix[next][next], matrix[last][last]) = (angle.cos(), angle.cos());
        (matrix[last][next], matrix[next][last]) = (angle.sin(), -angle.sin());
        matrix
    }

    fn times(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| (0..3).map(|k| row[k] * vector[k]).sum())
    }

    /// Where the tip is, seen from the origin of the body, along the base's
    /// axes: by matrices, from the last joint to the first.
    fn lever(angles: &[f64]) -> [f64; 3] {
        let mut place = [0.125, 0.0, 0.75];
        for (axis, angle) in [(0, angles[4]), (1, angles[3])] {
            place = times(&turn(axis, angle), place);
        }
        place = [place[0] + 0.5, place[1] + 0.25, place[2] + 0.125];
        for axis in [2, 1, 0] {
            place = times(&turn(axis, angles[axis]), place);
        }
        place
    }

    #[test]
    fn errors_are_those_of_rounding_far_positions() {
        for (size, held) in [(1e4, false), (1e6, false), (1e6, true)] {
            let mut most = 0.0f64;
            for seed in 1..=4 {
                let mut draw = Draw::new(seed);
                let (mut body, mut target) = ([0.0; 3], [0.0; 3]);
                for axis in 0..3 {
                    let place = size * (1.0 + 0.1 * axis as f64) + draw.within(1.0) / 3.0;
                    let nearest = |x: f64| if held { f64::from(x as f32) } else { x };
                    body[axis] = nearest(place);
                    target[axis] = nearest(body[axis] + draw.between(1.0, 2.0));
                    draw.within(20.0);
                }
                let angles: Vec<f64> = (0..5)
                    .map(|_| {
                        let angle = draw.within(1.0);
                        draw.within(1.0);
                        angle
                    })
                    .collect();
                let lever = lever(&angles);
                for axis in 0..3 {
                    let exact = body[axis] - target[axis] + lever[axis];
                    // The body's place and the target are rounded, then the
                    // sum of place and lever; the difference is exact.
                    let sum = (f64::from(body[axis] as f32) + lever[axis]) as f32;
                    let short = f64::from(sum - target[axis] as f32);
                    most = most.max((short / exact - 1.0).abs());
                }
            }
            let subject = sensor(size, held);
            let bench = subject.prepare().expect("it has equations");
            let measured = bench.measure(&ProgramTreatment::default());
            let error = measured.expect("it is computed").error;
            assert!((most / error - 1.0).abs() < 1e-2, "{most:e} {error:e}");
        }
    }
}
