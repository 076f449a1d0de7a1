//! Generated C, compiled, against the evaluator, bit for bit.

use crate::simulate::naive::{self, Random};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{
    Array, Assignment, Constant, Function, Input, Level, Machine, Module, Name, Node, Operand,
    Operation, Output, Shape, SourceSet, View,
};
use robovec_num::arithmetic::{Binary32, Binary64};
use robovec_passes::codegen::c::{Real, c_files};
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// Reads numbers as bits from the arguments, calls the function, and prints
/// the outputs' bits. Scalars, vectors and matrices are laid out from 1.
fn harness(function: &Function, module: &Module, name: &str, real: Real) -> String {
    let (bits, read) = match real {
        Real::Double => ("unsigned long long", "strtoull(argv[next++], 0, 16)"),
        Real::Float => ("unsigned int", "(unsigned int)strtoul(argv[next++], 0, 16)"),
    };
    let real = real.name();
    let mut text = format!(
        "#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n#include \"{name}.h\"\n\
         int main(int argc, char **argv) {{\n int next = 1; {bits} b; (void)argc;\n"
    );
    let mut arguments = Vec::new();
    for (array, is_input) in (function.inputs().iter().map(|array| (array, true)))
        .chain(function.outputs().iter().map(|array| (array, false)))
    {
        let name = storage(module, array, is_input);
        let (extent, count) = match array.shape {
            Shape::Scalar => ("[1]".to_owned(), 1),
            Shape::Vector(length) => (format!("[{}]", length + 1), length),
            Shape::Matrix(rows, columns) => {
                (format!("[{}][{}]", rows + 1, columns + 1), rows * columns)
            }
        };
        writeln!(text, " static {real} {name}{extent};").expect("a string");
        for offset in (0..count).filter(|_| is_input) {
            let place = place(&name, array.shape, offset);
            writeln!(text, " b = {read}; memcpy(&{place}, &b, sizeof b);").expect("a string");
        }
        let scalar_input = is_input && array.shape == Shape::Scalar;
        arguments.push(if scalar_input {
            format!("{name}[0]")
        } else {
            name
        });
    }
    writeln!(text, " {name}({});", arguments.join(", ")).expect("a string");
    for assignment in &function.assignments {
        let (array, _, _) = function.output_element(assignment.output);
        let offset = assignment.output.0 - array.offset;
        let place = place(&storage(module, array, false), array.shape, offset);
        writeln!(text, " memcpy(&b, &{place}, sizeof b);").expect("a string");
        writeln!(text, " printf(\"%llx\\n\", (unsigned long long)b);").expect("a string");
    }
    text + " return 0;\n}\n"
}

/// An input and an output may bear one name.
fn storage(module: &Module, array: &Array, is_input: bool) -> String {
    let name = module.tables.symbols.text(array.name);
    format!("{}_{name}", if is_input { "in" } else { "out" }).replace('.', "_")
}

fn place(name: &str, shape: Shape, offset: u32) -> String {
    let (indices, rank) = shape.indices(offset);
    match rank {
        0 => format!("{name}[0]"),
        1 => format!("{name}[{}]", indices[0]),
        _ => format!("{name}[{}][{}]", indices[0], indices[1]),
    }
}

/// Compiles without a single warning and runs; the outputs' bits.
fn compile_and_run(directory: &Path, module: &Module, real: Real, words: &[u64]) -> Vec<u64> {
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    let files = c_files(view, real);
    let name = files[0].0.trim_end_matches(".c").to_owned();
    for (file, text) in &files {
        std::fs::write(directory.join(file), text).expect("a temporary file");
    }
    let main = directory.join("main.c");
    std::fs::write(&main, harness(function, module, &name, real)).expect("a temporary file");
    let program = directory.join("program");
    let compiled = Command::new("gcc")
        .args([
            "-std=c99",
            "-O1",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-ffp-contract=off",
            "-o",
        ])
        .args([&program, &main, &directory.join(&files[0].0)])
        .arg("-lm")
        .output()
        .expect("gcc is there");
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{messages}");
    let inputs = words.iter().map(|word| format!("{word:x}"));
    let output = Command::new(&program)
        .args(inputs)
        .output()
        .expect("it runs");
    let text = String::from_utf8(output.stdout).expect("hexadecimal");
    let number = |line| u64::from_str_radix(line, 16).expect("hexadecimal");
    text.lines().map(number).collect()
}

fn check(module: &Module, inputs: &[f64]) {
    if Command::new("gcc").arg("--version").output().is_err() {
        eprintln!("no gcc: the generated C is not compiled");
        return;
    }
    let directory = tempfile::tempdir().expect("a temporary directory");
    let function = &module.functions[0];
    let numbers = evaluate(function, &Binary64, inputs);
    assert!(
        numbers.iter().all(|number| number.is_finite()),
        "{numbers:?}"
    );
    let expected: Vec<u64> = (numbers.iter()).map(|number| number.to_bits()).collect();
    let words: Vec<u64> = inputs.iter().map(|number| number.to_bits()).collect();
    let found = compile_and_run(directory.path(), module, Real::Double, &words);
    assert_eq!(found, expected);
    let singles: Vec<f32> = inputs.iter().map(|&number| number as f32).collect();
    let expected: Vec<u64> = (evaluate(function, &Binary32, &singles).iter())
        .map(|number| u64::from(number.to_bits()))
        .collect();
    let words: Vec<u64> = singles.iter().map(|n| u64::from(n.to_bits())).collect();
    let found = compile_and_run(directory.path(), module, Real::Float, &words);
    assert_eq!(found, expected);
}

#[test]
fn atomic_functions_of_many_parts() {
    let machine = Machine::built_in("fused").expect("it ships");
    for (seed, operations) in [(1, 30), (2, 600), (3, 4000)] {
        let mut random = Random(seed);
        let module = naive::random_function(&mut random, operations, &machine);
        let inputs: Vec<f64> = (0..5).map(|_| random.number()).collect();
        check(&module, &inputs);
    }
}

/// Expression trees, every operation, every shape, names C does not take.
#[test]
fn expression_trees_of_every_operation() {
    let mut random = Random(7);
    let module = trees(&mut random, 900);
    let inputs: Vec<f64> = (0..13).map(|_| 0.5 + random.number().abs()).collect();
    check(&module, &inputs);
}

/// Random expression trees, some of them deep.
fn trees(random: &mut Random, definitions: u32) -> Module {
    let mut module = Module::new();
    let symbols = &mut module.tables.symbols;
    let mut function = Function::new("double", Level::Equations);
    function.add_input(symbols.intern("tsim"), Shape::Scalar);
    function.add_input(symbols.intern("dpt"), Shape::Matrix(3, 4));
    function.add_output(symbols.intern("sin"), Shape::Matrix(2, 3));
    function.add_output(symbols.intern("energy"), Shape::Scalar);
    let base = symbols.intern("int");
    let constants: Vec<Constant> = [0.1, -2.5, -0.0, 3.0]
        .into_iter()
        .map(|number| function.constant(number))
        .collect();
    let mut known: Vec<Operand> = (0..13).map(|index| Input(index).into()).collect();
    known.extend(constants.into_iter().map(Operand::from));
    for count in 0..definitions {
        let depth = if count % 100 == 7 {
            300
        } else {
            random.below(6)
        };
        let mut tree = known[random.below(known.len())];
        for level in 0..=depth {
            let other = known[random.below(known.len())];
            let positive: Operand = Input(random.below(13) as u32).into();
            // Roots and quotients of inputs only, and few products: numbers
            // stay finite, so that their bits say something.
            let (operation, left, right) = match Operation::ALL[random.below(Operation::ALL.len())]
            {
                Operation::Div => (Operation::Div, tree, positive),
                Operation::Sqrt if level == 0 => (Operation::Sqrt, positive, positive),
                Operation::Sqrt => (Operation::Cos, tree, tree),
                Operation::Mul if random.below(2) > 0 => (Operation::Sin, tree, tree),
                operation if operation.is_fused() && random.below(2) > 0 => {
                    (Operation::Sin, tree, tree)
                }
                operation if random.below(2) == 0 => (operation, tree, other),
                operation if operation.arity() > 1 => (operation, other, tree),
                operation => (operation, tree, tree),
            };
            let last = level == depth;
            let operands = match operation.arity() {
                1 => Operand::list([left]),
                2 => Operand::list([left, right]),
                _ => [left, right, known[random.below(known.len())]],
            };
            let suffix = count;
            let name = if last {
                Name { base, suffix }
            } else {
                Name::NONE
            };
            let sources = SourceSet::EMPTY;
            let node = Node {
                name,
                sources,
                operands,
                operation,
            };
            tree = function.push(node).into();
        }
        known.push(tree);
    }
    function.assignments = (0..7)
        .map(|index| Assignment {
            output: Output(index),
            operand: known[known.len() - 1 - index as usize * 3],
            sources: SourceSet::EMPTY,
        })
        .collect();
    module.functions.push(function);
    module
}
