//! `robovec project` on a project of Robotran's kind: what it finds, replaces,
//! brings back, and compares in a copy.

use crate::compiled::has_gcc;
use crate::support::files::tree;
use crate::support::programs::{model, robovec, said, stderr, unfolded};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

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
        stderr(&other).contains("results differ by"),
        "{}",
        stderr(&other)
    );
    let failed = tried("false");
    assert!(
        stderr(&failed).contains("failed: false"),
        "{}",
        stderr(&failed)
    );
    assert_eq!(contents(folder.path()), before);
}
