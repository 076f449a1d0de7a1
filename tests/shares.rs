//! Shares of explorations: several workers on one folder leave the same files
//! as one run, byte for byte, also when one was killed half way.

use crate::determinism::files;
use crate::support::files::tree;
use crate::support::programs::{robovec_in, said, stderr};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Place where a run writes, from its working directory: commands print the
/// name.
const OUT: &str = "out";

fn run(folder: &Path, words: &[&str], more: &[&str]) -> String {
    let words = [words, &["-o", OUT], more].concat();
    said(&robovec_in(folder, &words))
}

/// Number of results that a worker found, of every line that it prints.
fn found(said: &str) -> usize {
    let lines = said.lines().map(|line| {
        let (_, line) = line.split_once(", ").expect("what was found");
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[1..], ["of", "them", "found"], "{said}");
        words[0].parse::<usize>().expect("a number")
    });
    lines.sum()
}

/// Names of the results that are kept.
fn points(folder: &Path) -> BTreeSet<PathBuf> {
    let kept = files(&folder.join(OUT).join("points"));
    kept.into_keys().collect()
}

/// Runs a command as a whole and in shares, one of which is killed half way.
fn are_the_whole(words: &[&str]) {
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a temporary folder"));
    let [whole, shared] = [folders[0].path(), folders[1].path()];
    let told = run(whole, words, &[]);
    run(shared, words, &["--shard=1/3"]);
    run(shared, words, &["--shard=2/3"]);
    let is_point = |path: &PathBuf| path.starts_with("points");
    let left = files(&shared.join(OUT));
    assert!(left.keys().all(is_point), "a share writes no tables");
    // What a worker leaves that is killed: a result it never wrote, and one cut off.
    let kept: Vec<PathBuf> = points(shared).into_iter().collect();
    assert!(kept.len() > 3, "{words:?} keeps {} results", kept.len());
    let point = |index: usize| shared.join(OUT).join("points").join(&kept[index]);
    fs::remove_file(point(0)).expect("it is there");
    fs::write(point(1), "{\"key\": \"").expect("it can be written");
    let shares = ["1/3", "2/3", "3/3"].map(|share| run(shared, words, &["--shard", share]));
    let found: usize = shares.iter().map(|said| found(said)).sum();
    assert!(found > 0, "{words:?}: what was left is used");
    assert_eq!(points(shared), points(whole), "{words:?}");
    assert_eq!(run(shared, words, &["--resume"]), told, "{words:?}");
    let [whole, shared] = [whole, shared].map(files);
    assert!(whole.keys().eq(shared.keys()), "{words:?}");
    for (name, content) in &whole {
        assert!(shared[name] == *content, "{words:?}: {}", name.display());
    }
}

#[test]
fn shares_of_a_sweep_are_the_whole() {
    let space = ["--adders=1,2", "--multipliers=1,2", "--couples=3-3,6-4"];
    are_the_whole(&[&["explore", "serial-2", "serial-3"], &space[..]].concat());
}

#[test]
fn shares_of_a_front_are_the_whole() {
    let suspension = tree("examples/suspension/mbs_dirdyna_suspension.m");
    let suspension = suspension.to_string_lossy();
    let size = ["--elements=2,4", "--states=8"];
    are_the_whole(&[&["explore", "serial-2", &suspension], &size[..]].concat());
}

#[test]
fn shares_of_a_bench_of_rules_are_the_whole() {
    let [suspension, bodies] = ["suspension/mbs_dirdyna_suspension.m", "models/bogie.mbs"]
        .map(|name| tree(&format!("examples/{name}")));
    let [suspension, bodies] = [suspension.to_string_lossy(), bodies.to_string_lossy()];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rules = folder.path().join("mine.rules");
    let text = "rule three: a*b + a*c + a*d => a*(b + c + d) class=real \"in common\";\n\
                rule two: a*b + a*c => a*(b + c) class=real \"in common\";\n\
                rule zero: a - a => 0 class=real \"nothing\";\n";
    fs::write(&rules, text).expect("a folder of our own");
    let rules = rules.to_string_lossy();
    let inputs = ["rules", "bench", &suspension, &bodies];
    are_the_whole(&[&inputs[..], &["--rules", &rules, "--only"]].concat());
}

#[test]
fn shares_of_a_search_are_the_whole() {
    let suspension = tree("examples/suspension/mbs_dirdyna_suspension.m");
    let suspension = suspension.to_string_lossy();
    are_the_whole(&["optimise", &suspension, "--effort=2", "--states=8"]);
}

#[test]
fn shares_are_refused_where_they_mean_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for words in [
        &["explore", "serial-1", "--shard=1/2"][..],
        &["explore", "serial-1", "--shard=1/2", "--cpu", "-o", OUT],
        &["optimise", "serial-1", "--shard=3/2", "-o", OUT],
        &["explore", "serial-1", "--designs", "--shard=0/2", "-o", OUT],
    ] {
        let output = robovec_in(folder.path(), words);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    }
}
