//! The planted faults of `scripts/faults` fit the present code: one that no
//! longer applies would not be tried by `scripts/plant-faults`.

use serde::Deserialize;
use std::fs;
use std::path::Path;

/// Contents of one file of faults; the tests and the faults themselves are for
/// the script.
#[derive(Deserialize)]
struct FaultList {
    #[serde(rename = "edit")]
    edits: Vec<FaultEdit>,
}

/// A piece of a source that faults replace.
#[derive(Deserialize)]
struct FaultEdit {
    file: String,
    from: String,
}

#[test]
fn every_planted_fault_applies() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut edits = 0;
    let mut stale = Vec::new();
    for list in fs::read_dir(root.join("scripts/faults")).expect("the faults are there") {
        let list = fs::read_to_string(list.expect("a readable folder").path());
        let list: FaultList = toml::from_str(&list.expect("a readable list")).expect("a list");
        edits += list.edits.len();
        for FaultEdit { file, from } in list.edits {
            let source = fs::read_to_string(root.join(&file)).unwrap_or_default();
            if source.matches(&from).count() != 1 {
                stale.push(format!("{file}: {from}"));
            }
        }
    }
    assert!(edits > 100, "only {edits} edits were found");
    assert!(
        stale.is_empty(),
        "these stand in their file not once:\n{}",
        stale.join("\n")
    );
}
