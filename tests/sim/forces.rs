//! Springs, dampers, drives and external forces: energy less work stays.

use super::models::{
    Builder, Solid, double_pendulum, four_bar, run_with, runge_kutta, spring_mechanism,
};
use robovec::kinematics::MotionState;
use robovec::model::{Asks, Model, Nature, Sensor};
use robovec::motion::{EquationSetting, IntegrationMethod, Laws, MotionEquations, SimulationRun};

const FINE: IntegrationMethod = IntegrationMethod::DormandPrince {
    relative: 1e-11,
    absolute: 1e-11,
};

fn laws(model: &Model, text: &str) -> Laws {
    Laws::parse(model, text).unwrap_or_else(|errors| panic!("{text}: {errors:?}"))
}

fn run(model: &Model, text: &str) -> SimulationRun {
    run_with(
        model,
        laws(model, text),
        &EquationSetting::default(),
        2.0,
        FINE,
    )
}

/// Demands that energy changes by the work alone, and that there is some.
fn assert_balance(run: &SimulationRun) {
    let drift = run.energy_drift();
    assert!(drift < 1e-8 * run.energy_scale().max(1.0), "{drift:e}");
    assert!(run.samples.iter().any(|sample| sample.work.abs() > 1e-2));
}

#[test]
fn dampers_take_what_energy_loses() {
    let text = "[[joint]]\nname = '*'\nstiffness = 3.0\ndamping = 0.5\nneutral = 0.2\n";
    for model in [double_pendulum(), four_bar()] {
        let run = run(&model, text);
        assert_balance(&run);
        let last = run.samples.last().expect("samples");
        assert!(last.work < 0.0);
        assert!(last.energy.springs > 0.0);
    }
}

#[test]
fn drives_put_in_what_energy_gains() {
    for (model, joint) in [(double_pendulum(), 0), (four_bar(), 0)] {
        let mut model = model;
        model.joints[joint].nature = Nature::Driven;
        let name = &model.joints[joint].name;
        // A spring and a damper on the driven joint share the work.
        let text = format!(
            "[[driven]]\nname = '{name}'\namplitude = 0.4\nfrequency = 7.0\nphase = 0.3\n\
             [[joint]]\nname = '*'\ndamping = 0.05\nstiffness = 0.5\n"
        );
        let run = run(&model, &text);
        assert_balance(&run);
        for sample in &run.samples {
            let expected =
                model.joints[joint].initial[0] + 0.4 * (7.0 * sample.state.time + 0.3).sin();
            assert_eq!(sample.state.q[joint], expected);
        }
    }
}

#[test]
fn links_and_external_forces_do_their_work() {
    let (model, text) = spring_mechanism();
    let run = run(&model, text);
    assert_balance(&run);
    let springs = run.samples.iter().map(|sample| sample.energy.springs);
    assert!(springs.fold(0.0, f64::max) > 1e-2, "the link's spring acts");
}

/// Bodies connected by joints and springs only to a first joint keep the
/// momentum along it: forces between them are opposite.
#[test]
fn inner_forces_leave_momentum() {
    let free = |kind| (kind, Nature::Independent, 0.1);
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 2.0,
        center: [0.1, -0.1, 0.2],
        inertia: [0.3, 0.4, 0.5],
        points: &[[0.5, 0.2, -0.3], [0.2, 0.6, 0.1]],
    };
    let floating = ["T1", "T2", "T3", "R3", "R1", "R2"].map(free);
    let first = builder.body(base, &floating, &solid);
    let on = builder.anchor(Some(first), 0);
    let second = builder.body(on, &[free("R1"), free("R2")], &solid);
    let ends = [
        builder.anchor(Some(first), 1),
        builder.anchor(Some(second), 1),
    ];
    builder.link(ends);
    let mut model = builder.model;
    model.gravity = [0.0; 3];
    for joint in &mut model.joints {
        joint.initial[1] = 0.7;
    }
    let text = "[[link]]\nname = '*'\nstiffness = 20.0\ndamping = 0.3\nneutral = 0.2\n\
                [[joint]]\nname = 'R1_7'\ndamping = 0.1\n";
    let run = run(&model, text);
    assert_balance(&run);
    let equations = MotionEquations::new(&model, &EquationSetting::default()).expect("equations");
    let momentum = |state: &MotionState| {
        let momentum = equations.dynamics(state).0.times(&state.qd);
        [momentum[0], momentum[1], momentum[2]]
    };
    let start = momentum(&run.samples[0].state);
    assert!(start.iter().all(|component| component.abs() > 0.5));
    for sample in &run.samples {
        for (now, start) in momentum(&sample.state).iter().zip(start) {
            assert!((now - start).abs() < 1e-9, "{now} was {start}");
        }
    }
}

/// About an axis along gravity the base's first rotation keeps its momentum.
#[test]
fn gravity_along_an_axis_leaves_the_momentum_about_it() {
    let free = |kind, start| (kind, Nature::Independent, start);
    let mut builder = Builder::new(&[]);
    let mut on = builder.anchor(None, 0);
    let solid = Solid {
        mass: 1.0,
        center: [0.3, 0.1, -0.2],
        inertia: [0.1, 0.2, 0.3],
        points: &[[0.6, -0.1, -0.2]],
    };
    for kind in ["R3", "R2", "R1"] {
        let body = builder.body(on, &[free(kind, 0.4)], &solid);
        on = builder.anchor(Some(body), 0);
    }
    let mut model = builder.model;
    model.joints[0].initial[1] = 2.0;
    let plain = Laws::of_model(&model);
    let run = run_with(
        &model,
        plain,
        &EquationSetting::default(),
        2.0,
        runge_kutta(0.001),
    );
    let equations = MotionEquations::new(&model, &EquationSetting::default()).expect("equations");
    let momentum = |state: &MotionState| equations.dynamics(state).0.times(&state.qd)[0];
    let start = momentum(&run.samples[0].state);
    for sample in &run.samples {
        assert!((momentum(&sample.state) - start).abs() < 1e-9);
    }
}

/// A mass on a spring whose other end moves: the forced oscillation in closed
/// form, and energy including the work of the moving end.
#[test]
fn a_moving_place_forces_an_oscillation() {
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 2.0,
        center: [0.0; 3],
        inertia: [0.0; 3],
        points: &[[0.0; 3]],
    };
    let cart = builder.body(base, &[("T1", Nature::Independent, 0.0)], &solid);
    let point = builder.anchor(Some(cart), 0).point.expect("it is there");
    let mut model = builder.model;
    let name = "shaker";
    model.forces.push(Sensor {
        name: name.to_owned(),
        point,
        asks: Asks::default(),
    });
    let (stiffness, frequency, amplitude) = (18.0_f64, 5.0_f64, 0.25);
    let text = format!(
        "[[force]]\nname = '{name}'\nstiffness = [{stiffness:?}, 0, 0]\n\
         amplitude = [{amplitude:?}, 0, 0]\nfrequency = {frequency:?}\n"
    );
    let run = run(&model, &text);
    assert_balance(&run);
    // x'' + w^2 (x - a sin f t) = 0 from rest.
    let own = (stiffness / 2.0).sqrt();
    let gain = own * own * amplitude / (own * own - frequency * frequency);
    for sample in &run.samples {
        let time = sample.state.time;
        let expected = gain * ((frequency * time).sin() - frequency / own * (own * time).sin());
        assert!((sample.state.q[0] - expected).abs() < 1e-8);
    }
}
