//! Bounds of random formulas against directed searches for larger errors.

use super::SearchSubject;
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, USUAL, WindowLeaves, input_ranges, largest_seen, subdivide,
};
use robovec_analysis::norms::norm_bounds;
use robovec_ir::Format;
use robovec_ir::parse::parse_module;
use robovec_ir::states::{Ranges, States};
use robovec_num::interval::Interval;
use robovec_num::random::Random;
use std::fmt::Write;
use std::sync::Arc;

/// Formats of every formula.
const FORMATS: [&str; 5] = ["f64", "f32", "f16", "bf16", "fixed(7,16)"];

/// Ranges of inputs: about zero, of one sign, up to powers of two, far apart.
const RANGES: [[f64; 2]; 6] = [
    [-1.3, 1.7],
    [0.4, 0.9],
    [1.0, 4.0],
    [-2.0, -0.5],
    [0.0, 2.0],
    [0.01, 1.0],
];

/// Literals that formats hold and others.
const LITERALS: [&str; 6] = ["0.1", "2.0", "0.5", "1.11", "3.0", "0.954929658551372"];

/// A formula of some ten operations of up to four inputs.
fn formula(random: &mut Random) -> (String, Ranges) {
    let inputs = 1 + random.below(4);
    let mut ranges = Ranges::default();
    let mut terms = Vec::new();
    for input in 1..=inputs {
        let [low, high] = RANGES[random.below(RANGES.len())];
        ranges.set("x", [input as u32, 0], low, high);
        terms.push(format!("x[{input}]"));
    }
    let mut text = format!("function f equations {{\n  in x[1..{inputs}]\n  out y\n");
    let operations = 3 + random.below(8);
    for number in 0..operations {
        let [a, b] = [(); 2].map(|()| match random.below(5) {
            0 => LITERALS[random.below(LITERALS.len())].to_owned(),
            // Recent terms, so that formulas are deep.
            1 | 2 => terms[terms.len() - 1].clone(),
            _ => terms[random.below(terms.len())].clone(),
        });
        let term = match random.below(12) {
            0 | 1 => format!("{a} + {b}"),
            2..=4 => format!("{a} - {b}"),
            5 | 6 => format!("{a}*{b}"),
            7 => format!("{a}/({b}*{b} + 0.75)"),
            8 => format!("sqrt({a}*{a} + 0.3)"),
            9 => format!("sin({a})"),
            10 => format!("cos({a})"),
            _ => format!("({a} + {b})*({a} - {b})"),
        };
        let _ = writeln!(text, "  %t{number} = {term}");
        terms.push(format!("%t{number}"));
    }
    let _ = writeln!(text, "  y = %t{}\n}}", operations - 1);
    (text, ranges)
}

/// Bounds random formulas, as many as asked for in each format, and searches
/// that many states of each; the number of bounds, of states, and the largest
/// quotient of an error found and its bound.
fn attack(formulas: usize, states: u64, boxes: usize) -> (usize, u64, f64) {
    let mut random = Random::new(20_261_128);
    let (mut bounds, mut tried, mut closest) = (0, 0u64, 0f64);
    for _ in 0..formulas {
        let (text, ranges) = formula(&mut random);
        let module = parse_module("random", &text).expect("it is well formed");
        let view = module.tables.view(&module.functions[0]);
        let tape = Tape::new(view.function);
        let drawn = States::new(1).within(Arc::new(ranges));
        let leaves = Leaves::new(view, &tape, &drawn, 0);
        let inputs = input_ranges(view, &drawn);
        let inputs: Vec<Interval> = inputs.iter().map(|input| input.range).collect();
        let slot = tape.output_slot(0);
        let window = ConeWindow::new(&tape, slot, USUAL);
        for text_of_format in FORMATS {
            let format: Format = text_of_format.parse().expect("it is one");
            let data = [GivenData::Held, GivenData::Real][random.below(2)];
            let leaves = WindowLeaves::new(&tape, &window, format, data, &leaves);
            let bound = subdivide(&tape, &window, &leaves, boxes);
            let norms = norm_bounds(&tape, &inputs, format, data).error[slot];
            let least = bound.error.min(norms);
            if least.is_infinite() {
                continue;
            }
            let subject = SearchSubject {
                view,
                inputs: &inputs,
                format,
                data,
            };
            let found = subject.largest_of(random.bits(), states);
            let (seen, inside) = largest_seen(&tape, &window, &leaves, &bound.worst, 1, 256);
            let error = found.errors[0].max(seen);
            assert!(
                error <= least,
                "{text_of_format} {data:?}: {error:e} above {least:e}\n{text}"
            );
            bounds += 1;
            tried += found.tried + inside as u64;
            closest = closest.max(if least > 0.0 { error / least } else { 0.0 });
        }
    }
    (bounds, tried, closest)
}

#[test]
fn no_error_of_a_random_formula_is_above_its_bound() {
    let (bounds, tried, closest) = attack(40, 400, 100);
    assert!(bounds > 120 && tried > 40_000, "{bounds} {tried}");
    assert!(closest > 0.5, "{closest}");
}

#[test]
#[ignore = "10⁸ states: minutes in a release"]
fn no_error_of_many_states_is_above_its_bound() {
    let (bounds, tried, closest) = attack(70, 340_000, 2000);
    println!("{bounds} bounds, {tried} states, {closest:.3} of a bound at most");
    assert!(bounds >= 300 && tried >= 100_000_000, "{bounds} {tried}");
}
