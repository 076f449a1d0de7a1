//! Files that are never replaced without a request.

use super::{folder, pendulum, read, refused, write};
use crate::support::programs::{opt_in, robovec_in, said};
use std::process::Output;

/// A program that is run with more arguments.
type Run<'a> = &'a dyn Fn(&[&str]) -> Output;

#[test]
fn files_of_others_stay_until_force_is_said() {
    let pendulum = pendulum();
    let folder = folder();
    let path = folder.path().join("x.rvir");
    let gen_into = |more: &[&str]| {
        let arguments = ["gen", &pendulum, "-o", "x.rvir"];
        robovec_in(folder.path(), &[&arguments[..], more].concat())
    };
    let opt_into = |more: &[&str]| {
        opt_in(
            folder.path(),
            &[&["blend.rvir", "-o", "x.rvir"][..], more].concat(),
        )
    };
    let runs: [Run<'_>; 2] = [&gen_into, &opt_into];
    for run in runs {
        write(&path, "notes of a week\n");
        let message = refused(&run(&[]));
        assert!(message.contains("robovec did not write it"), "{message}");
        assert!(message.contains("--force"), "{message}");
        assert_eq!(read(&path), "notes of a week\n");
        said(&run(&["--force"]));
        assert!(read(&path).starts_with("// robovec 1\n"));
        said(&run(&[]));
        write(&path, "");
        said(&run(&[]));
        assert!(read(&path).starts_with("// robovec 1\n"));
    }
}

#[test]
fn files_of_robotran_stay() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mine = "//\n//\tROBOTRAN - Version 6.6\n//\n//\t==> Project name : Blend\n";
    let model = pendulum();
    said(&robovec_in(
        folder.path(),
        &["gen", &model, "-o", "blend.rvir"],
    ));
    let language = |name: &str, more: &[&str]| {
        let arguments = ["gen", "blend.rvir", "--language", name, "--model", "Blend"];
        robovec_in(folder.path(), &[&arguments[..], more].concat())
    };
    for (name, files) in [
        ("c", &["mbs_dirdyna_Blend.c", "mbs_dirdyna_Blend.h"][..]),
        ("matlab", &["mbs_dirdyna_Blend.m"]),
        ("python", &["mbs_dirdyna_Blend.py"]),
    ] {
        for file in files {
            write(&at(file), mine);
            refused(&language(name, &[]));
            for file in files.iter().filter(|file| at(file).exists()) {
                assert_eq!(read(&at(file)), mine, "none of {files:?} is touched");
            }
            std::fs::remove_file(at(file)).expect("it is there");
        }
        for file in files {
            write(&at(file), mine);
        }
        said(&language(name, &["--force"]));
        said(&language(name, &[]));
        for file in files {
            assert!(read(&at(file)).contains("robovec - Version"), "{file}");
        }
    }
}

#[test]
fn models_and_results_do_not_replace_what_people_write() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let written = |more: &[&str]| {
        let arguments = ["model", "double-pendulum", "-o", "m.mbs"];
        robovec_in(folder.path(), &[&arguments[..], more].concat())
    };
    said(&written(&[]));
    let message = refused(&written(&[]));
    assert!(message.contains("--force"), "{message}");
    said(&written(&["--force"]));
    write(&at("mine.c"), "int mine;\n");
    let report = ["blend.rvir", "-passes=place", "--report", "mine.c"];
    refused(&opt_in(folder.path(), &report));
    assert_eq!(read(&at("mine.c")), "int mine;\n");
    write(&at("report.txt"), "an older report\n");
    let report = ["blend.rvir", "-passes=place", "--report", "report.txt"];
    said(&opt_in(folder.path(), &report));
    assert!(read(&at("report.txt")).contains("Schedule"));
}

#[test]
fn the_name_of_a_file_does_not_promise_another_language() {
    let folder = folder();
    for (passes, name, advice) in [
        ("cse", "x.c", "codegen{target=c}"),
        ("cse,place", "x.mif", "codegen{target=mif}"),
        ("cse", "x.m", "robovec gen"),
        ("codegen{target=rolled}", "x.rvir", "a name for one"),
        ("codegen{target=c signature=plain}", "x.c", "-o FOLDER"),
    ] {
        let passes = format!("-passes={passes}");
        let run = opt_in(folder.path(), &["blend.rvir", &passes, "-o", name]);
        let message = refused(&run);
        assert!(message.contains(advice), "{message}");
        assert!(!folder.path().join(name).exists(), "{name}");
    }
    said(&opt_in(
        folder.path(),
        &["blend.rvir", "-passes=cse", "-o", "x.rvir"],
    ));
    said(&opt_in(
        folder.path(),
        &["blend.rvir", "-passes=cse", "-o", "x"],
    ));
    let message = refused(&robovec_in(
        folder.path(),
        &["gen", &pendulum(), "-o", "x.c"],
    ));
    assert!(message.contains("robovec's text"), "{message}");
    assert!(!folder.path().join("x.c").exists());
}

#[test]
fn generated_folders_are_written_again_and_foreign_c_stays() {
    let folder = folder();
    let into = |passes: &str, more: &[&str]| {
        let passes = format!("-passes={passes}");
        let arguments = ["blend.rvir", &passes, "-o", "out"];
        opt_in(folder.path(), &[&arguments[..], more].concat())
    };
    for passes in [
        "place,codegen{target=rtl}",
        "place,codegen{target=mif}",
        "codegen{target=c signature=plain}",
        "codegen{target=rolled}",
        "codegen{target=batch}",
    ] {
        for _ in 0..2 {
            said(&into(passes, &[]));
        }
    }
    let path = folder.path().join("out/blend.c");
    write(&path, "int mine;\n");
    let header = read(&folder.path().join("out/blend.h"));
    refused(&into("codegen{target=c signature=plain}", &[]));
    assert_eq!(read(&path), "int mine;\n");
    assert_eq!(read(&folder.path().join("out/blend.h")), header);
    said(&into("codegen{target=c signature=plain}", &["--force"]));
    assert!(read(&path).contains("by robovec"));
}

/// Every result that could replace a user's file, by the name of the file or by
/// that of a link to it, is refused before the input, which does not exist, is
/// read.
#[cfg(unix)]
#[test]
fn refusals_come_before_work_and_look_behind_links() {
    use std::os::unix::fs::symlink;
    for (name, arguments) in [
        ("program.rvir", "optimise nothing.rvir -o ."),
        ("start.rvir", "optimise nothing.rvir -o ."),
        ("program.rvir", "fit nothing.toml -o ."),
        ("machine.toml", "fit nothing.toml -o ."),
        (
            "nothing-reduced.mbs",
            "fit nothing.scene.toml --reduce -o .",
        ),
        ("x.py", "sim nothing.mbs -o x.py"),
        ("x.py", "sim nothing.mbs --plot x.py"),
        ("x.py", "sim nothing.mbs --events x.py"),
        ("x.py", "view nothing.rvir -o x.py"),
        ("x.py", "view nothing.rvir --dot x.py"),
        ("x.py", "view nothing.rvir --trace x.py"),
        ("x.py", "sim modal nothing.mbs -o x.py"),
        ("x.py", "sim equilibrium nothing.mbs -o x.py"),
        ("x.py", "sim fmu nothing.mbs -o x.py"),
        ("x.rules", "rules find nothing.rvir -o x.rules"),
        (
            "x.rules",
            "rules import nothing.egg --syntax egglog -o x.rules",
        ),
        ("x.rvir", "gen nothing.mbs -o x.rvir"),
        ("x.rvir", "robovec-opt nothing.rvir -o x.rvir"),
    ] {
        for (link, target) in [(name, "notes"), (name, "mine.c"), ("", name)] {
            let folder = folder();
            let at = |name: &str| folder.path().join(name);
            write(&at(target), "notes of a week\n");
            if !link.is_empty() {
                symlink(target, at(link)).expect("a link");
            }
            let words: Vec<&str> = arguments.split(' ').collect();
            let output = match words[0] {
                "robovec-opt" => opt_in(folder.path(), &words[1..]),
                _ => robovec_in(folder.path(), &words),
            };
            let message = refused(&output);
            assert!(
                message.contains("robovec did not write it"),
                "{arguments}: {message}"
            );
            assert!(message.contains("--force"), "{arguments}: {message}");
            assert_eq!(read(&at(target)), "notes of a week\n", "{arguments}");
        }
    }
}

/// A result of no known kind whose name is a link to a file of a program: the
/// target of the link counts.
#[cfg(unix)]
#[test]
fn a_link_to_a_program_is_no_place_for_results() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    write(&at("mine.c"), "int mine;\n");
    symlink("mine.c", at("table.csv")).expect("a link");
    let run = |more: &[&str]| {
        let model = pendulum();
        let arguments = ["sim", &model, "--time=0.1", "-o", "table.csv"];
        robovec_in(folder.path(), &[&arguments[..], more].concat())
    };
    refused(&run(&[]));
    assert_eq!(read(&at("mine.c")), "int mine;\n");
    said(&run(&["--force"]));
    assert!(read(&at("mine.c")).starts_with("time"));
}
