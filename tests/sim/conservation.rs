//! Conserved quantities, and the order of their errors.

use super::models::{double_pendulum, four_bar, run, runge_kutta, spatial_chain};
use robovec::model::Model;
use robovec::motion::{IntegrationMethod, SimulationRun};

/// Demands that the error of energy falls with the fourth power of the step.
fn assert_order(model: &Model) {
    let drift = |step: f64| run(model, 1.0, runge_kutta(step)).energy_drift();
    let (coarse, fine) = (drift(0.0025), drift(0.00125));
    let order = (coarse / fine).log2();
    assert!(
        (3.8..4.2).contains(&order),
        "observed order {order}: {coarse:e} and {fine:e}"
    );
}

#[test]
fn a_double_pendulum_conserves_energy_to_fourth_order() {
    assert_order(&double_pendulum());
}

#[test]
fn a_chain_in_space_conserves_energy_to_fourth_order() {
    assert_order(&spatial_chain());
}

#[test]
fn a_four_bar_linkage_conserves_energy_to_fourth_order() {
    assert_order(&four_bar());
}

/// The largest difference of positions over all samples.
fn distance(left: &SimulationRun, right: &SimulationRun) -> f64 {
    let samples = left.samples.iter().zip(&right.samples);
    let positions = samples.flat_map(|(left, right)| left.state.q.iter().zip(&right.state.q));
    let differences = positions.map(|(left, right)| (left - right).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn trajectories_converge_with_fourth_order() {
    for model in [double_pendulum(), spatial_chain(), four_bar()] {
        let with = |step: f64| run(&model, 1.0, runge_kutta(step));
        let [coarse, middle, fine] = [0.005, 0.0025, 0.00125].map(with);
        let order = (distance(&coarse, &middle) / distance(&middle, &fine)).log2();
        assert!((3.6..4.4).contains(&order), "observed order {order}");
    }
}

#[test]
fn the_integrators_agree_and_the_adaptive_one_meets_its_tolerance() {
    for model in [double_pendulum(), spatial_chain(), four_bar()] {
        let fixed = run(&model, 1.0, runge_kutta(0.001));
        let mut before = f64::INFINITY;
        for tolerance in [1e-5, 1e-7, 1e-9] {
            let adaptive = run(
                &model,
                1.0,
                IntegrationMethod::DormandPrince {
                    relative: tolerance,
                    absolute: tolerance,
                },
            );
            let error = distance(&fixed, &adaptive);
            assert!(error < 100.0 * tolerance, "{error:e} at {tolerance:e}");
            assert!(error < before, "{error:e} is no better than {before:e}");
            before = error;
        }
    }
}

#[test]
fn loops_stay_closed() {
    let run = run(&four_bar(), 5.0, runge_kutta(0.01));
    assert!(run.largest_gap() < 1e-13, "{:e}", run.largest_gap());
    assert!(run.energy_scale() > 1.0, "it moves");
}
