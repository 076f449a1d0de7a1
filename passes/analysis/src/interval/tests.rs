//! Enclosures and bounds of windows against runs inside the ranges.

use super::*;
use crate::adjoint::AdjointRun;
use robovec_ir::Module;
use robovec_ir::parse::parse_module;
use robovec_ir::states::{Ranges, States};
use std::sync::Arc;

const SAMPLE: &str = "function f equations {
  in q[1..3]
  in m[1..2]
  out c[1..4]
  %s1 = sin(q[1])
  %c1 = cos(q[1])
  %s2 = sin(q[1] + q[2])
  %t = m[1]*%s1*%s1 + 0.1*m[2]*%s2 - q[3]*%c1
  %u = %t/(2.5 + %c1*%s2)
  c[1] = %t
  c[2] = %u
  c[3] = sqrt(3.7 + %u*%u)*%t - %t
  c[4] = q[2]
}";

fn module(text: &str) -> Module {
    parse_module("sample", text).expect("it is well formed")
}

#[test]
fn windows_are_cut_off_behind_everything_they_leave_out() {
    let module = module(SAMPLE);
    let tape = Tape::new(&module.functions[0]);
    for output in 0..tape.outputs() {
        for most in 0..20 {
            let root = tape.output_slot(output);
            let window = ConeWindow::new(&tape, root, most);
            assert!(window.nodes.len() <= most);
            let first = window.nodes.first().copied().unwrap_or(usize::MAX);
            let values = window.leaves.iter().filter(|&&leaf| leaf < tape.nodes());
            assert!(values.clone().all(|&leaf| leaf < first));
            match window.nodes.last() {
                Some(&last) => assert_eq!(last, root),
                None => assert_eq!(window.leaves, [root]),
            }
        }
    }
}

#[test]
fn errors_and_values_stay_inside_for_every_state_and_format() {
    let module = module(SAMPLE);
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let mut ranges = Ranges::default();
    for index in 1..=3 {
        ranges.set("q", [index, 0], -0.3, 0.9);
    }
    for index in 1..=2 {
        ranges.set("m", [index, 0], 0.5, 3.0);
    }
    let states = States::new(5).within(Arc::new(ranges));
    let leaves = Leaves::new(view, &tape, &states, 0);
    let mut tightest = f64::INFINITY;
    for text in ["f32", "f16", "float(8,12,flush)", "fixed(6,14)"] {
        let format: Format = text.parse().expect("it is one");
        for output in 0..tape.outputs() {
            let slot = tape.output_slot(output);
            let window = ConeWindow::new(&tape, slot, USUAL);
            let leaves = WindowLeaves::new(&tape, &window, format, GivenData::Held, &leaves);
            assert_eq!(leaves.knowledge, RangeBasis::Given);
            let enclosure = enclose(&tape, &window, &leaves, &leaves.ranges);
            assert!(enclosure.error.is_finite(), "{text} {output}");
            let arithmetic = FormatArithmetic::new(format);
            for state in 0..300 {
                // Inputs are given in the format.
                let inputs = states.draw(view, state);
                let inputs: Vec<f64> = inputs.iter().map(|&x| arithmetic.convert(x)).collect();
                let run = AdjointRun::new(&tape, &arithmetic, format, &inputs);
                let error = run.errors()[slot].abs();
                assert!(error <= enclosure.error, "{text} {output} {state}");
                if error > 0.0 && format == Format::BINARY32 {
                    tightest = tightest.min(enclosure.error / error);
                }
                for (&node, (exact, computed)) in window.nodes.iter().zip(
                    enclosure.exact[window.leaves.len()..]
                        .iter()
                        .zip(&enclosure.computed[window.leaves.len()..]),
                ) {
                    assert!(exact.contains(run.exact()[node]));
                    assert!(computed.contains(run.computed()[node]));
                }
            }
        }
    }
    assert!(tightest < 10.0, "{tightest}");
}

#[test]
fn secants_times_differences_of_operands_are_those_of_results() {
    // Far apart, so that a secant that is a derivative at one end shows.
    let exact = [0.5, 0.75, 2.0];
    let steps = [
        [0.75, 0.0, 0.0],
        [0.0, 0.5, 0.0],
        [0.0, 0.0, -1.5],
        [0.75, 0.5, -1.5],
    ];
    for operation in Operation::ALL {
        for step in steps {
            let computed: [f64; 3] = std::array::from_fn(|place| exact[place] + step[place]);
            let [before, after] = [exact, computed].map(|operands| {
                let mut values = operands.map(Interval::point).to_vec();
                values.push(operate(operation, &[0, 1, 2], &values));
                values
            });
            let difference = (after[3] - before[3]).widened(1e-12);
            let enclosure = WindowEnclosure {
                exact: before,
                computed: after,
                local: Vec::new(),
                error: 0.0,
            };
            let secants = secant(operation, [0, 1, 2], &enclosure, 3);
            let parts = secants.into_iter().zip(step).take(operation.arity());
            let sum = parts.fold(Interval::ZERO, |sum, (secant, step)| {
                sum + secant * Interval::point(step)
            });
            let meets = sum.low <= difference.high && difference.low <= sum.high;
            assert!(meets, "{operation:?} {step:?}: {sum:?}, not {difference:?}");
        }
    }
}

#[test]
fn sines_of_the_host_may_be_off_by_more_than_a_rounding() {
    let sine = Interval {
        low: 0.5,
        high: 0.75,
    };
    // A unit in the last place of binary64, and that of other formats besides.
    let unit = f64::EPSILON / 2.0;
    for (format, least) in [("f64", unit), ("f32", unit + 2f64.powi(-25))] {
        let format: Format = format.parse().expect("it is one");
        let (range, error) = loss::rounded(Operation::Sin, [sine; 3], sine, format);
        assert!(error >= least && error < 4.0 * least);
        assert!(range.low <= sine.low - error && range.high >= sine.high + error);
    }
}

#[test]
fn operations_that_compute_the_same_are_one() {
    let module = module(
        "function f equations {
  in x
  out y
  %a = 3.7*x
  %b = x*3.7
  %c = 3.7*x
  y = %a - %c + 0.0*%b
}",
    );
    let tape = Tape::new(&module.functions[0]);
    let window = ConeWindow::new(&tape, tape.output_slot(0), USUAL);
    let products = window.nodes.iter();
    let products = products.filter(|&&node| tape.operation(node) == Operation::Mul);
    assert_eq!(products.count(), 3);
    let ranges = vec![Interval::new(1.0, 2.0); window.leaves.len()];
    let mut leaves = WindowLeaves::anything(&window, Format::BINARY32, ranges);
    for (range, &slot) in leaves.ranges.iter_mut().zip(&window.leaves) {
        if let TapeSlot::Constant(constant) = tape.slot(slot) {
            *range = Interval::point(tape.constants()[constant.index()]);
        }
    }
    let enclosure = enclose(&tape, &window, &leaves, &leaves.ranges);
    assert_eq!(enclosure.error, 0.0);
}

#[test]
fn assumed_ranges_are_said_to_be() {
    let module = module(SAMPLE);
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let leaves = Leaves::new(view, &tape, &States::new(1), 16);
    let root = tape.output_slot(1);
    let knowledge = |most| {
        let window = ConeWindow::new(&tape, root, most);
        let format = Format::BINARY32;
        WindowLeaves::new(&tape, &window, format, GivenData::Held, &leaves).knowledge
    };
    assert_eq!(knowledge(2), RangeBasis::Assumed);
    assert_eq!(knowledge(USUAL), RangeBasis::Drawn);
}

#[test]
fn alarms_and_fixed_point_ranges_follow_from_ranges() {
    let f16: Format = "f16".parse().expect("it is one");
    let range = Interval::new;
    assert_eq!(Alarm::of(range(-1.0, 2.0), f16), None);
    assert_eq!(Alarm::of(range(-1.0, 7e4), f16), Some(Alarm::MayOverflow));
    assert_eq!(Alarm::of(range(7e4, 8e4), f16), Some(Alarm::Overflows));
    assert_eq!(Alarm::of(range(-1e-6, 1e-7), f16), Some(Alarm::Underflows));
    assert_eq!(Alarm::of(Interval::ZERO, f16), None);
    let fixed: Format = "fixed(3,8)".parse().expect("it is one");
    assert_eq!(Alarm::of(range(-8.0, 1.0), fixed), Some(Alarm::MayOverflow));
    assert_eq!(integer_bits(range(-0.4, 0.9)), Some(0));
    assert_eq!(integer_bits(range(-0.4, 1.0)), Some(1));
    assert_eq!(integer_bits(range(-8.0, 7.0)), Some(4));
    assert_eq!(integer_bits(Interval::WHOLE), None);
}
