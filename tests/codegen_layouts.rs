//! Plain C with arrays that count from 0, compiled, against the evaluator; and
//! C for CasADi, called as CasADi calls it.

use crate::codegen_c::trees;
use robovec_cgen::c::{self, ElementOrder, Layout, Options, Real};
use robovec_framework::manager::{self, Config};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Function, Machine, Module, Operand, Output, Shape, View, parse};
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Compiles files of a folder without a warning and runs them.
fn run(folder: &Path, compiler: &str, files: &[&str]) -> String {
    let program = folder.join("program");
    let compiled = Command::new(compiler)
        .args(["-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"])
        .arg("-o")
        .arg(&program)
        .args(files.iter().map(|file| folder.join(file)))
        .arg("-lm")
        .output()
        .expect("a C compiler is there");
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{messages}");
    let output = Command::new(&program).output().expect("it runs");
    assert!(output.status.success(), "{}", output.status);
    String::from_utf8(output.stdout).expect("numbers")
}

/// Random trees, with elements of the matrix that are zero, equal and never set.
fn with_gaps(seed: u64) -> Module {
    let mut module = trees(&mut Random::new(seed), 60);
    let function = &mut module.functions[0];
    function.name = "f".to_owned();
    let zero = function.constant(0.0);
    function.assignments[1].operand = zero.into();
    function.assignments.remove(4);
    module
}

fn operand(function: &Function, output: u32) -> Option<Operand> {
    let mut sets = function.assignments.iter();
    let set = sets.find(|set| set.output == Output(output))?;
    Some(set.operand)
}

/// Places of the 2x3 matrix in the order of a layout, counted without it.
fn places(function: &Function, order: ElementOrder, is_sparse: bool) -> Vec<u32> {
    let all: Vec<u32> = match order {
        ElementOrder::Row => vec![0, 1, 2, 3, 4, 5],
        ElementOrder::Column | ElementOrder::Packed => vec![0, 3, 1, 4, 2, 5],
    };
    let is_set = |place: &u32| {
        operand(function, *place).is_some_and(|operand| function.number(operand) != Some(0.0))
    };
    all.into_iter()
        .filter(|place| !is_sparse || is_set(place))
        .collect()
}

#[test]
fn every_layout_holds_the_same_numbers() {
    for (seed, order) in (1..).zip([
        ElementOrder::Row,
        ElementOrder::Column,
        ElementOrder::Packed,
    ]) {
        for is_sparse in [false, true] {
            let module = with_gaps(seed);
            let mut function = module.functions[0].clone();
            if is_sparse {
                function = c::layout::without_zeros(function);
            }
            let view = View {
                tables: &module.tables,
                function: &function,
            };
            let options = Options {
                layout: Layout::FromZero { order, is_sparse },
                ..Options::plain(Real::Double)
            };
            let inputs: Vec<f64> = (1..14).map(|k| 0.25 + f64::from(k) / 16.0).collect();
            // Elements that are never set are zero.
            let mut expected = [0.0; 7];
            let values = evaluate(&function, &Binary64, &inputs);
            for (set, value) in function.assignments.iter().zip(values) {
                expected[set.output.index()] = value;
            }
            let kept = places(&module.functions[0], order, is_sparse);
            let found = compiled(view, &options, &inputs, kept.len());
            for (place, number) in kept.iter().zip(&found) {
                let wanted = expected[*place as usize];
                assert_eq!(wanted.to_bits(), number.to_bits(), "{order:?} {place}");
            }
            assert_eq!(found.last(), Some(&expected[6]), "the scalar");
        }
    }
}

/// The numbers of the matrix in order, and the scalar, from compiled C; the
/// header is read by C++ too.
fn compiled(view: View<'_>, options: &Options, inputs: &[f64], count: usize) -> Vec<f64> {
    let folder = tempfile::tempdir().expect("a temporary directory");
    for (name, text) in c::files(view, options).expect("a plain signature") {
        std::fs::write(folder.path().join(name), text).expect("a temporary file");
    }
    // Matrix inputs have the order of outputs.
    let Layout::FromZero { order, .. } = options.layout else {
        panic!("arrays count from 0");
    };
    let mut given = [0.0; 12];
    for (index, &number) in inputs[1..].iter().enumerate() {
        let (row, column) = (index / 4, index % 4);
        let place = match order {
            ElementOrder::Row => index,
            ElementOrder::Column | ElementOrder::Packed => column * 3 + row,
        };
        given[place] = number;
    }
    let mut main = String::from("#include <stdio.h>\n#include \"f.h\"\nint main(void)\n{\n");
    let _ = writeln!(main, "    const double dpt[12] = {{");
    for number in given {
        let _ = writeln!(main, "        {number:?},");
    }
    let _ = writeln!(
        main,
        "    }};\n    double m[{count}], e;\n    for (int k = 0; k < {count}; k++) m[k] = 7;\n    \
         f({:?}, dpt, m, &e);\n    for (int k = 0; k < {count}; k++) printf(\"%.17g\\n\", m[k]);\n    \
         printf(\"%.17g\\n\", e);\n    return 0;\n}}",
        inputs[0]
    );
    let path = folder.path();
    std::fs::write(path.join("main.c"), &main).expect("a temporary file");
    std::fs::write(path.join("main.cpp"), &main).expect("a temporary file");
    let text = run(path, "gcc", &["main.c", "f.c"]);
    let object = Command::new("g++")
        .args(["-Wall", "-Wextra", "-Werror", "-c", "-o", "/dev/null"])
        .arg(path.join("main.cpp"))
        .output();
    let object = object.expect("g++ is there");
    assert!(
        object.status.success(),
        "{}",
        String::from_utf8_lossy(&object.stderr)
    );
    let numbers = text.lines().map(|line| line.parse().expect("a number"));
    numbers.collect()
}

#[test]
fn headers_of_sparse_arrays_give_rows_and_columns() {
    let text = "// robovec 1\nfunction f equations {\n  in x\n  out J[1..3,1..3]\n  \
        J[1,1] = x\n  J[2,3] = x*x\n  J[3,1] = 0.0\n  J[3,3] = -x\n}\n";
    let mut module = parse::parse_module("f", text).expect("it is the text form");
    let mut header = |layout: &str| {
        let passes = format!("codegen{{target=c base=0 sparse=true layout={layout}}}");
        let files = codegen(&mut module, &passes);
        let header = files.into_iter().find(|(name, _)| name == "f.h");
        header.expect("it has a header").1
    };
    insta::assert_snapshot!(header("column"));
    let rows = header("row");
    assert!(
        rows.contains("f_J_start[4] = {\n    0, 1, 2, 3,\n}"),
        "{rows}"
    );
}

fn codegen(module: &mut Module, passes: &str) -> Vec<(String, String)> {
    let pipeline = REGISTRY.pipeline(passes).expect("a pipeline");
    let machine = Machine::built_in("thesis").expect("it ships");
    let mut log = std::io::sink();
    let outcome = manager::run(module, &pipeline, Config::new(&machine, &mut log));
    let files = outcome.expect("it runs").artifacts.into_iter();
    files.map(|file| (file.name, file.text)).collect()
}

#[test]
fn symmetric_outputs_are_packed_as_their_upper_triangle() {
    let text = "// robovec 1\nfunction f equations {\n  in x\n  out M[1..2,1..2]\n  \
        %a = x*x\n  M[1,1] = x\n  M[1,2] = %a\n  M[2,1] = %a\n  M[2,2] = 2.0\n}\n";
    let module = parse::parse_module("f", text).expect("it is the text form");
    let layouts = c::output_layouts(&module.functions[0], ElementOrder::Packed, false);
    assert!(layouts[0].is_triangle);
    assert_eq!(layouts[0].kept, [[0, 0], [0, 1], [1, 1]]);
    assert_eq!(module.functions[0].outputs()[0].shape, Shape::Matrix(2, 2));
}

/// A function with scalars, vectors and matrices, one of them sparse.
const OF_EVERY_SHAPE: &str = "// robovec 1
function g equations {
  in t
  in x[1..3]
  in A[1..2,1..2]
  out y[1..2]
  out B[1..2,1..3]
  out e
  %s = sin(x[1])
  y[1] = %s*A[1,2] + t
  y[2] = x[2]/A[2,2]
  B[1,3] = x[3]*A[2,1]*%s
  B[2,1] = sqrt(x[2])*t
  e = x[1]*x[2]*x[3] + A[1,1]*A[1,1]
}
";

/// Directions, weights and Jacobian agree with each other and with differences;
/// arrays that are not given are zero, those not asked for are left out.
#[test]
fn functions_for_casadi_agree_with_each_other() {
    let mut module = parse::parse_module("g", OF_EVERY_SHAPE).expect("it is the text form");
    let files = codegen(&mut module, "codegen{target=casadi}");
    let [(name, text)] = &files[..] else {
        panic!("one file");
    };
    assert_eq!(name, "g_casadi.c");
    let folder = tempfile::tempdir().expect("a temporary directory");
    std::fs::write(folder.path().join(name), text).expect("a temporary file");
    let main = include_str!("support/casadi_main.c");
    std::fs::write(folder.path().join("main.c"), main).expect("a temporary file");
    let found = run(folder.path(), "gcc", &["main.c"]);
    insta::assert_snapshot!(found);
}
