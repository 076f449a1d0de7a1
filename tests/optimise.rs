//! `robovec optimise`: the best program is proved, made again by the commands
//! it names, and not beaten by other pipelines; more effort is never worse,
//! and threads change nothing.

use crate::determinism::files;
use crate::reference::random::ModelDraw;
use crate::support::programs::{assert_fits_a_screen, opt_in, robovec, robovec_in, said, stderr};
use robovec_num::random::Random;
use robovec_passes::registry::REGISTRY;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Optimises into a new folder.
fn optimised(words: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let words: Vec<&str> = ["optimise"]
        .into_iter()
        .chain(words.iter().copied())
        .chain(["-o", &path])
        .collect();
    let text = said(&robovec(&words));
    assert!(text.contains("\nproved       equal"), "{text}");
    assert_fits_a_screen(&text);
    assert_shows(&text, &results(folder.path()));
    folder
}

/// A search for the bogie, made once for all tests.
const BOGIE: [&str; 3] = ["examples/models/bogie.mbs", "--effort=1", "--states=16"];

/// Its results, in a new folder.
fn bogie() -> tempfile::TempDir {
    static FOUND: OnceLock<BTreeMap<PathBuf, Vec<u8>>> = OnceLock::new();
    let found = FOUND.get_or_init(|| files(optimised(&BOGIE).path()));
    let folder = tempfile::tempdir().expect("there is room for a folder");
    for (name, content) in found {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder of our own");
        fs::write(path, content).expect("a folder of our own");
    }
    folder
}

/// The numbers on the screen are those of the JSON.
fn assert_shows(text: &str, results: &Value) {
    let answer = &results["answer"];
    let number = |value: &Value| value.as_f64().expect("it was measured");
    let (before, after) = (number(&answer["before"]), number(&answer["after"]));
    let digits = |speed: f64| match answer["measure"].as_str() {
        Some("cycles" | "operations") => format!("{speed}"),
        _ if speed < 1.0 => format!("{speed:.2}"),
        _ if speed < 100.0 => format!("{speed:.1}"),
        _ => format!("{speed:.0}"),
    };
    let [worst, best] = [0, 1].map(|place| number(&answer["worst_errors"][place]));
    let found = number(&answer["found_error"]);
    if let Some(proved) = answer["proved_error"].as_f64() {
        assert!(found <= proved, "{found:e} was found, {proved:e} proved");
    }
    for shown in [
        format!("{} -> {} ", digits(before), digits(after)),
        format!("{worst:.1e} -> {best:.1e} in "),
        format!("up to {found:.1e}, found"),
    ] {
        assert!(text.contains(&shown), "no {shown} in {text}");
    }
    assert!(text.contains(&format!("\n{} program", results["programs"])));
    let points = results["points"].as_array().expect("a list");
    let row = |point: &Value| {
        let speed = ["cycles", "nanoseconds", "operations"]
            .iter()
            .find_map(|name| point[name].as_f64())?;
        let error = point["errors"][1].as_f64()?;
        Some(format!("{} {error:.1e}", digits(speed)))
    };
    let rows: BTreeSet<String> = points.iter().filter_map(row).collect();
    let table = text
        .lines()
        .skip_while(|line| !line.starts_with('─'))
        .skip(1);
    for line in table.take_while(|line| !line.is_empty()) {
        // Names have spaces: the columns after them are aligned to the right.
        let words: Vec<&str> = line.split_whitespace().collect();
        let error = words.iter().position(|word| word.contains("e-"));
        let error = error.expect("a row has an error");
        let shown = words[error - 1..=error].join(" ");
        assert!(rows.contains(&shown), "no {shown} in {rows:?}");
    }
}

fn results(folder: &Path) -> Value {
    serde_json::from_str(&read(folder, "optimise.json")).expect("JSON")
}

/// The points that were tried.
fn points(folder: &Path) -> Vec<Value> {
    let points = &results(folder)["points"];
    points.as_array().expect("a list").clone()
}

fn cycles(folder: &Path) -> u64 {
    let points = points(folder);
    let taken = points.iter().find(|point| point["taken"] == true);
    let taken = taken.expect("one is taken");
    taken["cycles"].as_u64().expect("it is placed")
}

#[test]
fn the_commands_it_names_make_the_same_program() {
    for words in [
        &["examples/suspension/mbs_dirdyna_suspension.m", "--effort=1"][..],
        &[
            "examples/models/bogie.mbs",
            "--effort=1",
            "--elements=8",
            "--states=16",
        ],
        &[
            "examples/models/bogie.mbs",
            "--effort=1",
            "--for=cpu",
            "--states=16",
            "--compiler=none",
        ],
    ] {
        let folder = optimised(words);
        let program = read(folder.path(), "program.rvir");
        let again = tempfile::tempdir().expect("there is room for a folder");
        // Commands are for who stands where the input is.
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        std::os::unix::fs::symlink(root.join("examples"), again.path().join("examples"))
            .expect("a link can be made");
        // Equations that no command makes stand beside the commands.
        let commands = read(folder.path(), "commands.txt");
        if commands.contains("start.rvir") && !commands.contains("robovec gen") {
            let start = read(folder.path(), "start.rvir");
            fs::write(again.path().join("start.rvir"), start).expect("it can be written");
        }
        for line in commands.lines() {
            let mut parts = line.split('\'');
            let mut words: Vec<String> = Vec::new();
            while let Some(plain) = parts.next() {
                words.extend(plain.split_whitespace().map(str::to_owned));
                words.extend(parts.next().map(str::to_owned));
            }
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            said(&match words[0] {
                "robovec" => robovec_in(again.path(), &words[1..]),
                _ => opt_in(again.path(), &words[1..]),
            });
        }
        assert_eq!(read(again.path(), "program.rvir"), program, "{words:?}");
    }
}

#[test]
fn effort_is_never_worse_and_threads_change_nothing() {
    let file = "examples/suspension/mbs_dirdyna_suspension.m";
    let mut known = u64::MAX;
    for effort in ["--effort=1", "--effort=2", "--effort=4"] {
        let searched = |jobs| optimised(&[file, effort, "--elements=16", jobs, "--states=16"]);
        let one = searched("--jobs=1");
        if effort == "--effort=2" {
            let three = searched("--jobs=3");
            for name in [
                "program.rvir",
                "optimise.json",
                "optimise.html",
                "commands.txt",
            ] {
                assert_eq!(read(one.path(), name), read(three.path(), name), "{name}");
            }
        }
        let cycles = cycles(one.path());
        assert!(cycles <= known, "{effort}: {cycles} after {known}");
        known = cycles;
    }
}

#[test]
fn a_search_that_goes_on_ends_as_one_that_was_not_interrupted() {
    let whole = bogie();
    let path = whole.path().to_string_lossy().into_owned();
    // As if it had been stopped half way.
    let mut kept: Vec<_> = fs::read_dir(whole.path().join("points"))
        .expect("programs are kept")
        .filter_map(Result::ok)
        .map(|entry| entry.path())
        .collect();
    kept.sort();
    assert!(kept.len() > 10, "{} programs are kept", kept.len());
    let marked = &kept[0];
    for path in kept.iter().step_by(2).skip(1) {
        fs::remove_file(path).expect("it can be removed");
    }
    let before = fs::metadata(marked)
        .and_then(|data| data.modified())
        .expect("its time");
    let program = read(whole.path(), "program.rvir");
    let report = read(whole.path(), "optimise.json");
    let mut again = vec!["optimise"];
    again.extend(BOGIE);
    again.extend(["--resume", "-o", &path]);
    said(&robovec(&again));
    assert_eq!(read(whole.path(), "program.rvir"), program);
    assert_eq!(read(whole.path(), "optimise.json"), report);
    let after = fs::metadata(marked)
        .and_then(|data| data.modified())
        .expect("its time");
    assert_eq!(before, after, "what was kept is not made again");
}

#[test]
fn every_target_is_ready_to_use() {
    let words = [
        "examples/suspension/mbs_dirdyna_suspension.m",
        "--effort=1",
        "--states=16",
    ];
    let fpga = optimised(&words);
    for name in ["program.rvir", "rtl", "optimise.svg", "optimise.csv"] {
        assert!(fpga.path().join(name).exists(), "{name}");
    }
    let cpu = optimised(&[&words[..], &["--for=cpu"]].concat());
    assert!(cpu.path().join("mbs_dirdyna_suspension.c").exists());
    let batch = optimised(&[&words[..], &["--for=batch"]].concat());
    assert!(batch.path().join("dirdyna_batch.c").exists());
    // A text of nobody's.
    let own = optimised(&["tests/passes/optimise/path.rvir", "--for=cpu", "--effort=1"]);
    assert!(own.path().join("f.c").exists());
}

#[test]
fn a_scene_leaves_out_what_it_does_not_need() {
    let general = bogie();
    let scene = optimised(&[
        "examples/scenes/bogie-1e-4.scene.toml",
        "--effort=1",
        "--states=16",
    ]);
    assert!(cycles(scene.path()) < cycles(general.path()));
}

#[test]
fn a_model_that_is_another_one_is_left_out_with_a_word() {
    let text = said(&robovec(&[
        "optimise",
        "examples/suspension/mbs_dirdyna_suspension.m",
        "--model=examples/models/bogie.mbs",
        "--effort=1",
        "--states=16",
    ]));
    assert!(text.contains("left out     4 formulations: "), "{text}");
}

#[test]
fn what_divides_gets_a_machine_with_a_divider() {
    let text = said(&robovec(&[
        "optimise",
        "examples/models/double-pendulum.mbs",
        "--function=accelred",
        "--effort=1",
    ]));
    assert!(
        text.contains("machine      solver (4 add, 4 multi, 1 div)"),
        "{text}"
    );
}

#[test]
fn class_real_rests_on_no_circle() {
    let folder = optimised(&[
        "examples/models/bogie.mbs",
        "--class=real",
        "--effort=1",
        "--states=16",
    ]);
    let points = points(folder.path());
    assert!(points.len() > 3);
    for point in points {
        let name = point["name"].as_str().expect("a name");
        assert!(!name.contains("composite"), "{name}");
    }
}

#[test]
fn no_preset_beats_it() {
    for elements in [4, 16] {
        let file = "examples/suspension/mbs_dirdyna_suspension.m";
        let folder = optimised(&[file, &format!("--elements={elements}")]);
        let best = cycles(folder.path());
        if elements == 4 {
            is_in_the_readme(folder.path());
        }
        for preset in REGISTRY.presets {
            let passes = preset
                .pipeline
                .replace(",asap-alap", "")
                .replace(",place,codegen", "");
            let found = cycles_of(file, &passes, elements).expect("it is placed");
            assert!(best <= found, "{}: {found} beats {best}", preset.name);
        }
    }
}

/// README.md has the answer of its main job, and its figure.
fn is_in_the_readme(folder: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (readme, figure) = (read(root, "README.md"), read(folder, "optimise.svg"));
    let answer = &results(folder)["answer"];
    let number = |value: &Value| value.as_f64().expect("it was measured");
    let [gain, before, after, median] =
        ["times_faster", "before", "after", "median_error"].map(|key| number(&answer[key]));
    let [worst, best] = [0, 1].map(|place| number(&answer["worst_errors"][place]));
    for line in [
        format!("{gain:.2} times faster: {before} -> {after} cycles"),
        format!("{worst:.1e} -> {best:.1e} in f32, median {median:.1e}"),
    ] {
        assert!(readme.contains(&line), "no {line} in README.md");
    }
    if std::env::var_os("INSTA_UPDATE").is_some_and(|value| value == "always") {
        fs::write(root.join("docs/suspension.svg"), &figure).expect("it can be written");
    }
    assert_eq!(read(root, "docs/suspension.svg"), figure);
}

/// Equations at the level atomic in another order: each as soon as its
/// operands are there, at random, sums and products turned about.
fn shuffled(text: &str, random: &mut Random) -> String {
    let is_equation = |line: &str| line.starts_with("  %");
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| is_equation(line));
    let first = first.expect("there are equations");
    let last = lines.iter().rposition(|line| is_equation(line));
    let last = last.expect("there are equations");
    let mut waiting: Vec<&str> = lines[first..=last].to_vec();
    let names = waiting.iter().map(|line| line.split_whitespace().next());
    let names: Vec<&str> = names.map(|name| name.expect("a name")).collect();
    let mut written: BTreeSet<&str> = BTreeSet::new();
    let mut shuffled: Vec<String> = lines[..first].iter().map(|&line| line.into()).collect();
    while !waiting.is_empty() {
        let place = random.below(waiting.len());
        let (name, rest) = waiting[place]
            .trim()
            .split_once(" = ")
            .expect("an equation");
        let read = rest.split(|c: char| !(c.is_alphanumeric() || "%._".contains(c)));
        let mut read = read.filter(|word| names.contains(word));
        if !read.all(|word| written.contains(word)) {
            continue;
        }
        let value = rest.split(" @").next().expect("a first part");
        let turned = match value.split_once(" + ").or_else(|| value.split_once('*')) {
            Some((a, b)) if random.chance(0.5) && !value.contains(['(', '-']) => rest.replacen(
                value,
                &value
                    .replacen(a, "\0", 1)
                    .replacen(b, a, 1)
                    .replacen('\0', b, 1),
                1,
            ),
            _ => rest.to_owned(),
        };
        shuffled.push(format!("  {name} = {turned}"));
        written.insert(name);
        waiting.remove(place);
    }
    shuffled.extend(lines[last + 1..].iter().map(|&line| line.to_owned()));
    shuffled.join("\n") + "\n"
}

#[test]
fn the_order_of_the_equations_does_not_matter() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let given = folder.path().join("given.rvir");
    let given = given.to_string_lossy();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = "examples/suspension/mbs_dirdyna_suspension.m";
    said(&opt_in(root, &[file, "-passes=atomise", "-o", &given]));
    let text = fs::read_to_string(&*given).expect("it was written");
    let mut random = Random::new(5);
    let mut programs = Vec::new();
    for _ in 0..2 {
        let other = folder.path().join("shuffled.rvir");
        let order = shuffled(&text, &mut random);
        assert_ne!(order, text);
        fs::write(&other, order).expect("there is room for a file");
        let found = optimised(&[&other.to_string_lossy(), "--effort=2", "--elements=16"]);
        programs.push(read(found.path(), "program.rvir"));
    }
    assert!(programs.windows(2).all(|pair| pair[0] == pair[1]));
}

/// A random pipeline from those that a user might try.
fn random_pipeline(random: &mut Random) -> String {
    const STEPS: [&str; 18] = [
        "fold",
        "zero-removal",
        "balance",
        "balance",
        "cse",
        "composite",
        "composite",
        "factor",
        "factor{path=free}",
        "factor-trig{path=free}",
        "factor-trig",
        "swap",
        "lookahead",
        "lookahead{growth=120}",
        "lookahead{growth=150}",
        "lookahead{growth=100 width=24 grid=5 frontiers=80}",
        "recurrence",
        "eqsat",
    ];
    let mut steps = vec!["atomise"];
    for _ in 0..3 + random.below(7) {
        steps.push(STEPS[random.below(STEPS.len())]);
    }
    steps.extend(["balance", "cse", "dce"]);
    steps.join(",")
}

/// The cycles of a pipeline on this number of elements; `None` where a pass
/// gives up.
fn cycles_of(file: &str, passes: &str, elements: u32) -> Option<u64> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let passes = format!("-passes={passes},place{{n_add={elements} n_multi={elements}}}");
    let remark = stderr(&opt_in(root, &[file, &passes, "-o", "-"]));
    let (before, _) = remark.rsplit_once(" cycles on")?;
    before.rsplit(' ').next()?.parse().ok()
}

/// The files of equations that pipelines start from: a file itself, of a model
/// its formulations.
fn starts(file: &str, folder: &Path) -> Vec<String> {
    if !file.ends_with(".mbs") {
        return vec![file.to_owned()];
    }
    let formulations = [
        "recursive",
        "composite",
        "composite-base",
        "prefix-sklansky",
    ];
    let made = formulations.map(|formulation| {
        let path = folder.join(format!("{formulation}.rvir"));
        let path = path.to_string_lossy().into_owned();
        said(&robovec(&[
            "gen",
            file,
            "--formulation",
            formulation,
            "-o",
            &path,
        ]));
        path
    });
    made.into()
}

#[test]
#[ignore = "takes long"]
fn no_random_pipeline_beats_it() {
    let models = std::env::var("ROBOVEC_OPTIMISE_FILES").unwrap_or_else(|_| {
        "examples/suspension/mbs_dirdyna_suspension.m examples/models/quarter-car.mbs \
         examples/models/double-pendulum.mbs examples/models/bogie.mbs \
         examples/models/serial-23.mbs examples/models/semi-serial-23.mbs \
         examples/models/parallel-23.mbs"
            .to_owned()
    });
    let mut random = Random::new(1);
    let mut worst: (f64, String) = (0.0, String::new());
    let mut compared = 0;
    for file in models.split_whitespace() {
        for elements in [4, 16] {
            let folder = optimised(&[file, &format!("--elements={elements}"), "--states=16"]);
            let best = cycles(folder.path());
            let starts = starts(file, folder.path());
            for count in 0..40 {
                let start = &starts[count % starts.len()];
                let passes = random_pipeline(&mut random);
                let Some(found) = cycles_of(start, &passes, elements) else {
                    continue;
                };
                compared += 1;
                let ratio = best as f64 / found as f64;
                if ratio > worst.0 {
                    worst = (
                        ratio,
                        format!("{file}, {elements}: {best} against {found} by {passes}"),
                    );
                }
            }
            println!("{file}, {elements}: {best} cycles; so far at most {worst:?}");
        }
    }
    assert!(compared > 0, "no pipeline made a schedule");
    assert!(worst.0 <= 1.02, "{worst:?}");
}

#[test]
fn nothing_is_taken_where_no_program_runs() {
    // 'true' compiles without a word and makes nothing.
    let output = robovec(&[
        "optimise",
        "tests/passes/optimise/path.rvir",
        "--for=cpu",
        "--compiler=true",
        "--effort=1",
    ]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no program could be timed"), "{message}");
    assert!(output.stdout.is_empty());
}
