//! The program around a generated function: random states, a clock, and the
//! least of many repetitions.

use robovec_ir::{Array, Shape, View};
use robovec_passes::codegen::c::Real;
use std::fmt::Write;

/// States the function is called with in turn.
const STATES: u32 = 16;

/// Doubles calls until a sample is long against the clock's steps, takes
/// samples and prints the least time of a call in nanoseconds, and a sum of
/// the results, so that no call is for nothing.
const TIMING: &str = "
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
static double sample(long calls) {
    const double start = now();
    for (long i = 0; i < calls; i++) call((int)(i % STATES));
    return (now() - start) / (double)calls;
}
int main(void) {
    long calls = 1;
    fill();
    while (sample(calls) * (double)calls < 2e6) calls *= 2;
    double least = sample(calls);
    for (int i = 0; i < 40; i++) {
        const double t = sample(calls);
        if (t < least) least = t;
    }
    printf(\"%.3f %g\\n\", least, sum());
    return 0;
}
";

/// The text of the program.
pub(super) fn main(view: View<'_>, header: &str, real: Real) -> String {
    let real = real.name();
    let function = view.function;
    let mut storage = String::new();
    let mut fill = String::new();
    let mut sum = String::new();
    let mut arguments = Vec::new();
    let inputs = function.inputs().iter().map(|array| (array, true));
    let outputs = function.outputs().iter().map(|array| (array, false));
    for (index, (array, is_input)) in inputs.chain(outputs).enumerate() {
        // Names of our own: an input and an output may share one.
        let name = format!("a{index}");
        let states = if is_input { "[STATES]" } else { "" };
        // Writing to a string cannot fail.
        let _ = writeln!(storage, "static {real} {name}{states}{};", extent(array));
        let place = |element: &str| format!("(({real} *){name})[{element}]");
        if is_input {
            let _ = writeln!(
                fill,
                "    for (size_t i = 0; i < sizeof {name} / sizeof({real}); i++) {} = ({real})next();",
                place("i")
            );
        } else {
            let _ = writeln!(
                sum,
                "    for (size_t i = 0; i < sizeof {name} / sizeof({real}); i++) s += {};",
                place("i")
            );
        }
        arguments.push(match (is_input, array.shape) {
            (true, Shape::Scalar) => format!("{name}[s][0]"),
            (true, Shape::Vector(_)) => format!("{name}[s]"),
            (true, Shape::Matrix(..)) => {
                format!("(const {real} (*){})", columns(array)) + &format!("{name}[s]")
            }
            (false, _) => name,
        });
    }
    let name = header.trim_end_matches(".h");
    format!(
        "#define _POSIX_C_SOURCE 199309L\n#include <stddef.h>\n#include <stdio.h>\n#include <time.h>\n\
         #include \"{header}\"\n#define STATES {STATES}\n{storage}\
         static unsigned long long seed = 88172645463325252ull;\n\
         static double next(void) {{\n    seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17;\n    \
         return (double)(seed >> 11) / 4503599627370496.0 - 1.0;\n}}\n\
         static void fill(void) {{\n{fill}}}\n\
         static double sum(void) {{\n    double s = 0.0;\n{sum}    return s;\n}}\n\
         static void call(int s) {{\n    {name}({});\n}}\n{TIMING}",
        arguments.join(", ")
    )
}

/// The extent of an array that counts from 1.
fn extent(array: &Array) -> String {
    match array.shape {
        Shape::Scalar => "[1]".to_owned(),
        Shape::Vector(length) => format!("[{}]", length + 1),
        Shape::Matrix(rows, columns) => format!("[{}][{}]", rows + 1, columns + 1),
    }
}

/// The extent of a row of a matrix.
fn columns(array: &Array) -> String {
    match array.shape {
        Shape::Matrix(_, columns) => format!("[{}]", columns + 1),
        Shape::Scalar | Shape::Vector(_) => String::new(),
    }
}
