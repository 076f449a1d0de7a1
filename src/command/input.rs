//! Reading the user's files: equations, models, scenes, pipelines, machines.
//!
//! Remarks of readers are printed here, so that no command can forget to.

use super::flags::FlagChoice;
use super::{CommandFailure, emit};
use robovec_cgen::template::{self, CodeTarget, TargetError};
use robovec_dynamics::generate::{GenerationRequest, generate_asked};
use robovec_dynamics::motion::Laws;
use robovec_explore::scene::{SceneFile, SceneSubject};
use robovec_framework::pass::TargetFolder;
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_io::files::limited::{self, FileLimit};
use robovec_io::sources::{self, EquationLanguage, ReadEquations};
use robovec_ir::diagnostic::{Diagnostic, Label, Report, clip, suggestion};
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, Operation};
use robovec_model::mbs::ReadModel;
use robovec_model::{Model, Nature};
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;
use robovec_robotran::Language;
use std::path::Path;

/// The scene, with the file's ranges for open inputs; none without either.
pub(crate) fn scene_of(read: &ReadEquations, given: Option<Scene>) -> Option<Scene> {
    if read.ranges.is_empty() {
        return given;
    }
    let mut scene = given.unwrap_or_else(|| Scene {
        name: read.name.clone(),
        ..Scene::default()
    });
    scene.ranges.add_missing(&read.ranges);
    Some(scene)
}

/// The module for a command without ranges.
///
/// # Errors
///
/// Fails when the file gives some, so that none is ignored. Limits of a model's
/// joints describe the robot and are not requested.
pub(crate) fn without_ranges(read: ReadEquations, command: &str) -> Result<Module, CommandFailure> {
    if read.ranges.is_empty() || sources::is_model_path(&read.path) {
        return Ok(read.module);
    }
    Err(CommandFailure::advised(
        format!(
            "{}: '{command}' knows no ranges of inputs, which ':pre' gives",
            read.name
        ),
        vec!["remove ':pre' to run it on any state".to_owned()],
    ))
}

/// Reads equations in any language, or generates them from a model.
pub(crate) fn equations_or_model(
    path: &Path,
    language: Option<EquationLanguage>,
    function: Option<&str>,
) -> Result<ReadEquations, CommandFailure> {
    let is_model = sources::is_model_path(path);
    if !is_model || language.is_some() {
        return equations_of(path, language, function);
    }
    let kind = function.map_or(Some(FunctionKind::Dirdyna), FunctionKind::with_name);
    let kind = kind.ok_or_else(|| no_such_kind(function.unwrap_or_default()))?;
    let read = model_for(path, Some(kind))?;
    let module = generate_asked(&read.model, &GenerationRequest::new(kind))
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
    Ok(ReadEquations {
        ranges: sources::limits_of_joints(&read.model),
        ..ReadEquations::of(path, module)
    })
}

/// Random states, those of a scene if there is one.
pub(crate) fn states(scene: Option<&Scene>, seed: u64) -> States {
    scene.map_or_else(|| States::new(seed), |scene| scene.states(seed))
}

/// The failure for a function that no model gives.
pub(crate) fn no_such_kind(name: &str) -> CommandFailure {
    let names = FunctionKind::ALL.map(FunctionKind::name).join(", ");
    let message = format!("no function '{name}' is generated");
    CommandFailure::advised(message, vec![format!("functions of a model: {names}")])
}

/// Reads equations in any language, also where no function sets an output.
pub(crate) fn equations_or_stubs(
    path: &Path,
    language: Option<EquationLanguage>,
) -> Result<ReadEquations, CommandFailure> {
    let read = sources::equations_or_stubs(path, language, None);
    Ok(told(read?))
}

pub(crate) fn equations(
    path: &Path,
    language: Option<EquationLanguage>,
) -> Result<ReadEquations, CommandFailure> {
    equations_of(path, language, None)
}

/// Reads equations in any language; of FPCore the function of a name.
pub(crate) fn equations_of(
    path: &Path,
    language: Option<EquationLanguage>,
    function: Option<&str>,
) -> Result<ReadEquations, CommandFailure> {
    let read = sources::equations(path, language, function);
    Ok(told(read?))
}

/// Languages of equations, as words of the command line.
pub(crate) const LANGUAGES: [FlagChoice<EquationLanguage>; 5] = [
    (
        &["c"],
        "Robotran's C",
        EquationLanguage::Robotran(Language::C),
    ),
    (
        &["matlab"],
        "Robotran's Matlab",
        EquationLanguage::Robotran(Language::Matlab),
    ),
    (
        &["python"],
        "Robotran's Python",
        EquationLanguage::Robotran(Language::Python),
    ),
    (&["rvir"], "robovec's own text", EquationLanguage::Rvir),
    (&["fpcore"], "FPCore, of FPBench", EquationLanguage::Fpcore),
];

/// Prints the remarks of the reader.
fn told(read: ReadEquations) -> ReadEquations {
    emit(&read.warnings);
    read
}

pub(crate) fn model(path: &Path) -> Result<ReadModel, CommandFailure> {
    model_for(path, None)
}

/// Reads a model for a function, whose omissions it prints, too.
pub(crate) fn model_for(
    path: &Path,
    kind: Option<FunctionKind>,
) -> Result<ReadModel, CommandFailure> {
    let read = sources::model(path)?;
    match kind {
        Some(kind) => emit(&read.warnings_for(kind)),
        None => emit(&read.warnings),
    }
    Ok(read)
}

/// Makes joints driven; gives their places. A law moves them, or nothing does.
pub(crate) fn drive(model: &mut Model, names: &[String]) -> Result<Vec<usize>, CommandFailure> {
    let mut places = Vec::with_capacity(names.len());
    for name in names {
        let Some(place) = model.joints.iter().position(|joint| joint.name == *name) else {
            let known = model.joints.iter().map(|joint| joint.name.as_str());
            let near = suggestion(name, known);
            let message = format!("the model has no joint '{}'", clip(name));
            return Err(CommandFailure::advised(message, near.into_iter().collect()));
        };
        model.joints[place].nature = Nature::Driven;
        places.push(place);
    }
    Ok(places)
}

/// Reads a scene, and the files that it names.
pub(crate) fn scene(path: &Path) -> Result<SceneFile, CommandFailure> {
    let file = SceneFile::load(path)?;
    emit(&file.warnings);
    Ok(file)
}

/// The laws of a scene's motion, if any, for its model with joints held.
pub(crate) fn laws_of(file: &SceneFile, folder: &Path) -> Result<Laws, CommandFailure> {
    let SceneSubject::Model(subject) = &file.subject else {
        unreachable!("the reader of scenes refuses [motion] without a model");
    };
    let named = file.motion.as_ref().and_then(|motion| motion.laws.as_ref());
    match named {
        None => Ok(Laws::of_model(&subject.model)),
        Some(named) => laws(&subject.model, &folder.join(named)),
    }
}

/// Laws of forces and driven motions of a model.
pub(crate) fn laws(model: &Model, path: &Path) -> Result<Laws, CommandFailure> {
    let text = text(path, &limited::LAWS)?;
    Laws::parse(model, &text).map_err(|diagnostics| {
        CommandFailure(Report::of(&path.display().to_string(), text, diagnostics))
    })
}

pub(crate) fn text(path: &Path, limit: &FileLimit) -> Result<String, CommandFailure> {
    sources::text(path, limit).map_err(CommandFailure)
}

/// The folder of a file; empty for one in the current folder.
pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The machine requested, else that of the scene, else the usual one.
pub(crate) fn machine_for(
    asked: Option<&str>,
    scene: Option<&Scene>,
) -> Result<Machine, CommandFailure> {
    let wished = scene.and_then(|scene| scene.machine.as_deref());
    machine(asked.or(wished).unwrap_or(USUAL_MACHINE))
}

/// The name of a file without folder and extension.
pub(crate) fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}

/// Reads a pipeline, from a file when it starts with `@`.
pub(crate) fn passes(text: &str) -> Result<Pipeline, CommandFailure> {
    let Some(file) = text.strip_prefix('@') else {
        return REGISTRY
            .pipeline(text)
            .map_err(|error| CommandFailure(error.0));
    };
    let content = self::text(Path::new(file), &limited::PIPELINE)?;
    REGISTRY.pipeline(&content).map_err(|error| {
        let diagnostics = error.0.diagnostics().to_vec();
        CommandFailure(Report::of(file, content, diagnostics))
    })
}

pub(crate) fn machine(name: &str) -> Result<Machine, CommandFailure> {
    sources::machine(name).map_err(CommandFailure)
}

pub(crate) fn target(folder: &Path) -> Result<TargetFolder, CommandFailure> {
    let read = |name: &str, limit: &FileLimit| {
        text(&folder.join(name), limit).map_err(|mut failure| {
            let advice =
                "a target is a folder with target.toml and template.jinja (docs/targets.md)";
            failure.0.push(Diagnostic::note().with_message(advice));
            failure
        })
    };
    let target = TargetFolder {
        name: folder.display().to_string(),
        description: read(template::DESCRIPTION, &limited::TARGET)?,
        template: read(template::TEMPLATE, &limited::TEMPLATE)?,
    };
    let Err(error) = CodeTarget::parse(&target) else {
        return Ok(target);
    };
    let notes = vec![error.advice().to_owned()];
    Err(match error {
        TargetError::Description { span, message, .. } => {
            let name = folder.join(template::DESCRIPTION).display().to_string();
            let diagnostic = Diagnostic::error()
                .with_message(message)
                .with_labels(vec![Label::primary(0, span)])
                .with_notes(notes);
            CommandFailure(Report::of(&name, target.description, vec![diagnostic]))
        }
        other => CommandFailure::advised(other.to_string(), notes),
    })
}

/// The machine where no other is named.
pub(crate) const USUAL_MACHINE: &str = "thesis";

/// The machine without whose divider nothing could be placed.
pub(crate) const WITH_DIVIDER: &str = "solver";

pub(crate) fn usual_machine(function: &Function) -> Result<&'static str, CommandFailure> {
    let mut nodes = function.nodes().iter();
    let divides = nodes.any(|node| node.operation == Operation::Div);
    if divides && machine(USUAL_MACHINE)?.kind_of(Operation::Div).is_none() {
        Ok(WITH_DIVIDER)
    } else {
        Ok(USUAL_MACHINE)
    }
}

/// Advice where nothing could be placed on a machine.
pub(crate) fn other_machine() -> Vec<String> {
    let advice = "'--machine' takes a name of 'robovec-opt --list-machines' or a machine file, where \
                  operations can be added to an element";
    vec![advice.to_owned()]
}

pub(crate) fn passes_or_empty(text: Option<&str>) -> Result<Pipeline, CommandFailure> {
    match text {
        None => Ok(Pipeline::default()),
        Some(text) => passes(text),
    }
}
