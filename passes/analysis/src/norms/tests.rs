//! Chains of rotations, along which intervals widen and norms do not.

use super::*;
use robovec_ir::parse::parse_module;
use std::fmt::Write;

/// A vector rotated about three axes in turn, one joint after another.
fn chain(joints: usize) -> String {
    let mut text =
        format!("function f equations {{\n  in q[1..{joints}]\n  in x[1..3]\n  out y[1..3]\n");
    let mut vector = ["x[1]", "x[2]", "x[3]"].map(str::to_owned);
    for joint in 1..=joints {
        let (a, b) = (joint % 3, (joint + 1) % 3);
        let (p, r) = (&vector[a], &vector[b]);
        let _ = writeln!(
            text,
            "  %c{joint} = cos(q[{joint}])\n  %s{joint} = sin(q[{joint}])\n  \
             %a{joint} = {p}*%c{joint} + {r}*%s{joint}\n  \
             %b{joint} = {r}*%c{joint} - {p}*%s{joint}"
        );
        (vector[a], vector[b]) = (format!("%a{joint}"), format!("%b{joint}"));
    }
    for (index, element) in vector.iter().enumerate() {
        let _ = writeln!(text, "  y[{}] = {element}", index + 1);
    }
    text + "}"
}

#[test]
fn ranges_stay_and_errors_grow_in_proportion_along_a_chain() {
    let largest = |joints: usize| {
        let module = parse_module("chain", &chain(joints)).expect("it is well formed");
        let tape = Tape::new(&module.functions[0]);
        let mut inputs = vec![Interval::within(3.0); joints];
        inputs.extend([Interval::within(1.0); 3]);
        let bounds = norm_bounds(&tape, &inputs, Format::BINARY32, GivenData::Held);
        let outputs = (0..tape.outputs()).map(|output| tape.output_slot(output));
        outputs.fold((0f64, 0f64), |(range, error), slot| {
            let size = bounds.exact[slot].magnitude();
            (range.max(size), error.max(bounds.error[slot]))
        })
    };
    let (range, error) = largest(20);
    let (far, more) = largest(80);
    let norm = 3f64.sqrt();
    assert!(range >= 1.0 && far <= norm * 1.000_001, "{range} {far}");
    assert!(
        more <= 5.0 * error && more <= 80.0 * 8.0 * norm * 2f64.powi(-24),
        "{error:e} {more:e}"
    );
}
