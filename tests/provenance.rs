//! Every value of a compiled program keeps its equations and the passes that
//! made it, for any pipeline.

use robovec_framework::manager::{self, Config};
use robovec_framework::trail::{Trail, explain, find};
use robovec_ir::print::{print_definition, print_module};
use robovec_ir::{History, Machine, Module, View, parse};
use robovec_passes::registry::REGISTRY;
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

const PIPELINES: &[&str] = &[
    "$shorten",
    "atomise,fold,zero-removal,balance,cse,dce,place",
    "atomise,zero-removal,lookahead,cse,dce",
    "atomise,zero-removal,eqsat,balance,cse,dce,asap-alap",
    "atomise,zero-removal,swap,cse,dce,inline,atomise",
];

/// A file of Robotran's kind, as written from a model: its equations have
/// places.
fn read(model: &str) -> Module {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let status = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(root.join("models").join(model))
        .args(["--language", "c", "-o"])
        .arg(folder.path())
        .status()
        .expect("the program starts");
    assert!(status.success());
    let files = std::fs::read_dir(folder.path()).expect("the folder was made");
    let files = files.map(|file| file.expect("it can be read").path());
    let file = files
        .filter(|path| path.to_string_lossy().contains("dirdyna"))
        .find(|path| path.extension().is_some_and(|extension| extension == "c"))
        .expect("the equations were written");
    let bytes = std::fs::read(&file).expect("it can be read");
    let name = file.file_name().expect("a file").to_string_lossy();
    let read = robovec::robotran::read(&name, &bytes, None);
    read.expect("it is well formed").module
}

/// Every definition by name, up to its attributes.
fn definitions(module: &Module) -> HashMap<String, String> {
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    let named = function.values().filter(|(_, node)| !node.name.is_none());
    named
        .map(|(value, node)| {
            let text = print_definition(view, value);
            let marks = [" {", " @", " on ", " history "];
            let ends = marks.iter().filter_map(|mark| text.find(mark));
            let end = ends.min().unwrap_or(text.len());
            let name = node.name.display(&module.tables.symbols);
            (name, text[..end].to_owned())
        })
        .collect()
}

#[test]
fn every_value_keeps_its_equations_and_the_passes_that_made_it() {
    let machine = Machine::built_in("thesis").expect("it ships");
    for model in ["bogie.mbs", "quarter-car.mbs"] {
        let before = read(model);
        let as_read = definitions(&before);
        for text in PIPELINES {
            let pipeline = REGISTRY.pipeline(text).expect("the pipeline is sound");
            let mut module = before.clone();
            let mut trail = Trail::new();
            let mut log = Vec::new();
            let config = Config {
                histories: true,
                trail: Some(&mut trail),
                ..Config::new(&machine, &mut log)
            };
            manager::run(&mut module, &pipeline, config).expect("the passes run");
            let changed = check(&module, &as_read, text);
            assert!(changed > 10, "{model}, {text}: {changed} values are new");
            let printed = print_module(&module);
            let again = parse::parse_module("printed", &printed).expect("it reads back");
            assert!(again == module, "{model}, {text}: it reads otherwise");
            tell_outputs(&module, &trail, &machine);
        }
    }
}

/// Tests every value; returns the number of values that differ from those read.
fn check(module: &Module, as_read: &HashMap<String, String>, text: &str) -> usize {
    let function = &module.functions[0];
    let histories = function.histories.as_ref().expect("they were asked for");
    let now = definitions(module);
    let mut changed = 0;
    for ((value, node), &history) in function.values().zip(&histories.values) {
        let sources = &module.tables.sources;
        let name = node.name.display(&module.tables.symbols);
        let count = sources.places(node.sources).len();
        assert!(count > 0, "{text}: {name} comes from nowhere");
        if node.name.is_none() || as_read.get(&name) == now.get(&name) {
            continue;
        }
        changed += 1;
        let chain = histories.chain(history);
        assert!(
            history != History::NONE && !chain.is_empty(),
            "{text}: {} has no history",
            value.0
        );
        for step in chain {
            let pass = step.pass.split('{').next().unwrap_or_default();
            assert!(REGISTRY.find(pass).is_some(), "{pass} is no pass");
        }
    }
    changed
}

/// Explains every output: the explanation starts with an equation that was read
/// and ends with the present definition of the output.
fn tell_outputs(module: &Module, trail: &Trail, machine: &Machine) {
    let function = &module.functions[0];
    let view = View {
        tables: &module.tables,
        function,
    };
    for assignment in function.assignments.iter().step_by(7) {
        let name = robovec_ir::print::print_output(view, assignment.output);
        let (_, item) = find(module, trail, &name).expect("it exists");
        let account = explain(&module.tables, function, trail, machine, item);
        assert!(!account.read.is_empty() && !account.sources.is_empty());
        let now = account.now.expect("outputs stay");
        assert!(now.text.starts_with(&format!("{name} = ")), "{}", now.text);
        assert!(now.arrival + now.slack <= now.path);
    }
}
