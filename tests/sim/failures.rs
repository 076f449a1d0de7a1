//! Models that cannot move, and laws that are none: clear errors.

use super::models::{Builder, Solid, double_pendulum, four_bar, runge_kutta};
use robovec::kinematics::{Partition, StateError};
use robovec::model::{CutKind, Model, Nature};
use robovec::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, MotionError, MultibodySystem,
    SimulationPlan, simulate,
};

fn error(model: &Model, text: &str, method: IntegrationMethod, limit: u64) -> MotionError {
    let laws = Laws::parse(model, text).expect("laws");
    let plan = SimulationPlan {
        duration: 1.0,
        samples: 10,
        method,
        step_limit: limit,
        event_tolerance: EVENT_TOLERANCE,
    };
    MultibodySystem::new(model, laws, &EquationSetting::default())
        .and_then(|(mut system, initial)| simulate(&mut system, &initial, &plan, &mut |_| {}))
        .expect_err("it cannot move")
}

fn fixed(model: &Model) -> MotionError {
    error(model, "", runge_kutta(0.01), 10_000)
}

#[test]
fn a_massless_leaf_is_named() {
    let mut model = double_pendulum();
    model.bodies[1].mass = 0.0;
    model.bodies[1].inertia = [0.0; 6];
    let error = fixed(&model);
    let MotionError::Singular { joints, time } = &error else {
        panic!("{error}");
    };
    assert_eq!((joints.join(" ").as_str(), *time), ("R2_2", 0.0));
    assert!(error.advice().is_some());
    // Both joints at once, not the second after the first is held.
    model.bodies[0].mass = 0.0;
    model.bodies[0].inertia = [0.0; 6];
    let error = fixed(&model).to_string();
    assert!(
        error.contains("at the joints 'R2_1', 'R2_2': what they move"),
        "{error}"
    );
}

#[test]
fn two_joints_that_do_the_same_are_named() {
    let mut builder = Builder::new(&[]);
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 1.0,
        center: [0.3, 0.0, 0.0],
        inertia: [0.1; 3],
        points: &[],
    };
    let slide = |start| ("T1", Nature::Independent, start);
    builder.body(base, &[slide(0.1), slide(0.2)], &solid);
    let error = fixed(&builder.model);
    assert!(
        matches!(&error, MotionError::Singular { joints, .. } if joints[..] == ["T1_2"]),
        "{error}"
    );
}

#[test]
fn a_loop_that_cannot_close_is_named() {
    let mut model = four_bar();
    // The right-hand bearing is out of reach.
    model.points[1].coordinates[0] = 5.0;
    let error = fixed(&model);
    let MotionError::State(StateError::OpenLoop { cut, gap, .. }) = &error else {
        panic!("{error}");
    };
    assert_eq!(cut, "cut1");
    assert!(*gap > 1.0);
    // Bars of 0.4, 1, 0.5 and 0.8 m in a row are 2.3 m too short.
    model.cuts[0].kind = CutKind::Rod(0.5);
    let message = fixed(&model).to_string();
    assert!(
        message.ends_with("its ends miss the length of the rod by 2.300e0"),
        "{message}"
    );
}

#[test]
fn constraints_that_follow_from_others_only_at_the_start_are_named() {
    let mut builder = Builder::new(&[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let rods = [builder.anchor(None, 0), builder.anchor(None, 1)];
    let base = builder.anchor(None, 0);
    let solid = Solid {
        mass: 1.0,
        center: [0.0; 3],
        inertia: [0.1; 3],
        points: &[],
    };
    let slides = [
        ("T1", Nature::Dependent, 1.0),
        ("T3", Nature::Independent, 0.0),
    ];
    // A body between two rods in a line falls: the second rod holds it.
    let body = builder.body(base, &slides, &solid);
    for rod in rods {
        let end = builder.anchor(Some(body), 0);
        builder.cut(CutKind::Rod(1.0), [rod, end]);
    }
    let error = fixed(&builder.model);
    let MotionError::State(StateError::Overdetermined { cut, .. }) = &error else {
        panic!("{error}");
    };
    assert_eq!(cut, "cut2");
    assert!(error.advice().is_some());
}

#[test]
fn a_loop_that_reaches_a_dead_point_says_when() {
    let mut model = four_bar();
    // A crank that is driven round where the linkage lets it only swing.
    model.points[1].coordinates[0] = 1.6;
    model.joints[0].nature = Nature::Driven;
    let text = "[[driven]]\nname = 'R2_1'\namplitude = 3.0\nfrequency = 3.0\n";
    let error = error(&model, text, runge_kutta(0.01), 10_000);
    assert!(
        matches!(error, MotionError::State(StateError::OpenLoop { time, .. }) if time > 0.0 && time < 1.0),
        "{error}"
    );
}

#[test]
fn dependent_joints_are_chosen_where_the_models_do_not_serve() {
    let mut model = four_bar();
    // Named the wrong way round, or not at all.
    for natures in [
        [Nature::Dependent, Nature::Independent, Nature::Independent],
        [Nature::Independent; 3],
        [Nature::Dependent; 3],
    ] {
        for (joint, nature) in model.joints.iter_mut().zip(natures) {
            joint.nature = nature;
        }
        let laws = Laws::of_model(&model);
        let (system, _) =
            MultibodySystem::new(&model, laws, &EquationSetting::default()).expect("a system");
        let Partition {
            independent,
            dependent,
            rows,
            chosen,
            ..
        } = system.partition();
        assert_eq!((independent.len(), dependent.len(), rows.len()), (1, 2, 2));
        assert!(*chosen);
    }
}

#[test]
fn redundant_cuts_are_borne() {
    let mut model = four_bar();
    // The same cut twice, and the length of a bar once more as a rod.
    let mut again = model.cuts[0].clone();
    again.name = "again".to_owned();
    model.cuts.push(again.clone());
    again.name = "length".to_owned();
    again.kind = CutKind::Rod(1.0);
    again.ends[0].body = Some(0);
    again.ends[0].point = Some(2);
    model.cuts.push(again);
    assert!(model.check());
    let run = super::models::run(&model, 1.0, runge_kutta(0.005));
    let single = super::models::run(&four_bar(), 1.0, runge_kutta(0.005));
    for (one, other) in run.samples.iter().zip(&single.samples) {
        for (one, other) in one.state.q.iter().zip(&other.state.q) {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
    }
}

#[test]
fn laws_that_are_too_stiff_end_the_run() {
    let model = double_pendulum();
    let stiff = "[[joint]]\nname = '*'\nstiffness = 1e9\nneutral = 0.0\n";
    let error = error(&model, stiff, runge_kutta(0.01), 10_000);
    assert!(
        matches!(error, MotionError::State(StateError::NotFinite { .. })),
        "{error}"
    );
    let adaptive = IntegrationMethod::DormandPrince {
        relative: 1e-8,
        absolute: 1e-8,
    };
    let error = self::error(&model, stiff, adaptive, 500);
    assert_eq!(error, MotionError::TooManySteps(500));
}

#[test]
fn wrong_laws_are_pointed_at() {
    let mut model = four_bar();
    model.joints[0].nature = Nature::Driven;
    model.joints[0].has_velocity = false;
    for (text, place, words) in [
        ("[[joint]]\nname = 'R2_9'", "'R2_9'", "no joint 'R2_9'"),
        (
            "[[joint]]\nname = 'R2_1'\nstifness = 1.0",
            "'R2_1'",
            "stifness",
        ),
        (
            "[[joint]]\nname = 'R2_1'\ndamping = nan",
            "'R2_1'",
            "NaN is not allowed",
        ),
        ("[[joints]]\nname = 'R2_1'", "joints", "unknown field"),
        (
            "[[joint]]\nstiffness = 1",
            "[[joint]]",
            "missing field `name`",
        ),
        ("[[joint]]\nname = 3", "3", "expected a string"),
        ("[[joint]", "]", "expected"),
        (
            "[[joint]]\nname='R2_2'\n[[joint]]\nname=\"R2_2\"",
            "\"R2_2\"",
            "has a law already",
        ),
        ("[[driven]]\nname = 'R2_2'", "'R2_2'", "is not driven"),
        ("[[driven]]\nname = 'R2_1'", "'R2_1'", "no symbol"),
        ("[[link]]\nname = 'R2_1'", "'R2_1'", "no link"),
        (
            "[[joint]]\nname = 'R2_1'\ndamping = 'much'",
            "'R2_1'",
            "invalid type",
        ),
    ] {
        let errors = Laws::parse(&model, text).expect_err(text);
        assert_eq!(errors.len(), 1, "{text}: {errors:?}");
        let message = &errors[0].message;
        assert!(message.contains(words), "{text}: {message}");
        let range = errors[0].labels[0].range.clone();
        assert!(
            text[range.clone()].contains(place) || place.contains(&text[range.clone()]),
            "{text}: {range:?}"
        );
    }
}
