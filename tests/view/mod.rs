//! The page of a compilation: its content, and its behaviour in a browser.
//! Where no Chromium is installed, a line reports it and no page is opened.

mod browser;

use crate::support::programs::{model, robovec, said};
use std::fs;
use std::path::{Path, PathBuf};

fn shown(input: &Path, words: &[&str], folder: &Path) -> PathBuf {
    let page = folder.join("page.html");
    let paths = [input, &page].map(|path| path.display().to_string());
    said(&robovec(
        &[&["view", &paths[0], "-o", &paths[1]], words].concat(),
    ));
    page
}

fn suspension() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.m")
}

/// The data of a page.
fn data(page: &Path) -> serde_json::Value {
    data_of(&fs::read_to_string(page).expect("it was written"))
}

fn data_of(text: &str) -> serde_json::Value {
    let (_, rest) = text
        .split_once("<script type=\"application/json\" id=\"data\">")
        .expect("a page holds its data");
    let (data, _) = rest.split_once("</script>").expect("the script ends");
    serde_json::from_str(data).expect("data are JSON")
}

#[test]
fn a_page_needs_nothing_else_and_is_the_same_twice() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let page = shown(&suspension(), &[], folder.path());
    let text = fs::read_to_string(&page).expect("it was written");
    for outside in [
        "http:", "https:", " src=", "@import", "url(", "fetch(", "import(",
    ] {
        let allowed = text.matches("http://www.w3.org/2000/svg").count();
        let found = text.matches(outside).count();
        let allowed = if outside == "http:" { allowed } else { 0 };
        assert_eq!(found, allowed, "the page refers to something by {outside}");
    }
    let times = |text: &str| {
        let mut data: serde_json::Value = data_of(text);
        for pass in data["functions"][0]["passes"]
            .as_array_mut()
            .expect("a list")
        {
            pass["cpu_s"] = 0.into();
            pass["peak_mb"] = 0.into();
        }
        data
    };
    let again = shown(&suspension(), &[], folder.path());
    let again = fs::read_to_string(&again).expect("it was written");
    assert_eq!(times(&text), times(&again));
}

#[test]
fn statements_are_those_of_the_text_with_their_times_and_origins() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let data = data(&shown(&suspension(), &[], folder.path()));
    let texts = data["texts"].as_array().expect("a list");
    let function = &data["functions"][0];
    let states = function["states"].as_array().expect("a list");
    let text = |column: &str, state: &serde_json::Value, at: usize| {
        let number = state[column][at].as_u64().expect("a number") as usize;
        texts[number].as_str().expect("a text").to_owned()
    };
    let mut before = 0;
    for (number, state) in states.iter().enumerate() {
        let count = state["names"].as_array().expect("a list").len();
        for column in [
            "texts", "sources", "arrivals", "slacks", "origins", "errors",
        ] {
            let column = state[column].as_array().expect("a list");
            assert_eq!(column.len(), count);
        }
        let path = state["path"].as_u64();
        let arrivals = state["arrivals"].as_array().expect("a list").iter();
        assert_eq!(arrivals.filter_map(|at| at.as_u64()).max(), path);
        for origin in state["origins"].as_array().expect("a list") {
            let origin = origin.as_i64().expect("a number");
            assert!(
                origin < before,
                "state {number} is made from the one before"
            );
        }
        before = count as i64;
    }
    let (first, last) = (&states[0], &states[states.len() - 1]);
    let find = |state: &serde_json::Value, name: &str| {
        let count = state["names"].as_array().expect("a list").len();
        (0..count).find(|&at| text("names", state, at) == name)
    };
    let read = find(first, "%OM13").expect("it is in the file");
    assert_eq!(text("texts", first, read), "qd[2] + qd[3]");
    let now = find(last, "%OM13").expect("it is left");
    assert_eq!(text("texts", last, now), "qd[2] + qd[3]");
    assert!(
        states.len() > 4
            && function["heat"]
                .as_array()
                .is_some_and(|heat| !heat.is_empty())
    );
    let schedule = &function["schedule"];
    let (cycle, ready) = (&schedule["cycle"], &schedule["ready"]);
    let cycles = cycle.as_array().expect("a list").iter();
    for (cycle, ready) in cycles.zip(ready.as_array().expect("a list")) {
        assert!(
            ready.as_u64() <= cycle.as_u64(),
            "nothing is read too early"
        );
    }
}

#[test]
fn a_model_shows_its_equations_and_its_joints() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let words = [
        "--dot",
        "graph.dot",
        "--value",
        "c[3]",
        "--trace",
        "events.json",
    ];
    let words = words.map(|word| {
        if word.contains('.') && !word.starts_with("--") {
            folder.path().join(word).display().to_string()
        } else {
            word.to_owned()
        }
    });
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let data = data(&shown(&model("bogie.mbs"), &words, folder.path()));
    assert_eq!(data["files"][0]["name"], "equations of bogie.mbs");
    let joints = data["joints"].as_array().expect("a list");
    assert_eq!(joints.len(), 23);
    for joint in joints {
        let line = joint["place"][1].as_u64().expect("its line") as usize - 1;
        let line = data["files"][1]["lines"][line].as_str().expect("a line");
        assert!(line.contains(joint["name"].as_str().expect("a name")));
    }
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("it was written");
    assert!(
        read("graph.dot").starts_with("digraph \"dirdyna\" {")
            && read("graph.dot").contains("\"c[3]\"")
    );
    let events: serde_json::Value = serde_json::from_str(&read("events.json")).expect("JSON");
    let events = events["traceEvents"].as_array().expect("a list");
    let placed = data["functions"][0]["schedule"]["element"]
        .as_array()
        .expect("a list");
    let placed = placed
        .iter()
        .filter(|element| element.as_i64() >= Some(0))
        .count();
    let shown = events
        .iter()
        .filter(|event| event["pid"] == 2 && event["ph"] == "X")
        .count();
    assert_eq!(shown, placed);
}
