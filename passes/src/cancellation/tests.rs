//! Differences that are proved and rewritten, and those that are not.

use crate::registry::REGISTRY;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::parse::parse_module;
use robovec_ir::{Machine, Module, Operation};

/// The function of an expression of `x` and `y` after a pass, checked; and
/// whether a difference was rewritten.
fn run(pass: &str, expression: &str, x: Option<[f64; 2]>) -> (Module, bool) {
    let text =
        format!("function f equations {{\n  in x\n  in y\n  out o\n  o = {expression}\n}}\n");
    let mut module = parse_module("f", &text).expect("it is sound");
    let machine = Machine::built_in("ideal").expect("it ships");
    let mut scene = Scene::default();
    if let Some([low, high]) = x {
        scene.ranges.set("x", [0, 0], low, high);
        scene.ranges.set("y", [0, 0], low, high);
    }
    let mut log = Vec::new();
    let config = Config {
        check_each: Some(8),
        scene: Some(&scene),
        ..Config::new(&machine, &mut log)
    };
    let pipeline = format!("atomise,cse,{pass}");
    let pipeline = REGISTRY.pipeline(&pipeline).expect("it is a pipeline");
    let before = format!("{module:?}");
    let outcome = manager::run(&mut module, &pipeline, config);
    outcome.unwrap_or_else(|error| panic!("{expression}: {error}"));
    assert_ne!(before, format!("{module:?}"), "it was made atomic");
    let count = |operation| {
        let nodes = module.functions[0].nodes().iter();
        nodes.filter(|node| node.operation == operation).count()
    };
    let rewritten = match pass {
        "accurate-roots" => count(Operation::Div) > 0,
        _ => count(Operation::Sin) > 0,
    };
    (module, rewritten)
}

#[test]
fn differences_of_roots_need_a_proof_for_divisor_and_ranges() {
    let far = Some([1e3, 1e9]);
    for (expression, x, better) in [
        ("sqrt(x + 1.0) - sqrt(x)", far, true),
        ("sqrt(x) - sqrt(x + 1.0)", far, true),
        ("sqrt(x*x + 2.0) - sqrt(x*x + 1.0)", far, true),
        ("sqrt(x + y + 3.0) - sqrt(y + x + 2.5)", far, true),
        // Positive whatever x is.
        (
            "sqrt(x*x + 4.0) - sqrt(y*0.0 + 4.0)",
            Some([1e-4, 1e-3]),
            true,
        ),
        // Nothing is won.
        ("sqrt(x + 1.0) - sqrt(x)", Some([0.0, 0.5]), false),
        // Both could be zero.
        ("sqrt(x) - sqrt(y)", far, false),
        // Ranges that nobody gave.
        ("sqrt(x + 1.0) - sqrt(x)", None, false),
        ("sqrt(x + 1.0) + sqrt(x)", far, false),
    ] {
        assert_eq!(
            run("accurate-roots", expression, x).1,
            better,
            "{expression} {x:?}"
        );
    }
    let (module, _) = run("accurate-roots", "sqrt(x + 1.0) - sqrt(x)", far);
    // Two roots, the sum under one, their sum, a quotient.
    assert_eq!(module.functions[0].nodes().len(), 5);
}

#[test]
fn one_less_a_cosine_needs_a_small_angle() {
    let small = Some([-1e-3, 1e-3]);
    for (expression, x, better) in [
        ("1.0 - cos(x)", small, true),
        ("cos(x) - 1.0", small, true),
        ("y*(1.0 - cos(x + y))", small, true),
        ("1.0 - cos(x)", Some([-3.0, 3.0]), false),
        ("1.0 - cos(x)", None, false),
        ("2.0 - cos(x)", small, false),
    ] {
        assert_eq!(
            run("accurate-trig", expression, x).1,
            better,
            "{expression} {x:?}"
        );
    }
}
