//! Labels follow the data: every page and text names the device and the clock
//! of its run, counts with the right noun, and shows the numbers of its JSON.
//! Runs are data: two devices, two machines, one subject, and one and several
//! of everything.

use crate::support::files::tree;
use crate::support::programs::{robovec, said, unfolded};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Words that name one device, by the name of its family.
const DEVICES: [(&str, &[&str]); 2] = [
    ("cyclone", &["Cyclone V 5CSEBA6U23I7"]),
    ("ecp5", &["ECP5 LFE5UM-85F"]),
];

/// Words that belong to one device and are no names.
const FOREIGN: [&str; 4] = ["5CSEBA6U23I7", "thesis' device", "M10K", "ALUT"];

/// A run.
struct LabelledRun {
    /// The words; `OUT` represents a folder of the test, `HERE` that of the
    /// inputs.
    command: &'static str,
    /// The device of [`DEVICES`].
    device: &'static str,
    /// The page.
    page: &'static str,
    /// Words that page and terminal have together.
    words: &'static [&'static str],
    /// Words that neither output may have.
    absent: &'static [&'static str],
    /// The table, its JSON, the place of the points in it, and columns with
    /// their keys.
    points: Option<PointFiles>,
}

/// Points as CSV and as JSON.
struct PointFiles {
    csv: &'static str,
    json: &'static str,
    pointer: &'static str,
    columns: &'static [(&'static str, &'static str)],
}

const SWEEP: PointFiles = PointFiles {
    csv: "explore.csv",
    json: "explore.json",
    pointer: "/0/points",
    columns: &[
        ("adders", "/design/adders"),
        ("estimated clock (MHz)", "/clock/mhz"),
        ("cycles", "/cycles"),
        ("lower bound", "/lower_bound"),
        ("us per evaluation", "/us_per_evaluation"),
        ("look-up tables", "/resources/look_up_tables"),
        ("memory blocks", "/resources/memory_blocks"),
        ("share", "/share"),
    ],
};

const FRONT: PointFiles = PointFiles {
    csv: "explore.csv",
    json: "explore.json",
    pointer: "/0/points",
    columns: &[
        ("operations", "/operations"),
        ("path (cycles)", "/path"),
        ("cycles", "/cycles/0"),
        ("time (us)", "/microseconds/0"),
        ("share of device", "/shares/0"),
        ("normwise worst", "/normwise/worst"),
    ],
};

const FIT: PointFiles = PointFiles {
    csv: "fit.csv",
    json: "fit.json",
    pointer: "/candidates",
    columns: &[
        ("operations", "/operations"),
        ("cycles", "/cycles"),
        ("time (us)", "/microseconds"),
        ("normwise worst", "/normwise/worst"),
        ("cells", "/cells"),
    ],
};

const RUNS: &[LabelledRun] = &[
    LabelledRun {
        command: "explore HERE/pair.rvir --passes atomise --adders 1 --multipliers 1 --couples 3-3 \
                  --memories unified --buffers 16 --instances 1 --device ecp5 -o OUT",
        device: "ecp5",
        page: "explore.html",
        words: &["1 design on ECP5 LFE5UM-85F, 1 on the front"],
        absent: &["The dashed line", "The steps connect"],
        points: Some(SWEEP),
    },
    LabelledRun {
        command: "explore HERE/pair.rvir --passes atomise --adders 1,2 --multipliers 1 --couples \
                  3-3,6-4 --memories unified --buffers 16 --instances 1,4 -o OUT",
        device: "cyclone",
        page: "explore.html",
        words: &["8 designs on Cyclone V 5CSEBA6U23I7", "The steps connect"],
        absent: &["The dashed line"],
        points: Some(SWEEP),
    },
    LabelledRun {
        command: "explore HERE/pair.rvir --states 1 --elements 1 --machine HERE/lattice.toml -o OUT",
        device: "ecp5",
        page: "explore.html",
        words: &[
            "Machine lattice: ",
            "(1 random state in the given ranges, seed 1",
        ],
        absent: &["178 MHz"],
        points: Some(FRONT),
    },
    LabelledRun {
        command: "explore HERE/pair.rvir --states 8 --elements 2 -o OUT",
        device: "cyclone",
        page: "explore.html",
        words: &[
            "Machine thesis: ",
            " 120 MHz (estimated)",
            "(8 random states in the given ranges, seed 1",
        ],
        absent: &["178 MHz"],
        points: Some(FRONT),
    },
    LabelledRun {
        command: "fit HERE/pair.scene.toml --machine HERE/lattice.toml -o OUT",
        device: "ecp5",
        page: "fit.html",
        words: &["y[1] 1e-3 of its array's largest element; y[2] 1e-4"],
        absent: &["multiplier blocks, "],
        points: Some(FIT),
    },
    LabelledRun {
        command: "explore --plan HERE/one.toml -o OUT",
        device: "cyclone",
        page: "explore.html",
        words: &["1 placement", "178 MHz (published)"],
        absent: &[],
        points: None,
    },
    LabelledRun {
        command: "optimise HERE/pair.rvir --effort 1 --machine HERE/lattice.toml -o OUT",
        device: "ecp5",
        page: "optimise.html",
        words: &["% of ECP5 LFE5UM-85F (estimated)"],
        absent: &[],
        points: None,
    },
];

/// Single things in the plural: `1 models`.
fn lone_plurals(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split([' ', '\n', '<', '>', '"', '(']).collect();
    let pairs = words.windows(2).filter(|pair| {
        let word = pair[1].trim_end_matches([',', '.', ';', ':', ')']);
        let is_plural = word.len() > 3 && word.ends_with('s') && !word.ends_with("ss");
        let is_noun = word.chars().all(|c| c.is_ascii_lowercase());
        pair[0] == "1" && is_plural && is_noun && !["times", "gives", "takes"].contains(&word)
    });
    pairs.map(|pair| pair.join(" ")).collect()
}

/// The page without its data.
fn visible(page: &str) -> String {
    let end = page.find("<script").unwrap_or(page.len());
    page[..end].to_owned()
}

fn rows(csv: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv.lines().map(fields);
    let head = reader.next().expect("a table has a head");
    reader
        .map(|row| head.iter().cloned().zip(row).rev().collect())
        .collect()
}

/// The fields of a line, some of them in quotes.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for character in line.chars() {
        match character {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => fields.last_mut().expect("one at least").push(character),
        }
    }
    fields
}

fn value(printed: &str) -> f64 {
    printed.parse().expect("a number")
}

/// A little over half a unit in the last place of a number as printed.
fn last_place(printed: &str) -> f64 {
    let (digits, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, after)| after.len());
    0.51 * 10f64.powi(exponent.parse::<i32>().expect("an exponent") - decimals as i32)
}

/// Every row of the table is a point of the JSON: each number is that of the
/// point, to the printed digits, and the page shows it.
fn table_is_json(folder: &Path, page: &str, files: &PointFiles) {
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("it was written");
    let json: Value = serde_json::from_str(&read(files.json)).expect("it is JSON");
    let points = json.pointer(files.pointer).and_then(Value::as_array);
    let points = points.expect("there are points");
    let rows = rows(&read(files.csv));
    assert_eq!(rows.len(), points.len());
    for row in rows {
        let agrees = |point: &Value, (column, key): &(&str, &str)| {
            let printed = &row[*column];
            match point.pointer(key).and_then(Value::as_f64) {
                None => printed.is_empty(),
                Some(number) => (value(printed) - number).abs() <= last_place(printed),
            }
        };
        let is_point = |point: &&Value| files.columns.iter().all(|column| agrees(point, column));
        assert!(points.iter().any(|point| is_point(&point)), "{row:?}");
        for (column, _) in files.columns {
            let cell = format!(">{}<", row[*column]);
            assert!(page.contains(&cell), "{column}: {cell}");
        }
    }
}

#[test]
fn pages_and_texts_name_what_they_show() {
    let here = tree("tests/labels").display().to_string();
    for run in RUNS {
        let folder = tempfile::tempdir().expect("a folder can be made");
        let out = folder.path().display().to_string();
        let command = run.command.replace("HERE", &here).replace("OUT", &out);
        let words: Vec<&str> = command.split_whitespace().collect();
        let text = said(&robovec(&words));
        let page = fs::read_to_string(folder.path().join(run.page)).expect("there is a page");
        let shown = visible(&page);
        let both = format!("{}\n{shown}", unfolded(&text));
        let command = run.command;
        for word in run.words {
            assert!(both.contains(word), "{command}: no '{word}' in {text}");
        }
        for (family, names) in DEVICES {
            for name in names {
                let is_named = family == run.device;
                assert_eq!(shown.contains(name), is_named, "{command}: {name}");
            }
        }
        let foreign = FOREIGN.iter().filter(|_| run.device != "cyclone");
        for word in foreign.chain(run.absent) {
            assert!(!both.contains(word), "{command}: '{word}'");
        }
        assert_eq!(lone_plurals(&both), [] as [String; 0], "{command}");
        if let Some(files) = &run.points {
            table_is_json(folder.path(), &page, files);
        }
    }
}

/// Counts of one have nouns in the singular.
#[test]
fn one_is_counted_in_the_singular() {
    for command in [
        "error tests/labels/pair.rvir --states 1 --passes atomise",
        "error tests/labels/pair.rvir --states 1 --number f32",
        "error tests/labels/pair.rvir --blame --outputs y[1]",
        "eval tests/labels/pair.rvir --states 1",
        "fit tests/labels/pair.scene.toml --explain",
        "sim modal examples/models/double-pendulum.mbs",
        "view tests/labels/pair.rvir -o OUT/view.html",
        "rtl tests/labels/pair.rvir --passes atomise,place -o OUT/rtl",
        "rules check rules/associativity.rules",
    ] {
        let folder = tempfile::tempdir().expect("a folder can be made");
        let out = folder.path().display().to_string();
        let command = command.replace("OUT", &out);
        let words: Vec<&str> = command.split(' ').collect();
        let output = robovec(&words);
        let text = said(&output) + &String::from_utf8_lossy(&output.stderr);
        assert_eq!(lone_plurals(&text), [] as [String; 0], "{command}: {text}");
    }
    assert_eq!(lone_plurals("1 models, 1 model"), ["1 models,"]);
}
