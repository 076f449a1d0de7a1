//! Speed against error: what the thesis could choose is dominated by what we
//! choose.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn robovec(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program starts");
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("it prints UTF-8")
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("it was written")
}

#[test]
fn every_choice_of_the_thesis_is_dominated() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let text = robovec(&[
        "front",
        "examples/models/bogie.mbs",
        "examples/suspension/mbs_dirdyna_suspension.m",
        "--elements=4,16",
        "--states=64",
        "-o",
        &path,
    ]);
    assert!(text.contains("of the 10 choices of the thesis"), "{text}");
    let fronts: Value = serde_json::from_str(&read(folder.path(), "front.json")).expect("JSON");
    let fronts = fronts.as_array().expect("a list");
    assert_eq!(fronts.len(), 2);
    for front in fronts {
        let verdicts = front["verdicts"].as_array().expect("a list");
        assert_eq!(verdicts.len(), 10);
        for verdict in verdicts {
            let point = &front["points"][verdict["point"].as_u64().expect("an index") as usize];
            assert!(
                verdict["by"].is_u64(),
                "{}: {} stands",
                front["name"],
                point["choice"]
            );
        }
        // The series of order 1 is wrong by far more than any rounding.
        let points = front["points"].as_array().expect("a list");
        for point in points {
            let worst = point["normwise"]["worst"].as_f64().expect("a number");
            let first = point["choice"]
                .as_str()
                .is_some_and(|name| name.contains("order 1"));
            assert_eq!(worst > 1e-4, first, "{point}");
        }
    }
    for (name, word) in [
        ("front.html", "look-ahead"),
        ("front.svg", "worst normwise error"),
        ("front.csv", "look-ahead"),
    ] {
        assert!(read(folder.path(), name).contains(word), "{name}");
    }
}
