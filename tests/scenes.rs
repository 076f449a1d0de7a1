//! Scenes: programs for them are small, right, and reported; mistakes in them
//! are reported too.

use crate::support::files::{compare_with_record, each, stem, tree};
use crate::support::programs::{robovec, stderr};
use robovec::generate::{Formulation, GenerationRequest, Options, generate};
use robovec::robotran::FunctionKind;
use robovec::scene::{PIPELINE, SceneFile, SceneSubject, USUAL, read};
use robovec_framework::manager::{self, Config};
use robovec_framework::pass::{Context, NestedReport, Pass};
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_framework::scene::Scene;
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Function, Input, Machine, Module, View};
use robovec_num::arithmetic::{Arithmetic, Binary64};
use robovec_num::double_double::DoubleDouble;
use robovec_passes::registry::REGISTRY;
use robovec_rules::RuleSet;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes")
}

fn load(name: &str) -> SceneFile {
    let path = folder().join(name);
    SceneFile::load(&path).unwrap_or_else(|report| panic!("{}", report.render_plain()))
}

/// A scene that is an example with something replaced.
fn changed(name: &str, changes: &[(&str, &str)]) -> SceneFile {
    let mut text = std::fs::read_to_string(folder().join(name)).expect("it ships");
    for (from, to) in changes {
        assert!(text.contains(from), "the example does not say {from:?}");
        text = text.replacen(from, to, 1);
    }
    read(name, &text, &folder()).unwrap_or_else(|report| panic!("{}", report.render_plain()))
}

fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships")
}

/// Runs a pipeline under the check.
fn compile(mut module: Module, passes: &str, scene: Option<&Scene>) -> Module {
    let pipeline = REGISTRY.pipeline(passes).expect("a pipeline");
    let machine = thesis();
    let mut log = Vec::new();
    let base = Config::new(&machine, &mut log);
    let config = Config {
        check_each: Some(4),
        states: scene.map_or(base.states.clone(), |scene| scene.states(1)),
        scene,
        ..base
    };
    manager::run(&mut module, &pipeline, config).unwrap_or_else(|error| panic!("{error}"));
    module
}

fn operations(module: &Module) -> usize {
    let counts = module.functions.iter().map(Counts::of);
    counts.map(|counts| counts.operations).sum()
}

fn view(module: &Module) -> View<'_> {
    View {
        tables: &module.tables,
        function: &module.functions[0],
    }
}

type Element = (String, [u32; 2]);

/// The outputs of a function by name, for inputs by name; missing ones are
/// zero.
fn outputs<A: Arithmetic>(
    view: View<'_>,
    arithmetic: &A,
    given: &BTreeMap<Element, f64>,
) -> BTreeMap<Element, A::Number> {
    let function: &Function = view.function;
    let inputs: Vec<A::Number> = (0..function.input_len())
        .map(|index| {
            let (array, indices, _) = function.input_element(Input(index as u32));
            let name = view.tables.symbols.text(array.name).to_owned();
            arithmetic.literal(given.get(&(name, indices)).copied().unwrap_or(0.0))
        })
        .collect();
    let values = evaluate(function, arithmetic, &inputs);
    let names = function.assignments.iter().map(|assignment| {
        let (array, indices, _) = function.output_element(assignment.output);
        (view.tables.symbols.text(array.name).to_owned(), indices)
    });
    names.zip(values).collect()
}

/// The inputs of a function in a state, by name.
fn state(view: View<'_>, scene: &Scene, index: u32) -> BTreeMap<Element, f64> {
    let drawn = scene.states(7).draw(view, index);
    let elements = (0..drawn.len()).map(|place| {
        let (array, indices, _) = view.function.input_element(Input(place as u32));
        (view.tables.symbols.text(array.name).to_owned(), indices)
    });
    elements.zip(drawn).collect()
}

/// Four accelerations of the bogie on straight track, its parameters known:
/// at most half the operations, and the same numbers.
#[test]
fn the_bogie_on_straight_track_takes_half_the_operations() {
    let file = load("bogie-straight.scene.toml");
    let general = compile(file.general().expect("equations"), USUAL, None);
    let special = compile(
        file.module().expect("equations"),
        PIPELINE,
        Some(&file.scene),
    );
    let (all, kept) = (operations(&general), operations(&special));
    assert!(2 * kept <= all, "{kept} of {all} operations");
    assert_eq!(special.functions[0].assignments.len(), 4);
    for index in 0..20 {
        let inputs = state(view(&general), &file.scene, index);
        let reference = outputs(view(&general), &DoubleDouble, &inputs);
        let exact = outputs(view(&special), &DoubleDouble, &inputs);
        let computed = outputs(view(&special), &Binary64, &inputs);
        let norm = |map: &BTreeMap<Element, _>| {
            let values = map
                .values()
                .map(|value: &robovec_num::double_double::Double| value.high);
            values.map(f64::abs).fold(0.0, f64::max)
        };
        let size = norm(&reference);
        for (element, value) in &exact {
            let distance = (*value - reference[element]).high.abs();
            // Constants are rounded to binary64, nothing else.
            assert!(
                distance <= 1e-14 * size,
                "{element:?}: {distance:e} of {size:e}"
            );
            let distance = reference[element].distance(computed[element]);
            assert!(
                distance <= 1e-12 * size,
                "{element:?}: {distance:e} of {size:e}"
            );
        }
    }
}

/// Before constants are rounded the special function is the general one, to
/// all digits of double-double.
#[test]
fn before_constants_are_rounded_nothing_differs() {
    let file = load("bogie-straight.scene.toml");
    let general = file.general().expect("equations");
    let mut special = file.module().expect("equations");
    let witness = witness(&mut special, &file.scene);
    let tables = &special.tables;
    let witness = View {
        tables,
        function: &witness,
    };
    for index in 0..5 {
        let inputs = state(view(&general), &file.scene, index);
        let reference = outputs(view(&general), &DoubleDouble, &inputs);
        for (element, value) in outputs(witness, &DoubleDouble, &inputs) {
            let size = reference[&element].high.abs();
            let distance = (value - reference[&element]).high.abs();
            assert!(
                distance <= 1e-20 * size,
                "{element:?}: {distance:e} of {size:e}"
            );
        }
    }
}

/// Runs `specialise` and takes its witness.
fn witness(module: &mut Module, scene: &Scene) -> Function {
    let machine = thesis();
    let (rules, rewrites) = (RuleSet::default(), RewriteLimit::default());
    let mut report = NestedReport::default();
    let mut context = Context {
        tables: &mut module.tables,
        machine: &machine,
        registry: &REGISTRY,
        rules: &rules,
        scene: Some(scene),
        target: None,
        witness: &mut report.witness,
        promise: &mut report.promise,
        artifacts: &mut report.artifacts,
        statistics: &mut report.statistics,
        remarks: &mut report.remarks,
        notes: &mut report.notes,
        rewrites: &rewrites,
    };
    let info = REGISTRY.find("specialise").expect("it is registered");
    let pass: Box<dyn Pass> = (info.build)(&[]).expect("it has no options");
    let function = &mut module.functions[0];
    pass.run(function, &mut context)
        .expect("it takes equations");
    report.witness.expect("it leaves one")
}

/// Figures of docs/results-operations.md.
#[test]
fn every_part_of_a_scene_has_its_share() {
    let name = "bogie-straight.scene.toml";
    let machine = thesis();
    let file = load(name);
    let effects = robovec::scene::effects(&file, &machine).expect("it compiles");
    let counts: Vec<usize> = effects.iter().map(|effect| effect.operations).collect();
    let module = || file.general().expect("equations");
    let parameters = Scene {
        outputs: Vec::new(),
        bound: {
            let mut bound = robovec_framework::scene::Bindings::default();
            for (array, indices, number) in file.scene.bound.iter() {
                if ["dpt", "l", "m", "In", "g", "lrod"].contains(&array) {
                    bound.set(array, indices, number);
                }
            }
            bound
        },
        ..file.scene.clone()
    };
    let only_parameters = operations(&compile(module(), PIPELINE, Some(&parameters)));
    let sliced = Scene {
        outputs: file.scene.outputs.clone(),
        ..parameters
    };
    let parameters_and_slice = operations(&compile(module(), PIPELINE, Some(&sliced)));
    let [general, needed, all] = counts[..] else {
        panic!("{effects:?}");
    };
    assert!(needed < general && only_parameters < general);
    assert!(parameters_and_slice < needed.min(only_parameters));
    assert!(all < parameters_and_slice);
    insta::assert_snapshot!(
        "shares",
        format!(
            "general {general}\nneeded outputs {needed}\nparameters {only_parameters}\n\
             parameters and needed outputs {parameters_and_slice}\n\
             and straight track {all}\n"
        )
    );
}

/// A locked joint takes the force that holds it: given that force, the general
/// function has the same accelerations.
#[test]
fn locked_joints_are_joints_held_by_their_reaction() {
    let locked = "[locked]\nT2_Frame = 0\nR3_Frame = 0.01\nR1_Wheelset_Front = 0\n\n[[output]]";
    let straight = load("bogie-straight.scene.toml");
    let text =
        std::fs::read_to_string(folder().join("bogie-straight.scene.toml")).expect("it ships");
    let held: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("q = { T2") || line.starts_with("qd = { T2"))
        .collect();
    let file = changed(
        "bogie-straight.scene.toml",
        &[
            (held[0], ""),
            (held[1], ""),
            ("[[output]]\nelements", &format!("{locked}\nelements")),
            ("Qq = 0.0", ""),
        ],
    );
    let everything = Scene {
        outputs: Vec::new(),
        ..file.scene.clone()
    };
    let special = compile(
        file.module().expect("equations"),
        PIPELINE,
        Some(&everything),
    );
    let (SceneSubject::Model(subject), SceneSubject::Model(_)) = (&file.subject, &straight.subject)
    else {
        panic!("both have models");
    };
    let inverse = GenerationRequest {
        function: FunctionKind::Invdyna,
        formulation: Formulation::Recursive,
        options: Options::default(),
    };
    let inverse = generate(&subject.general, &inverse).expect("equations");
    let general = file.general().expect("equations");
    for index in 0..5 {
        let mut inputs = state(view(&general), &file.scene, index);
        let special = outputs(view(&special), &DoubleDouble, &inputs);
        for (element, value) in &special {
            inputs.insert(element.clone(), value.high);
        }
        let forces = outputs(view(&inverse), &DoubleDouble, &inputs);
        for (element, value) in forces {
            inputs.insert(element, value.high);
        }
        let general = outputs(view(&general), &DoubleDouble, &inputs);
        let values = general.values().map(|value| value.high.abs());
        let size = values.fold(0.0, f64::max);
        for (element, value) in special {
            let distance = (general[&element] - value).high.abs();
            assert!(
                distance <= 1e-9 * size,
                "{element:?}: {distance:e} of {size:e}"
            );
        }
    }
}

/// Every scene that ships compiles under the check.
#[test]
fn the_scenes_that_ship_compile() {
    let entries = std::fs::read_dir(folder()).expect("the folder is there");
    let mut names: Vec<String> = entries
        .map(|entry| {
            entry
                .expect("readable")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .filter(|name| name.ends_with(".scene.toml"))
        .collect();
    names.sort();
    assert!(names.len() >= 4);
    for name in names {
        let file = load(&name);
        let general = operations(&compile(file.general().expect("equations"), USUAL, None));
        let module = file.module().expect("equations");
        let special = operations(&compile(module, PIPELINE, Some(&file.scene)));
        assert!(special < general, "{name}: {special} of {general}");
    }
}

/// Driven joints are no unknowns, and locked ones are not even inputs.
#[test]
fn held_joints_are_no_unknowns() {
    let file = load("quarter-car-rig.scene.toml");
    let module = compile(
        file.module().expect("equations"),
        PIPELINE,
        Some(&file.scene),
    );
    let function = &module.functions[0];
    let mut read: Vec<String> = Vec::new();
    let operands = function.nodes().iter().flat_map(|node| node.operands());
    for input in operands.filter_map(|operand| operand.input()) {
        let (array, indices, _) = function.input_element(input);
        read.push(format!(
            "{}{indices:?}",
            module.tables.symbols.text(array.name)
        ));
    }
    let holds = |name: &str| read.iter().any(|other| other == name);
    assert!(
        holds("qdd[1, 0]"),
        "the acceleration of the chassis is given"
    );
    assert!(!holds("q[5, 0]") && !holds("qd[5, 0]") && !holds("qdd[5, 0]"));
    assert!(
        !read
            .iter()
            .any(|name| name.starts_with("dpt") || name.starts_with("m["))
    );
}

#[test]
fn a_scene_is_told() {
    for name in ["bogie-straight", "quarter-car-rig", "arm-torques"] {
        let path = format!("examples/scenes/{name}.scene.toml");
        let output = robovec(&["fit", "--explain", &path]);
        let message = stderr(&output);
        assert!(output.status.success(), "{message}");
        insta::assert_snapshot!(name, String::from_utf8_lossy(&output.stdout));
    }
}

#[test]
fn scenes_that_are_wrong_are_refused_with_a_caret() {
    each("tests/scenes/errors", &["toml"], |path| {
        let output = robovec(&["fit", "--explain", &path.to_string_lossy()]);
        assert_eq!(output.status.code(), Some(1));
        assert!(output.stdout.is_empty());
        let told = String::from_utf8_lossy(&output.stderr);
        compare_with_record(&tree("tests/scenes/errors"), &stem(path), &told);
    });
}

/// Every text of a scene file gets an answer from the reader.
#[test]
fn broken_scene_files_are_answered() {
    let whole =
        std::fs::read_to_string(folder().join("quarter-car-rig.scene.toml")).expect("it ships");
    let cuts = (0..whole.len())
        .step_by(37)
        .filter(|&end| whole.is_char_boundary(end));
    for end in cuts {
        if let Err(report) = read("cut", &whole[..end], &folder()) {
            assert!(!report.render_plain().is_empty());
        }
    }
    let deep = "[".repeat(100_000);
    for text in [
        format!("model = {deep}"),
        format!("{deep}\n"),
        "\u{0}\u{1}".to_owned(),
        "model = \"../models/bogie.mbs\"\n[range]\nq = { all = [-1e400, 1] }".to_owned(),
        "model = \"../models/bogie.mbs\"\n[range]\nq = { all = [1e-400, 1] }".to_owned(),
        "model = \"../models/bogie.mbs\"\n[bind]\nq = 0xffffffffffffffffffffff".to_owned(),
        "equations = \"bogie-straight.scene.toml\"".to_owned(),
        "model = \"bogie-straight.scene.toml\"".to_owned(),
        "model = \"../models\"".to_owned(),
    ] {
        let report = read("broken", &text, &folder()).expect_err("it is wrong");
        assert!(!report.render_plain().is_empty());
    }
}

/// Limits of joints are the weakest source for positions: an entry of the scene
/// about the same joint has priority.
#[test]
fn positions_of_a_robot_lie_within_its_limits() {
    let scene = load("arm-torques.scene.toml");
    let range = |joint: u32| scene.scene.ranges.get("q", [joint, 0]);
    assert_eq!(range(1), Some([-2.9, 2.9]));
    assert_eq!(range(4), Some([-3.0, 0.1]));
    assert_eq!(range(6), Some([0.2, 1.8]));
    let all = ("q = { joint_6 = [0.2, 1.8] }", "q = [-9, 9]");
    let scene = changed("arm-torques.scene.toml", &[all]);
    assert_eq!(scene.scene.ranges.get("q", [6, 0]), Some([-9.0, 9.0]));
    let free = ("[[output]]", "free = [\"q[1]\"]\n\n[[output]]");
    let scene = changed("arm-torques.scene.toml", &[free]);
    assert_eq!(scene.scene.ranges.get("q", [1, 0]), None);
}
