//! Robots in URDF and MJCF: their equations against a computation from the numbers of
//! the file alone, and the messages for wrong files.

mod account;
mod base_parameters;
mod draw;
mod frames;
mod losses;
mod mjcf;
mod quaternion;
mod refusals;
mod shipped;

use crate::agreement::{Case, Outputs};
use crate::reference::State;
use account::{Account, Motion};
use draw::DrawnRobot;
use robovec::generate::{Formulation, GenerationRequest};
use robovec::model::robot::{RobotBase, read_robot};
use robovec::model::{CutKind, Model};
use robovec::robotran::FunctionKind;
use robovec_num::random::Random;

/// Number of random robots tried, each on both bases.
const ROBOTS: u64 = 120;

/// The largest accepted difference, relative to the largest entry.
const TOLERANCE: f64 = 1e-12;

/// Reads a robot that must be one.
fn read(name: &str, text: &str, base: RobotBase) -> Model {
    match read_robot(name, text.as_bytes(), base) {
        Ok(read) => read.model,
        Err(error) => panic!("{name}:\n{}\n{text}", error.report.render_plain()),
    }
}

/// Mass matrix and bias of a model, by the formulation of a number.
fn dynamics(seed: u64, model: Model, state: State<f64>) -> (Outputs, Model) {
    let all = Formulation::ALL.into_iter();
    let able: Vec<Formulation> = all
        .filter(|formulation| formulation.gives(FunctionKind::Dirdyna))
        .collect();
    let case = Case { seed, model, state };
    let module = case.generate(&GenerationRequest {
        formulation: able[seed as usize % able.len()],
        ..GenerationRequest::new(FunctionKind::Dirdyna)
    });
    let outputs = Outputs::of(&case, &module, "dirdyna", &case.inputs());
    (outputs, case.model)
}

/// Compares the results for a robot with the independent computation; returns
/// the largest difference of `M` and `c`.
fn compare(seed: u64, robot: &DrawnRobot, base: RobotBase) -> f64 {
    compare_files(seed, robot, ("drawn.urdf", &robot.text()), base)
}

/// The same for the file of a robot.
fn compare_files(
    seed: u64,
    robot: &DrawnRobot,
    (file, text): (&str, &str),
    base: RobotBase,
) -> f64 {
    let model = read(file, text, base);
    let joints = model.joints.len();
    let mut random = Random::new(seed ^ 0x5eed);
    let mut list = || {
        (0..joints)
            .map(|_| 2.0 * random.signed())
            .collect::<Vec<f64>>()
    };
    let state = State {
        q: list(),
        qd: list(),
        qdd: vec![0.0; joints],
        frc: vec![[0.0; 3]; joints],
        trq: vec![[0.0; 3]; joints],
    };
    let number = |name: &str| model.joints.iter().position(|joint| joint.name == name);
    let motion = |name: &str| -> Motion {
        let joint = number(name).unwrap_or_else(|| panic!("seed {seed}: no joint {name}"));
        (state.q[joint], state.qd[joint])
    };
    let account = Account::new(robot, base == RobotBase::Floating, &motion);
    if joints == 0 {
        return 0.0;
    }
    let (outputs, model) = dynamics(seed, model.clone(), state.clone());
    let name = |joint: usize| model.joints[joint].name.clone();
    let masses: Vec<f64> = (0..joints * joints)
        .map(|at| {
            let pair = (name(at / joints), name(at % joints));
            account.mass.get(&pair).copied().unwrap_or(0.0)
        })
        .collect();
    let forces: Vec<f64> = (0..joints)
        .map(|joint| account.bias.get(&name(joint)).copied().unwrap_or(0.0))
        .collect();
    assert_eq!(account.bias.len(), joints, "seed {seed}: freedoms");
    let zeros = vec![0.0; joints * joints];
    let mass = outputs.array("M").unwrap_or(&zeros);
    let bias = outputs.array("c").unwrap_or(&zeros[..joints]);
    let mut worst = 0.0f64;
    for (what, found, expected) in [("M", mass, masses), ("c", bias, forces)] {
        let size = expected.iter().fold(1.0f64, |size, x| size.max(x.abs()));
        for (place, (found, expected)) in found.iter().zip(expected).enumerate() {
            let error = (found - expected).abs() / size;
            assert!(
                error <= TOLERANCE,
                "seed {seed}, {base:?}: {what} at {place}: {found} instead of {expected}\n{text}"
            );
            worst = worst.max(error);
        }
    }
    worst
}

/// Followers are reported with the leader at the end of their chain.
fn couplings(seed: u64, robot: &DrawnRobot, (file, text): (&str, &str)) -> usize {
    let model = read(file, text, RobotBase::Fixed);
    let name = |joint: usize| model.joints[joint].name.as_str();
    let mut found = Vec::new();
    for cut in &model.cuts {
        if let CutKind::Coupling(coupling) = cut.kind {
            let names = (name(coupling.joint), name(coupling.leader));
            found.push((names, coupling.factor, coupling.offset));
        }
    }
    let followers = (0..robot.joints.len()).filter(|&joint| robot.leader(joint).is_some());
    let followers: Vec<usize> = followers.collect();
    assert_eq!(found.len(), followers.len(), "seed {seed}");
    for follower in &followers {
        let (leader, factor, offset) = robot.leader(*follower).expect("it follows");
        let wanted = (format!("j{follower}"), format!("j{leader}"));
        let matches = found.iter().any(|((joint, other), ratio, shift)| {
            (*joint, *other) == (wanted.0.as_str(), wanted.1.as_str())
                && (ratio - factor).abs() < 1e-13 * factor.abs().max(1.0)
                && (shift - offset).abs() < 1e-13 * offset.abs().max(1.0)
        });
        assert!(matches, "seed {seed}: {wanted:?} in {found:?}");
    }
    followers.len()
}

#[test]
fn equations_of_random_robots_are_those_of_the_numbers_in_their_files() {
    let (mut worst, mut followers, mut joints) = (0.0f64, 0, 0);
    for seed in 1..=ROBOTS {
        let robot = DrawnRobot::new(&mut Random::new(seed));
        for base in [RobotBase::Fixed, RobotBase::Floating] {
            worst = worst.max(compare(seed, &robot, base));
        }
        followers += couplings(seed, &robot, ("drawn.urdf", &robot.text()));
        joints += robot.joints.len();
    }
    println!("worst of {ROBOTS} robots with {joints} joints: {worst:e}");
    assert!(followers > 30 && joints > 500, "{followers}, {joints}");
}
