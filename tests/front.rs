//! Speed against error: what the thesis could choose is dominated by what we
//! choose, and what a scene is given holds in simulation.

use crate::support::programs::{robovec, said};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("it was written")
}

#[test]
fn every_choice_of_the_thesis_is_dominated() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let text = said(&robovec(&[
        "front",
        "examples/models/bogie.mbs",
        "examples/suspension/mbs_dirdyna_suspension.m",
        "--elements=4,16",
        "--states=64",
        "-o",
        &path,
    ]));
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

/// A search for a scene: what was chosen, and its confirmation.
fn fit(scene: &str) -> (Value, Value) {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let text = said(&robovec(&[
        "fit",
        scene,
        "--formulation=composite",
        "--states=12",
        "-o",
        &path,
    ]));
    assert!(!text.to_lowercase().contains("confirmed"), "{text}");
    assert!(text.contains("not established  for every state"), "{text}");
    let result: Value = serde_json::from_str(&read(folder.path(), "fit.json")).expect("JSON");
    let tried = &result["challenge"];
    let established = format!(
        "Held at {} fresh states (seed {}): with a confidence of 95 %, at 99.",
        tried["fresh"], tried["seed"]
    );
    assert!(text.contains(&established), "{text}");
    let chosen = result["chosen"]
        .as_u64()
        .expect("something meets the scene") as usize;
    let mut candidate = result["candidates"][chosen].clone();
    let program = candidate["program"].as_u64().expect("an index") as usize;
    candidate["trigonometry"] = result["programs"][program]["trigonometry"].clone();
    // What was chosen compiles again from its text.
    let program = folder.path().join("program.rvir");
    let machine = folder.path().join("machine.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
        .arg(program)
        .arg("--machine")
        .arg(machine)
        .args(["--simulate=2", "-o", "/dev/null"])
        .output()
        .expect("the program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    (candidate, result["confirmation"].clone())
}

#[test]
fn a_scene_gets_the_order_and_the_format_that_its_tolerance_needs() {
    let mut mantissas = Vec::new();
    for (scene, tolerance) in [
        ("examples/scenes/bogie-1e-4.scene.toml", 1e-4),
        ("examples/scenes/bogie-1e-6.scene.toml", 1e-6),
    ] {
        let (candidate, confirmation) = fit(scene);
        let worst = candidate["normwise"]["worst"].as_f64().expect("a number");
        assert!(worst <= tolerance, "{scene}: {worst}");
        assert_eq!(candidate["meets"], true);
        assert_eq!(confirmation["equal"], true);
        assert!(confirmation["simulated_used"].as_f64().expect("a number") <= 1.0);
        let order = candidate["trigonometry"].as_str().expect("a text");
        assert!(
            !order.contains("true"),
            "the elements compute them: {order}"
        );
        let format: robovec_ir::Format = (candidate["format"].as_str())
            .and_then(|text| text.parse().ok())
            .expect("a format");
        mantissas.push((order.to_owned(), format.significand()));
    }
    // A hundred times less error takes about seven bits more.
    let [(_, loose), (_, tight)] = &mantissas[..] else {
        panic!("two scenes");
    };
    assert!((4..=10).contains(&(tight - loose)), "{mantissas:?}");
    assert!(*loose < 24, "{mantissas:?}");
}
