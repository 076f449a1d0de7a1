//! `robovec project` on a project of Robotran's kind: what it finds, replaces,
//! brings back, and compares in a copy.

use crate::compiled::has_gcc;
use crate::support::files::tree;
use crate::support::programs::{model, robovec, said, stderr, unfolded};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A main program that prints c of the leg along a motion.
const MAIN: &str = r#"#include "mbs_data.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim);
static double *row(int n)
{
    double *r = calloc(n + 1, sizeof *r);
    for (int i = 1; i <= n; i++)
        r[i] = 0.3 + 0.1 * i;
    return r;
}
int main(void)
{
    /* mbs_set_qdriven(s, 3); */
    MbsData data = {0}, *s = &data;
    double *M[JOINTS + 1], *c = row(JOINTS);
    for (int i = 0; i <= JOINTS; i++)
        M[i] = row(JOINTS);
    s->q = row(JOINTS), s->qd = row(JOINTS), s->qdd = row(JOINTS), s->m = row(JOINTS);
    for (int axis = 0; axis < 4; axis++)
        s->dpt[axis] = row(40), s->l[axis] = row(JOINTS), s->frc[axis] = row(JOINTS), s->trq[axis] = row(JOINTS);
    for (int entry = 0; entry < 10; entry++)
        s->In[entry] = row(JOINTS);
    s->g[3] = -9.81;
    FILE *file = fopen("result.txt", "w");
    for (int k = 0; k < 20; k++) {
        s->q[1 + k % JOINTS] += 0.1;
        mbs_dirdyna(M, c, s, 0);
        for (int i = 1; i <= JOINTS; i++)
            fprintf(file, "%.17g ", c[i] * FACTOR);
        fprintf(file, "\n");
    }
    fclose(file);
    return 0;
}
"#;

/// A project of the leg, with a driven joint and a constraint of the project.
fn project(folder: &Path) {
    let symbolic = folder.join("symbolicR");
    for name in ["dataR", "symbolicR", "userfctR", "workR/src"] {
        fs::create_dir_all(folder.join(name)).expect("a folder");
    }
    let leg = model("leg.mbs");
    let text = fs::read_to_string(&leg).expect("the model is there");
    let bound = "<jointname>R1_Foot</jointname><type>R1</type><nature>";
    let text = text.replace(&format!("{bound}independent"), &format!("{bound}dependent"));
    fs::write(folder.join("dataR/leg.mbs"), text).expect("a file");
    let made = robovec(&[
        "gen",
        &leg.to_string_lossy(),
        "--function",
        "dirdyna,invdyna",
        "--language",
        "c",
        "--name",
        "leg",
        "-o",
        &symbolic.to_string_lossy(),
    ]);
    said(&made);
    let calls = "// mbs_set_nb_userc(data, 7);\nmbs_set_nb_userc(data, 1);\nmbs_set_qdriven(data, R2_Toes_id);\n";
    fs::write(folder.join("userfctR/user_load.c"), calls).expect("a file");
    fs::write(folder.join("workR/src/main.c"), MAIN).expect("a file");
    fs::copy(
        tree("tests/host/mbs_data.h"),
        folder.join("workR/src/mbs_data.h"),
    )
    .expect("a copy");
}

/// All files of a folder with their contents.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let bytes = fs::read(&path).expect("a file");
                all.insert(path.to_string_lossy().into_owned(), bytes);
            }
        }
    }
    all
}

#[test]
fn equations_are_replaced_and_brought_back() {
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path());
    let before = contents(folder.path());
    let name = folder.path().to_string_lossy();
    let shown = robovec(&["project", &name]);
    let text = unfolded(&said(&shown));
    for part in [
        "2 files in C, symbolicR",
        "9 joints, 3 driven, 0 loops, 1 constraint of the project",
        "for the option accelred",
        "nothing is written",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert_eq!(contents(folder.path()), before);
    said(&robovec(&["project", &name, "--apply"]));
    let dirdyna = folder.path().join("symbolicR/mbs_dirdyna_leg.c");
    let changed = fs::read_to_string(&dirdyna).expect("a file");
    assert_ne!(before[&*dirdyna.to_string_lossy()], changed.as_bytes());
    let step = folder.path().join("symbolicR/mbs_accelred_leg.c");
    assert!(
        fs::read_to_string(step)
            .expect("a file")
            .contains("R2_Toes")
    );
    let twice = robovec(&["project", &name, "--apply"]);
    assert!(stderr(&twice).contains("--undo"), "{}", stderr(&twice));
    let undone = said(&robovec(&["project", &name, "--undo"]));
    assert!(undone.contains("brought back"), "{undone}");
    assert_eq!(contents(folder.path()), before);
    let twice = robovec(&["project", &name, "--undo"]);
    assert!(!twice.status.success() && stderr(&twice).contains("--apply"));
}

#[test]
fn a_copy_is_built_and_run_with_both() {
    if !has_gcc() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path());
    let before = contents(folder.path());
    let name = folder.path().to_string_lossy();
    let joints = "-DJOINTS=9";
    let build = |factor: &str| {
        format!(
            "gcc -O1 {joints} '-DFACTOR={factor}' -IworkR/src -IsymbolicR -o try workR/src/main.c \
             symbolicR/mbs_dirdyna_leg.c -lm"
        )
    };
    let tried = |build: &str| {
        let trial = [
            "--build",
            build,
            "--run",
            "./try",
            "--result",
            "result.txt",
            "--times",
            "1",
        ];
        robovec(&[&["project", &name][..], &trial].concat())
    };
    let text = said(&tried(&build("1")));
    assert!(
        text.contains("Robotran") && text.contains("largest difference"),
        "{text}"
    );
    // Results of the second build are twice as large.
    let other = tried(&format!("echo >> n && {}", build("'$(wc -l < n)'")));
    assert!(!other.status.success());
    assert!(
        stderr(&other).contains("differ by 1.0e0"),
        "{}",
        stderr(&other)
    );
    let failed = tried("false");
    assert!(
        stderr(&failed).contains("exit status: 1: false"),
        "{}",
        stderr(&failed)
    );
    assert_eq!(contents(folder.path()), before);
}

fn has(tool: &str) -> bool {
    Command::new(tool).arg("--version").output().is_ok()
}

/// A Makefile for the main program.
const MAKEFILE: &str = "exe_leg: src/main.c ../symbolicR/mbs_dirdyna_leg.c\n\tgcc -O1 -DJOINTS=9 \
    -DFACTOR=1 -Isrc -I../symbolicR -o $@ $^ -lm\n";

#[test]
fn the_build_of_a_project_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path());
    let name = folder.path().to_string_lossy();
    let tried = || robovec(&["project", &name, "--trial", "--times", "1"]);
    let without = stderr(&tried());
    assert!(
        unfolded(&without).contains("leg has no main program"),
        "{without}"
    );
    if !has_gcc() || !has("make") {
        return;
    }
    let makefile = folder.path().join("workR/Makefile");
    fs::write(&makefile, MAKEFILE).expect("a file");
    // A tool among the sources is no main program of the project.
    let tool = folder.path().join("userfctR/tool");
    fs::create_dir_all(&tool).expect("a folder");
    fs::write(tool.join("Makefile"), "all:\n\tfalse\n").expect("a file");
    let before = contents(folder.path());
    let text = said(&tried());
    for part in ["as workR/Makefile asks", "1 file, such as workR/result.txt"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    let missing = MAKEFILE.replace("src/main.c ", "src/main.c src/more.c ");
    let more = folder.path().join("workR/src/more.c");
    fs::write(&more, "#include \"more.h\"\n").expect("a file");
    fs::write(&makefile, missing).expect("a file");
    let failed = stderr(&tried());
    assert!(failed.contains("a header is missing: more.h"), "{failed}");
    fs::write(&makefile, "all:\n\ttrue\n").expect("a file");
    let failed = stderr(&tried());
    assert!(failed.contains("makes 0 programs"), "{failed}");
    fs::remove_file(&more).expect("it is there");
    fs::write(&makefile, MAKEFILE).expect("a file");
    assert_eq!(contents(folder.path()), before);
}

/// A library with the names of MBsysPy, and the integration of nothing: it
/// computes c along a motion.
const LIBRARY: &str = r#"import importlib.util, os
import numpy as np
class MbsData:
    def __init__(self, path):
        self.n, self.path = 9, path
        row = lambda: 0.3 + 0.1 * np.arange(self.n + 1)
        self.q, self.qd, self.qdd, self.m = row(), row(), row(), row()
        table = lambda rows: 0.1 + 0.01 * np.arange(rows * 41).reshape(rows, 41)
        self.dpt, self.l, self.frc, self.trq, self.In = table(4), table(4), table(4), table(4), table(10)
        self.g = np.array([0.0, 0.0, 0.0, -9.81])
class MbsDirdyn:
    def __init__(self, data):
        self.data = data
    def run(self):
        s = self.data
        path = os.path.join(os.path.dirname(s.path), "../symbolicR/mbs_dirdyna_leg.py")
        spec = importlib.util.spec_from_file_location("dirdyna", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        os.makedirs("../resultsR", exist_ok=True)
        with open("../resultsR/dirdyn_c.res", "w") as file:
            for step in range(5):
                M, c = np.zeros((s.n + 1, s.n + 1)), np.zeros(s.n + 1)
                s.q[1 + step] += 0.1
                module.dirdyna(M, c, s, 0.0)
                file.write(" ".join("%.9e" % x for x in c[1:]) + "\n")
"#;

#[test]
fn a_script_of_python_runs_with_its_library() {
    if !has("python3") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path().join("project");
    project(&root);
    fs::remove_dir_all(root.join("symbolicR")).expect("it is there");
    let symbolic = root.join("symbolicR").to_string_lossy().into_owned();
    let leg = model("leg.mbs").to_string_lossy().into_owned();
    let made = ["gen", &leg, "--function", "dirdyna", "--language", "python"];
    said(&robovec(
        &[&made[..], &["--name", "leg", "-o", &symbolic]].concat(),
    ));
    let main = "import MBsysPy\ndata = MBsysPy.MbsData('../dataR/leg.mbs')\nMBsysPy.MbsDirdyn(data).run()\n";
    fs::write(root.join("workR/main.py"), main).expect("a file");
    let before = contents(&root);
    let name = root.to_string_lossy();
    let trial = ["project", &name, "--trial", "--times", "1"];
    let failed = stderr(&robovec(&trial));
    assert!(
        failed.contains("MBsysPy is not installed: --library names its folder"),
        "{failed}"
    );
    let library = folder.path().join("library");
    fs::create_dir_all(&library).expect("a folder");
    fs::write(library.join("MBsysPy.py"), LIBRARY).expect("a file");
    let numpy = Command::new("python3")
        .args(["-c", "import numpy"])
        .output();
    if numpy.is_ok_and(|output| output.status.success()) {
        let library = library.to_string_lossy();
        let text = said(&robovec(&[&trial[..], &["--library", &library]].concat()));
        assert!(text.contains("resultsR/dirdyn_c.res"), "{text}");
    }
    assert_eq!(contents(&root), before);
}

#[test]
fn the_library_inside_a_project_is_passed_over() {
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path());
    let root = folder.path();
    let void = root.join("mbsysCopy/mbs_common/mbs_void_symbolicR");
    fs::create_dir_all(&void).expect("a folder");
    for function in ["dirdyna", "invdyna", "sensor"] {
        let name = format!("mbs_{function}_void.c");
        fs::write(void.join(name), "").expect("a file");
    }
    // As many equations of another model, which has no file.
    for function in ["dirdyna", "invdyna"] {
        let path = |name: &str| root.join(format!("symbolicR/mbs_{function}_{name}.c"));
        fs::copy(path("leg"), path("a")).expect("a copy");
    }
    let shown = robovec(&["project", &root.to_string_lossy()]);
    let text = said(&shown);
    assert!(text.starts_with("leg\n"), "{text}");
    assert!(text.contains("such as a in symbolicR"), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
}
