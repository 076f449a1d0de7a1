//! Frames of links by their names: pose, motion and Jacobian against the
//! computation from the numbers of the file, and the rate of the Jacobian
//! against differences.

use super::account::{Account, Motion};
use super::draw::DrawnRobot;
use super::{TOLERANCE, read};
use crate::agreement::{Case, Outputs};
use crate::reference::State;
use robovec::generate::GenerationRequest;
use robovec::model::Model;
use robovec::model::robot::RobotBase;
use robovec::robotran::FunctionKind;
use robovec_ir::Module;
use robovec_num::random::Random;

/// A state of a robot.
fn state(random: &mut Random, joints: usize) -> State<f64> {
    let mut list = || {
        (0..joints)
            .map(|_| 2.0 * random.signed())
            .collect::<Vec<f64>>()
    };
    State {
        q: list(),
        qd: list(),
        qdd: vec![0.0; joints],
        frc: vec![[0.0; 3]; joints],
        trq: vec![[0.0; 3]; joints],
    }
}

fn outputs(model: &Model, state: &State<f64>, module: &Module, name: &str) -> Outputs {
    let case = Case {
        seed: 0,
        model: model.clone(),
        state: state.clone(),
    };
    Outputs::of(&case, module, name, &case.inputs())
}

/// Compares the frames of all links; returns how many.
fn compare(seed: u64, robot: &DrawnRobot, base: RobotBase) -> usize {
    let model = read("drawn.urdf", &robot.text(), base);
    let joints = model.joints.len();
    let place = |name: &str| model.joints.iter().position(|joint| joint.name == name);
    let place = |name: &str| place(name).unwrap_or_else(|| panic!("seed {seed}: no joint {name}"));
    let here = state(&mut Random::new(seed ^ 0xf4a), joints);
    let motion = |name: &str| -> Motion { (here.q[place(name)], here.qd[place(name)]) };
    let account = Account::new(robot, base == RobotBase::Floating, &motion);
    let request = GenerationRequest::new(FunctionKind::Frame);
    let module = robovec::generate::generate(&model, &request).expect("it is generated");
    assert_eq!(module.functions.len(), robot.links.len(), "seed {seed}");
    // The same at two moments beside this one.
    let beside = |step: f64| {
        let q = here.q.iter().zip(&here.qd).map(|(q, qd)| q + step * qd);
        State {
            q: q.collect(),
            ..here.clone()
        }
    };
    for (number, frame) in account.frames.iter().enumerate() {
        let name = format!("frame_l{number}");
        let found = outputs(&model, &here, &module, &name);
        let mut jacobian = vec![0.0; 6 * joints];
        let mut velocity = [0.0; 3];
        for (freedom, (linear, angular)) in frame.freedoms.iter().zip(frame.columns()) {
            let joint = place(&freedom.name);
            for k in 0..3 {
                jacobian[k * joints + joint] = linear[k];
                jacobian[(k + 3) * joints + joint] = angular[k];
                velocity[k] += linear[k] * here.qd[joint];
            }
        }
        let rotation = frame.rotation.concat();
        for (array, expected) in [
            ("position", &frame.origin[..]),
            ("rotation", &rotation),
            ("velocity", &velocity),
            ("angular_velocity", &frame.spin),
            ("acceleration", &frame.acceleration),
            ("angular_acceleration", &frame.rate),
            ("jacobian", &jacobian),
        ] {
            let size = expected.iter().fold(1.0f64, |size, x| size.max(x.abs()));
            let numbers = found.array(array).unwrap_or(&[]);
            assert_eq!(numbers.len(), expected.len(), "seed {seed}: {name}.{array}");
            for (found, expected) in numbers.iter().zip(expected) {
                let error = (found - expected).abs() / size;
                assert!(
                    error <= TOLERANCE,
                    "seed {seed}, {base:?}: {name}.{array}: {error:e}"
                );
            }
        }
        let step = 1e-6;
        let [after, before] =
            [step, -step].map(|step| outputs(&model, &beside(step), &module, &name));
        let [after, before] =
            [&after, &before].map(|moment| moment.array("jacobian").expect("it is there"));
        let rates = found.array("jacobian_rate").expect("it is there");
        assert_eq!(rates.len(), 6 * joints);
        for (rate, (after, before)) in rates.iter().zip(after.iter().zip(before)) {
            let wanted = (after - before) / (2.0 * step);
            let error = (rate - wanted).abs() / (1.0 + wanted.abs());
            assert!(
                error <= 1e-6,
                "seed {seed}: {name}.jacobian_rate: {rate}, {wanted}"
            );
        }
    }
    account.frames.len()
}

#[test]
fn frames_of_links_are_those_of_the_numbers_in_their_files() {
    let mut frames = 0;
    for seed in 1..=60 {
        let robot = DrawnRobot::new(&mut Random::new(seed));
        for base in [RobotBase::Fixed, RobotBase::Floating] {
            if !read("drawn.urdf", &robot.text(), base).joints.is_empty() {
                frames += compare(seed, &robot, base);
            }
        }
    }
    assert!(frames > 500, "{frames}");
}

/// Names of links that C cannot have, and that become the same.
#[test]
fn functions_of_frames_have_names_of_c() {
    let link = |name: &str| format!("<link name='{name}'/>");
    let joint = |number: u32, child: &str| {
        format!(
            "<joint name='j{number}' type='revolute'><parent link='base'/><child link='{child}'/>\
             <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        )
    };
    let text = format!(
        "<robot name='r'>{}{}{}{}{}</robot>",
        link("base"),
        link("a-b"),
        link("a b"),
        joint(1, "a-b"),
        joint(2, "a b")
    );
    let model = read("names.urdf", &text, RobotBase::Fixed);
    let request = GenerationRequest::new(FunctionKind::Frame);
    let module = robovec::generate::generate(&model, &request).expect("it is generated");
    let names: Vec<&str> = module
        .functions
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    assert_eq!(names, ["frame_base", "frame_a_b", "frame_a_b__2"]);
}
