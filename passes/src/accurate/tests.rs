//! Cases where cancellation dominates.

use crate::registry::REGISTRY;
use robovec_analysis::critical_path::critical_path;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::evaluate::evaluate;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, View};
use robovec_num::arithmetic::{Arithmetic, Binary32};
use robovec_num::double_double::DoubleDouble;

/// A scene in which elements of `x` lie in these ranges.
fn scene(ranges: &[[f64; 2]]) -> Scene {
    let mut scene = Scene::default();
    for (place, [low, high]) in ranges.iter().enumerate() {
        scene.ranges.set("x", [place as u32 + 1, 0], *low, *high);
    }
    scene
}

fn module(inputs: usize, body: &str) -> Module {
    let text = format!("function f atomic {{\n  in x[1..{inputs}]\n  out o\n{body}\n}}\n");
    parse_module("f", &text).expect("it is sound")
}

fn run(module: &Module, pass: &str, machine: &str, scene: &Scene) -> Module {
    let mut module = module.clone();
    let pipeline = REGISTRY.pipeline(pass).expect("it is a pipeline");
    let machine = Machine::built_in(machine).expect("it ships");
    let mut log = Vec::new();
    let config = Config {
        check_each: Some(4),
        scene: Some(scene),
        ..Config::new(&machine, &mut log)
    };
    manager::run(&mut module, &pipeline, config).expect("it runs");
    module
}

/// The median relative error in binary32.
fn error(module: &Module, states: &States) -> f64 {
    let function: &Function = &module.functions[0];
    let tables = &module.tables;
    let view = View { tables, function };
    let mut errors: Vec<f64> = (0..101)
        .map(|index| {
            let state = states.draw(view, index);
            let narrow: Vec<f32> = state.iter().map(|&x| x as f32).collect();
            let wide: Vec<_> = state.iter().map(|&x| DoubleDouble.literal(x)).collect();
            let computed = evaluate(function, &Binary32, &narrow)[0];
            let exact = evaluate(function, &DoubleDouble, &wide)[0];
            exact.distance(f64::from(computed)) / exact.high.abs()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors[50]
}

/// Factor by which the error decreases.
fn gain(module: &Module, pass: &str, machine: &str, scene: &Scene) -> f64 {
    let states = scene.states(77);
    let new = run(module, pass, machine, scene);
    error(module, &states) / error(&new, &states).max(1e-10)
}

#[test]
fn differences_of_products_are_factored_without_a_cycle_more() {
    let near = [[0.5, 1.5], [1.0, 1.0001], [1.0, 1.0001]];
    let scene = scene(&near);
    let module = module(
        3,
        "  %p = x[1]*x[2]\n  %r = x[1]*x[3]\n  %d = %p - %r\n  o = %d",
    );
    assert!(gain(&module, "accurate", "thesis", &scene) > 100.0);
    let new = run(&module, "accurate", "thesis", &scene);
    assert_eq!(new.functions[0].nodes().len(), 2);
    let squares = "  %p = x[2]*x[2]\n  %r = x[3]*x[3]\n  %d = %p - %r\n  o = %d";
    let squares = self::module(3, squares);
    assert!(gain(&squares, "accurate", "thesis", &scene) > 100.0);
}

#[test]
fn a_counterweight_is_balanced_to_the_last_digits() {
    // Two torques of 1000 N m that differ by about one.
    let arm = [[101.0, 102.0], [1.0, 1.001], [50.5, 51.0], [2.0, 2.002]];
    let scene = scene(&arm);
    let body = "  %a = x[1]*x[2]\n  %b = x[3]*x[4]\n  %t = %a - %b\n  o = %t";
    let module = module(4, body);
    let fused = gain(&module, "accurate{growth=300 slack=200}", "fused", &scene);
    let split = gain(&module, "accurate{growth=2000 slack=900}", "thesis", &scene);
    assert!(fused > 100.0 && split > 100.0, "{fused} and {split}");
}

#[test]
fn ill_conditioned_sums_are_compensated_within_the_budget() {
    for condition in [1e2, 1e4, 1e6] {
        let large = [condition, 2.0 * condition];
        let scene = scene(&[large, [0.5, 1.0], large, [0.5, 1.0]]);
        let body = "  %a = x[1] + x[2]\n  %b = %a + x[3]\n  %c = %b + x[4]\n  \
                    %d = %c - x[1]\n  %e = %d - x[3]\n  o = %e";
        let module = module(4, body);
        let pass = "accurate{growth=1000 slack=400}";
        assert!(gain(&module, pass, "thesis", &scene) > 10.0, "{condition}");
        let old = &module.functions[0];
        for growth in [0, 100, 300] {
            let pass = format!("accurate{{growth={growth} slack={growth}}}");
            let new = run(&module, &pass, "thesis", &scene);
            let new = &new.functions[0];
            let machine = Machine::built_in("thesis").expect("it ships");
            let path = |function| critical_path(function, &machine).asap_cycle;
            assert!(path(new) * 100 <= path(old) * (100 + growth));
            assert!(new.nodes().len() as u32 * 100 <= old.nodes().len() as u32 * (100 + growth));
        }
    }
}

#[test]
fn states_without_numbers_are_no_obstacle() {
    let body = "  %a = x[1] - x[1]\n  %b = x[2]/%a\n  %m = 0.0 - x[2]\n  %c = sqrt(%m)\n  \
                %d = %b + %c\n  %e = %d + x[1]\n  o = %e";
    let module = module(2, body);
    for pass in ["accurate{growth=500 slack=500}", "mixed{error=1e-3}"] {
        run(&module, pass, "ideal", &Scene::default());
    }
}
