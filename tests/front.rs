//! Speed against error: the choices of the thesis are dominated by those of
//! robovec, and the choice for a scene holds in simulation.

use crate::support::programs::{robovec, said, stderr, unfolded};
use robovec::explore::program::{transformed_by, view};
use robovec::generate::Formulation;
use robovec::scene::SceneSubject;
use robovec::yardstick::{Yardstick, results};
use robovec_framework::scene::{Allowed, ArraySizes};
use robovec_ir::Machine;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("it was written")
}

#[test]
fn every_choice_of_the_thesis_is_dominated() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let text = unfolded(&said(&robovec(&[
        "explore",
        "examples/models/bogie.mbs",
        "examples/suspension/mbs_dirdyna_suspension.m",
        "--elements=4,16",
        "--states=64",
        "-o",
        &path,
    ])));
    assert_eq!(
        text.matches("10 of 10 choices of the thesis").count(),
        2,
        "{text}"
    );
    let fronts: Value = serde_json::from_str(&read(folder.path(), "explore.json")).expect("JSON");
    let fronts = fronts.as_array().expect("a list");
    assert_eq!(fronts.len(), 2);
    for front in fronts {
        let points = front["points"].as_array().expect("a list");
        let searched = points.iter().filter(|point| !point["found"].is_null());
        let searched: Vec<&Value> = searched.collect();
        assert!(searched.len() >= 2, "{}", front["name"]);
        for point in searched {
            let [found, sampled] = [&point["found"], &point["normwise"]["worst"]]
                .map(|error| error.as_f64().expect("a number"));
            assert!(found > 0.9 * sampled, "{}: {found}", point["choice"]);
        }
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
        ("explore.html", "look-ahead"),
        ("explore.svg", "worst normwise error"),
        ("explore.csv", "look-ahead"),
    ] {
        assert!(read(folder.path(), name).contains(word), "{name}");
    }
}

/// Result of a search for a scene.
pub(crate) struct FittedScene {
    /// Chosen candidate.
    pub(crate) candidate: Value,
    confirmation: Value,
    /// The machine written for it.
    pub(crate) machine: String,
}

/// The bogie to 1e-4 on a machine for an ECP5, searched once for all tests.
pub(crate) fn loose() -> &'static FittedScene {
    static FOUND: OnceLock<FittedScene> = OnceLock::new();
    FOUND.get_or_init(|| {
        let folder = tempfile::tempdir().expect("there is room for a folder");
        crate::clock::machine(folder.path(), "ecp5");
        let machine = folder.path().join("machine.toml");
        let machine = machine.to_string_lossy();
        fit(
            "examples/scenes/bogie-1e-4.scene.toml",
            &["--machine", &machine],
        )
    })
}

/// A search for a scene.
fn fit(scene: &str, options: &[&str]) -> FittedScene {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().to_string_lossy().into_owned();
    let words = [
        "fit",
        scene,
        "--formulation=composite",
        "--states=12",
        "-v",
        "-o",
        &path,
    ];
    let text = unfolded(&said(&robovec(&[&words[..], options].concat())));
    assert!(!text.to_lowercase().contains("confirmed"), "{text}");
    assert!(text.contains("not proved for every state"), "{text}");
    let result: Value = serde_json::from_str(&read(folder.path(), "fit.json")).expect("JSON");
    let tried = &result["challenge"];
    let established = format!(
        "held at {} fresh states (seed {}), at most ",
        tried["fresh"], tried["seed"]
    );
    for word in [&established, "with a confidence of 95 %, at 99."] {
        assert!(text.contains(word), "{text}");
    }
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
    FittedScene {
        candidate,
        confirmation: result["confirmation"].clone(),
        machine: read(folder.path(), "machine.toml"),
    }
}

#[test]
fn a_scene_gets_the_order_and_the_format_that_its_tolerance_needs() {
    let mut mantissas = Vec::new();
    let tight = fit("examples/scenes/bogie-1e-6.scene.toml", &[]);
    for (fitted, tolerance) in [(loose(), 1e-4), (&tight, 1e-6)] {
        let FittedScene {
            candidate,
            confirmation,
            ..
        } = fitted;
        let worst = candidate["normwise"]["worst"].as_f64().expect("a number");
        assert!(worst <= tolerance, "{tolerance}: {worst}");
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

/// Searches a scene for its function: the outcome as JSON, with the printed
/// text.
fn searched(scene: &str, equations: Option<&str>) -> (Value, String) {
    searched_with(scene, equations, &[])
}

/// As [`searched`], with more words on the command line.
fn searched_with(scene: &str, equations: Option<&str>, words: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().join("tried.scene.toml");
    std::fs::write(&path, scene).expect("it can be written");
    if let Some(equations) = equations {
        std::fs::write(folder.path().join("f.rvir"), equations).expect("it can be written");
    }
    let output = folder.path().join("results").to_string_lossy().into_owned();
    let path = path.to_string_lossy().into_owned();
    let asked = [&["fit", &path, "--states=32", "-v", "-o", &output], words].concat();
    let text = unfolded(&said(&robovec(&asked)));
    let result = read(Path::new(&output), "fit.json");
    (serde_json::from_str(&result).expect("JSON"), text)
}

#[test]
fn a_choice_holds_where_the_largest_element_vanishes() {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/double-pendulum.mbs");
    let text = format!(
        "name = \"whole turns\"\nmodel = \"{}\"\nfunction = \"dirdyna\"\n\
         parameters = \"from-model\"\n\
         [[output]]\nelements = [\"M\", \"c\"]\nerror = 1e-3\n\
         [bind]\nfrc = 0.0\ntrq = 0.0\n[range]\nq = [-3.2, 3.2]\nqd = [-10, 10]\n",
        model.display()
    );
    let (result, told) = searched(&text, None);
    let challenge = &result["challenge"];
    assert!(challenge["fresh"].as_u64().expect("a count") > 100_000);
    let [fresh, used] =
        ["fresh_used", "used"].map(|key| challenge[key].as_f64().expect("a number"));
    // The directed search finds worse states than chance does.
    assert!(0.0 < fresh && fresh <= used && used <= 1.0, "{challenge}");
    assert!(told.contains("c 1."), "the size of c is told: {told}");
    // Other states, drawn and measured here: the choice, in its format,
    // against the general function in double-double numbers.
    let scene = robovec::scene::read("tried", &text, Path::new("."));
    let scene = scene.unwrap_or_else(|report| panic!("{}", report.render_plain()));
    let general = scene.module().expect("the model gives it");
    let chosen = &result["candidates"][result["chosen"].as_u64().expect("one holds") as usize];
    let program = &result["programs"][chosen["program"].as_u64().expect("an index") as usize];
    let formulation = program["formulation"]
        .as_str()
        .and_then(Formulation::from_name);
    let SceneSubject::Model(subject) = &scene.subject else {
        panic!("the scene is about a model");
    };
    let other = subject.equations(formulation.expect("a formulation"));
    let made = transformed_by(
        &other.expect("the model gives it"),
        program["pipeline"].as_str().expect("a pipeline"),
        &Machine::built_in("thesis").expect("it ships"),
        Some(&scene.scene),
    );
    let made = made.expect("the pipeline was run before");
    let format: robovec_ir::Format = (chosen["format"].as_str())
        .and_then(|text| text.parse().ok())
        .expect("a format");
    let yardstick = Yardstick::new(view(&general), &scene.scene.states(4711), 20_000);
    let inputs = yardstick.inputs(view(&made)).expect("the same inputs");
    let sizes = ArraySizes::of(view(&general), Some(&scene.scene));
    let allowed = Allowed::new(view(&made), Some(&scene.scene), f64::INFINITY, &sizes);
    let computed = results(view(&made), format, &inputs);
    let shares = yardstick.shares(view(&made), &computed, &allowed);
    let worst = shares
        .expect("the same outputs")
        .into_iter()
        .fold(0.0, f64::max);
    assert!(0.01 < worst && worst <= 1.0, "{worst}");
}

#[test]
fn an_output_that_is_always_zero_has_a_tolerance_like_others() {
    let scene = "name = \"zero\"\nequations = \"f.rvir\"\n\
                 [[output]]\nelements = [\"y\", \"z\"]\nerror = 1e-3\n\
                 [range]\na = [-1.0, 1.0]\nb = [1.0, 2.0]\nc = [1.0, 2.0]\n";
    let equations = "// robovec 1\nfunction f equations {\n  in a\n  in b\n  in c\n\
                     \x20 out y[1..2]\n  out z\n  y[1] = a*b*c - c*b*a\n\
                     \x20 y[2] = 0.3*a - a*0.3\n  z = a + b\n}\n";
    let (result, told) = searched(scene, Some(equations));
    let chosen = result["chosen"].as_u64().expect("one holds") as usize;
    // Nothing narrower than z needs.
    let format = result["candidates"][chosen]["format"].as_str();
    let format: robovec_ir::Format = (format.and_then(|text| text.parse().ok())).expect("a format");
    assert!((9..=16).contains(&format.significand()), "{format}");
    // The zeros are proved; z is nearly: its bound takes the largest error and
    // the least size at once.
    assert!(told.contains("bounds of the rounding"), "{told}");
    assert_eq!(result["bound"]["outputs"], 3);
    assert!(result["bound"]["proved"].as_u64().expect("a count") >= 2);
    assert!(result["bound"]["used"].as_f64().expect("a number") < 4.0);
}

/// A turned sum of products: a few values need more digits than most.
const TURNED: [&str; 2] = [
    "name = \"turned\"\nequations = \"f.rvir\"\n\
     [[output]]\nelements = [\"y\"]\nerror = 1e-4\n\
     [range]\na = [-1.5, 1.5]\nb = [1.0, 2.0]\nc = [0.001, 0.002]\n",
    "// robovec 1\nfunction f equations {\n  in a\n  in b\n  in c\n  out y\n\
     \x20 %s = sin(a)\n  %t = cos(a)\n  %u = %s*b + %t*c\n  y = %u*%u + b*c*%t*0.37\n}\n",
];

/// The candidates that satisfy something.
fn those(result: &Value, is_one: impl Fn(&Value) -> bool) -> Vec<&Value> {
    let all = result["candidates"].as_array().expect("a list").iter();
    all.filter(|candidate| is_one(candidate)).collect()
}

fn chosen(result: &Value) -> &Value {
    &result["candidates"][result["chosen"].as_u64().expect("one holds") as usize]
}

#[test]
fn fixed_point_and_formats_of_values_are_measured_and_chosen_where_they_can_be() {
    let [scene, equations] = TURNED;
    let (device, told) = searched(scene, Some(equations));
    let is_fixed = |one: &Value| {
        one["format"]
            .as_str()
            .is_some_and(|name| name.starts_with("fixed"))
    };
    let is_mixed = |one: &Value| {
        let program = one["program"].as_u64().expect("an index") as usize;
        !device["programs"][program]["mixture"].is_null()
    };
    for (kind, reason) in [
        (those(&device, is_fixed), "no Verilog cores for fixed point"),
        (those(&device, is_mixed), "elements compute in one format"),
    ] {
        assert!(!kind.is_empty(), "{reason}: {told}");
        for candidate in kind {
            assert_eq!(candidate["meets"], false);
            assert!(
                candidate["remark"]
                    .as_str()
                    .is_some_and(|why| why.contains(reason))
            );
            assert!(
                candidate["used"]
                    .as_f64()
                    .is_some_and(|used| 0.0 < used && used <= 1.0)
            );
            assert!(candidate["share"].as_f64().is_some_and(|share| share > 0.0));
        }
        assert!(told.contains(reason), "{told}");
    }
    let (cells, told) = searched_with(scene, Some(equations), &["--cost=cells"]);
    let cost = |one: &Value| one["cells"].as_f64().expect("a number");
    let meeting = those(&cells, |one| one["meets"] == true);
    assert!(
        meeting
            .iter()
            .all(|other| cost(chosen(&cells)) <= cost(other))
    );
    // What needs not float, or not every digit everywhere, takes less.
    assert!(cost(chosen(&cells)) < cost(chosen(&device)), "{told}");
    assert!(
        cells["challenge"]["fresh"]
            .as_u64()
            .is_some_and(|count| count > 100_000)
    );
    assert!(
        cells["challenge"]["used"]
            .as_f64()
            .is_some_and(|used| used <= 1.0)
    );
}

#[test]
fn fixed_point_that_overflows_is_told() {
    let scene = "name = \"wide\"\nequations = \"f.rvir\"\n\
                 [[output]]\nelements = [\"y\", \"z\"]\nerror = 1e-3\n\
                 [range]\na = [1e11, 1e12]\nb = [1e-12, 1e-11]\n";
    let equations = "// robovec 1\nfunction f equations {\n  in a\n  in b\n  out y\n  out z\n\
                     \x20 y = a*b\n  z = b*b\n}\n";
    let (result, told) = searched(scene, Some(equations));
    let untried = result["untried"].to_string();
    assert!(
        untried.contains("in fixed point: numbers reach 2^40 over the ranges"),
        "{untried}"
    );
    assert!(untried.contains("13 bits after the point"), "{untried}");
    assert!(
        told.contains("in fixed point: numbers reach 2^40"),
        "{told}"
    );
}

#[test]
fn a_unit_for_sines_is_the_quickest_that_does() {
    let [scene, equations] = TURNED;
    let (result, told) = searched_with(scene, Some(equations), &["--trigonometry=unit"]);
    let program = &chosen(&result)["program"];
    let program = &result["programs"][program.as_u64().expect("an index") as usize];
    let treatment = program["trigonometry"].as_str().expect("a text");
    assert!(treatment.starts_with("unit "), "{told}");
    // Alone it errs, within the tolerance, and the simulator has the same unit.
    assert!(
        program["share_of_tolerance"]
            .as_f64()
            .is_some_and(|share| 1e-3 < share && share < 1.0)
    );
    assert_eq!(result["confirmation"]["equal"], true);
    assert!(
        told.contains("no unit computes sines without an error"),
        "{told}"
    );
}

#[test]
fn what_no_machine_computes_is_told() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let path = folder.path().join("root.scene.toml");
    let scene = "name = \"root\"\nequations = \"f.rvir\"\n[range]\na = [1.0, 2.0]\n";
    std::fs::write(&path, scene).expect("it can be written");
    let equations = "// robovec 1\nfunction f equations {\n  in a\n  out y\n  y = sqrt(a)\n}\n";
    std::fs::write(folder.path().join("f.rvir"), equations).expect("it can be written");
    let output = robovec(&["fit", &path.to_string_lossy()]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(
        told.contains("no program can be placed on the machine"),
        "{told}"
    );
    assert!(
        told.contains("'--machine' takes a name of 'robovec-opt --list-machines'"),
        "{told}"
    );
}

#[test]
fn a_formulation_that_reads_more_than_the_function_is_left_out() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let model = folder.path().join("random.mbs");
    let model = model.to_string_lossy();
    let random = ["--joints=4", "--seed=3010", "-o", &model];
    said(&robovec(&[&["model", "random"][..], &random].concat()));
    let text = unfolded(&said(&robovec(&[
        "explore",
        &model,
        "--states=4",
        "--elements=4",
    ])));
    assert!(text.contains("left out formulation"), "{text}");
    assert!(text.contains(": the program reads 'dpt["), "{text}");
    assert!(text.contains("choices of the thesis"), "{text}");
}

#[test]
fn words_that_an_exploration_does_not_take_are_refused() {
    for (words, message, advice) in [
        (
            &["serial-1", "--passes=atomise"][..],
            "--passes: not for an exploration of programs",
            "for designs of machines, add '--designs'",
        ),
        (
            &["serial-1", "--adders=1", "--angle=1"],
            "--angle: not for an exploration of designs of machines",
            "for programs, leave '--plan' and the options of machines out",
        ),
        (
            &["--plan=thesis", "-o=out", "--seed=2"],
            "--seed: not for an exploration of a plan",
            "for programs, leave",
        ),
        (
            &["--plan=thesis", "-o=out", "--ratio=1"],
            "--designs and options of machines: not for an exploration of a plan",
            "add '--designs'",
        ),
        (
            &["serial-1", "--idle-watts=5", "--full-watts=3"],
            "--full-watts 3 is below --idle-watts 5",
            "expected the power with all cells in use",
        ),
        (
            &["serial-1", "--cpu-limit=9"],
            "--cpu-limit: not for an exploration of programs",
            "for a plan, add '--plan'",
        ),
        (
            &["serial-1", "--machine=thesis,solver"],
            "expected one machine for an exploration of programs",
            "for a plan, add '--plan'",
        ),
    ] {
        let output = robovec(&[&["explore"], words].concat());
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains(message) && told.contains(advice), "{told}");
    }
}
