//! Motion by the generated functions of the whole step, and loops that are
//! kept closed in other ways.

use super::models::{double_pendulum, four_bar, runge_kutta, spring_mechanism};
use robovec::model::family::built_in;
use robovec::model::{Model, Nature};
use robovec::motion::{
    EVENT_TOLERANCE, EquationSetting, IntegrationMethod, Laws, LoopKeeping, MotionError,
    MultibodySystem, SimulationPlan, SimulationRun, simulate,
};
use robovec_ir::{Format, Machine};
use robovec_passes::registry::REGISTRY;

const WHOLE: EquationSetting<'static> = EquationSetting {
    formulation: robovec::generate::Formulation::Recursive,
    passes: None,
    format: Format::BINARY64,
    accelerations: false,
    whole_step: true,
    scene: None,
    program: None,
};

fn tried(
    model: &Model,
    setting: &EquationSetting<'_>,
    keeping: LoopKeeping,
    method: IntegrationMethod,
) -> Result<SimulationRun, MotionError> {
    let plan = SimulationPlan {
        duration: 1.0,
        samples: 20,
        method,
        step_limit: 100_000,
        event_tolerance: EVENT_TOLERANCE,
    };
    let (mut system, initial) = MultibodySystem::new(model, Laws::of_model(model), setting)?;
    system.keep_loops(keeping);
    simulate(&mut system, &initial, &plan, &mut |_| {})
}

fn run(model: &Model, setting: &EquationSetting<'_>, keeping: LoopKeeping) -> SimulationRun {
    tried(model, setting, keeping, runge_kutta(0.005)).expect("a run")
}

fn distance(left: &SimulationRun, right: &SimulationRun, model: &Model) -> f64 {
    let joints = 0..model.joints.len();
    joints.fold(0.0, |most, joint| left.distance(right, joint).max(most))
}

fn models() -> [Model; 4] {
    [
        double_pendulum(),
        four_bar(),
        built_in("slider-crank").expect("a family"),
        spring_mechanism().0,
    ]
}

#[test]
fn the_whole_step_moves_models_as_dense_solutions_do() {
    let machine = Machine::built_in("thesis").expect("the thesis' machine");
    let pipeline = REGISTRY
        .pipeline("atomise,zero-removal,balance,cse,dce")
        .expect("a pipeline");
    for model in models() {
        let dense = EquationSetting::default();
        let passed = EquationSetting {
            passes: Some((&pipeline, &machine)),
            ..WHOLE
        };
        for keeping in [
            LoopKeeping::Project,
            LoopKeeping::Stabilise { rate: 20.0 },
            LoopKeeping::Free,
        ] {
            let expected = run(&model, &dense, keeping);
            for setting in [WHOLE, passed] {
                let found = run(&model, &setting, keeping);
                let moved = distance(&expected, &found, &model);
                assert!(moved < 1e-9, "{} {keeping:?}: {moved:e}", model.name);
            }
        }
    }
}

#[test]
fn the_whole_step_in_binary32_errs_by_its_rounding() {
    let narrow = EquationSetting {
        format: Format::BINARY32,
        ..WHOLE
    };
    for model in [four_bar(), built_in("slider-crank").expect("a family")] {
        let wide = run(&model, &WHOLE, LoopKeeping::Project);
        let found = run(&model, &narrow, LoopKeeping::Project);
        let moved = distance(&wide, &found, &model);
        assert!((1e-9..1e-3).contains(&moved), "{}: {moved:e}", model.name);
        // Residuals are measured in binary64, loops closed in binary32.
        let gap = found.largest_gap();
        assert!((1e-10..1e-5).contains(&gap), "{}: {gap:e}", model.name);
        assert!(wide.largest_gap() < 1e-13);
    }
}

#[test]
fn loops_that_are_not_projected_open() {
    let model = four_bar();
    for setting in [EquationSetting::default(), WHOLE] {
        let gap = |keeping| {
            tried(&model, &setting, keeping, runge_kutta(0.01))
                .expect("a run")
                .largest_gap()
        };
        let (projected, free) = (gap(LoopKeeping::Project), gap(LoopKeeping::Free));
        let stabilised = gap(LoopKeeping::Stabilise { rate: 20.0 });
        assert!(projected < 1e-13, "{projected:e}");
        assert!(free > 1e-8, "{free:e}");
        assert!(
            projected < stabilised && stabilised < 0.5 * free,
            "{stabilised:e} of {free:e}"
        );
    }
}

/// A slider-crank that the slider drives: at the dead centres the direction of
/// the crank is undetermined. The crank turns round in 0.19 s.
fn driven_by_the_slider() -> Model {
    let mut model = built_in("slider-crank").expect("a family");
    model.joints[0].nature = Nature::Dependent;
    model.joints[1].nature = Nature::Independent;
    model.joints[1].initial[1] = 2.0;
    model
}

#[test]
fn a_dead_point_ends_the_whole_step_and_no_other() {
    let model = driven_by_the_slider();
    let fine = IntegrationMethod::DormandPrince {
        relative: 1e-9,
        absolute: 1e-9,
    };
    // Joints are exchanged in time, so that energy stays.
    let dense = tried(
        &model,
        &EquationSetting::default(),
        LoopKeeping::Project,
        fine,
    );
    let dense = dense.expect("a run");
    let drift = dense.energy_drift() / dense.energy_scale();
    assert!(drift < 1e-5, "{drift:e}");
    let turns = dense.samples.iter().map(|sample| sample.state.q[0].abs());
    assert!(turns.fold(0.0, f64::max) > 4.0, "the crank goes round");
    for format in [Format::BINARY64, Format::BINARY32] {
        for method in [fine, runge_kutta(5e-4)] {
            let setting = EquationSetting { format, ..WHOLE };
            let error = tried(&model, &setting, LoopKeeping::Project, method)
                .expect_err("nothing tells where the crank goes");
            let MotionError::DeadPoint {
                joint, cut, time, ..
            } = &error
            else {
                panic!("{error}");
            };
            assert_eq!((&**joint, &**cut), ("R2_Crank", "Rod"));
            // 0.5 rad at 33 rad/s.
            assert!((0.013..0.016).contains(time), "{time}");
            assert!(error.advice().is_some());
        }
    }
}
