//! Generated C, compiled, against the evaluator, bit for bit.

use crate::simulate::naive;
use robovec_cgen::c::{self, Options, Real, TrialState, trial_main};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{
    Assignment, Constant, Function, Input, Level, Machine, Module, Name, Node, Operand, Operation,
    Output, Shape, SourceSet, View,
};
use robovec_num::arithmetic::Binary32;
use robovec_num::random::Random;
use std::path::Path;
use std::process::Command;

/// Compiles without a warning and runs; returns the outputs, with 17 digits,
/// which distinguish all numbers.
fn compile_and_run(
    directory: &Path,
    view: View<'_>,
    options: &Options,
    trial: &TrialState,
) -> Vec<f64> {
    let files = c::files(view, options).expect("a plain signature");
    for (file, text) in &files {
        std::fs::write(directory.join(file), text).expect("a temporary file");
    }
    let name = files[0].0.trim_end_matches(".c").to_owned();
    let text = trial_main(view, options, &[&name], trial);
    let main = directory.join("main.c");
    std::fs::write(&main, text).expect("a temporary file");
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
    let output = Command::new(&program).arg("print").output();
    let text = String::from_utf8(output.expect("it runs").stdout).expect("numbers");
    let lines = text.lines().take(trial.expected.len());
    let number = |line: &str| line.split(' ').nth(2).and_then(|word| word.parse().ok());
    lines.map(|line| number(line).expect("a number")).collect()
}

/// Compares C with the evaluator in both types, with the options of each.
pub(crate) fn check(module: &Module, inputs: &[f64], options: impl Fn(Real) -> Options) {
    if Command::new("gcc").arg("--version").output().is_err() {
        eprintln!("no gcc: the generated C is not compiled");
        return;
    }
    let directory = tempfile::tempdir().expect("a temporary directory");
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let trial = TrialState::new(view, inputs.to_vec(), 1.0);
    let numbers = &trial.expected;
    assert!(
        numbers.iter().all(|number| number.is_finite()),
        "{numbers:?}"
    );
    let expected: Vec<u64> = (numbers.iter()).map(|number| number.to_bits()).collect();
    let found = compile_and_run(directory.path(), view, &options(Real::Double), &trial);
    let found: Vec<u64> = found.iter().map(|number| number.to_bits()).collect();
    assert_eq!(found, expected);
    let singles: Vec<f32> = inputs.iter().map(|&number| number as f32).collect();
    let expected: Vec<u32> = (evaluate(view.function, &Binary32, &singles).iter())
        .map(|number| number.to_bits())
        .collect();
    let found = compile_and_run(directory.path(), view, &options(Real::Float), &trial);
    let found: Vec<u32> = found.iter().map(|&n| (n as f32).to_bits()).collect();
    assert_eq!(found, expected);
}

#[test]
fn atomic_functions_of_many_parts() {
    let machine = Machine::built_in("fused").expect("it ships");
    for (seed, operations) in [(1, 30), (2, 600), (3, 4000)] {
        let mut random = Random::new(seed);
        let module = naive::random_function(&mut random, operations, &machine);
        let inputs: Vec<f64> = (0..5).map(|_| naive::number(&mut random)).collect();
        check(&module, &inputs, Options::plain);
    }
}

/// Expression trees, every operation, every shape, names C does not take.
#[test]
fn expression_trees_of_every_operation() {
    let mut random = Random::new(7);
    let module = trees(&mut random, 900);
    let inputs: Vec<f64> = (0..13)
        .map(|_| 0.5 + naive::number(&mut random).abs())
        .collect();
    check(&module, &inputs, Options::plain);
}

/// Random expression trees, some of them deep.
pub(crate) fn trees(random: &mut Random, definitions: u32) -> Module {
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
