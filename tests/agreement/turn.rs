//! A four-bar through a full turn, by every choice of the joint that leads: its
//! accelerations against the full equations, also where an entry of the
//! Jacobian, which was a good pivot elsewhere, is zero.

use super::closing::{equations, full, independent, outputs_of};
use super::{Case, Outputs};
use crate::reference::State;
use crate::support::programs::model;
use robovec::generate::{Formulation, GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::model::{Model, Nature};
use robovec::robotran::FunctionKind;
use robovec_ir::Module;
use robovec_num::double_double::Double;

/// States of a turn.
const STATES: usize = 360;

/// Forces of the joints.
const FORCES: [f64; 3] = [3.0, -1.0, 2.0];

/// A joint that moves less than this part of the fastest one determines the
/// others badly: they lose the corresponding number of digits.
const LEADS: f64 = 0.02;

/// The four-bar with one leading joint.
fn led_by(leader: usize) -> Model {
    let bytes = std::fs::read(model("four-bar.mbs")).expect("the model is there");
    let mut model = read_mbs("four-bar", &bytes).expect("a good model").model;
    for (index, joint) in model.joints.iter_mut().enumerate() {
        joint.nature = if index == leader {
            Nature::Independent
        } else {
            Nature::Dependent
        };
    }
    model
}

/// A four-bar with the functions that close its loop.
struct Linkage {
    model: Model,
    /// Positions and velocities of the dependent joints.
    closing: [Module; 2],
}

/// The functions of [`Linkage::closing`].
const CLOSING: [FunctionKind; 2] = [FunctionKind::LoopPositions, FunctionKind::LoopVelocities];

impl Linkage {
    fn new(model: Model) -> Linkage {
        let closing = CLOSING.map(|kind| equations(&model, kind).expect("it closes"));
        Linkage { model, closing }
    }

    /// The crank at an angle, the loop closed from the positions given, the
    /// crank turning at 1 rad/s.
    fn turned(&self, angle: f64, q: &[f64]) -> Case {
        let n = q.len();
        let mut case = Case {
            seed: 0,
            model: self.model.clone(),
            state: State {
                q: q.to_vec(),
                qd: vec![1.0; n],
                qdd: vec![0.0; n],
                frc: vec![[0.0; 3]; n],
                trq: vec![[0.0; 3]; n],
            },
        };
        case.state.q[0] = angle;
        let forces = vec![0.0; n];
        let [positions, velocities] = &self.closing;
        for _ in 0..8 {
            let round = outputs_of(positions, &case, CLOSING[0], &forces);
            for (joint, q) in round.assigned("q") {
                case.state.q[joint] = q;
            }
        }
        let velocities = outputs_of(velocities, &case, CLOSING[1], &forces);
        for (joint, qd) in velocities.assigned("qd") {
            case.state.qd[joint] = qd;
        }
        case
    }
}

/// The entries of the Jacobian of the rows that joints change.
fn entries(case: &Case) -> Vec<f64> {
    let rows = independent(case, &[0, 1]);
    let entries = rows.jacobian.iter().flatten();
    entries.map(|entry| entry.high).collect()
}

/// The angle between two states at which an entry vanishes, by bisection.
fn vanishing(crank: &Linkage, (low, high): (&Case, &Case), place: usize) -> Case {
    let (mut low, mut high) = (low.state.clone(), high.state.q[0]);
    let sign = |case: &Case| entries(case)[place].is_sign_positive();
    let first = sign(&crank.turned(low.q[0], &low.q));
    loop {
        let middle = crank.turned(0.5 * (low.q[0] + high), &low.q);
        let angle = middle.state.q[0];
        if angle <= low.q[0] || angle >= high {
            return middle;
        }
        if sign(&middle) == first {
            low = middle.state;
        } else {
            high = angle;
        }
    }
}

#[test]
fn a_four_bar_turns_whichever_joint_leads() {
    let crank = Linkage::new(led_by(0));
    let joints = crank.model.joints.iter();
    let initial: Vec<f64> = joints.map(|joint| joint.initial[0]).collect();
    let start = crank.turned(-1.0, &initial);
    let mut cases = vec![start];
    for step in 1..=STATES {
        let last = cases.last().expect("it has a start");
        let angle = -1.0 + std::f64::consts::TAU * step as f64 / STATES as f64;
        cases.push(crank.turned(angle, &last.state.q));
    }
    let mut special = Vec::new();
    for pair in cases.windows(2) {
        let signs = entries(&pair[0]).into_iter().zip(entries(&pair[1]));
        for (place, (one, other)) in signs.enumerate() {
            if one * other < 0.0 {
                special.push(vanishing(&crank, (&pair[0], &pair[1]), place));
            }
        }
    }
    assert!(special.len() >= 2, "entries vanish {} times", special.len());
    cases.extend(special);
    // Those of the full equations depend on no choice of the joint that leads.
    let expected = |case: &Case| full(case, &FORCES, &independent(case, &[0, 1]));
    let expected: Vec<Vec<Double>> = cases.iter().map(expected).collect();
    // Pivots are those of the initial state.
    for start in cases[..STATES].iter().step_by(STATES / 6) {
        for leader in 0..3 {
            let mut model = led_by(leader);
            for (joint, &q) in model.joints.iter_mut().zip(&start.state.q) {
                joint.initial[0] = q;
            }
            let (worst, tried) = worst(&model, leader, &cases, &expected);
            let angle = start.state.q[0];
            println!(
                "from {angle:.2}, joint {} leads at {tried} states: {worst:e}",
                leader + 1
            );
            assert!(tried > STATES * 9 / 10, "joint {}: {tried}", leader + 1);
            assert!(
                worst < 1e-10,
                "joint {} from {angle}: {worst:e}",
                leader + 1
            );
        }
    }
}

/// The largest error of accelerations, in parts of the largest, and the number
/// of states at which the joint leads well.
fn worst(model: &Model, leader: usize, cases: &[Case], expected: &[Vec<Double>]) -> (f64, usize) {
    let request = GenerationRequest {
        formulation: Formulation::Composite,
        ..GenerationRequest::new(FunctionKind::Accelred)
    };
    let module = generate(model, &request).expect("it closes");
    let (mut worst, mut tried) = (0.0f64, 0);
    for (case, expected) in cases.iter().zip(expected) {
        let speeds = case.state.qd.iter().map(|qd| qd.abs());
        let fastest = speeds.fold(0.0, f64::max);
        if case.state.qd[leader].abs() < LEADS * fastest {
            continue;
        }
        tried += 1;
        let mut inputs = case.inputs();
        inputs.joint_forces.copy_from_slice(&FORCES);
        let found = Outputs::of(case, &module, FunctionKind::Accelred.name(), &inputs);
        let size = expected
            .iter()
            .fold(1.0f64, |size, x| size.max(x.high.abs()));
        for (joint, number) in found.assigned("qdd") {
            worst = worst.max(expected[joint].distance(number) / size);
        }
    }
    (worst, tried)
}
