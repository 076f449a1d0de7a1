//! Targets of users: the tutorial's, and folders with mistakes.

use super::{TargetCase, arm};
use crate::support::files::tree;
use crate::support::programs::{opt_in, said, stderr, unfolded};
use robovec_cgen::template::CodeTarget;
use robovec_framework::pass::TargetFolder;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The folder of the tutorial.
const TUTORIAL: &str = "examples/targets/javascript";

fn text(name: &str) -> String {
    fs::read_to_string(tree(TUTORIAL).join(name)).expect("it ships")
}

#[test]
fn the_tutorial_shows_its_files_in_60_lines() {
    let page = fs::read_to_string(tree("docs/targets.md")).expect("a page");
    let files = ["target.toml", "template.jinja"].map(text);
    for file in &files {
        assert!(page.contains(file.as_str()), "{file}");
    }
    let lines: usize = files.iter().map(|file| file.lines().count()).sum();
    assert!(lines <= 60, "{lines}");
}

/// Writes a function by the target of the tutorial, by the program.
fn javascript(folder: &Path, case: &TargetCase) -> String {
    let equations = robovec_ir::print::print_module(&case.module);
    fs::write(folder.join("f.rvir"), equations).expect("a temporary file");
    let target = tree(TUTORIAL);
    let target = target.to_str().expect("a path of text");
    let passes = "-passes=codegen{target=template}";
    let written = ["f.rvir", passes, "--target", target, "-o", "f.mjs"];
    said(&opt_in(folder, &written));
    fs::read_to_string(folder.join("f.mjs")).expect("it is written")
}

#[test]
fn the_tutorial_gives_the_results_of_the_evaluator() {
    if Command::new("node").arg("--version").output().is_err() {
        eprintln!("SKIPPED: node is not installed, the tutorial's target was not run");
        return;
    }
    for case in [
        super::random(super::rounded),
        super::of_every_shape(),
        arm(),
    ] {
        let folder = super::folder();
        let path = folder.path();
        let module = javascript(path, &case);
        let (_, rest) = module.split_once("export function ").expect("a function");
        let (name, _) = rest.split_once('(').expect("parameters");
        let arguments: Vec<String> = (case.view().function.inputs().iter())
            .map(|array| {
                let numbers = &case.state[array.offset as usize..][..array.shape.len()];
                match array.shape {
                    robovec_ir::Shape::Scalar => format!("{:?}", numbers[0]),
                    robovec_ir::Shape::Vector(_) => format!("{numbers:?}"),
                    robovec_ir::Shape::Matrix(_, columns) => {
                        let rows: Vec<&[f64]> = numbers.chunks(columns as usize).collect();
                        format!("{rows:?}")
                    }
                }
            })
            .collect();
        let main = format!(
            "import {{ {name} }} from './f.mjs';\n\
             const flat = (x) => typeof x === 'number' ? [x] : Array.from(x).flatMap(flat);\n\
             for (const x of Object.values({name}({})).flatMap(flat)) console.log(x);\n",
            arguments.join(", ")
        );
        fs::write(path.join("main.mjs"), main).expect("a temporary file");
        let output = Command::new("node")
            .current_dir(path)
            .arg("main.mjs")
            .output();
        let found = said(&output.expect("it starts"));
        let found: Vec<f64> = (found.lines())
            .map(|line| line.parse().expect("a number"))
            .collect();
        case.assert_near_or_same(&found);
    }
}

/// The message about the tutorial's target after a change, with its advice.
fn refused(file: &str, old: &str, new: &str) -> String {
    let [description, template] = ["target.toml", "template.jinja"].map(|name| {
        let text = text(name);
        match name == file {
            true => {
                assert!(text.contains(old), "{old}");
                text.replacen(old, new, 1)
            }
            false => text,
        }
    });
    let folder = TargetFolder {
        name: "mine".to_owned(),
        description,
        template,
    };
    let case = super::of_every_shape();
    let target = CodeTarget::parse(&folder);
    let error = target.and_then(|target| target.file(case.view()));
    error.expect_err("it is refused").to_string()
}

#[test]
fn mistakes_have_a_file_and_a_line() {
    let mistakes = [
        ("target.toml", "neg =", "negate ="),
        ("target.toml", "nested = true", "nested = 1"),
        ("target.toml", "nested = true", "nested = true = 1"),
        ("target.toml", "file = \"{name}.mjs\"", ""),
        ("target.toml", "{a} - {b}", "{a} - {d}"),
        ("target.toml", "{a} - {b}", "{a} - 1"),
        ("target.toml", "Math.sin({a})", "{name} = Math.sin({a})"),
        ("target.toml", "{name}.mjs", "../{name}.mjs"),
        ("target.toml", "Math.sin({a})", "Math.sin({a)"),
        ("target.toml", "sin = \"Math.sin({a})\"\n", ""),
        ("template.jinja", "{% endfor %}", "{% end %}"),
        ("template.jinja", "s.text", "s.txt"),
        ("template.jinja", "in statements", "in statement"),
    ];
    let messages = mistakes.map(|(file, old, new)| refused(file, old, new));
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn a_target_with_a_mistake_writes_nothing() {
    let folder = super::folder();
    let path = folder.path();
    fs::write(path.join("f.rvir"), super::OF_EVERY_SHAPE).expect("a temporary file");
    let run = |passes: &str, further: &[&str]| {
        let words = [&["f.rvir", passes, "-o", "out.mjs"], further].concat();
        let output = opt_in(path, &words);
        assert_eq!(output.status.code(), Some(1));
        assert!(!path.join("out.mjs").exists());
        unfolded(&stderr(&output))
    };
    let passes = "-passes=codegen{target=template}";
    let mut messages = vec![
        run(passes, &[]),
        run(passes, &["--target", "nothing"]),
        run("-passes=codegen{target=rust}", &["--target", "nothing"]),
        run("-passes=codegen{target=rust number=float}", &[]),
    ];
    let mine = path.join("mine");
    fs::create_dir(&mine).expect("a temporary folder");
    let write = |name: &str, text: String| fs::write(mine.join(name), text).expect("a file");
    write(
        "target.toml",
        text("target.toml").replace("cos =", "cosine ="),
    );
    write("template.jinja", text("template.jinja"));
    messages.push(run(passes, &["--target", "mine"]));
    write("target.toml", text("target.toml"));
    write(
        "template.jinja",
        text("template.jinja").replace("s.text", "s.txt"),
    );
    messages.push(run(passes, &["--target", "mine"]));
    insta::assert_snapshot!(messages.join("\n"));
}
