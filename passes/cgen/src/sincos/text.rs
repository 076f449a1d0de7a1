//! The C text of the kernel, from the templates in this folder.

use super::{KernelConstants, SineKernel};
use crate::emit::Real;
use crate::emit::expression::{self, BoundText, Operands, apply};
use robovec_framework::template::fill;
use robovec_ir::Operation;
use std::fmt::Write;

/// One vector of angles; `far` gathers lanes that are left to the library in
/// its sign bits.
const CIRCULAR: &str = include_str!("circular.c");

/// The library for lanes that are too large or no numbers.
const FAR: &str = include_str!("far.c");

/// Types of vectors where compilers have them, with the number of lanes of a
/// register: wider ones are split in memory, which takes several times longer
/// than narrower ones one after the other.
pub(super) fn types(kernel: SineKernel) -> String {
    let types = match kernel.lanes {
        1 => "typedef @real@ @vector@;\ntypedef @real@ @unaligned@;\n",
        _ => include_str!("types.c"),
    };
    filled(kernel, &format!("#include <math.h>\n\n{types}"), "")
}

/// The function for an array of angles.
pub(super) fn arrays(kernel: SineKernel) -> String {
    let head = "static void robovec_sincos_@suffix@(long count, const @real@ *angles, \
                @real@ *sines, @real@ *cosines)";
    function(kernel, head, "angles[i]", include_str!("arrays.c"))
}

/// The function for angles of many states.
pub(super) fn runs(kernel: SineKernel) -> String {
    let head = "static void robovec_sincos_runs_@suffix@(long count, const @real@ *angles, \
                const int *places, long stride,\n    @vector@ *sines, @vector@ *cosines)";
    let angle = "angles[places[i] * stride]";
    function(kernel, head, angle, include_str!("runs.c"))
}

/// A function with vectors, and the same by the library where there are none.
fn function(kernel: SineKernel, head: &str, angle: &str, body: &str) -> String {
    let library = format!("{head}\n{}", include_str!("library.c"));
    let library = filled(kernel, &library, angle);
    if kernel.lanes == 1 {
        return library;
    }
    let head = head.replacen("static", "static ROBOVEC_PRECISE", 1);
    let vectors = format!("#if @lanes@\n{CIRCULAR}\n{FAR}\n{head}\n{body}#else\n");
    filled(kernel, &vectors, "angles[i]") + &library + "#endif\n"
}

/// Fills a template with the names and constants of the kernel; `angle` is the
/// argument of the library's sine and cosine.
fn filled(kernel: SineKernel, template: &str, angle: &str) -> String {
    let SineKernel { real, lanes } = kernel;
    let constants = KernelConstants::of(real);
    let (size, integer, ones, absolute, most) = match real {
        Real::Double => (8, "long long", "ull", "fabs", constants.limit.to_bits()),
        Real::Float => {
            let most = (constants.limit as f32).to_bits();
            (4, "int", "u", "fabsf", u64::from(most))
        }
    };
    let sign = 8 * size - 1;
    let suffix = kernel.suffix();
    let upper = suffix.to_ascii_uppercase();
    let bits = |bits: u64| format!("{bits:#x}{ones}");
    let fit = |bytes: u32| (bytes / size).min(lanes);
    let number = |value: f64| literal(real, value);
    let library = |operation| {
        let angle = [BoundText::primary(angle)];
        apply(operation, &angle, real, Operands::Numbers).text
    };
    fill(
        template,
        &[
            ("real", &real.name()),
            ("vector", &kernel.vector()),
            ("unaligned", &kernel.unaligned()),
            ("bits", &format!("robovec_bits_{suffix}")),
            ("suffix", &suffix),
            ("upper", &upper),
            // The macro for the number of lanes of a vector.
            ("lanes", &format!("ROBOVEC_{upper}")),
            ("all", &lanes),
            ("some", &fit(32)),
            ("least", &fit(16)),
            ("bytes", &format!("{size} * ROBOVEC_{upper}")),
            ("own", &size),
            ("integer", &integer),
            // The suffix of an unsigned integer of the lanes' width.
            ("ones", &ones),
            ("sign", &sign),
            ("shift", &(sign - 1)),
            ("signs", &bits(1 << sign)),
            ("mask", &bits((1 << sign) - 1)),
            ("most", &bits(most)),
            ("limit", &constants.limit),
            ("limit_number", &number(constants.limit)),
            ("absolute", &absolute),
            ("turns", &number(constants.turns)),
            ("rounder", &number(constants.rounder)),
            ("first", &number(constants.quarter[0])),
            ("reduction", &reduction(kernel)),
            ("half", &number(0.5)),
            ("one", &number(1.0)),
            ("sine_polynomial", &pairs(real, constants.sine)),
            ("cosine_polynomial", &pairs(real, constants.cosine)),
            ("sine", &library(Operation::Sin)),
            ("cosine", &library(Operation::Cos)),
        ],
    )
}

/// The subtraction of the parts of a quarter turn after the first.
fn reduction(kernel: SineKernel) -> String {
    let vector = kernel.vector();
    let parts = &KernelConstants::of(kernel.real).quarter[1..];
    let mut text = String::new();
    for (index, &part) in (1..).zip(parts) {
        let part = literal(kernel.real, part);
        let (from, carried) = match index - 1 {
            0 => ("near".to_owned(), String::new()),
            before => (format!("r{before}"), format!(" + low{before}")),
        };
        let _ = write!(
            text,
            "    const {vector} w{index} = turns * {part};
    {vector} r{index} = {from} - w{index};
    const {vector} low{index} = ({from} - r{index}) - w{index}{carried};
",
        );
    }
    let last = parts.len();
    text + &format!("    const {vector} r = r{last};\n    const {vector} low = low{last};\n")
}

/// A number as a literal that reads back as itself.
fn literal(real: Real, number: f64) -> String {
    expression::literal(number, real).text
}

/// A polynomial in `z`: pairs of terms are one step each and joined by powers
/// of `zz`, half as long a chain as term by term.
fn pairs(real: Real, coefficients: &[f64]) -> String {
    let mut text = String::new();
    for pair in coefficients.chunks(2).rev() {
        let own = match *pair {
            [first, second] => format!("{} + z * {}", literal(real, first), literal(real, second)),
            _ => literal(real, pair[0]),
        };
        text = if text.is_empty() {
            own
        } else {
            format!("({own}) + zz * ({text})")
        };
    }
    text
}
