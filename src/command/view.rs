//! `robovec view`: a compilation as a page for the browser.

use super::flags::{SEED, choice, whole};
use super::opt::select;
use super::{CommandFailure, input, output, rules};
use clap::Args;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_framework::trail::{self, Trail};
use robovec_io::files::{Replace, limited};
use robovec_io::sources::{self, EquationLanguage, ReadEquations};
use robovec_ir::View;
use robovec_ir::diagnostic::counted;
use robovec_view::report::{PassRunRecord, ReadCounts};
use robovec_view::{ModelText, ViewedRun};
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

/// Write a page for the browser that shows a compilation: passes side by side,
/// the origin of values, the longest path, the schedule, errors
#[derive(Args, Debug)]
pub(super) struct ViewArguments {
    /// File of equations, or model (.mbs, .urdf, .xml)
    file: PathBuf,
    /// Pipeline, e.g. atomise,balance,place; @FILE reads it from a file
    #[arg(long, value_name = "PIPELINE", default_value = "$shorten,place")]
    passes: String,
    /// Page to write; by default NAME.html in the current folder
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Language of the file, if its name does not show it
    #[arg(long = "input-language", alias = "language", value_name = "LANGUAGE",
        value_parser = choice(&input::LANGUAGES))]
    language: Option<EquationLanguage>,
    /// Model (.mbs, .urdf, .xml) that the equations come from, to show its joints
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Only this function; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Machine to compile for: a name or a .toml file; by default the scene's,
    /// or thesis
    #[arg(long)]
    machine: Option<String>,
    /// Scene (.scene.toml) that describes the use of the functions
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Additional rewriting rules
    #[arg(long, value_name = "FILE")]
    rules: Vec<String>,
    /// After every pass, check at N random points that the function is
    /// unchanged
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "4",
          require_equals = true, add = whole(1, 1_000_000, "every pass is checked at every point"))]
    check_each: Option<u32>,
    /// Seed of all random points and states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Also write the dataflow graph of the last state, for Graphviz
    #[arg(long, value_name = "FILE")]
    dot: Option<PathBuf>,
    /// Limit the graph to the operations that a value (%OM16) or an output
    /// (M[1,2]) depends on
    #[arg(long, value_name = "VALUE", requires = "dot")]
    value: Option<String>,
    /// Also write the time of the passes and the schedule as trace events (JSON), for Perfetto
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
}

pub(super) fn run(arguments: &ViewArguments) -> Result<String, CommandFailure> {
    let pipeline = input::passes(&arguments.passes)?;
    let rules = rules::sound(&arguments.rules, true)?;
    let given = match &arguments.scene {
        Some(path) => Some(input::scene(path)?.scene),
        None => None,
    };
    let machine = input::machine_for(arguments.machine.as_deref(), given.as_ref())?;
    let function = arguments.function.as_deref();
    let mut read = input::equations_or_model(&arguments.file, arguments.language, function)?;
    if let Some(name) = function {
        select(&mut read.module, name)?;
    }
    let scene = input::scene_of(&read, given);
    let counts = ReadCounts::of(&read.module);
    let files = equations(&mut read, arguments);
    let model = model(arguments)?;
    let states = input::states(scene.as_ref(), arguments.seed);
    let mut trail = Trail::new();
    let mut remarks = io::sink();
    let config = Config {
        rules: Some(&rules),
        check_each: arguments.check_each,
        rounding: Some(0),
        states: states.clone(),
        scene: scene.as_ref(),
        trail: Some(&mut trail),
        ..Config::new(&machine, &mut remarks)
    };
    let outcome = manager::run(&mut read.module, &pipeline, config)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let viewed = ViewedRun {
        module: &read.module,
        trail: &trail,
        passes: &PassRunRecord::of(&outcome),
        machine: &machine,
        states: &states,
        files: &files,
        model: model.as_ref(),
        pipeline: &arguments.passes,
        read: counts,
    };
    write(arguments, &read, &viewed, scene.as_ref())
}

/// The text of the equations with its name; a model's are printed first.
fn equations(read: &mut ReadEquations, arguments: &ViewArguments) -> Vec<(String, String)> {
    let name = if sources::is_model_path(&arguments.file) {
        format!("equations of {}", read.name)
    } else {
        read.name.clone()
    };
    let text = robovec_view::place_lines(&mut read.module, &name);
    let text = text.or_else(|| read.text());
    text.map(|text| (name, text)).into_iter().collect()
}

/// The model that was read, or that was named beside equations.
fn model(arguments: &ViewArguments) -> Result<Option<ModelText>, CommandFailure> {
    let own = sources::is_model_path(&arguments.file).then_some(&arguments.file);
    let Some(path) = arguments.model.as_ref().or(own) else {
        return Ok(None);
    };
    let read = match own {
        // Its warnings were told when the equations were made.
        Some(path) => sources::model(path)?,
        None => input::model(path)?,
    };
    let joints = read.model.joints.iter();
    Ok(Some(ModelText {
        name: sources::display_name(path),
        // A model that is built in has no file.
        text: if path.exists() {
            input::text(path, &limited::MODEL)?
        } else {
            String::new()
        },
        joints: joints.map(|joint| joint.name.clone()).collect(),
    }))
}

/// Writes the requested files, and prints their names.
fn write(
    arguments: &ViewArguments,
    read: &ReadEquations,
    viewed: &ViewedRun<'_>,
    scene: Option<&Scene>,
) -> Result<String, CommandFailure> {
    let usual = || PathBuf::from(format!("{}.html", input::stem(&read.path)));
    let path = arguments.output.clone().unwrap_or_else(usual);
    let mut told = String::new();
    let page = robovec_view::page(viewed);
    put(&path, &page)?;
    if let Some(scene) = scene.filter(|scene| !scene.name.is_empty()) {
        let _ = writeln!(told, "scene       {}", scene.name);
    }
    for function in &read.module.functions {
        let passes = viewed.passes.iter();
        let last = passes.rev().find(|pass| pass.function == function.name);
        let _ = writeln!(told, "{}", summary(&function.name, last));
    }
    let kilobytes = page.len().div_ceil(1000);
    let _ = writeln!(told, "page        {}, {kilobytes} kB", path.display());
    if let Some(file) = &arguments.dot {
        put(file, &graph(arguments, viewed)?)?;
        let _ = writeln!(told, "graph       {}", file.display());
    }
    if let Some(file) = &arguments.trace {
        let events = robovec_view::events(viewed.module, viewed.passes, viewed.machine);
        put(file, &events)?;
        let _ = writeln!(told, "events      {}", file.display());
    }
    Ok(told)
}

fn summary(function: &str, last: Option<&PassRunRecord>) -> String {
    match last {
        None => format!("{function}: no pass was run"),
        Some(last) => format!(
            "{function}: {}, longest path {}",
            counted(last.operations, "operation"),
            counted(last.asap_cycle, "cycle")
        ),
    }
}

/// Graph of the requested outputs, else of all outputs of the first function.
fn graph(arguments: &ViewArguments, viewed: &ViewedRun<'_>) -> Result<String, CommandFailure> {
    let module = viewed.module;
    let (index, item) = match &arguments.value {
        None => (0, None),
        Some(asked) => {
            let found = trail::find(module, viewed.trail, asked);
            let (index, item) = found
                .map_err(|error| CommandFailure::advised(error.to_string(), vec![error.help]))?;
            (index, Some(item))
        }
    };
    let Some(function) = module.functions.get(index) else {
        return Err(CommandFailure::plain("there is no function to draw"));
    };
    let tables = &module.tables;
    Ok(robovec_view::dot(
        View { tables, function },
        viewed.machine,
        item,
    ))
}

fn put(path: &Path, text: &str) -> Result<(), CommandFailure> {
    output::write_over(path, Replace::Results, |writer| {
        writer.write_all(text.as_bytes())
    })
}
