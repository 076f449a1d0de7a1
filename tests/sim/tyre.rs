//! Wheels with tyres against closed formulas.

use super::models::{Builder, Solid, run_with};
use robovec::model::{Asks, Model, Nature, Sensor};
use robovec::motion::{EquationSetting, IntegrationMethod, Laws, MultibodySystem, SimulationRun};

const FINE: IntegrationMethod = IntegrationMethod::DormandPrince {
    relative: 1e-11,
    absolute: 1e-11,
};

const GRAVITY: f64 = 9.81;
const MASS: f64 = 300.0;
const INERTIA: f64 = 1.2;
const RADIUS: f64 = 0.3;
const STIFFNESS: f64 = 2e5;

const PLANE: &str = "[[tyre]]\nname = 'wheel'\nradius = 0.3\nstiffness = 2e5\n";
const LINEAR: &str = "law = 'linear'\nlongitudinal = 8e4\nlateral = 6e4\nfriction = 0.9\n";
const BAKKER: &str = "law = 'bakker'\n\
                      longitudinal = { B = 12, C = 1.65, D = 1.0, E = 0.3 }\n\
                      lateral = { B = 10.0, C = 1.3, D = 0.9, E = -1 }\n";

/// A wheel with joints, their positions and velocities; an external force at
/// its centre.
fn wheel(joints: &[(&str, [f64; 2])]) -> Model {
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: MASS,
        center: [0.0; 3],
        inertia: [0.8, INERTIA, 0.8],
        points: &[[0.0; 3]],
    };
    let named: Vec<_> = joints
        .iter()
        .map(|&(kind, [start, _])| (kind, Nature::Independent, start))
        .collect();
    let body = builder.body(base, &named, &solid);
    let point = builder.anchor(Some(body), 0).point.expect("a point");
    let mut model = builder.model;
    for (joint, (_, [_, rate])) in model.joints.iter_mut().zip(joints) {
        joint.initial[1] = *rate;
    }
    model.forces.push(Sensor {
        name: "wheel".to_owned(),
        point,
        asks: Asks::default(),
    });
    assert!(model.check());
    model
}

/// Height of a wheel that carries its weight.
fn height() -> f64 {
    RADIUS - MASS * GRAVITY / STIFFNESS
}

/// A wheel that rolls along the first axis.
fn rolling(velocity: f64) -> Model {
    wheel(&[
        ("T1", [0.0, velocity]),
        ("T3", [height(), 0.0]),
        ("R2", [0.4, velocity / RADIUS]),
    ])
}

fn run(model: &Model, text: &str, duration: f64) -> SimulationRun {
    let laws = Laws::parse(model, text).unwrap_or_else(|errors| panic!("{errors:?}"));
    run_with(model, laws, &EquationSetting::default(), duration, FINE)
}

#[test]
fn a_wheel_that_rolls_freely_keeps_its_velocity() {
    for law in [LINEAR, BAKKER] {
        let run = run(&rolling(20.0), &format!("{PLANE}{law}"), 2.0);
        for sample in &run.samples {
            let state = &sample.state;
            assert!((state.qd[0] - 20.0).abs() < 1e-9, "{}", state.qd[0]);
            assert!((state.q[0] - 20.0 * state.time).abs() < 1e-8);
            assert!((state.q[1] - height()).abs() < 1e-9);
            assert!(sample.work.abs() < 1e-9);
        }
    }
}

/// Under a torque `T` slip is constant: `m v' = C k`, `I w' = -T - r C k`, and
/// `r w = (1 + k) v` give `I C k (1 + k) / (m r) + r C k + T = 0`.
#[test]
fn a_braked_wheel_reaches_its_slip() {
    let (slope, torque) = (8e4, 400.0);
    let text = format!("{PLANE}{LINEAR}slip = 1e-4\n[[joint]]\nname = 'R2_3'\nforce = -400.0\n");
    let run = run(&rolling(30.0), &text, 1.0);
    let square = INERTIA * slope / (MASS * RADIUS);
    let linear = square + RADIUS * slope;
    let root = (linear * linear - 4.0 * square * torque).sqrt();
    let slip = -2.0 * torque / (linear + root);
    let last = &run.samples.last().expect("samples").state;
    let found = RADIUS * last.qd[2] / last.qd[0] - 1.0;
    assert!((found - slip).abs() < 1e-8, "{found} {slip}");
    // Whatever the law, the force at the ground changes both momenta.
    let start = &run.samples[0].state;
    let turned = INERTIA * (last.qd[2] - start.qd[2]);
    let travelled = RADIUS * MASS * (last.qd[0] - start.qd[0]);
    let braked = turned + travelled + torque * last.time;
    assert!(braked.abs() < 1e-6, "{braked}");
    assert!(run.energy_drift() < 1e-5, "{:e}", run.energy_drift());
}

/// Across a rolling wheel `m y'' = -C y' / V`.
#[test]
fn lateral_velocity_decays_as_the_slope_gives() {
    let model = wheel(&[
        ("T1", [0.0, 10.0]),
        ("T2", [0.0, 0.2]),
        ("T3", [height(), 0.0]),
        ("R2", [0.0, 10.0 / RADIUS]),
    ]);
    let run = run(&model, &format!("{PLANE}{LINEAR}slip = 0.5\n"), 0.3);
    let rate = 6e4 / (MASS * 10.0f64.hypot(0.5));
    for sample in &run.samples {
        let expected = 0.2 * (-rate * sample.state.time).exp();
        let found = sample.state.qd[1];
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        assert!((sample.state.qd[0] - 10.0).abs() < 1e-9);
    }
    assert!(run.energy_drift() < 1e-7, "{:e}", run.energy_drift());
}

/// A wheel free in space that falls on the ground and staggers: energy changes
/// by the work, forces stay in the ellipse.
#[test]
fn a_staggering_wheel_keeps_the_balance() {
    let model = wheel(&[
        ("T1", [0.0, 4.0]),
        ("T2", [0.0, 0.6]),
        ("T3", [0.31, 0.0]),
        ("R3", [0.2, 1.0]),
        ("R1", [0.1, -0.3]),
        ("R2", [0.0, 5.0]),
    ]);
    for (law, peaks) in [(LINEAR, [0.9, 0.9]), (BAKKER, [1.0, 0.9])] {
        let text = format!("{PLANE}{law}damping = 500.0\nnormal = [0.02, -0.03, 1]\n");
        let laws = Laws::parse(&model, &text).expect("laws");
        let setting = EquationSetting::default();
        let run = run_with(&model, laws.clone(), &setting, 0.5, FINE);
        let drift = run.energy_drift();
        assert!(drift < 1e-8 * run.energy_scale(), "{drift:e}");
        let (system, _) = MultibodySystem::new(&model, laws, &setting).expect("a system");
        let (mut touched, mut largest) = (0, 0.0f64);
        for sample in &run.samples {
            let force = &system.loaded(&sample.state).external[0];
            let normal = [0.02, -0.03, 1.0].map(|part: f64| part / 1.0013f64.sqrt());
            let pressure: f64 = (0..3).map(|k| force[k] * normal[k]).sum();
            let along: Vec<f64> = (0..3).map(|k| force[k] - pressure * normal[k]).collect();
            let size = along.iter().map(|part| part * part).sum::<f64>().sqrt();
            assert!(size <= peaks[0] * pressure * (1.0 + 1e-9) + 1e-9);
            touched += u32::from(pressure > 0.0);
            largest = largest.max(size / pressure.max(1e-9));
        }
        assert!(touched > 10 && run.contacts > 0, "{touched}");
        assert!(largest > 0.7, "{largest}");
        let last = run.samples.last().expect("samples");
        assert!(last.work < -30.0, "{}", last.work);
    }
}

/// At standstill the slope over `slip` is a damper at the ground, the spring
/// holds the height, and the weight tips the wheel over.
#[test]
fn small_motions_at_standstill_are_those_of_a_damper() {
    let still = [0.0, 0.0];
    let model = wheel(&[
        ("T1", still),
        ("T2", still),
        ("T3", [height(), 0.0]),
        ("R1", still),
        ("R2", still),
    ]);
    let bakker = [12.0 * 1.65, 10.0 * 1.3 * 0.9].map(|slope| slope * MASS * GRAVITY);
    for (law, slopes) in [(LINEAR, [8e4, 6e4]), (BAKKER, bakker)] {
        let text = format!("{PLANE}{law}slip = 0.4\n");
        let laws = Laws::parse(&model, &text).expect("laws");
        let setting = EquationSetting::default();
        let (system, initial) = MultibodySystem::new(&model, laws, &setting).expect("a system");
        let motions = system.linearise(&initial).expect("small motions");
        let [along, across] = slopes.map(|slope| slope / 0.4);
        let mut damping = [[0.0; 5]; 5];
        let mut stiffness = [[0.0; 5]; 5];
        for (first, turn, slope, arm) in [(0, 4, along, -RADIUS), (1, 3, across, RADIUS)] {
            damping[first][first] = slope;
            damping[first][turn] = slope * arm;
            damping[turn][first] = slope * arm;
            damping[turn][turn] = slope * arm * arm;
        }
        stiffness[2][2] = STIFFNESS;
        stiffness[3][3] = -MASS * GRAVITY * RADIUS;
        for (found, expected) in [(motions.damping, damping), (motions.stiffness, stiffness)] {
            for (row, numbers) in expected.iter().enumerate() {
                for (column, number) in numbers.iter().enumerate() {
                    let error = (found[(row, column)] - number).abs();
                    assert!(error < 1e-7, "{row} {column}: {error:e}");
                }
            }
        }
    }
}

/// The gap of an event is that of the lowest point of the wheel.
#[test]
fn a_wheel_touches_after_its_fall() {
    let model = wheel(&[("T3", [0.8, 0.0]), ("R2", [0.0, 3.0])]);
    let text = format!(
        "{PLANE}{LINEAR}place = [5, 0, 0.1]\n\
         [[event]]\nname = 'wheel'\nquantity = 'gap'\ndirection = 'falling'\n"
    );
    let run = run(&model, &text, 0.5);
    let fall = (2.0f64 * 0.4 / GRAVITY).sqrt();
    let time = run.events[0].time;
    assert!((time - fall).abs() < 2e-9, "{time} {fall}");
}

#[test]
fn tyres_are_read_back() {
    let model = rolling(1.0);
    for text in [
        format!("{PLANE}{LINEAR}axis = [0, 1, 0.1]\nplace = [1, 2, -0.5]\nslip = 0.2\n"),
        format!("{PLANE}{BAKKER}damping = 20.0\nnormal = [0.0, 0.1, 1.0]\n"),
    ] {
        let laws = Laws::parse(&model, &text).expect("laws");
        let written = laws.to_text(&model);
        let again = Laws::parse(&model, &written).expect("its own text");
        assert_eq!(laws, again, "{written}");
    }
}

#[test]
fn a_named_entry_has_priority_over_that_of_all() {
    let model = rolling(1.0);
    let contact = |name: &str| format!("[[contact]]\nname = '{name}'\nstiffness = 1e3\n");
    let tyre = |name: &str| format!("{PLANE}{LINEAR}").replace("'wheel'", &format!("'{name}'"));
    for (names, is_tyre) in [(["*", "wheel"], true), (["wheel", "*"], false)] {
        let text = contact(names[0]) + &tyre(names[1]);
        let law = Laws::parse(&model, &text).expect("laws").forces[0];
        assert_eq!(law.tyre.is_some(), is_tyre);
        assert_eq!(law.contact.acts(), !is_tyre);
    }
}

#[test]
fn wrong_tyres_are_pointed_at() {
    let model = rolling(1.0);
    let linear = format!("{PLANE}{LINEAR}");
    for (text, word) in [
        (linear.replace("radius = 0.3", ""), "missing field `radius`"),
        (linear.replace("radius = 0.3", "radius = 0"), "'radius'"),
        (
            linear.replace("stiffness = 2e5", ""),
            "missing field `stiffness`",
        ),
        (linear.replace("law = 'linear'", ""), "missing field `law`"),
        (linear.replace("'linear'", "'brush'"), "brush"),
        (linear.replace("friction = 0.9", ""), "needs `friction`"),
        (
            linear.replace("lateral = 6e4", ""),
            "missing field `lateral`",
        ),
        (
            linear.replace("lateral = 6e4", "lateral = 'soft'"),
            "is a number",
        ),
        (
            linear.replace("friction = 0.9", "friction = -1"),
            "'friction'",
        ),
        (format!("{linear}normal = [0, 0, 0]\n"), "normal of a plane"),
        (format!("{linear}axis = [0, 0.0, 0]\n"), "axis of a wheel"),
        (
            format!(
                "{linear}axis = [{:?}, 0, {:?}]\n",
                -(0.4f64.sin()),
                0.4f64.cos()
            ),
            "lies flat",
        ),
        (format!("{linear}camber = 0.1\n"), "camber"),
        (format!("{PLANE}{BAKKER}friction = 0.3\n"), "no `friction`"),
        (
            format!("{PLANE}{BAKKER}").replace("C = 1.3, ", ""),
            "missing field `C`",
        ),
        (
            format!("{PLANE}{BAKKER}").replace("C = 1.3", "C = 2.5"),
            "'C'",
        ),
        (
            format!("{PLANE}{BAKKER}").replace("E = -1", "E = 1.5"),
            "'E'",
        ),
        (linear.replace("'wheel'", "'whel'"), "no external force"),
        (
            format!("[[contact]]\nname = 'wheel'\nstiffness = 1.0\n{linear}"),
            "a contact already",
        ),
    ] {
        let errors = Laws::parse(&model, &text).expect_err(&text);
        let found = errors.iter().find(|error| error.message.contains(word));
        let found = found.unwrap_or_else(|| panic!("{text}: {errors:?}"));
        let range = found.labels[0].range.clone();
        assert!(["'wheel'", "'whel'"].contains(&&text[range]), "{text}");
    }
}
