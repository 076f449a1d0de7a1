//! Parts that scenes leave out: measured against mechanics, written as judged,
//! refused where they are meaningless.

use crate::reference::random::{self, ModelDraw, Recipe};
use crate::support::programs::{assert_fits_a_screen, robovec, stderr, unfolded};
use robovec::explore::program::{transformed_by, view};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::Model;
use robovec::model::build::{BASE, ModelBuilder};
use robovec::model::family::built_in;
use robovec::model::mbs::{read_mbs, write_mbs};
use robovec::model::{Axis, JointKind};
use robovec::motion::{
    EVENT_TOLERANCE, IntegrationMethod, Laws, SimulationPlan, SimulationRun, simulate,
};
use robovec::neglect::{self, NeglectError, NeglectFindings, NeglectTask};
use robovec::robotran::FunctionKind;
use robovec::scene::{PIPELINE, SceneFile, read};
use robovec_ir::Machine;
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_num::arithmetic::Binary64;
use robovec_num::random::Random;
use std::fs;
use std::path::Path;

/// A scene file in a folder, searched.
fn searched(folder: &Path, name: &str) -> NeglectFindings {
    try_searched(folder, name).unwrap_or_else(|error| panic!("{error}"))
}

fn try_searched(folder: &Path, name: &str) -> Result<NeglectFindings, NeglectError> {
    let text = fs::read_to_string(folder.join(name)).expect("it was written");
    let file =
        read(name, &text, folder).unwrap_or_else(|report| panic!("{}", report.render_plain()));
    let wish = file.motion.clone().expect("it has the section");
    let laws = wish.laws.expect("it has laws");
    let laws = fs::read_to_string(folder.join(laws)).expect("they were written");
    let robovec::scene::SceneSubject::Model(subject) = &file.subject else {
        panic!("a scene of a model");
    };
    let task = NeglectTask {
        file: &file,
        name,
        text: &text,
        folder,
        laws: Laws::parse(&subject.model, &laws).expect("laws"),
        machine: &Machine::built_in("solver").expect("it ships"),
    };
    neglect::neglect(&task, &|_| ())
}

/// Two carts in line, the second on the first.
const CARTS: [f64; 2] = [1.0, 0.15];
const SPRINGS: [f64; 2] = [10.0, 300.0];

fn carts() -> Model {
    let mut builder = ModelBuilder::new("carts");
    let slide = [JointKind::Prismatic(Axis::X)];
    let first = builder.body("First", BASE.origin(), &slide);
    builder.mass(first, CARTS[0], [0.0; 3], [0.0; 6]);
    let second = builder.body("Second", first.origin(), &slide);
    builder.mass(second, CARTS[1], [0.0; 3], [0.0; 6]);
    builder.finish()
}

/// The position of the first cart, which starts at `start` and at rest, by the
/// two modes of `M x'' + K x = 0` with `M = [m1 + m2, m2; m2, m2]` and
/// `K = diag(k1, k2)`.
fn first_cart(start: f64, time: f64) -> f64 {
    let ([m1, m2], [k1, k2]) = (CARTS, SPRINGS);
    // det(K - w^2 M) = m1 m2 w^4 - (k1 m2 + k2 (m1 + m2)) w^2 + k1 k2.
    let (a, b, c) = (m1 * m2, -(k1 * m2 + k2 * (m1 + m2)), k1 * k2);
    let root = (b * b - 4.0 * a * c).sqrt();
    let squares = [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)];
    // The second row gives x2 = r x1 in each mode.
    let ratios = squares.map(|square| square * m2 / (k2 - square * m2));
    // Amplitudes p, q with p + q = start and r1 p + r2 q = 0.
    let q = start * ratios[0] / (ratios[0] - ratios[1]);
    let p = start - q;
    p * (squares[0].sqrt() * time).cos() + q * (squares[1].sqrt() * time).cos()
}

/// Locking the second cart makes the first a mass of both on its spring: the
/// error over time is that between two solutions in closed form.
#[test]
fn a_locked_joint_costs_what_mechanics_says() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = "model = 'carts.mbs'\nfunction = 'accelred'\nparameters = 'from-model'\n\
                 [[output]]\nelements = 'qdd[T1_First]'\n\
                 [motion]\nlaws = 'laws.toml'\ntime = 4.0\nerror = 0.5\n\
                 start = { T1_First = 0.1 }\n[neglect]\nkinds = ['joints']\n";
    let laws = format!(
        "[[joint]]\nname = 'T1_First'\nstiffness = {:?}\nneutral = 0.0\n\
         [[joint]]\nname = 'T1_Second'\nstiffness = {:?}\n",
        SPRINGS[0], SPRINGS[1]
    );
    for (name, text) in [
        ("carts.mbs", write_mbs(&carts())),
        ("carts.scene.toml", scene.to_owned()),
        ("laws.toml", laws),
    ] {
        fs::write(folder.path().join(name), text).expect("writable");
    }
    let findings = searched(folder.path(), "carts.scene.toml");
    let samples = (0..=500).map(|sample| 4.0 * f64::from(sample) / 500.0);
    let full: Vec<f64> = samples.clone().map(|time| first_cart(0.1, time)).collect();
    let mean = full.iter().sum::<f64>() / full.len() as f64;
    let scale = full.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    let slow = (SPRINGS[0] / (CARTS[0] + CARTS[1])).sqrt();
    let locked = samples.map(|time| 0.1 * (slow * time).cos());
    let apart = locked.zip(&full).map(|(a, b)| (a - b).abs());
    let expected = apart.fold(0.0, f64::max) / scale;
    assert!(expected > 1e-3, "the second cart matters: {expected}");
    let [(name, found_scale)] = findings.watched.as_slice() else {
        panic!("one joint is watched");
    };
    assert_eq!(name, "T1_First");
    assert!((found_scale / scale - 1.0).abs() < 1e-4);
    let alone = findings
        .findings
        .iter()
        .find(|one| one.what == "joint T1_Second");
    let found = alone
        .expect("it was tried")
        .alone
        .clone()
        .expect("it moves");
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{found} for {expected}"
    );
}

/// Duration of the random motions, s, and the error that they allow.
const RANDOM_TIME: f64 = 1.5;
const RANDOM_ERROR: f64 = 0.02;

/// The motion of a scene file under a file of laws, from a start.
fn motion_of(folder: &Path, scene: &str, laws: &str, start: &[(usize, f64)]) -> SimulationRun {
    let file = SceneFile::load(&folder.join(scene));
    let file = file.unwrap_or_else(|report| panic!("{}", report.render_plain()));
    let robovec::scene::SceneSubject::Model(subject) = &file.subject else {
        panic!("a scene of a model");
    };
    let laws = fs::read_to_string(folder.join(laws)).expect("written");
    let laws = Laws::parse(&subject.model, &laws).expect("laws");
    let machine = Machine::built_in("solver").expect("it ships");
    let tolerance = 1e-8;
    let plan = SimulationPlan {
        duration: RANDOM_TIME,
        samples: 300,
        method: IntegrationMethod::DormandPrince {
            relative: tolerance,
            absolute: tolerance,
        },
        step_limit: 1_000_000,
        event_tolerance: EVENT_TOLERANCE,
    };
    let run = file.moving((&laws, &machine), start, None, |system, initial| {
        simulate(system, initial, &plan, &mut |_| ())
    });
    run.unwrap_or_else(|error| panic!("{scene}: {error}"))
}

/// A random tree on springs and dampers: its scene is searched, then every
/// corner of the starts and 50 draws inside compare the files that are written.
/// The number of parts left out, the largest error and the largest that the
/// search found; `None` where the watched joint rests.
fn random_errors(seed: u64) -> Option<(usize, f64, f64)> {
    let mut random = Random::new(seed);
    let recipe = Recipe {
        bodies: 2 + random.below(3),
        zeros: 0.3,
        massless: false,
        driven: false,
        placed: false,
        cuts: 0,
        devices: 0,
    };
    let model = random::model(&mut random, &recipe);
    let mut laws = String::new();
    for joint in &model.joints {
        let (stiffness, damping) = (random.between(20.0, 400.0), random.between(0.5, 4.0));
        let name = &joint.name;
        laws += &format!(
            "[[joint]]\nname = '{name}'\nstiffness = {stiffness:?}\ndamping = {damping:?}\n\
             neutral = 0.0\n"
        );
    }
    let count = model.joints.len();
    let mut free: Vec<usize> = (0..2 + random.below(2))
        .map(|_| random.below(count))
        .collect();
    free.sort_unstable();
    free.dedup();
    let ranges: Vec<(usize, [f64; 2])> = free
        .iter()
        .map(|&joint| {
            (
                joint,
                [-random.between(0.05, 0.5), random.between(0.05, 0.5)],
            )
        })
        .collect();
    let named = |&(joint, range): &(usize, [f64; 2])| format!("j{} = {range:?}", joint + 1);
    let start: Vec<String> = ranges.iter().map(named).collect();
    let watched = random.below(count);
    let name = &model.joints[watched].name;
    let scene = format!(
        "model = 'random.mbs'\nfunction = 'accelred'\nparameters = 'from-model'\n\
         [[output]]\nelements = 'qdd[{name}]'\n\
         [motion]\nlaws = 'laws.toml'\ntime = {RANDOM_TIME:?}\nerror = {RANDOM_ERROR}\n\
         start = {{ {} }}\n",
        start.join(", ")
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("room");
    write("random.mbs", &write_mbs(&model));
    write("random.scene.toml", &scene);
    write("laws.toml", &laws);
    let findings = match try_searched(folder.path(), "random.scene.toml") {
        Ok(findings) => findings,
        Err(NeglectError::Motion(_)) => return None,
        Err(error) => panic!("seed {seed}: {error}"),
    };
    for (name, text) in neglect::files(&findings, "less", None) {
        write(&name, &text);
    }
    let scale = findings.watched[0].1;
    let mut worst: f64 = 0.0;
    for draw in 0..(1 << ranges.len()) + 50 {
        let place = |(bit, &(joint, [low, high])): (usize, &(usize, [f64; 2]))| {
            let position = if draw >= 1 << ranges.len() {
                random.between(low, high)
            } else if draw >> bit & 1 == 1 {
                high
            } else {
                low
            };
            (joint, position)
        };
        let start: Vec<(usize, f64)> = ranges.iter().enumerate().map(place).collect();
        let full = motion_of(folder.path(), "random.scene.toml", "laws.toml", &start);
        let less = motion_of(folder.path(), "less.scene.toml", "less.laws.toml", &start);
        worst = worst.max(full.distance(&less, watched) / scale);
    }
    let taken = findings.findings.iter().filter(|one| one.taken.is_some());
    let searched = findings.searched.expect("starts vary");
    Some((taken.count(), worst, searched.worst))
}

fn assert_random_scenes_hold(count: usize) {
    let mut over = Vec::new();
    let found = (1..).filter_map(|seed| Some((seed, random_errors(seed)?)));
    for (seed, (taken, worst, searched)) in found.take(count) {
        println!("seed {seed}: {taken} left out, {worst:.2e}, search {searched:.2e}");
        assert!(searched <= RANDOM_ERROR, "seed {seed}: {searched}");
        if worst > RANDOM_ERROR {
            over.push((seed, worst));
        }
    }
    assert!(over.is_empty(), "over {RANDOM_ERROR}: {over:?}");
}

/// The omissions stay within the allowed error from corners and from starts
/// that the search has not compared.
#[test]
fn random_scenes_stay_within_their_allowance() {
    assert_random_scenes_hold(3);
}

/// The same for 20 scenes.
#[test]
#[ignore = "minutes"]
fn twenty_random_scenes_stay_within_their_allowance() {
    assert_random_scenes_hold(20);
}

/// The example of the leg, for a short motion and few kinds.
const SHORT: [(&str, &str); 3] = [
    (
        "[motion]",
        "[neglect]\nkinds = ['joints', 'angles', 'links']\n\n[motion]",
    ),
    ("time = 10.0", "time = 0.4"),
    ("../", "EXAMPLES/"),
];

/// The written files agree with the judged scene: the scene read from them has
/// the operations of the report, the model without the forces left out and the
/// remaining error; its laws read back.
#[test]
fn what_is_written_is_what_was_judged() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let examples = root.join("examples");
    let mut text =
        fs::read_to_string(examples.join("scenes/leg-swing.scene.toml")).expect("it ships");
    for (from, to) in SHORT {
        text = text.replace(from, to);
    }
    let text = text.replace("EXAMPLES", &examples.to_string_lossy());
    let scene = folder.path().join("leg.scene.toml");
    fs::write(&scene, text).expect("writable");
    let out = folder.path().join("out");
    let told = robovec(&[
        "fit",
        "--reduce",
        &scene.to_string_lossy(),
        "-o",
        &out.to_string_lossy(),
    ]);
    assert!(told.status.success(), "{}", stderr(&told));
    let report = String::from_utf8_lossy(&told.stdout).into_owned();
    assert_fits_a_screen(&report);
    for name in ["reduce.svg", "reduce.html"] {
        let drawn = fs::read_to_string(out.join(name)).expect("written");
        assert!(drawn.contains("R2_Thigh"), "{name}");
    }
    let reduced = SceneFile::load(&out.join("leg-reduced.scene.toml"))
        .unwrap_or_else(|report| panic!("{}", report.render_plain()));
    assert!(
        !reduced.scene.joints.is_empty(),
        "joints are locked: {report}"
    );
    let motion = reduced.motion.as_ref().expect("it keeps its motion");
    assert_eq!(
        motion.laws.as_deref(),
        Some(Path::new("leg-reduced.laws.toml"))
    );
    assert!(
        motion.error > 0.0 && motion.error < 0.02,
        "{}",
        motion.error
    );
    let module = reduced.module().expect("equations");
    let machine = Machine::built_in("solver").expect("it ships");
    let program =
        transformed_by(&module, PIPELINE, &machine, Some(&reduced.scene)).expect("passes");
    let counts = Counts::of(view(&program).function);
    let line = report
        .lines()
        .find(|line| line.starts_with("with things left out"));
    let line = line.expect("the report has it");
    let told: Vec<&str> = line["with things left out".len()..]
        .split_whitespace()
        .collect();
    assert_eq!(told[0], (counts.operations + counts.sin_cos).to_string());
    let model = fs::read(out.join("leg-reduced.mbs")).expect("written");
    let model = read_mbs("leg-reduced.mbs", &model).expect("a model").model;
    let laws = fs::read_to_string(out.join("leg-reduced.laws.toml")).expect("written");
    let robovec::scene::SceneSubject::Model(subject) = &reduced.subject else {
        panic!("a scene of a model");
    };
    assert_eq!(subject.general, model);
    let laws = Laws::parse(&subject.model, &laws).expect("laws");
    assert_eq!(Laws::parse(&subject.model, &laws.to_text(&model)), Ok(laws));
}

/// The largest difference that taking an angle as small makes to M and c of
/// the double pendulum in a state.
fn small_difference(model: &Model, angle: f64) -> f64 {
    let mut request = GenerationRequest::new(FunctionKind::Dirdyna);
    let exact = generate(model, &request).expect("equations");
    request.options.small_angles = vec![1];
    let small = generate(model, &request).expect("equations");
    let results = [&exact, &small].map(|module| {
        let function = view(module).function;
        let sines = function
            .nodes()
            .iter()
            .filter(|node| node.operation.is_trigonometric());
        let inputs: Vec<f64> = (0..function.input_len())
            .map(|place| {
                let (array, indices, _) = function.input_element(robovec_ir::Input(place as u32));
                match (module.tables.symbols.text(array.name), indices[0]) {
                    ("q", 2) => angle,
                    ("q", _) => 0.3,
                    ("qd", _) => 0.7,
                    ("frc" | "trq", _) => 0.0,
                    _ => 1.0 + 0.1 * f64::from(indices[0]),
                }
            })
            .collect();
        (sines.count(), evaluate(function, &Binary64, &inputs))
    });
    let [(exact_sines, exact), (small_sines, small)] = results;
    assert_eq!(exact_sines, small_sines + 2, "one sine and one cosine less");
    let apart = exact.iter().zip(&small).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max)
}

/// Small angles leave out second-order terms.
#[test]
fn small_angles_err_by_their_square() {
    let model = built_in("double-pendulum").expect("a family");
    let ratio = small_difference(&model, 0.02) / small_difference(&model, 0.01);
    assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
}

/// A scene without the section, and one whose watched joint rests.
#[test]
fn what_cannot_be_judged_is_told() {
    let refused = |scene: &str, words: &[&str]| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("carts.mbs"), write_mbs(&carts())).expect("writable");
        let path = folder.path().join("carts.scene.toml");
        let text = format!("model = 'carts.mbs'\nfunction = 'accelred'\n{scene}");
        fs::write(&path, text).expect("writable");
        let output = robovec(&["fit", "--reduce", &path.to_string_lossy()]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        for word in words {
            assert!(message.contains(word), "no '{word}' in\n{message}");
        }
    };
    refused("", &["no section [motion]", "see docs/scenes.md"]);
    refused(
        "[[output]]\nelements = 'qdd[1]'\n[motion]\n",
        &["'T1_First' does not move", "start = {"],
    );
    refused(
        "[motion]\nwatch = 'T1_Frist'\n",
        &["did you mean 'T1_First'"],
    );
    refused("[neglect]\nkinds = 'joint'\n", &["did you mean 'joints'"]);
}

/// Choice of `fit` for the double pendulum, limited by its motion alone.
fn fitted_over_time(limits: &str) -> (serde_json::Value, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let scene = format!(
        "model = '{}/models/double-pendulum.mbs'\nfunction = 'accelred'\n\
         parameters = 'from-model'\n\
         [[output]]\nelements = 'qdd'\n\
         [bind]\nQq = 0.0\nfrc = 0.0\ntrq = 0.0\n\
         [range]\nq = [-1.0, 1.0]\nqd = [-5.0, 5.0]\n\
         [motion]\ntime = 1.0\n{limits}",
        examples.display()
    );
    let path = folder.path().join("swing.scene.toml");
    fs::write(&path, scene).expect("writable");
    let out = folder.path().join("out");
    let words = ["--formulation=recursive", "--states=64"];
    let path = path.to_string_lossy().into_owned();
    let out_word = out.to_string_lossy().into_owned();
    let told = robovec(&[&["fit", &path, "-o", &out_word], &words[..]].concat());
    assert!(told.status.success(), "{}", stderr(&told));
    let text = String::from_utf8_lossy(&told.stdout);
    assert_fits_a_screen(&text);
    let text = unfolded(&text);
    assert!(text.contains(" allowed in 1 s"), "{text}");
    let json = fs::read_to_string(out.join("fit.json")).expect("written");
    (serde_json::from_str(&json).expect("JSON"), text)
}

/// A scene whose only limit is an error over time gets a mantissa that keeps
/// it and is hardly wider than needed.
#[test]
fn an_error_over_time_chooses_a_format() {
    let (json, _) = fitted_over_time("error = 1e-4\n");
    let error = json["motion"]["error"].as_f64().expect("an error");
    assert!(error <= 1e-4, "{error}");
    assert!(error > 1e-6, "a wider format than needed: {error}");
    let drifted = json["drifted"].as_u64().expect("a number");
    assert!(drifted > 0, "narrower ones were tried");
    // The chosen one is as cheap as any that was not refused, within the
    // uncertainty of costs.
    let chosen = json["chosen"].as_u64().expect("one holds") as usize;
    let candidates = json["candidates"].as_array().expect("a list");
    let share = |candidate: &serde_json::Value| candidate["share"].as_f64().expect("a number");
    let meeting = candidates.iter().filter(|one| one["meets"] == true);
    assert!(
        meeting
            .map(share)
            .all(|other| share(&candidates[chosen]) <= 1.05 * other)
    );
    let cheaper = candidates
        .iter()
        .filter(|one| share(one) < share(&candidates[chosen]));
    assert!(
        cheaper.count() as u64 >= drifted,
        "{drifted} were cheaper and refused"
    );
}

/// A limit of the drift of energy needs more digits than a loose limit of the
/// motion, and the drift is within it.
#[test]
fn a_drift_of_energy_chooses_a_format() {
    let digits = |json: &serde_json::Value| {
        let chosen = json["chosen"].as_u64().expect("one holds") as usize;
        let format = json["candidates"][chosen]["format"].as_str();
        let format: robovec_ir::Format = (format.and_then(|text| text.parse().ok())).expect("one");
        format.significand()
    };
    let (loose, _) = fitted_over_time("error = 0.1\n");
    let (strict, text) = fitted_over_time("error = 0.1\nenergy = 1e-5\n");
    let drift = strict["motion"]["energy"]["drift"]
        .as_f64()
        .expect("a drift");
    assert!(drift > 1e-8 && drift <= 1e-5, "{drift}");
    assert!(text.contains("; energy "), "{text}");
    assert!(digits(&strict) > digits(&loose) + 4);
    assert_eq!(loose["motion"]["energy"], serde_json::Value::Null);
}
