//! The same motion from equations in other numbers and after passes.

use super::models::{
    double_pendulum, four_bar, run, run_with, runge_kutta, spatial_chain, spring_mechanism,
};
use robovec::generate::Formulation;
use robovec::model::{Model, Nature};
use robovec::motion::{EquationSetting, Laws, SimulationRun};
use robovec_ir::{Format, Machine};
use robovec_passes::registry::REGISTRY;

fn models() -> [Model; 4] {
    [
        double_pendulum(),
        spatial_chain(),
        four_bar(),
        spring_mechanism().0,
    ]
}

/// The largest difference of positions over all samples.
fn distance(left: &SimulationRun, right: &SimulationRun) -> f64 {
    let samples = left.samples.iter().zip(&right.samples);
    let positions = samples.flat_map(|(left, right)| left.state.q.iter().zip(&right.state.q));
    let differences = positions.map(|(left, right)| (left - right).abs());
    differences.fold(0.0, f64::max)
}

fn with(model: &Model, setting: &EquationSetting<'_>) -> SimulationRun {
    run_with(
        model,
        Laws::of_model(model),
        setting,
        1.0,
        runge_kutta(0.005),
    )
}

#[test]
fn narrow_numbers_move_the_trajectory_by_their_rounding() {
    for model in models() {
        let wide = run(&model, 1.0, runge_kutta(0.005));
        let narrow = with(
            &model,
            &EquationSetting {
                format: Format::BINARY32,
                ..EquationSetting::default()
            },
        );
        let moved = distance(&wide, &narrow);
        assert!(moved < 1e-4, "{moved:e}");
        assert!(
            moved > 1e-10,
            "equations in f32 cannot be this good: {moved:e}"
        );
    }
}

#[test]
fn passes_leave_the_trajectory_where_it_is() {
    let machine = Machine::built_in("thesis").expect("the thesis' machine");
    for text in [
        "atomise,zero-removal,balance,cse,dce",
        "atomise,zero-removal,balance,cse,dce,place",
    ] {
        let pipeline = REGISTRY.pipeline(text).expect("a pipeline");
        // The machine has no square roots, which links need.
        let fits = |model: &Model| !text.ends_with("place") || model.links.is_empty();
        for model in models().into_iter().filter(fits) {
            let plain = run(&model, 1.0, runge_kutta(0.005));
            let passed = with(
                &model,
                &EquationSetting {
                    passes: Some((&pipeline, &machine)),
                    ..EquationSetting::default()
                },
            );
            let moved = distance(&plain, &passed);
            assert!(moved < 1e-10, "{text}: {moved:e}");
        }
    }
}

#[test]
fn formulations_give_the_same_motion() {
    for formulation in Formulation::ALL {
        for model in models() {
            if !(formulation.closes_loops() || model.cuts.is_empty()) {
                continue;
            }
            let plain = run(&model, 1.0, runge_kutta(0.01));
            for accelerations in [false, true] {
                let setting = EquationSetting {
                    formulation,
                    accelerations,
                    ..EquationSetting::default()
                };
                let laws = Laws::of_model(&model);
                let other = run_with(&model, laws, &setting, 1.0, runge_kutta(0.01));
                let moved = distance(&plain, &other);
                assert!(moved < 1e-10, "{}: {moved:e}", formulation.name());
            }
        }
    }
}

/// Drives need the forces that equations leave open, also where these are
/// solved already.
#[test]
fn solved_accelerations_do_the_same_work() {
    let mut model = four_bar();
    model.joints[0].nature = Nature::Driven;
    let text = "[[driven]]\nname = 'R2_1'\namplitude = 0.4\nfrequency = 7.0\n";
    let [plain, solved] = [false, true].map(|accelerations| {
        let laws = Laws::parse(&model, text).expect("laws");
        let setting = EquationSetting {
            accelerations,
            ..EquationSetting::default()
        };
        run_with(&model, laws, &setting, 1.0, runge_kutta(0.001))
    });
    assert!(distance(&plain, &solved) < 1e-11);
    let work = |run: &SimulationRun| run.samples.last().map_or(0.0, |sample| sample.work);
    assert!(work(&plain).abs() > 0.1);
    assert!((work(&plain) - work(&solved)).abs() < 1e-9);
    assert!(solved.energy_drift() < 1e-7, "{:e}", solved.energy_drift());
}
