//! Contact and dry friction against closed formulas.

use super::models::{Builder, Solid, run_with};
use robovec::model::{Asks, Model, Nature, Sensor};
use robovec::motion::{EquationSetting, IntegrationMethod, Laws, SimulationRun};

const FINE: IntegrationMethod = IntegrationMethod::DormandPrince {
    relative: 1e-12,
    absolute: 1e-12,
};

/// A mass of 2 kg that slides along x and z, with an external force at its
/// centre; where it starts, and how fast.
fn mass(start: [f64; 2], rate: [f64; 2]) -> Model {
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 2.0,
        center: [0.0; 3],
        inertia: [0.1; 3],
        points: &[[0.0; 3]],
    };
    let joints = [
        ("T1", Nature::Independent, start[0]),
        ("T3", Nature::Independent, start[1]),
    ];
    let body = builder.body(base, &joints, &solid);
    let point = builder.anchor(Some(body), 0).point.expect("a point");
    let mut model = builder.model;
    for (joint, rate) in model.joints.iter_mut().zip(rate) {
        joint.initial[1] = rate;
    }
    model.forces.push(Sensor {
        name: "foot".to_owned(),
        point,
        asks: Asks::default(),
    });
    assert!(model.check());
    model
}

fn run(model: &Model, text: &str, duration: f64) -> SimulationRun {
    let laws = Laws::parse(model, text).unwrap_or_else(|errors| panic!("{errors:?}"));
    run_with(model, laws, &EquationSetting::default(), duration, FINE)
}

const GRAVITY: f64 = 9.81;

#[test]
fn a_mass_bounces_as_the_formula_says() {
    let model = mass([0.0, 0.3], [0.0; 2]);
    let stiffness = 5e3;
    let text = format!(
        "[[contact]]\nname = 'foot'\nplace = [0, 0, 0.1]\nstiffness = {stiffness:?}\n\
         [[event]]\nname = 'foot'\nquantity = 'gap'\n"
    );
    let run = run(&model, &text, 0.5);
    let fall = (2.0f64 * 0.2 / GRAVITY).sqrt();
    let omega = (stiffness / 2.0f64).sqrt();
    let half = std::f64::consts::PI - (GRAVITY * fall * omega / GRAVITY).atan();
    let expected = [fall, fall + 2.0 * half / omega];
    let times: Vec<f64> = run.events.iter().map(|event| event.time).collect();
    assert_eq!(times.len(), 2, "{times:?}");
    for (time, expected) in times.iter().zip(expected) {
        assert!((time - expected).abs() < 2e-9, "{time} {expected}");
    }
    assert_eq!(run.contacts, 2);
    assert!(run.events[1].rising && !run.events[0].rising);
    assert!(run.energy_drift() < 1e-9, "{:e}", run.energy_drift());
    // What the spring holds at the lowest sample is energy, and no work.
    let springs = run.samples.iter().map(|sample| sample.energy.springs);
    assert!(springs.fold(0.0, f64::max) > 0.1);
    assert!(run.samples.iter().all(|sample| sample.work == 0.0));
}

#[test]
fn a_damper_in_a_contact_takes_energy_and_never_pulls() {
    let model = mass([0.0, 0.3], [0.0; 2]);
    let text = "[[contact]]\nname = '*'\nstiffness = 5e3\ndamping = 60.0\n";
    let run = run(&model, text, 2.0);
    let last = run.samples.last().expect("samples");
    assert!(last.work < -1.0, "{}", last.work);
    // The force jumps where contact opens with a speed; steps are cut there.
    assert!(run.energy_drift() < 1e-8, "{:e}", run.energy_drift());
    // It rests where the spring carries it.
    let rest = -2.0 * GRAVITY / 5e3;
    assert!((last.state.q[1] - rest).abs() < 1e-4, "{}", last.state.q[1]);
}

/// Time of dry friction from one speed to another: the integral of `sqrt(v^2 +
/// s^2) / v` over the deceleration of full friction.
fn slowing([from, to]: [f64; 2], slip: f64, deceleration: f64) -> f64 {
    let primitive = |v: f64| {
        let root = v.hypot(slip);
        root + slip * (v / (slip + root)).ln()
    };
    (primitive(from) - primitive(to)) / deceleration
}

#[test]
fn friction_slows_joints_and_contacts_as_the_integral_says() {
    let (slip, share) = (0.02, 0.4);
    let sunk = 2.0 * GRAVITY / 1e4;
    let event = "[[event]]\nname = 'T1_1'\nquantity = 'velocity'\nvalue = 0.01\nstop = true\n";
    let deceleration = share * GRAVITY;
    let expected = slowing([1.5, 0.01], slip, deceleration);
    // Weight presses the one, a force of the same size acts in the other, and
    // a plane that stands upright is the third.
    let contact = format!(
        "[[contact]]\nname = 'foot'\nstiffness = 1e4\nfriction = {share:?}\nslip = {slip:?}\n\
         normal = [0, 0, 3]\n{event}"
    );
    let joint = format!(
        "[[joint]]\nname = 'T1_1'\nfriction = {:?}\nslip = {slip:?}\n{event}",
        2.0 * deceleration
    );
    for (text, start) in [(contact, -sunk), (joint, 0.0)] {
        let run = run(&mass([0.0, start], [1.5, 0.0]), &text, 2.0);
        let stopped = run.stopped.expect("it stops");
        assert!((stopped - expected).abs() < 1e-8, "{stopped} {expected}");
        assert_eq!(run.events.len(), 1);
        let last = run.samples.last().expect("samples");
        assert_eq!(last.state.time, stopped);
        // All of the motion along x is in the work.
        let lost = 0.5 * 2.0 * (1.5f64.powi(2) - 0.01f64.powi(2));
        assert!((last.work + lost).abs() < 1e-7, "{} {lost}", last.work);
        assert!(run.energy_drift() < 1e-8, "{:e}", run.energy_drift());
    }
}

#[test]
fn a_quantity_that_passes_and_comes_back_within_a_step_is_seen() {
    // A parabola is no trouble for the integrator: its steps are as long as
    // the samples are apart.
    let model = mass([0.0, 0.0], [0.0, 1.0]);
    let top = 1.0 / (2.0 * GRAVITY);
    let value = top - 1e-6;
    let text = format!("[[event]]\nname = 'T3_2'\nvalue = {value:?}\n");
    for method in [FINE, IntegrationMethod::RungeKutta { step: 1.0 }] {
        let laws = Laws::parse(&model, &text).expect("laws");
        let run = run_with(&model, laws, &EquationSetting::default(), 4.0, method);
        let half = (2e-6f64 / GRAVITY).sqrt();
        let expected = [1.0 / GRAVITY - half, 1.0 / GRAVITY + half];
        assert_eq!(run.events.len(), 2, "{:?}", run.events);
        for (event, expected) in run.events.iter().zip(expected) {
            assert!((event.time - expected).abs() < 2e-9, "{event:?} {expected}");
        }
    }
}

#[test]
fn events_have_directions() {
    let model = mass([0.0, 0.0], [0.0, 1.0]);
    for (direction, times) in [("rising", 0), ("falling", 1), ("both", 1)] {
        let text =
            format!("[[event]]\nname = 'T3_2'\nquantity = 'velocity'\ndirection = '{direction}'\n");
        let run = run(&model, &text, 0.5);
        assert_eq!(run.events.len(), times, "{direction}");
        for event in &run.events {
            assert!((event.time - 1.0 / GRAVITY).abs() < 2e-9);
        }
    }
}

#[test]
fn laws_of_contact_and_events_are_read_back() {
    let model = mass([0.0, 0.3], [0.0; 2]);
    let text = "[[contact]]\nname = 'foot'\nplace = [0.0, 0.5, 0.1]\nnormal = [0.0, 1.0, 1.0]\n\
                stiffness = 5e3\ndamping = 3.0\nfriction = 0.4\nslip = 0.1\n\
                [[joint]]\nname = 'T1_1'\nfriction = 2.0\nslip = 0.3\n\
                [[event]]\nname = 'foot'\nquantity = 'gap'\ndirection = 'falling'\nvalue = 0.2\n\
                [[event]]\nname = 'T1_1'\nstop = true\n";
    let laws = Laws::parse(&model, text).expect("laws");
    let again = Laws::parse(&model, &laws.to_text(&model)).expect("its own text");
    assert_eq!(laws, again);
}

#[test]
fn laws_that_are_none_are_refused() {
    let model = mass([0.0, 0.3], [0.0; 2]);
    for (text, word) in [
        (
            "[[contact]]\nname = 'foot'\nnormal = [0, 0.0, 0]\n",
            "direction",
        ),
        ("[[contact]]\nname = 'fot'\n", "no external force"),
        ("[[contact]]\nname = 'foot'\nfriction = -0.1\n", "friction"),
        ("[[joint]]\nname = '*'\nslip = 0.0\n", "slip"),
        ("[[event]]\nname = 'foot'\n", "no joint 'foot'"),
        (
            "[[event]]\nname = 'T1_1'\nquantity = 'gap'\n",
            "no external force",
        ),
        ("[[event]]\nname = 'T1_1'\nquantity = 'speed'\n", "speed"),
        ("[[event]]\nname = 'T1_1'\nsubject = 7\n", "subject"),
    ] {
        let errors = Laws::parse(&model, text).expect_err(text);
        let said = errors.iter().any(|error| error.message.contains(word));
        assert!(said, "{text}: {errors:?}");
    }
}
