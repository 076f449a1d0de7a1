//! Targets as templates: every target that ships, compiled and run against the
//! evaluator where its tool is installed, and targets of users.

mod drivers;
mod user;

use crate::codegen_c::trees;
use crate::support::programs::{robovec, said};
use drivers::{c_main, compile_object, link_and_run, python, rust_main, tools};
use robovec_cgen::template::CodeTarget;
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Module, Operand, Operation, View, parse};
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A function at a state, and the largest difference of its results, in units in
/// the last place of the largest one, when sines are not the library's.
struct TargetCase {
    module: Module,
    state: Vec<f64>,
    ulps: f64,
}

impl TargetCase {
    fn new(module: Module, ulps: f64) -> TargetCase {
        let count = module.functions[0].input_len();
        let state = (0..count).map(|k| 0.25 + ((k * 7) % 16) as f64 / 16.0);
        TargetCase {
            state: state.collect(),
            module,
            ulps,
        }
    }

    fn view(&self) -> View<'_> {
        View {
            tables: &self.module.tables,
            function: &self.module.functions[0],
        }
    }

    /// The results of the evaluator; elements that are never set are zero.
    fn expected(&self) -> Vec<f64> {
        let function = self.view().function;
        let mut all = vec![0.0; function.output_len()];
        let values = evaluate(function, &Binary64, &self.state);
        for (set, value) in function.assignments.iter().zip(values) {
            all[set.output.index()] = value;
        }
        assert!(all.iter().all(|number: &f64| number.is_finite()), "{all:?}");
        all
    }

    /// Compares results bit for bit, or up to the difference of the case if that
    /// is not zero.
    fn assert_near_or_same(&self, found: &[f64]) {
        if self.ulps == 0.0 {
            self.assert_same(found);
        } else {
            self.assert_near(found);
        }
    }

    fn assert_same(&self, found: &[f64]) {
        let bits = |all: &[f64]| {
            all.iter()
                .map(|number| number.to_bits())
                .collect::<Vec<_>>()
        };
        assert_eq!(bits(found), bits(&self.expected()), "{found:?}");
    }

    fn assert_near(&self, found: &[f64]) {
        let expected = self.expected();
        assert_eq!(found.len(), expected.len());
        let size = expected
            .iter()
            .fold(0.0_f64, |size, number| size.max(number.abs()));
        for (found, expected) in found.iter().zip(&expected) {
            let ulps = (found - expected).abs() / (size * f64::EPSILON);
            assert!(ulps <= self.ulps, "{ulps} ulp: {found} {expected}");
        }
    }
}

/// A function with scalars, vectors and matrices, copies, names that languages
/// reserve, elements that are never set and a number that needs all its digits.
const OF_EVERY_SHAPE: &str = "// robovec 1
function lambda equations {
  in let
  in x[1..3]
  in A[1..2,1..2]
  out y[1..2]
  out B[1..2,1..3]
  out fn
  %s = sin(x[1])
  %def = %s
  y[1] = %def*A[1,2] + let
  y[2] = x[2]/(A[2,2] - -0.1)
  B[1,3] = -(x[3] + A[2,1]*(%s - (let - x[1])))/1e-300
  B[2,1] = cos(sqrt(x[2])*let)
  fn = 1e300*x[1] - (x[2] - (x[3] - 2.0)) + A[1,1]*A[1,1]
}
";

/// Random expressions with all operations, or with those that remain after a
/// replacement.
fn random(replace: impl Fn(Operation) -> Operation) -> TargetCase {
    let mut module = trees(&mut Random::new(7), 300);
    let function = &mut module.functions[0];
    let values: Vec<_> = function.values().map(|(value, _)| value).collect();
    for value in values {
        let node = function.node_mut(value);
        node.operation = replace(node.operation);
        let kept = node.operation.arity();
        node.operands[kept..].fill(Operand::NONE);
    }
    TargetCase::new(module, 0.0)
}

/// Operations of NumPy with exact results.
fn rounded(operation: Operation) -> Operation {
    match operation {
        Operation::Sin | Operation::Cos => Operation::Neg,
        operation if operation.is_fused() => Operation::Sub,
        operation => operation,
    }
}

fn of_every_shape() -> TargetCase {
    let module = parse::parse_module("f", OF_EVERY_SHAPE).expect("it is the text form");
    TargetCase::new(module, 4.0)
}

/// Inverse dynamics of a robot.
fn arm() -> TargetCase {
    let words = "gen examples/robots/arm.urdf --function invdyna --numbers --no-forces";
    let words: Vec<&str> = words.split(' ').collect();
    let text = said(&robovec(&words));
    TargetCase::new(
        parse::parse_module("arm", &text).expect("it is the text form"),
        16.0,
    )
}

/// The file of a target in a folder: its name.
fn write(folder: &Path, target: &str, case: &TargetCase) -> String {
    let (name, text) = CodeTarget::built_in(target)
        .file(case.view())
        .expect("it is written");
    fs::write(folder.join(&name), text).expect("a temporary file");
    name
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn rust_gives_the_bits_of_the_evaluator() {
    for case in [random(|operation| operation), of_every_shape(), arm()] {
        let folder = folder();
        let name = write(folder.path(), "rust", &case);
        let module = name.trim_end_matches(".rs");
        let found = rust_main(folder.path(), module, &case);
        case.assert_same(&found);
    }
}

#[test]
fn numpy_gives_the_bits_of_the_evaluator_but_for_sines() {
    for case in [random(rounded), of_every_shape(), arm()] {
        let folder = folder();
        let name = write(folder.path(), "numpy", &case);
        let script = include_str!("targets/numpy_main.py");
        match python(folder.path(), "numpy", script, &name, &case) {
            Some(found) => case.assert_near_or_same(&found),
            None => return,
        }
    }
}

#[test]
fn jax_is_near_the_evaluator_and_has_derivatives() {
    for case in [of_every_shape(), arm()] {
        let folder = folder();
        let name = write(folder.path(), "jax", &case);
        let script = include_str!("targets/jax_main.py");
        match python(folder.path(), "jax", script, &name, &case) {
            Some(found) => case.assert_near_or_same(&found),
            None => return,
        }
    }
}

#[test]
fn llvm_gives_the_bits_of_the_evaluator() {
    let Some([llc]) = tools(["llc"]) else { return };
    for case in [random(|operation| operation), of_every_shape(), arm()] {
        let folder = folder();
        let name = write(folder.path(), "llvm", &case);
        compile_object(folder.path(), &llc, &name);
        let title = name.trim_end_matches(".ll");
        let main = c_main(&case, title, false);
        case.assert_same(&link_and_run(folder.path(), &main));
    }
}

/// From the dialects to LLVM's.
const LOWERING: [&str; 5] = [
    "--convert-math-to-llvm",
    "--convert-math-to-libm",
    "--convert-arith-to-llvm",
    "--convert-func-to-llvm",
    "--reconcile-unrealized-casts",
];

#[test]
fn mlir_is_verified_lowered_and_gives_the_bits_of_the_evaluator() {
    let Some([optimiser, translator, llc]) = tools(["mlir-opt", "mlir-translate", "llc"]) else {
        return;
    };
    for case in [random(|operation| operation), of_every_shape(), arm()] {
        let folder = folder();
        let path = folder.path();
        let name = write(path, "mlir", &case);
        let run = |program: &str, arguments: &[&str]| {
            let output = Command::new(program)
                .current_dir(path)
                .args(arguments)
                .output();
            said(&output.expect("it starts"));
        };
        run(&optimiser, &["--verify-each", &name, "-o", "verified.mlir"]);
        let mut lowering = vec!["verified.mlir", "-o", "lowered.mlir"];
        lowering.extend(LOWERING);
        // Its name changed with version 16.
        let has = |pass: &str| {
            let help = Command::new(&optimiser).arg("--help").output();
            String::from_utf8_lossy(&help.expect("it starts").stdout).contains(pass)
        };
        let memory = ["--finalize-memref-to-llvm", "--convert-memref-to-llvm"];
        lowering.push(memory[usize::from(!has(memory[0]))]);
        lowering.rotate_right(1);
        run(&optimiser, &lowering);
        run(
            &translator,
            &["--mlir-to-llvmir", "lowered.mlir", "-o", "f.ll"],
        );
        compile_object(path, &llc, "f.ll");
        let title = name.trim_end_matches(".mlir");
        let main = c_main(&case, title, true);
        case.assert_same(&link_and_run(path, &main));
    }
}
