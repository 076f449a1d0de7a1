//! `robovec explore --plan`: results of a small plan, its figures and files,
//! the remains of an interrupted run, and messages about wrong plans.

use crate::support::files::{compare_with_record, each, stem, tree};
use crate::support::programs::unfolded;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn study(plan: &Path, folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("explore")
        .arg("--plan")
        .arg(plan)
        .arg("-o")
        .arg(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn small_plan() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/study/plans/suspension.toml")
}

fn run_small(folder: &Path, arguments: &[&str]) -> String {
    let output = study(&small_plan(), folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    unfolded(&String::from_utf8_lossy(&output.stdout))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).expect("the study wrote it")
}

/// The files of a folder, by name.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder is there");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("readable").path())
        .collect();
    files.sort();
    files
}

#[test]
fn a_small_plan_gives_these_numbers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    run_small(folder, &[]);
    let recorded = tree("tests/study/plans");
    for table in [
        "programs",
        "points",
        "table-2.2",
        "table-3.1",
        "knee",
        "split",
        "errors",
    ] {
        let text = read(&folder.join(format!("tables/{table}.csv")));
        compare_with_record(&recorded, table, &text);
    }
    for figure in ["cycles-suspension", "rate-chain", "memory-suspension"] {
        let text = read(&folder.join(format!("figures/{figure}.csv")));
        compare_with_record(&recorded, figure, &text);
    }
    let results = read(&folder.join("explore.json"));
    let mut results: serde_json::Value = serde_json::from_str(&results).expect("JSON");
    let points = results["points"].as_array_mut().expect("a list of points");
    for kind in points
        .iter_mut()
        .flat_map(|point| point["kinds"].as_array_mut().into_iter().flatten())
    {
        let curve = kind["occupation"].as_array().expect("a curve");
        assert_eq!(curve.len(), 201);
        kind.as_object_mut()
            .expect("an object")
            .remove("occupation");
    }
    points.truncate(3);
    let text = serde_json::to_string_pretty(&results).expect("JSON");
    compare_with_record(&recorded, "results", &text);
}

/// The table of the whole step, and sums of its calls computed anew from the
/// table of all placements.
#[test]
fn a_whole_step_is_put_together_from_its_functions() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let recorded = tree("tests/study/plans");
    let output = study(&recorded.join("step.toml"), folder, &[]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    let table = read(&folder.join("tables/whole-step.csv"));
    compare_with_record(&recorded, "whole-step", &table);
    let results = read(&folder.join("explore.json"));
    let results: serde_json::Value = serde_json::from_str(&results).expect("JSON");
    let points = results["points"].as_array().expect("a list of points");
    let cycles = |model: &str| {
        let is_it = |point: &&serde_json::Value| {
            point["model"] == model && point["n_add"] == 1 && point["n_multi"] == 2
        };
        let point = points.iter().find(is_it).expect("it was placed");
        point["cycles"].as_u64().expect("a number")
    };
    let step = 3 * cycles("positions") + cycles("velocities") + cycles("accelerations");
    let row = table
        .lines()
        .find(|line| line.starts_with("slider-crank,") && line.contains(",1+2,"));
    let row = row.expect("a row of the mechanism");
    assert!(row.contains(&format!(",{step},")), "{step}: {row}");
    // Functions that only a sweep by name has are on no other machine.
    let is_elsewhere =
        |point: &&serde_json::Value| point["machine"] == "thesis" && point["model"] != "pendulum";
    assert_eq!(points.iter().filter(is_elsewhere).count(), 0);
    assert!(read(&folder.join("explore.html")).contains("The whole step"));
}

#[test]
fn drawings_are_well_formed_and_the_page_needs_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    run_small(folder, &[]);
    let mut drawn = 0;
    for path in files(&folder.join("figures")) {
        if path.extension().is_some_and(|extension| extension == "svg") {
            let text = read(&path);
            let document = roxmltree::Document::parse(&text).expect("well-formed XML");
            assert_eq!(document.root_element().tag_name().name(), "svg");
            assert!(
                document
                    .descendants()
                    .any(|node| node.has_tag_name("polyline") || node.has_tag_name("rect"))
            );
            assert!(
                !text.contains("NaN") && !text.contains("inf"),
                "{}",
                path.display()
            );
            drawn += 1;
        }
    }
    assert!(drawn > 10, "{drawn} figures");
    let page = read(&folder.join("explore.html"));
    let data = page.split_once("id=\"data\">").expect("data").1;
    let data = data.split_once("</script>").expect("the end of the data").0;
    let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
    assert_eq!(data["points"].as_array().map(Vec::len), Some(54));
    assert_eq!(data["verdicts"].as_array().map(Vec::len), Some(4));
    let elsewhere = page.replace("http://www.w3.org/2000/svg", "");
    for reference in [
        "http:",
        "https:",
        "src=",
        "url(",
        "@import",
        "fetch(",
        "XMLHttpRequest",
    ] {
        assert!(!elsewhere.contains(reference), "{reference}");
    }
}

#[test]
fn an_interrupted_study_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    assert!(run_small(folder, &["--jobs", "2"]).contains("54 placements: "));
    let whole = read(&folder.join("explore.json"));
    let page = read(&folder.join("explore.html"));
    let points = files(&folder.join("points"));
    assert_eq!(points.len(), 54);
    fs::remove_file(&points[0]).expect("it is there");
    fs::write(&points[1], "{\"key\": \"").expect("it can be written");
    let point = read(&points[2]);
    fs::write(&points[3], point).expect("it can be written");
    let said = run_small(folder, &["--resume", "--jobs", "1"]);
    assert!(
        said.contains("54 placements, 51 of them from an earlier run"),
        "{said}"
    );
    assert_eq!(read(&folder.join("explore.json")), whole);
    assert_eq!(read(&folder.join("explore.html")), page);
    assert!(run_small(folder, &["--resume"]).contains("54 of them"));
    assert!(
        run_small(folder, &[]).contains("54 placements: "),
        "without --resume all is new"
    );
}

#[test]
fn shares_of_a_study_are_the_whole_also_when_one_is_lost_half_way() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [whole, shared] = ["whole", "shared"].map(|name| folder.path().join(name));
    run_small(&whole, &[]);
    run_small(&shared, &["--shard", "1/3"]);
    run_small(&shared, &["--shard", "2/3"]);
    let points = files(&shared.join("points"));
    assert!(
        !shared.join("explore.json").exists(),
        "a share writes no tables"
    );
    // What a worker leaves that is killed: points it never wrote, and one cut off.
    fs::remove_file(&points[0]).expect("it is there");
    fs::write(&points[1], "{\"key\": \"").expect("it can be written");
    let mut found = 0;
    for share in ["1/3", "2/3", "3/3"] {
        let said = run_small(&shared, &["--shard", share]);
        let words: Vec<&str> = said.split_whitespace().collect();
        found += words[2].parse::<usize>().expect("a number");
    }
    assert_eq!(found, points.len() - 2, "what was left is used");
    assert!(run_small(&shared, &["--resume"]).contains("54 of them"));
    for file in ["explore.json", "explore.html"] {
        assert_eq!(read(&shared.join(file)), read(&whole.join(file)));
    }
    for wrong in ["0/3", "4/3", "1", "a/b", "1/0"] {
        let output = study(&small_plan(), &shared, &["--shard", wrong]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn the_command_line_chooses_among_models_pipelines_and_numbers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["quarter-car", "--passes=atomise,swap", "--elements=1,3"];
    let said = run_small(folder.path(), &arguments);
    // 2 usual, 2 x 2 x 2 of orders and choices of which one is usual, 9 of the grid.
    assert!(said.contains("placements"), "{said}");
    let programs = read(&folder.path().join("tables/programs.csv"));
    assert!(
        programs.contains("quarter-car,\"atomise,swap\",thesis,"),
        "{programs}"
    );
    assert_eq!(programs.lines().count(), 2, "{programs}");
}

#[test]
fn plans_that_are_wrong_are_refused_with_a_caret() {
    each("tests/study/errors", &["toml"], |path| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let results = folder.path().join("results");
        let output = study(path, &results, &[]);
        assert_eq!(output.status.code(), Some(1));
        let left = results.join("explore.json").exists() || results.join("explore.html").exists();
        assert!(!left, "something was written");
        let told = String::from_utf8_lossy(&output.stderr);
        compare_with_record(&tree("tests/study/errors"), &stem(path), &told);
    });
}

#[test]
fn the_thesis_bogie_is_within_four_per_cent_of_its_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let output = study(
        Path::new("thesis"),
        folder,
        &["bogie", "serial-23", "--elements=1,4", "--machine=thesis"],
    );
    assert!(output.status.success());
    let table = read(&folder.join("tables/table-3.1.json"));
    let table: serde_json::Value = serde_json::from_str(&table).expect("JSON");
    let rows = table["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 4);
    // Columns 11 to 13: the ratios of operations, ASAP and ASAPCycle.
    for row in rows.iter().filter(|row| row[2] == "printed") {
        for ratio in (11..14).map(|column| row[column].as_f64().expect("a ratio")) {
            assert!((0.96..1.04).contains(&ratio), "{row}");
        }
    }
    // The figure Y of the modified serial system cannot be right.
    assert_eq!(rows[3][10]["doubtful"].as_f64(), Some(12.25));
    assert!(rows[3][14].is_null());
    assert!(
        rows[3][15]
            .as_str()
            .is_some_and(|reason| reason.contains("16.12"))
    );
    for name in [
        "figure-1.9",
        "figure-2.4",
        "figure-3.4",
        "figure-3.9",
        "figure-3.15",
        "figure-3.33",
    ] {
        assert!(
            folder.join(format!("figures/{name}.svg")).is_file(),
            "{name}"
        );
    }
}
