//! No value is outside its range, and no error above its bound, where both are
//! proved by norms of vectors: in programs of exact and approximate rotations,
//! and of sums, products and quotients of their elements.

use arbitrary::{Result, Unstructured};
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{GivenData, exact_literal};
use robovec_analysis::norms::{NormBounds, norm_bounds};
use robovec_ir::Format;
use robovec_ir::parse::parse_module;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::interval::Interval;
use robovec_num::random::{mix, unit};
use robovec_num::soft_float::FormatArithmetic;
use std::fmt::Write;

/// Input elements, and angles among them.
const INPUTS: usize = 9;
const ANGLES: usize = 3;

/// States at which bounds are compared.
const STATES: u64 = 48;

/// Bounds random programs, and looks for values and errors beyond.
///
/// # Panics
///
/// Panics when a value or an error is beyond its bound.
pub fn norms_hold(data: &[u8]) {
    // Bytes that run out make a smaller case, never a failure.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    let format = *bytes.choose(&["f64", "f32", "f16", "float(8,12,flush)", "fixed(20,20)"])?;
    let format: Format = format.parse().expect("it is one");
    let data = *bytes.choose(&[GivenData::Held, GivenData::Real])?;
    let (seed, spread): (u64, i32) = (bytes.arbitrary()?, bytes.int_in_range(0..=12)?);
    let mut inputs = Vec::new();
    for _ in 0..INPUTS {
        let middle = f64::from(bytes.int_in_range(-2000..=2000)?) / 1000.0;
        let width = 2.0 * 0.5f64.powi(spread);
        inputs.push(Interval::new(middle - width, middle + width));
    }
    let text = program(bytes)?;
    let module = parse_module("random", &text).expect("it is well formed");
    let tape = Tape::new(&module.functions[0]);
    let bounds = norm_bounds(&tape, &inputs, format, data);
    for state in 0..STATES {
        let place = |input: usize| unit(mix(mix(state ^ seed) ^ input as u64));
        let numbers = inputs.iter().enumerate().map(|(input, range)| {
            let corner = state % 3 == 0;
            let place = if corner {
                place(input).round()
            } else {
                place(input)
            };
            (range.low + (range.high - range.low) * place).clamp(range.low, range.high)
        });
        let numbers: Vec<f64> = numbers.collect();
        compare(&tape, (format, data), &numbers, &inputs, &bounds, &text);
    }
    Ok(())
}

/// Compares all values at a state with their bounds.
fn compare(
    tape: &Tape,
    (format, data): (Format, GivenData),
    state: &[f64],
    inputs: &[Interval],
    bounds: &NormBounds,
    text: &str,
) {
    let arithmetic = FormatArithmetic::new(format);
    let held: Vec<f64> = state.iter().map(|&x| arithmetic.convert(x)).collect();
    let taken = match data {
        GivenData::Held => &held,
        GivenData::Real => state,
    };
    if !inputs
        .iter()
        .zip(taken)
        .all(|(range, &x)| range.contains(x))
    {
        return;
    }
    let numbers = taken.iter().map(|&number| Double::from(number));
    let literals = tape.constants().iter();
    let literals = literals.map(|&number| exact_literal(number, data));
    let exact = tape.evaluate_numbers(&DoubleDouble, numbers, literals);
    let computed = tape.evaluate(&arithmetic, &held);
    for slot in 0..tape.slots() {
        // Double-double is exact to 100 bits of what went into a value.
        let slack = 1e-28 * bounds.exact[slot].magnitude();
        let value = exact[slot].high;
        let inside = bounds.exact[slot].widened(slack).contains(value);
        assert!(inside, "{value:e} at {slot}, {state:?}\n{text}");
        let error = (Double::from(computed[slot]) - exact[slot]).high.abs();
        let bound = bounds.error[slot];
        assert!(
            error <= bound + slack || bound.is_infinite(),
            "{error:e} above {bound:e} at {slot}, {format} {data:?} {state:?}\n{text}"
        );
    }
}

/// A program over the inputs and the sines and cosines of some of them.
fn program(bytes: &mut Unstructured<'_>) -> Result<String> {
    let mut lines = String::new();
    let mut values: Vec<String> = (1..=INPUTS).map(|input| format!("x[{input}]")).collect();
    values.extend(["0.3".to_owned(), "2.5".to_owned()]);
    for angle in 1..=ANGLES {
        let _ = writeln!(
            lines,
            "  %c{angle} = cos(x[{angle}])\n  %s{angle} = sin(x[{angle}])"
        );
        values.extend([format!("%c{angle}"), format!("%s{angle}")]);
    }
    let mut count = 0;
    for _ in 0..bytes.int_in_range(1..=12)? {
        let made = definitions(bytes, &values)?;
        for definition in made {
            count += 1;
            let _ = writeln!(lines, "  %v{count} = {definition}");
            values.push(format!("%v{count}"));
        }
    }
    Ok(format!(
        "function f equations {{\n  in x[1..{INPUTS}]\n  out y[1..1]\n{lines}  y[1] = %v{count}\n}}"
    ))
}

/// Some definitions that belong together.
fn definitions(bytes: &mut Unstructured<'_>, values: &[String]) -> Result<Vec<String>> {
    let recent = values.len().saturating_sub(8);
    let any = |bytes: &mut Unstructured<'_>| -> Result<&String> {
        let from = if bytes.ratio(2, 3)? { recent } else { 0 };
        bytes.choose(&values[from..])
    };
    let (a, b, c) = (any(bytes)?, any(bytes)?, any(bytes)?);
    let (d, e, f) = (any(bytes)?, any(bytes)?, any(bytes)?);
    let angle = bytes.int_in_range(1..=ANGLES)?;
    let (cos, sin) = (format!("%c{angle}"), format!("%s{angle}"));
    let sign = |bytes: &mut Unstructured<'_>| -> Result<char> {
        Ok(if bytes.arbitrary()? { '+' } else { '-' })
    };
    let (p, q, r) = (sign(bytes)?, sign(bytes)?, sign(bytes)?);
    Ok(match bytes.int_in_range(0..=9)? {
        0 => vec![
            format!("{a}*{cos} + {b}*{sin}"),
            format!("{b}*{cos} - {a}*{sin}"),
        ],
        // Signs may be those of a rotation or not.
        1 => vec![
            format!("{a}*{cos} {p} {b}*{sin}"),
            format!("{a}*{sin} {q} {b}*{cos}"),
        ],
        2 => vec![
            format!("{a}*{cos} {p} {sin}*{b} {q} {c}*{d}"),
            format!("{b}*{cos} {r} {a}*{sin} - {d}*{e}"),
            format!("{c} {q} {d}"),
        ],
        3 => vec![
            format!("{a}*{cos}"),
            format!("{a}*{sin}"),
            format!("{b} {p} {c}"),
        ],
        4 => vec![
            format!("{a}*{b} {p} {c}*{d}"),
            format!("{c}*{e} - {a}*{f}"),
            format!("{a} {q} 0.7*{b}"),
        ],
        5 => vec![
            format!("{a}*{d}"),
            format!("{b}*{d} {p} {c}"),
            format!("{c}*{d} {q} {e}*{f}"),
        ],
        6 => vec![format!("{a} {p} {b} {q} {c}"), format!("{d} {r} {e} - {f}")],
        7 => vec![
            format!("{a}/(2.5 + {cos}*{sin})"),
            format!("{b}/(2.5 + {cos}*{sin})"),
        ],
        8 => vec![
            format!("fma({a}, {cos}, {b}*{sin})"),
            format!("sqrt({a}*{a} + 0.5)"),
        ],
        _ => vec![
            format!("{a}*{a} {p} {b}*{b}"),
            format!("-{c} {q} ({a} - {d})*{cos}"),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn no_value_is_beyond_its_norm() {
        cases::of_sizes(1500, 600, |bytes| {
            norms_hold(bytes.bytes(bytes.len())?);
            Ok(())
        });
    }
}
