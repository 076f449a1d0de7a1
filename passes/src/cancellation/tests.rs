//! Differences that are proved and rewritten, and those that are not.

use crate::registry::REGISTRY;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::evaluate::evaluate;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_ir::{Format, Machine, Module, Operation, View};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::DoubleDouble;
use robovec_num::soft_float::FormatArithmetic;

/// The function of an expression of `x` and `y` after a pass, checked; and a
/// flag: true when a difference was rewritten.
fn run(pass: &str, expression: &str, x: Option<[f64; 2]>) -> (Module, bool) {
    let ranges: Vec<(&str, [f64; 2])> = x.iter().flat_map(|&x| [("x", x), ("y", x)]).collect();
    run_in(pass, expression, &ranges)
}

/// The same with the ranges of inputs.
fn run_in(pass: &str, expression: &str, ranges: &[(&str, [f64; 2])]) -> (Module, bool) {
    let text = format!(
        "function f equations {{\n  in x\n  in y\n  in z\n  out o\n  o = {expression}\n}}\n"
    );
    let mut module = parse_module("f", &text).expect("it is sound");
    let machine = Machine::built_in("ideal").expect("it ships");
    let mut scene = Scene::default();
    for (name, [low, high]) in ranges {
        scene.ranges.set(name, [0, 0], *low, *high);
    }
    let mut log = Vec::new();
    let config = Config {
        check_each: Some(8),
        states: scene.states(1),
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

/// Lost bits of a function in binary32 in ranges: the logarithm of one more
/// than its largest relative error in units of the last place.
fn lost_bits(module: &Module, exact: &Module, ranges: &[(&str, [f64; 2])]) -> f64 {
    let view = |module| -> View<'_> {
        let module: &Module = module;
        module.tables.view(&module.functions[0])
    };
    let mut scene = Scene::default();
    for (name, [low, high]) in ranges {
        scene.ranges.set(name, [0, 0], *low, *high);
    }
    let source: States = scene.states(3);
    let single = FormatArithmetic::new(Format::BINARY32);
    let mut largest = 0.0f64;
    for number in 0..2000 {
        // Data that binary32 holds: only the operations err.
        let state = source.draw(view(exact), number);
        let state: Vec<f64> = state.iter().map(|&one| single.literal(one)).collect();
        let computed = evaluate(view(module).function, &single, &state)[0];
        let inputs: Vec<_> = state.iter().map(|&one| DoubleDouble.literal(one)).collect();
        let exact = evaluate(view(exact).function, &DoubleDouble, &inputs)[0].high;
        largest = largest.max((computed - exact).abs() / exact.abs());
    }
    (1.0 + largest / f64::from(f32::EPSILON)).log2()
}

/// Cores of Hamming's third chapter, in ranges in which they cancel.
#[test]
fn hamming_s_cores_keep_their_bits() {
    const FAR: [f64; 2] = [1e2, 1e5];
    const ANGLE: [f64; 2] = [0.2, 1.0];
    const SMALL: [f64; 2] = [1e-5, 1e-3];
    const SIZE: [f64; 2] = [1e2, 1e3];
    let (roots, trig) = ("accurate-roots", "accurate-trig");
    for (name, pass, expression, ranges) in [
        ("3.1", roots, "sqrt(x + 1.0) - sqrt(x)", vec![("x", FAR)]),
        (
            "3.3",
            trig,
            "sin(x + y) - sin(x)",
            vec![("x", ANGLE), ("y", SMALL)],
        ),
        ("3.4", trig, "(1.0 - cos(x))/sin(x)", vec![("x", SMALL)]),
        (
            "3.6",
            roots,
            "1.0/sqrt(x) - 1.0/sqrt(x + 1.0)",
            vec![("x", FAR)],
        ),
        ("3.3.1", roots, "1.0/(x + 1.0) - 1.0/x", vec![("x", FAR)]),
        (
            "3.3.3",
            roots,
            "(1.0/(x + 1.0) - 2.0/x) + 1.0/(x - 1.0)",
            vec![("x", FAR)],
        ),
        (
            "3.3.5",
            trig,
            "cos(x + y) - cos(x)",
            vec![("x", ANGLE), ("y", SMALL)],
        ),
        (
            "p42+",
            roots,
            "(-y + sqrt(y*y - 4.0*(x*z)))/(2.0*x)",
            vec![("x", [0.5, 1.0]), ("y", SIZE), ("z", [0.5, 1.0])],
        ),
        (
            "p42-",
            roots,
            "(-y - sqrt(y*y - 4.0*(x*z)))/(2.0*x)",
            vec![("x", [0.5, 1.0]), ("y", [-1e3, -1e2]), ("z", [0.5, 1.0])],
        ),
        (
            "3.2.1+",
            roots,
            "(-y + sqrt(y*y - x*z))/x",
            vec![("x", [0.5, 1.0]), ("y", SIZE), ("z", [0.5, 1.0])],
        ),
        (
            "3.2.1-",
            roots,
            "(-y - sqrt(y*y - x*z))/x",
            vec![("x", [0.5, 1.0]), ("y", [-1e3, -1e2]), ("z", [0.5, 1.0])],
        ),
        ("3.4.1", trig, "(1.0 - cos(x))/(x*x)", vec![("x", SMALL)]),
    ] {
        let (plain, _) = run_in("cse", expression, &ranges);
        let (module, _) = run_in(pass, expression, &ranges);
        let [before, after] = [&plain, &module].map(|one| lost_bits(one, &plain, &ranges));
        println!("{name}: {before:.1} -> {after:.1} bits");
        assert!(before > 6.0 && after <= 2.0, "{name}: {before} -> {after}");
    }
}
