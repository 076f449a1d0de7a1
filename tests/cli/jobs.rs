//! Programs that are made, placed and simulated, whole and always the same.

use super::{PIPELINE, SUSPENSION, example, opt, run};
use crate::support::programs::stderr;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_main_job_prints_a_placed_program_and_a_report() {
    let output = run(opt()
        .arg(example(SUSPENSION))
        .args([PIPELINE, "--report", "-"]));
    assert!(output.status.success(), "{}", stderr(&output));
    let program = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(program.contains(" placed {"), "{program}");
    assert!(stderr(&output).contains("cycles"));
    let module = robovec_ir::parse::parse_module("stdout", &program).expect("it reads back");
    assert_eq!(robovec_ir::print::print_module(&module), program);
}

#[test]
fn results_do_not_depend_on_where_and_when() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut results = Vec::new();
    for directory in [Path::new(env!("CARGO_MANIFEST_DIR")), folder.path()] {
        for _ in 0..2 {
            let images = folder.path().join(format!("images{}", results.len()));
            let mut command = opt();
            command.current_dir(directory).arg(example(SUSPENSION));
            command
                .arg(format!("{PIPELINE},codegen"))
                .arg("-o")
                .arg(&images);
            let output = run(&mut command);
            assert!(output.status.success(), "{}", stderr(&output));
            let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(&images)
                .expect("the images")
                .map(|entry| {
                    let entry = entry.expect("a readable folder");
                    let content = fs::read(entry.path()).expect("an image");
                    (entry.file_name().to_string_lossy().into_owned(), content)
                })
                .collect();
            files.sort();
            results.push(files);
        }
    }
    assert!(results[0].len() > 8);
    assert!(results.iter().all(|result| *result == results[0]));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_into_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(
        made.is_ok_and(|status| status.success()),
        "mkfifo is part of every unix"
    );
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe)
    });
    let output = run(opt().arg(example(SUSPENSION)).arg("-o").arg(&pipe));
    assert!(output.status.success(), "{}", stderr(&output));
    let text = reader.join().expect("no panic").expect("a readable pipe");
    assert!(text.starts_with(b"// robovec 1"));
    let kind = fs::metadata(&pipe).expect("still there").file_type();
    assert!(kind.is_fifo(), "the pipe is still a pipe");
}

#[test]
fn every_level_reads_back_and_goes_on_alike() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stages = [
        "atomise",
        "zero-removal",
        "balance",
        "cse,dce",
        "asap-alap",
        "place",
        "asap-alap",
    ];
    let mut input = example(SUSPENSION);
    for (index, stage) in stages.iter().enumerate() {
        let result = folder.path().join(format!("{index}.rvir"));
        let output = run(opt()
            .arg(&input)
            .arg(format!("-passes={stage}"))
            .arg("-o")
            .arg(&result));
        assert!(output.status.success(), "{stage}: {}", stderr(&output));
        let again = run(opt().arg(&result));
        assert_eq!(
            again.stdout,
            fs::read(&result).expect("a result"),
            "{stage}"
        );
        input = result;
    }
    let whole = run(opt()
        .arg(example(SUSPENSION))
        .arg(format!("-passes={}", stages.join(","))));
    assert_eq!(
        whole.stdout,
        fs::read(input).expect("a result"),
        "pass by pass through files gives the same as in one go"
    );
}

#[test]
fn every_pass_is_checked_and_the_images_are_simulated() {
    for machine in ["thesis", "side-split", "ideal", "de10-nano"] {
        for count in [1, 4] {
            let output = run(opt().arg(example(SUSPENSION)).args([
                &format!("{PIPELINE}{{n_add={count} n_multi={count}}}"),
                "--check-each",
                "--simulate=3",
                "--machine",
                machine,
            ]));
            let message = stderr(&output);
            assert!(output.status.success(), "{machine}: {message}");
            assert!(message.contains("bit for bit"), "{machine}: {message}");
        }
    }
}

#[test]
fn machines_of_other_formats_are_simulated_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let machine = folder.path().join("machine.toml");
    let table = "[number]\nexponent = 8\nmantissa = 23\nsubnormals = true\n";
    let thesis = include_str!("../../machines/thesis.toml");
    assert!(thesis.contains(table));
    for format in ["float(8,17)", "float(11,51,flush)", "fixed(24,29)"] {
        let text = format!("number = \"{format}\"\n{}", thesis.replace(table, ""));
        fs::write(&machine, text).expect("a file");
        let output = run(opt()
            .arg(example(SUSPENSION))
            .args([
                &format!("{PIPELINE}{{n_add=2 n_multi=2}}"),
                "--simulate=3",
                "--machine",
            ])
            .arg(&machine));
        let message = stderr(&output);
        assert!(output.status.success(), "{format}: {message}");
        assert!(message.contains("bit for bit"), "{format}: {message}");
    }
    // Values that want another format have no images on this machine.
    let text = "function f atomic {\n in a\n out o\n %x = a*a as f16\n o = %x\n}\n";
    let source = folder.path().join("mixed.rvir");
    fs::write(&source, text).expect("a file");
    let output = run(opt().arg(&source).args(["-passes=place,codegen"]));
    assert!(!output.status.success());
    let message = stderr(&output);
    assert!(message.contains("'%x' is computed as f16"), "{message}");
}

#[test]
fn a_million_terms_in_one_sum_are_balanced() {
    let terms: Vec<String> = (0..1_000_000)
        .map(|term| format!("x[{}]", 1 + term % 100))
        .collect();
    let text = format!(
        "function f equations {{\n  in x[1..100]\n  out o\n\n  o = {}\n}}\n",
        terms.join(" + ")
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("sum.rvir");
    fs::write(&path, text).expect("room for the input");
    let result = folder.path().join("result.rvir");
    let output = run(opt()
        .arg(&path)
        .args(["-passes=atomise,balance,asap-alap", "-o"])
        .arg(&result));
    assert!(output.status.success(), "{}", stderr(&output));
    let result = fs::read_to_string(&result).expect("a result");
    assert!(
        result.contains("{asap 20 "),
        "a tree of a million leaves is 20 deep"
    );
}
