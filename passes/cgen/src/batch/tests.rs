use super::*;
use crate::emit::arrays::{extent, place as element};
use crate::testing::compiled_output;
use robovec_ir::evaluate::evaluate;
use robovec_ir::parse::parse_module;
use robovec_ir::{Function, Module, Shape};
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use std::fmt::Write as _;

/// Every operation, inputs of every shape, shared and not, angles that are
/// inputs, computed, and sines; outputs that are literals, inputs and shared.
fn program(operations: usize) -> String {
    let mut random = Random::new(operations as u64);
    let mut text = String::from(
        "function double atomic {\n  in q[1..4]\n  in tsim\n  in m[1..3]\n  in dpt[1..2,1..3]\n  \
         in never[1..2]\n  out M[1..3,1..3]\n  out c[1..3]\n  out energy\n\n\
         %U1 = m[1]*dpt[2,3]\n%U2 = sin(%U1)\n%U3 = %U2 + 1.5\n%U4 = sqrt(%U3)\n\
         %S1 = sin(q[1])\n%C1 = cos(q[1])\n%S3 = sin(q[3])\n%CT = cos(tsim)\n\
         %A1 = q[1] + q[2]\n%A2 = %A1 + %U1\n%SA = sin(%A2)\n%SS = sin(%S1)\n%CS = cos(%SS)\n\
         %R0 = %S1*%S1\n%R1 = %R0 + 0.5\n%R2 = sqrt(%R1)\n%D = %C1 / %R2\n%N = 0 - %D\n\
         %F1 = fma(%D, %S3, %CT)\n%F2 = fms(%D, %U4, %SA)\n%F3 = fnma(-0.5, %CS, %F1)\n",
    );
    let mut known: Vec<String> = [
        "%S1", "%C1", "%S3", "%CT", "%SA", "%CS", "%D", "%N", "%F1", "%F2", "%F3", "%U4", "q[2]",
        "m[2]", "0.25", "-1.5",
    ]
    .map(str::to_owned)
    .to_vec();
    for number in 1..=operations {
        let mut pick = || {
            let recent = random.below(3) > 0 && known.len() > 24;
            let first = if recent { known.len() - 8 } else { 0 };
            known[first + random.below(known.len() - first)].clone()
        };
        let (left, right) = (pick(), pick());
        let small = ["%S1", "%C1", "%S3", "0.25"][random.below(4)];
        let written = match random.below(3) {
            0 => format!("{left} + {right}"),
            1 => format!("{left} - {right}"),
            _ => format!("{left}*{small}"),
        };
        writeln!(text, "%x{number} = {written}").expect("a string");
        // Sums are damped, so that errors say something.
        if number % 2 == 0 {
            writeln!(text, "%y{number} = %x{number}*{small}").expect("a string");
            known.push(format!("%y{number}"));
        }
    }
    let last = |back: usize| known[known.len() - 1 - back].clone();
    write!(
        text,
        "\nM[1,1] = {}\nM[1,2] = {}\nM[3,3] = {}\nM[2,1] = 1.25\nc[1] = %U4\nc[2] = %SS\n\
         c[3] = q[4]\nenergy = {}\n}}\n",
        last(0),
        last(1),
        last(2),
        last(3)
    )
    .expect("a string");
    text
}

fn module(operations: usize) -> Module {
    let text = program(operations);
    parse_module("test.rvir", &text).unwrap_or_else(|errors| panic!("{errors:?}\n{text}"))
}

/// A main program that evaluates the states with both functions and prints the
/// outputs; it fails when they differ.
fn harness(function: &Function, module: &Module, options: &Options, states: &[Vec<f64>]) -> String {
    let real = options.real.name();
    let count = states.len();
    let mut text = format!(
        "#include \"double_1_batch.h\"\n#include <stdio.h>\n#include <string.h>\n\
         enum {{ STATES = {count}, LANES = double_1_LANES, PLACES = (STATES + LANES - 1) / LANES * LANES }};\n"
    );
    let (mut fill, mut plain, mut runs) = (String::new(), Vec::new(), Vec::new());
    for array in function.inputs() {
        let name = module.tables.symbols.text(array.name);
        let shared = options.shared.iter().any(|shared| shared == name);
        let size = extent(array);
        let held = if shared { "1" } else { "PLACES" };
        writeln!(
            text,
            "static {real} s_{name}[{held} * {size}], r_{name}[{held} * {size}];"
        )
        .expect("a string");
        for (number, state) in states.iter().enumerate() {
            for offset in 0..array.shape.len() as u32 {
                let value = state[(array.offset + offset) as usize];
                let element = element(array, offset);
                if !shared || number == 0 {
                    let lanes = u64::from(options.lanes);
                    let (batch, lane) = (number as u64 / lanes, number as u64 % lanes);
                    let place = (batch * size + element) * lanes + lane;
                    let place = if shared { element } else { place };
                    let own = number as u64 * size + element;
                    writeln!(
                        fill,
                        " s_{name}[{own}] = r_{name}[{place}] = ({real}){value:?};"
                    )
                    .expect("a string");
                }
            }
        }
        let scalar = shared && array.shape == Shape::Scalar;
        let star = if scalar { "*" } else { "" };
        plain.push(format!("{star}s_{name}"));
        runs.push(format!("{star}r_{name}"));
    }
    let mut print = String::new();
    for array in function.outputs() {
        let name = module.tables.symbols.text(array.name);
        let size = extent(array);
        writeln!(
            text,
            "static {real} s_{name}[PLACES * {size}], r_{name}[PLACES * {size}];"
        )
        .expect("a string");
        plain.push(format!("s_{name}"));
        runs.push(format!("r_{name}"));
        writeln!(
            print,
            " for (int e = 0; e < {size}; e++) {{ {real} a = s_{name}[s * {size} + e], b = r_{name}[(s / LANES * {size} + e) * LANES + s % LANES];\n  \
             if (memcmp(&a, &b, sizeof a)) return 2;\n  printf(\"%.17g\\n\", (double)a); }}"
        )
        .expect("a string");
    }
    text + &format!(
        "int main(void)\n{{\n{fill} if (double_1_states(STATES, {})) return 1;\n \
         if (double_1_many(STATES, {})) return 1;\n for (int s = 0; s < STATES; s++) {{\n{print} }}\n return 0;\n}}\n",
        plain.join(", "),
        runs.join(", ")
    )
}

/// The numbers a program prints, where there is a compiler.
fn run(main: String, files: [(String, String); 2], flags: &[&str]) -> Option<Vec<f64>> {
    let mut files = files.to_vec();
    files.push(("main.c".to_owned(), main));
    let (text, succeeds) = compiled_output(&files, flags, &[])?;
    assert!(succeeds, "{text}");
    let numbers = text.lines().map(|line| line.parse().expect("a number"));
    Some(numbers.collect())
}

/// Compiles for some states and compares with the evaluator.
fn check(operations: usize, options: &Options, count: usize, flags: &[&str]) {
    let module = module(operations);
    let function = &module.functions[0];
    let mut random = Random::new(17 + count as u64);
    let mut states: Vec<Vec<f64>> = Vec::new();
    for _ in 0..count {
        let mut state: Vec<f64> = (0..function.input_len()).map(|_| random.signed()).collect();
        for array in function.inputs() {
            let name = module.tables.symbols.text(array.name);
            if let (true, Some(first)) = (options.shared.iter().any(|s| s == name), states.first())
            {
                let range = array.offset as usize..array.offset as usize + array.shape.len();
                state[range.clone()].copy_from_slice(&first[range]);
            }
        }
        states.push(state);
    }
    let view = View {
        tables: &module.tables,
        function,
    };
    let files = batch_files(view, options);
    let main = harness(function, &module, options, &states);
    let Some(found) = run(main, files, flags) else {
        return;
    };
    let width: u64 = function.outputs().iter().map(extent).sum();
    assert_eq!(found.len() as u64, count as u64 * width);
    let tolerance = match options.real {
        Real::Double => 1e-12,
        Real::Float => 2e-4,
    };
    for (state, found) in states.iter().zip(found.chunks(width as usize)) {
        let expected = evaluate(function, &Binary64, state);
        for (assignment, expected) in function.assignments.iter().zip(expected) {
            let (array, _, _) = function.output_element(assignment.output);
            let before = function
                .outputs()
                .iter()
                .take_while(|other| *other != array);
            let place = before.map(extent).sum::<u64>()
                + element(array, assignment.output.0 - array.offset);
            let found = found[place as usize];
            let distance = (found - expected).abs();
            assert!(
                distance <= tolerance * expected.abs().max(1.0),
                "{found} for {expected} with {options:?} and {flags:?}"
            );
        }
    }
}

#[test]
fn many_states_agree_with_the_evaluator() {
    let native = ["-O2", "-march=native"];
    for (lanes, real, count) in [
        (8, Real::Double, 19),
        (4, Real::Double, 8),
        (16, Real::Float, 33),
        (1, Real::Double, 3),
    ] {
        let options = Options {
            real,
            lanes,
            part: 60,
            ..Options::default()
        };
        check(300, &options, count, &native);
    }
}

#[test]
fn compilers_without_vectors_get_the_same() {
    for (lanes, real) in [(8, Real::Double), (4, Real::Float)] {
        let options = Options {
            real,
            lanes,
            shared: Vec::new(),
            part: 100,
        };
        check(120, &options, 11, &["-O1", "-DROBOVEC_SCALAR"]);
    }
}

#[test]
fn parameters_can_differ_from_state_to_state() {
    let options = Options {
        lanes: 16,
        shared: Vec::new(),
        ..Options::default()
    };
    check(50, &options, 5, &["-O1"]);
}

#[test]
fn threads_change_nothing() {
    let options = Options::default();
    check(100, &options, 101, &["-O1", "-fopenmp"]);
}

#[test]
fn functions_of_nothing_compile() {
    let text = "function f atomic {\n  out c[1..2]\n\n  c[1] = 2\n}\n";
    let module = parse_module("test.rvir", text).expect("a module");
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let main = "#include \"f_batch.h\"\n#include <stdio.h>\nint main(void) { double c[9] = {0}; \
                if (f_states(3, c)) return 1; for (int i = 0; i < 9; i++) printf(\"%g\\n\", c[i]); return 0; }\n";
    let files = batch_files(view, &Options::default());
    let Some(found) = run(main.to_owned(), files, &["-O1"]) else {
        return;
    };
    assert_eq!(found, [0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0]);
}
