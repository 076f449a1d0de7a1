//! Adjoints against differences, bounds and predictions against errors.

use super::*;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_ir::value_formats::ValueFormats;
use robovec_ir::{Format, Module, Value};
use robovec_num::arithmetic::{Arithmetic, Binary32};

const EVERYTHING: &str = "function f atomic {
  in x[1..4]
  out y[1..5]
  %a = x[1] * x[2]
  %b = %a + x[3]
  %c = %b / x[4]
  %d = sin(%c)
  %e = cos(%b)
  %f = %d * %d
  %g = %f + 1.1
  %h = sqrt(%g)
  %i = fma(%h, %e, x[1])
  %j = fms(%i, %c, %d)
  %k = fnma(%j, %h, %a)
  %l = 0 - %k
  %m = %l - %b
  y[1] = %m
  y[2] = %j
  y[3] = x[2]
  y[4] = %d
  y[5] = 0.1
}";

fn module(text: &str) -> Module {
    parse_module("sample", text).expect("it is well formed")
}

/// A state in the middle of the plain, every number one of binary32.
const STATE: [f64; 4] = [0.75, -1.3125, 2.40625, 1.15625];

#[test]
fn adjoints_are_derivatives() {
    let module = module(EVERYTHING);
    let tape = Tape::new(&module.functions[0]);
    let outputs: Vec<usize> = (0..tape.outputs()).collect();
    let mut jacobian = vec![[0.0; 4]; outputs.len()];
    let workspace = &mut Workspace::default();
    Adjoint::new(&tape, &STATE).sweep_lanes(workspace, &outputs, |slot, lanes| {
        if let TapeSlot::Input(input) = tape.slot(slot) {
            for (row, lane) in jacobian.iter_mut().zip(lanes.0) {
                row[input.0 as usize] = lane;
            }
        }
    });
    let value =
        |inputs: &[f64], output: usize| tape.evaluate(&Binary64, inputs)[tape.output_slot(output)];
    for (output, row) in jacobian.iter().enumerate() {
        for (input, &derivative) in row.iter().enumerate() {
            let step = 1e-6;
            let (mut above, mut below) = (STATE, STATE);
            above[input] += step;
            below[input] -= step;
            let quotient = (value(&above, output) - value(&below, output)) / (2.0 * step);
            let distance = (quotient - derivative).abs();
            assert!(
                distance <= 1e-8 * (1.0 + derivative.abs()),
                "{output} {input}: {quotient} {derivative}"
            );
        }
    }
}

#[test]
fn adjoints_of_inner_values_are_products_along_paths() {
    let module = module(
        "function f atomic {
  in x[1..2]
  out y[1..2]
  %a = x[1] * x[2]
  %b = %a + %a
  %c = %b * x[1]
  y[1] = %c
  y[2] = %b
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let adjoint = Adjoint::new(&tape, &[3.0, 5.0]);
    let mut seen = [[0.0; 2]; 5];
    adjoint.sweep_lanes(&mut Workspace::default(), &[0, 1], |slot, lanes| {
        seen[slot] = [lanes.0[0], lanes.0[1]];
    });
    let expected = [
        [6.0, 2.0],
        [3.0, 1.0],
        [1.0, 0.0],
        [60.0, 10.0],
        [18.0, 6.0],
    ];
    assert_eq!(seen, expected);
}

#[test]
fn secants_predict_the_error_to_the_last_digits_and_bounds_hold() {
    let module = module(EVERYTHING);
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let outputs: Vec<usize> = (0..tape.outputs()).collect();
    let states = States::new(3);
    for state in 0..200 {
        let inputs = states.draw(view, state);
        let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &inputs);
        for error in run.outputs(&outputs) {
            assert!(error.actual.abs() <= error.bound, "{state}: {error:?}");
            let distance = (error.predicted - error.actual).abs();
            assert!(distance <= 1e-6 * error.bound, "{state}: {error:?}");
        }
    }
}

#[test]
fn a_literal_that_the_format_cannot_hold_is_an_error() {
    let module = module(EVERYTHING);
    let tape = Tape::new(&module.functions[0]);
    let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &STATE);
    let [error] = run.outputs(&[4])[..] else {
        panic!("one output was asked for");
    };
    assert_eq!(error.actual, f64::from(0.1f32) - 0.1);
    assert_eq!(error.predicted, error.actual);
    assert!(error.bound >= error.actual && error.bound < 1.1 * error.actual);
}

#[test]
fn division_by_zero_has_no_bound_and_leaves_the_others_alone() {
    let module = module(
        "function f atomic {
  in x[1..2]
  out y[1..2]
  %a = x[1] - x[1]
  %b = x[2] / %a
  %c = x[2] * x[2]
  y[1] = %b
  y[2] = %c
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &[3.0, 5.0]);
    let bounds: Vec<f64> = run.outputs(&[0, 1]).iter().map(|o| o.bound).collect();
    assert_eq!(bounds[0], f64::INFINITY);
    assert!(bounds[1] > 0.0 && bounds[1] < 1e-5);
}

#[test]
fn an_error_that_is_no_number_has_no_bound() {
    // Infinity times zero.
    let module = module(
        "function f atomic {
  in x[1..3]
  out y
  %a = x[1] / x[2]
  %b = %a * x[3]
  y = %b
}",
    );
    let function = &module.functions[0];
    let tape = Tape::new(function);
    let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &[3.0, 0.0, 0.0]);
    assert_eq!(run.outputs(&[0])[0].bound, f64::INFINITY);
    let mut blame = Blame::new(&tape);
    blame.add(function, &run, &[0]);
    assert_eq!(blame.refused(), 1);
    assert_eq!(blame.share(0), 0.0);
}

#[test]
fn a_derivative_that_is_no_number_gives_no_bound() {
    // The literal is rounded, and what that does is 0/0 times as much.
    let module = module(
        "function f atomic {
  in x[1..2]
  out y
  %a = x[1] / x[2]
  %b = %a * 0.1
  y = %b
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &[0.0, 0.0]);
    assert_eq!(run.outputs(&[0])[0].bound, f64::INFINITY);
}

#[test]
fn what_is_divided_by_an_overflow_has_no_bound() {
    // The quotient comes out as 0, which looks like a number.
    let module = module(
        "function f atomic {
  in x[1..2]
  out y
  %a = x[1] * x[1]
  %b = x[2] / %a
  y = %b
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let format: Format = "f16".parse().expect("it is a format");
    let run = AdjointRun::of(&module.functions[0], &tape, format, &[300.0, 30000.0]);
    let error = run.outputs(&[0])[0];
    assert!(
        error.actual.abs() > 0.3 && error.bound == f64::INFINITY,
        "{error:?}"
    );
}

#[test]
fn bounds_of_single_operations_are_those_of_any_run() {
    let bounds = |operation: &str, inputs: [f64; 2]| {
        let module = module(&format!(
            "function f atomic {{
  in x[1..2]
  out y
  %a = {operation}
  y = %a
}}"
        ));
        let tape = Tape::new(&module.functions[0]);
        AdjointRun::new(&tape, &Binary64, Format::BINARY64, &inputs).local_bounds()[0]
    };
    // The sine of a host is not rounded as a sum is.
    assert!(bounds("sin(x[1])", [0.5, 0.0]) > half_ulp(Format::BINARY64, 0.5));
    // Another run has another number where this one has a zero.
    assert!(bounds("x[1] + x[2]", [0.5, 0.0]) > 0.0);
    assert_eq!(bounds("x[1] + 0.0", [0.5, 0.0]), 0.0);
}

#[test]
fn a_result_just_below_a_power_of_two_is_judged_by_the_exact_one() {
    let module = module("function f atomic {\n in x[1..2]\n out y\n %a = x[1] * x[2]\n y = %a\n}");
    let tape = Tape::new(&module.functions[0]);
    let exact = vec![1.0; tape.slots()];
    let mut computed = exact.clone();
    computed[0] = 1.0 - 2f64.powi(-24);
    let errors = vec![0.0; tape.slots()];
    let found = local::bounds(&tape, |_| Format::BINARY32, [&exact, &computed, &errors]);
    assert_eq!(found[0], half_ulp(Format::BINARY32, 1.0));
}

#[test]
fn half_an_ulp_is_that_of_the_format() {
    let f32 = Format::BINARY32;
    assert_eq!(half_ulp(f32, 1.0), 2f64.powi(-24));
    assert_eq!(half_ulp(f32, -1.99), 2f64.powi(-24));
    assert_eq!(half_ulp(f32, 2.0), 2f64.powi(-23));
    assert_eq!(half_ulp(f32, 0.0), 2f64.powi(-150));
    assert_eq!(half_ulp(f32, 1e39), f64::INFINITY);
    assert_eq!(half_ulp(f32, f64::NAN), f64::INFINITY);
    let flush: Format = "float(8,23,flush)".parse().expect("it is one");
    assert_eq!(half_ulp(flush, 1e-40), 2f64.powi(-126));
    let fixed: Format = "fixed(3,4)".parse().expect("it is one");
    assert_eq!(half_ulp(fixed, 7.9), 2f64.powi(-5));
    assert_eq!(half_ulp(fixed, 8.0), f64::INFINITY);
    assert_eq!(half_ulp(Format::BINARY64, 1.0), 2f64.powi(-53));
}

#[test]
fn blame_goes_to_the_operation_that_cancels() {
    // The product is large and loses much, the sum takes it away again.
    let module = module(
        "function f atomic {
  in x[1..3]
  out y[1..1]
  %big = x[1] * x[2]
  %gone = %big - x[3]
  %small = %gone * x[1]
  y[1] = %small
}",
    );
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let factor = f64::from(1000.1f32);
    let square = f64::from((factor * factor) as f32);
    let run = AdjointRun::new(
        &tape,
        &Binary32,
        Format::BINARY32,
        &[factor, factor, square - 1.0],
    );
    let mut blame = Blame::new(&tape);
    blame.add(view.function, &run, &[0]);
    let equations = blame.equations(view, 12);
    let first = equations[0].name.expect("it has one");
    assert_eq!(module.tables.symbols.text(first), "big");
    assert!(equations[0].share > 0.99, "{equations:?}");
    let total: f64 = equations.iter().map(|equation| equation.share).sum();
    assert!((total - 1.0).abs() < 1e-12);
    assert!(blame.inputs(&tape, 12).is_empty() && blame.literals(&tape) == 0.0);
}

#[test]
fn values_in_formats_of_their_own_are_predicted_too() {
    let mut module = module(EVERYTHING);
    let function = &mut module.functions[0];
    let mut formats = ValueFormats::new(function.nodes().len());
    let narrow: Format = "float(8,12)".parse().expect("it is one");
    for node in [0, 3, 6, 8, 11] {
        formats.set(Value(node), Some(narrow));
    }
    function.formats = Some(formats);
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    for state in 0..100 {
        let inputs = States::new(4).draw(view, state);
        let run = AdjointRun::of(view.function, &tape, Format::BINARY32, &inputs);
        for error in run.outputs(&[0, 1, 2, 3]) {
            assert!(error.actual.abs() <= error.bound, "{state}: {error:?}");
            let distance = (error.predicted - error.actual).abs();
            assert!(distance <= 1e-6 * error.bound, "{state}: {error:?}");
        }
    }
}

#[test]
fn paths_that_cancel_leave_the_rest_its_digits() {
    let module = module(
        "function f atomic {
  in x[1..3]
  out y[1..1]
  %big = x[1]*x[2]
  %none = %big - %big
  %second = %none*%big
  %third = %second*%big
  %linear = %big*x[3]
  %sum = %third + %linear
  y[1] = %sum
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let inputs = [1e9, 1.1, 3.0].map(|number: f64| f64::from(number as f32));
    let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &inputs);
    let [error] = run.outputs(&[0])[..] else {
        panic!("one output");
    };
    assert!(error.actual != 0.0 && error.actual.abs() <= error.bound);
    let distance = (error.predicted - error.actual).abs();
    assert!(distance <= 1e-12 * error.bound, "{error:?}");
    // Two roundings of half a unit in the last place.
    assert!(error.bound < 1e-6 * error.exact, "{error:?}");
}

/// The error of an output over its bound when every operation loses as much
/// as it can, in the direction that the output's adjoints name.
fn worst_luck(tape: &Tape, inputs: &[f64], output: usize) -> f64 {
    let format = Format::BINARY32;
    let run = AdjointRun::new(tape, &Binary32, format, inputs);
    let mut slots = run.exact().to_vec();
    let mut gradients = vec![0.0; tape.slots()];
    let workspace = &mut Workspace::default();
    run.adjoint()
        .sweep_lanes(workspace, &[output], |slot, lanes| {
            gradients[slot] = lanes.0[0];
        });
    for node in 0..tape.nodes() {
        let operands = tape.operands(node).map(|slot| slots[slot]);
        let result = Binary64.apply(tape.operation(node), operands);
        let loss = match run.local_bounds()[node] {
            0.0 => 0.0,
            _ => half_ulp(format, result),
        };
        slots[node] = result + loss.copysign(gradients[node]);
    }
    let slot = tape.output_slot(output);
    (slots[slot] - run.exact()[slot]).abs() / run.outputs(&[output])[0].bound
}

#[test]
fn worst_luck_reaches_the_bound_and_exceeds_it_by_little() {
    let module = module(EVERYTHING);
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let mut ratios = Vec::new();
    for state in 0..2000 {
        let inputs = States::new(3).draw(view, state);
        ratios.extend([0, 1, 3].map(|output| worst_luck(&tape, &inputs, output)));
    }
    ratios.sort_by(f64::total_cmp);
    // Adjoints change with the errors.
    assert!(ratios[ratios.len() / 2] > 0.9, "the bound is no waste");
    let most = ratios[ratios.len() - 1];
    assert!(most > 1.0 && most < 1.001, "{most}");
}

#[test]
fn luck_that_crosses_a_power_of_two_exceeds_the_bound() {
    let module = module(
        "function f atomic {
  in x[1..3]
  out y
  %a = x[1] + x[2]
  %b = %a * x[3]
  y = %b
}",
    );
    let tape = Tape::new(&module.functions[0]);
    // The product is a little below 2, above which a number rounds by twice as
    // much.
    let inputs = [1.0, 3_034_177.0 / 8_388_608.0, 1.46875];
    let ratio = worst_luck(&tape, &inputs, 0);
    assert!(ratio > 1.3 && ratio < 2.0, "{ratio}");
}
