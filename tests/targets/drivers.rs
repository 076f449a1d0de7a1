//! Programs around the files of targets.

use super::TargetCase;
use crate::support::programs::said;
use robovec_ir::{Array, Shape};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Programs of LLVM, all of one version; a message if there are none.
pub(super) fn tools<const N: usize>(names: [&str; N]) -> Option<[String; N]> {
    let versions = (15..30).rev().map(|version| format!("-{version}"));
    let mut versions = std::iter::once(String::new()).chain(versions);
    let starts = |name: &String| Command::new(name).arg("--version").output().is_ok();
    let found = versions.find_map(|version| {
        let programs = names.map(|name| format!("{name}{version}"));
        programs.iter().all(starts).then_some(programs)
    });
    if found.is_none() {
        eprintln!("SKIPPED: {names:?} are not installed, their target was not run");
    }
    found
}

fn numbers(text: &str) -> Vec<f64> {
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(|line| line.parse().expect("a number")).collect()
}

fn extents(shape: Shape) -> Vec<u32> {
    match shape {
        Shape::Scalar => vec![],
        Shape::Vector(count) => vec![count],
        Shape::Matrix(rows, columns) => vec![rows, columns],
    }
}

/// The numbers of an input, row by row.
fn given<'a>(case: &'a TargetCase, array: &Array) -> &'a [f64] {
    &case.state[array.offset as usize..][..array.shape.len()]
}

/// Compiles a file of Rust as part of a library without the standard one, and
/// of a program that calls it: the results.
pub(super) fn rust_main(folder: &Path, module: &str, case: &TargetCase) -> Vec<f64> {
    let math = |body: [&str; 4]| {
        let [sin, cos, sqrt, fma] = body;
        format!(
            "pub mod math {{\n    pub fn sin(x: f64) -> f64 {{ {sin} }}\n    pub fn cos(x: f64) -> f64 {{ {cos} }}\n    \
             pub fn sqrt(x: f64) -> f64 {{ {sqrt} }}\n    pub fn fma(x: f64, y: f64, z: f64) -> f64 {{ {fma} }}\n}}\n\
             pub mod {module};\n"
        )
    };
    let head = "#![no_std]\n#![forbid(unsafe_code)]\n";
    let library = format!("{head}{}", math(["x", "x", "x", "x * y + z"]));
    let mut main = math(["x.sin()", "x.cos()", "x.sqrt()", "x.mul_add(y, z)"]);
    main += "fn main() {\n";
    let mut arguments = Vec::new();
    for array in case.view().function.inputs() {
        let numbers = given(case, array);
        arguments.push(match array.shape {
            Shape::Scalar => format!("{:?}", numbers[0]),
            Shape::Vector(_) => format!("&{numbers:?}"),
            Shape::Matrix(_, columns) => {
                let rows: Vec<&[f64]> = numbers.chunks(columns as usize).collect();
                format!("&{rows:?}")
            }
        });
    }
    let mut printed = String::new();
    for (number, array) in case.view().function.outputs().iter().enumerate() {
        let (start, all) = match array.shape {
            Shape::Scalar => ("7.0".to_owned(), format!("[out{number}].iter()")),
            Shape::Vector(count) => (format!("[7.0; {count}]"), format!("out{number}.iter()")),
            Shape::Matrix(rows, columns) => (
                format!("[[7.0; {columns}]; {rows}]"),
                format!("out{number}.iter().flatten()"),
            ),
        };
        let _ = writeln!(main, "    let mut out{number} = {start};");
        let _ = writeln!(printed, "    for x in {all} {{ println!(\"{{x:?}}\"); }}");
        arguments.push(format!("&mut out{number}"));
    }
    let _ = writeln!(main, "    {module}::{module}({});", arguments.join(", "));
    main += &format!("{printed}}}\n");
    let rustc = |file: &str, text: &str, arguments: &[&str]| {
        fs::write(folder.join(file), text).expect("a temporary file");
        let rustc = Command::new("rustc")
            .current_dir(folder)
            .args(["--edition=2021", "-D", "warnings", file])
            .args(arguments)
            .output();
        said(&rustc.expect("rustc is there"));
    };
    rustc(
        "library.rs",
        &library,
        &["--crate-type=lib", "--emit=metadata"],
    );
    rustc("main.rs", &main, &["-O", "-A", "dead_code"]);
    let output = Command::new(folder.join("main")).output();
    numbers(&said(&output.expect("it starts")))
}

/// Calls a function of Python by a script: the results, or a message and
/// nothing if the library is not installed.
pub(super) fn python(
    folder: &Path,
    library: &str,
    script: &str,
    file: &str,
    case: &TargetCase,
) -> Option<Vec<f64>> {
    let python = |arguments: &[&str]| {
        let mut call = Command::new("python3");
        call.current_dir(folder).args(arguments).output()
    };
    let found = python(&["-c", &format!("import {library}")]);
    if !found.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: {library} is not installed, its target was not run");
        return None;
    }
    let mut inputs = String::new();
    for array in case.view().function.inputs() {
        let shape: Vec<String> = extents(array.shape).iter().map(u32::to_string).collect();
        let numbers: Vec<String> = (given(case, array).iter())
            .map(|number| format!("{number:?}"))
            .collect();
        let _ = writeln!(inputs, "{};{}", shape.join(" "), numbers.join(" "));
    }
    fs::write(folder.join("inputs"), inputs).expect("a temporary file");
    fs::write(folder.join("main.py"), script).expect("a temporary file");
    // A module can have a name that the language reserves for other uses.
    let module = file.trim_end_matches(".py");
    let output = python(&["main.py", module, module, "inputs"]).expect("it starts");
    Some(numbers(&said(&output)))
}

/// A C program that calls a function with pointers, or with descriptors of
/// memory as MLIR has them, and prints the results.
pub(super) fn c_main(case: &TargetCase, title: &str, is_described: bool) -> String {
    let function = case.view().function;
    let mut text =
        String::from("#include <stdio.h>\nstruct memory { double *a, *b; long c, d[4]; };\n");
    let mut main = String::from("int main(void)\n{\n");
    let mut printed = String::new();
    let mut arguments = Vec::new();
    let inputs = function.inputs().iter().map(|array| (array, false));
    let outputs = function.outputs().iter().map(|array| (array, true));
    for (number, (array, is_output)) in inputs.chain(outputs).enumerate() {
        let count = array.shape.len();
        let start = match is_output {
            true => "7".to_owned(),
            false => {
                let numbers = given(case, array).iter();
                let numbers: Vec<String> = numbers.map(|number| format!("{number:?}")).collect();
                numbers.join(", ")
            }
        };
        let _ = writeln!(text, "static double a{number}[{count}] = {{{start}}};");
        let extents = extents(array.shape);
        let strides: &[u32] = match &extents[..] {
            [] => &[],
            [_] => &[1],
            [_, columns] => &[*columns, 1],
            _ => unreachable!("arrays have at most two indices"),
        };
        let layout: Vec<String> = (extents.iter().chain(strides).chain([&0]))
            .map(u32::to_string)
            .collect();
        let _ = writeln!(
            text,
            "static struct memory m{number} = {{a{number}, a{number}, 0, {{{}}}}};",
            layout.join(", ")
        );
        arguments.push(match is_described {
            true => format!("&m{number}"),
            false => format!("a{number}"),
        });
        if is_output {
            let _ = writeln!(
                printed,
                "    for (int k = 0; k < {count}; k++) printf(\"%.17g\\n\", a{number}[k]);"
            );
        }
    }
    let prefix = if is_described { "_mlir_ciface_" } else { "" };
    let types = vec!["void *"; arguments.len()].join(", ");
    let _ = writeln!(text, "extern void {prefix}{title}({types});");
    let _ = writeln!(main, "    {prefix}{title}({});", arguments.join(", "));
    text + &main + &printed + "    return 0;\n}\n"
}

/// Compiles LLVM IR into `f.o`.
pub(super) fn compile_object(folder: &Path, llc: &str, file: &str) {
    let compile = |further: &[&str]| {
        let output = Command::new(llc)
            .current_dir(folder)
            .args(["-filetype=obj", "-relocation-model=pic", "-o", "f.o", file])
            .args(further)
            .output();
        output.expect("it starts")
    };
    // Version 14 has opaque pointers on request only.
    if !compile(&[]).status.success() {
        said(&compile(&["-opaque-pointers"]));
    }
}

/// Links `f.o` with a program of C and runs it: the results.
pub(super) fn link_and_run(folder: &Path, main: &str) -> Vec<f64> {
    fs::write(folder.join("main.c"), main).expect("a temporary file");
    let compiled = Command::new("gcc")
        .current_dir(folder)
        .args(["-o", "main", "main.c", "f.o", "-lm"])
        .output();
    said(&compiled.expect("gcc is there"));
    let output = Command::new(folder.join("main")).output();
    numbers(&said(&output.expect("it starts")))
}
