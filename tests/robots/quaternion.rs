//! A free base described by a quaternion, against yaw, pitch and roll.

use crate::support::files::tree;
use crate::support::programs::{robovec, stderr};
use robovec::generate::{
    Formulation, GenerationRequest, ParameterBinding, generate, with_jacobians,
};
use robovec::model::Model;
use robovec::model::robot::{RobotBase, read_robot};
use robovec::robotran::FunctionKind;
use robovec_ir::Module;
use robovec_ir::evaluate::evaluate;
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use std::collections::BTreeMap;
use std::fs;

type Arrays = BTreeMap<&'static str, Vec<f64>>;

/// The outputs of a function of a model, one array after the other.
fn run(model: &Model, request: &GenerationRequest, given: &Arrays) -> Vec<f64> {
    outputs(&generate(model, request).expect("it is generated"), given)
}

fn outputs(module: &Module, given: &Arrays) -> Vec<f64> {
    let function = &module.functions[0];
    let mut inputs = vec![0.0; function.input_len()];
    for array in function.inputs() {
        let name = module.tables.symbols.text(array.name);
        let values = given.get(name).map_or(&[][..], Vec::as_slice);
        let start = array.offset as usize;
        inputs[start..start + values.len()].copy_from_slice(values);
    }
    let mut outputs = vec![0.0; function.output_len()];
    let found = evaluate(function, &Binary64, &inputs);
    for (set, value) in function.assignments.iter().zip(found) {
        outputs[set.output.index()] = value;
    }
    outputs
}

/// From rates of x, y, z, yaw, pitch and roll to the velocity along the axes of
/// the base, and the rate of this matrix.
fn transform(q: &[f64], qd: &[f64]) -> [[[f64; 6]; 6]; 2] {
    let [(sy, cy), (sp, cp), (sr, cr)] = [3, 4, 5].map(|joint| q[joint].sin_cos());
    let mut all = [[[0.0; 6]; 6]; 2];
    let [matrix, rate] = &mut all;
    // Rows are the axes of the base.
    let axes = [
        [cy * cp, sy * cp, -sp],
        [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
        [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
    ];
    let turning = [[-sp, 0.0, 1.0], [cp * sr, cr, 0.0], [cp * cr, -sr, 0.0]];
    let [pd, rd] = [qd[4], qd[5]];
    let changing = [
        [-cp * pd, 0.0, 0.0],
        [-sp * sr * pd + cp * cr * rd, -sr * rd, 0.0],
        [-sp * cr * pd - cp * sr * rd, -cr * rd, 0.0],
    ];
    let w: Vec<f64> = (0..3)
        .map(|k| (0..3).map(|j| turning[k][j] * qd[3 + j]).sum())
        .collect();
    for k in 0..3 {
        let (b, c) = ((k + 1) % 3, (k + 2) % 3);
        for j in 0..3 {
            matrix[k][j] = axes[k][j];
            rate[k][j] = w[c] * axes[b][j] - w[b] * axes[c][j];
            matrix[3 + k][3 + j] = turning[k][j];
            rate[3 + k][3 + j] = changing[k][j];
        }
    }
    all
}

/// The base of a vector of joints after a matrix; other joints stay.
fn moved(matrix: &[[f64; 6]; 6], vector: &[f64], is_transposed: bool) -> Vec<f64> {
    let mut all = vector.to_vec();
    for (k, value) in all[..6].iter_mut().enumerate() {
        let entry = |j: usize| {
            if is_transposed {
                matrix[j][k]
            } else {
                matrix[k][j]
            }
        };
        *value = (0..6).map(|j| entry(j) * vector[j]).sum();
    }
    all
}

fn quaternion(q: &[f64]) -> Vec<f64> {
    let [(sy, cy), (sp, cp), (sr, cr)] = [3, 4, 5].map(|joint| (q[joint] / 2.0).sin_cos());
    vec![
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
        cy * cp * cr + sy * sp * sr,
    ]
}

fn close(what: &str, found: &[f64], wanted: &[f64]) {
    close_within(1e-10, what, found, wanted);
}

fn close_within(limit: f64, what: &str, found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    let size = wanted.iter().fold(1.0f64, |most, x| most.max(x.abs()));
    for (place, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        let error = (found - wanted).abs() / size;
        assert!(
            error <= limit,
            "{what} at {place}: {found} instead of {wanted}"
        );
    }
}

fn compare(model: &Model, formulation: Formulation, seed: u64) {
    let mut random = Random::new(seed);
    let joints = model.joints.len();
    let mut list = || (0..joints).map(|_| random.signed()).collect::<Vec<f64>>();
    let mut angles = Arrays::new();
    for name in ["q", "qd", "qdd", "Qq"] {
        angles.insert(name, list());
    }
    let gravity = vec![0.3, -1.0, -9.0];
    for (name, values) in [("frc", list()), ("trq", list()), ("g", gravity)] {
        angles.insert(name, values);
    }
    let [matrix, rate] = transform(&angles["q"], &angles["qd"]);
    let mut own = angles.clone();
    own.insert("quat", quaternion(&angles["q"]));
    own.insert("qd", moved(&matrix, &angles["qd"], false));
    let rates = angles["qd"].clone();
    let accelerated = |accelerations: &[f64]| {
        let mut all = moved(&matrix, accelerations, false);
        let more = moved(&rate, &rates, false);
        all[..6]
            .iter_mut()
            .zip(more)
            .for_each(|(all, more)| *all += more);
        all
    };
    own.insert("qdd", accelerated(&angles["qdd"]));
    own.insert("Qq", list());
    angles.insert("Qq", moved(&matrix, &own["Qq"], true));
    let request = |function, quaternion| {
        let mut request = GenerationRequest::new(function);
        request.formulation = formulation;
        request.options.quaternion = quaternion;
        request.options.parameters = ParameterBinding::Numbers;
        request.options.external_forces = false;
        request
    };
    let name = formulation.name();
    if formulation.gives(FunctionKind::Invdyna) {
        let forces = run(model, &request(FunctionKind::Invdyna, true), &own);
        let wanted = run(model, &request(FunctionKind::Invdyna, false), &angles);
        close(name, &moved(&matrix, &forces, true), &wanted);
        // The same by M and c.
        let all = run(model, &request(FunctionKind::Dirdyna, true), &own);
        let (mass, bias) = all.split_at(joints * joints);
        let rows = mass.chunks(joints).zip(bias).map(|(row, bias)| {
            let products = row.iter().zip(&own["qdd"]);
            bias + products.map(|(mass, qdd)| mass * qdd).sum::<f64>()
        });
        close(name, &rows.collect::<Vec<_>>(), &forces);
    }
    if formulation.closes_loops() || model.cuts.is_empty() {
        let found = run(model, &request(FunctionKind::Accelred, true), &own);
        let wanted = run(model, &request(FunctionKind::Accelred, false), &angles);
        close(name, &found, &accelerated(&wanted));
    }
}

#[test]
fn a_quaternion_gives_the_motion_of_yaw_pitch_and_roll() {
    for (file, base) in [
        ("quadruped.urdf", RobotBase::Floating),
        ("biped.xml", RobotBase::Fixed),
    ] {
        let bytes = fs::read(tree(&format!("examples/robots/{file}"))).expect("it ships");
        let model = read_robot(file, &bytes, base).expect("it is read").model;
        for (seed, formulation) in Formulation::ALL.into_iter().enumerate() {
            compare(&model, formulation, seed as u64 + 1);
        }
    }
}

/// Moves one number of a state, or its base along or about one of its axes.
fn integrate(given: &Arrays, name: &'static str, joint: usize, step: f64) -> Arrays {
    let mut moved = given.clone();
    if name == "q" && (3..6).contains(&joint) {
        let old = &given["quat"];
        let (a, b, c) = (joint - 3, (joint - 2) % 3, (joint - 1) % 3);
        let (sine, cosine) = (step / 2.0).sin_cos();
        let new = moved.get_mut("quat").expect("it is given");
        new[a] = cosine * old[a] + sine * old[3];
        new[b] = cosine * old[b] + sine * old[c];
        new[c] = cosine * old[c] - sine * old[b];
        new[3] = cosine * old[3] - sine * old[a];
    } else {
        moved.get_mut(name).expect("it is given")[joint] += step;
    }
    moved
}

/// The derivatives of some numbers by a step, by differences of the fourth order.
fn slopes(step: f64, at: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let sides = [2.0 * step, step, -step, -2.0 * step].map(at);
    let places = 0..sides[0].len();
    let slope = |place| {
        let [far, near, back, far_back] = [0, 1, 2, 3].map(|side: usize| sides[side][place]);
        (far_back - far + 8.0 * (near - back)) / (12.0 * step)
    };
    places.map(slope).collect()
}

/// The Jacobians along the axes of the base, against differences of the fourth
/// order.
#[test]
fn jacobians_of_a_quaternion_base_are_along_its_axes() {
    let mut random = Random::new(7);
    for (file, base, functions) in [
        (
            "quadruped.urdf",
            RobotBase::Floating,
            &[("Qq", "qdd"), ("qdd", "Qq")][..],
        ),
        ("biped.xml", RobotBase::Fixed, &[("Qq", "qdd")]),
    ] {
        let bytes = fs::read(tree(&format!("examples/robots/{file}"))).expect("it ships");
        let model = read_robot(file, &bytes, base).expect("it is read").model;
        let joints = model.joints.len();
        let mut list = |count| (0..count).map(|_| random.signed()).collect::<Vec<f64>>();
        let names = ["q", "qd", "qdd", "Qq", "frc", "trq"];
        let mut given: Arrays = names.map(|name| (name, list(joints))).into();
        let q = list(6);
        given.insert("quat", quaternion(&q));
        for &(output, last) in functions {
            let is_inverse = output == "Qq";
            let mut request = GenerationRequest::new(if is_inverse {
                FunctionKind::Invdyna
            } else {
                FunctionKind::Accelred
            });
            request.options.quaternion = true;
            request.options.parameters = ParameterBinding::Numbers;
            let module = with_jacobians(&model, &request).expect("it is generated");
            let found = outputs(&module, &given);
            for (number, name) in ["q", "qd", last].into_iter().enumerate() {
                let first = joints + number * joints * joints;
                let mut wanted = vec![0.0; joints * joints];
                for column in 0..joints {
                    let at = |step| outputs(&module, &integrate(&given, name, column, step));
                    for (row, slope) in slopes(1e-3, at).into_iter().take(joints).enumerate() {
                        wanted[row * joints + column] = slope;
                    }
                }
                let found = &found[first..first + joints * joints];
                close(&format!("{file} {output}_{name}"), found, &wanted);
            }
        }
    }
}

/// Elements of an output that a function sets, by their places in its array.
fn assigned(module: &Module, given: &Arrays, name: &str) -> Vec<(usize, f64)> {
    let (function, values) = (&module.functions[0], outputs(module, given));
    let mut arrays = function.outputs().iter();
    let array = arrays.find(|array| module.tables.symbols.text(array.name) == name);
    let first = array.expect("it is an output").offset as usize;
    let places = function.assignments.iter().map(|set| set.output);
    let places = places.filter(|&output| {
        let (array, ..) = function.output_element(output);
        module.tables.symbols.text(array.name) == name
    });
    places
        .map(|output| (output.index() - first, values[output.index()]))
        .collect()
}

/// The derivatives along loops and the axes of the base, against differences of
/// the fourth order of accelerations with closed loops.
#[test]
fn derivatives_with_loops_are_along_the_axes_of_the_base() {
    let file = "biped.xml";
    let bytes = fs::read(tree(&format!("examples/robots/{file}"))).expect("it ships");
    let model = read_robot(file, &bytes, RobotBase::Fixed).expect("it is read");
    let model = model.model;
    let joints = model.joints.len();
    let made = |function, quaternion| {
        let mut request = GenerationRequest::new(function);
        request.options.quaternion = quaternion;
        request.options.parameters = ParameterBinding::Numbers;
        generate(&model, &request).expect("it is generated")
    };
    let loops = [
        (made(FunctionKind::LoopPositions, false), "q"),
        (made(FunctionKind::LoopVelocities, false), "qd"),
    ];
    let closed = |mut given: Arrays| {
        for (module, name) in &loops {
            for _ in 0..8 {
                for (place, value) in assigned(module, &given, name) {
                    given.get_mut(name).expect("it is given")[place] = value;
                }
            }
        }
        given
    };
    let mut random = Random::new(11);
    // Slow, and near the closed state that the file describes.
    let mut list = |count| {
        let numbers = (0..count).map(|_| 0.2 * random.signed());
        numbers.collect::<Vec<f64>>()
    };
    let names = ["q", "qd", "Qq", "frc", "trq"];
    let mut given: Arrays = names.map(|name| (name, list(joints))).into();
    given.insert("quat", quaternion(&list(6)));
    let starts = model.joints.iter().zip(&given["q"]);
    let starts = starts.map(|(joint, more)| joint.initial[0] + 0.05 * more);
    let starts = starts.collect();
    given.insert("q", starts);
    let given = closed(given);
    let dependent: Vec<usize> = assigned(&loops[0].0, &given, "q")
        .into_iter()
        .map(|(joint, _)| joint)
        .collect();
    assert!(!dependent.is_empty(), "the robot has loops");
    let (accelerations, derivatives) = (
        made(FunctionKind::Accelred, true),
        made(FunctionKind::AccelD, true),
    );
    for (array, name) in [("qdd_q", "q"), ("qdd_qd", "qd"), ("qdd_Qq", "Qq")] {
        let mut found = vec![0.0; joints * joints];
        for (place, value) in assigned(&derivatives, &given, array) {
            found[place] = value;
        }
        let mut wanted = vec![0.0; joints * joints];
        for column in (0..joints).filter(|joint| name == "Qq" || !dependent.contains(joint)) {
            let at = |step| {
                let moved = closed(integrate(&given, name, column, step));
                outputs(&accelerations, &moved)
            };
            for (row, slope) in slopes(2e-4, at).into_iter().enumerate() {
                wanted[row * joints + column] = slope;
            }
        }
        // The mechanism is sensitive: this is what differences leave.
        close_within(1e-8, array, &found, &wanted);
    }
}

#[test]
fn what_has_no_free_base_or_depends_on_its_place_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rotor = folder.path().join("rotor.xml");
    let text = "<mujoco><worldbody><body><joint type='free' armature='1'/><geom size='0.1'/></body>\
                </worldbody></mujoco>";
    fs::write(&rotor, text).expect("written");
    let rotor = format!("gen {} --quaternion", rotor.display());
    for (arguments, reason) in [
        (rotor.as_str(), "its base has an armature"),
        (
            "gen examples/robots/arm.urdf --quaternion",
            "its first body has other joints",
        ),
        (
            "gen examples/robots/quadruped.urdf --base floating --quaternion --function frame",
            "frame is not among its functions",
        ),
        (
            "gen examples/robots/biped.xml --quaternion --function linear",
            "linear is not among its functions",
        ),
    ] {
        let output = robovec(&arguments.split(' ').collect::<Vec<_>>());
        assert!(
            !output.status.success() && output.stdout.is_empty(),
            "{arguments}"
        );
        assert!(stderr(&output).contains(reason), "{}", stderr(&output));
    }
}
