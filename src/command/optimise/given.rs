//! Starts of a search, from the user's arguments.

use super::OptimiseArguments;
use crate::command::{CommandFailure, input, opt, subjects};
use robovec_dynamics::generate::{GenerationRequest, generate_asked};
use robovec_explore::optimise::start::{self, OptimisationStart};
use robovec_explore::scene::{SceneFile, SceneSubject};
use robovec_framework::scene::Scene;
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use std::path::{Path, PathBuf};

/// Inputs of the user, read.
pub(super) struct GivenStarts {
    pub(super) starts: Vec<OptimisationStart>,
    /// Formulations that are not the function that came in, and why.
    pub(super) left: Vec<(String, String)>,
    pub(super) scene: Option<Scene>,
    /// The model that formulations are made from, as a word of a command.
    pub(super) model: String,
    /// The C file of the equations.
    pub(super) file: Option<PathBuf>,
}

pub(super) fn given(arguments: &OptimiseArguments) -> Result<GivenStarts, CommandFailure> {
    if let Some(scene) = &arguments.scene {
        return with_scene(arguments, input::scene(scene)?.scene);
    }
    if arguments.input.ends_with(".scene.toml") {
        return of_scene(arguments, input::scene(Path::new(&arguments.input))?);
    }
    equations(arguments, arguments.function.as_deref(), None)
}

/// Equations for a scene that the user named in addition.
fn with_scene(arguments: &OptimiseArguments, scene: Scene) -> Result<GivenStarts, CommandFailure> {
    let wished = scene.function.clone();
    let function = arguments.function.clone().or(wished);
    equations(arguments, function.as_deref(), Some(scene))
}

fn of_scene(arguments: &OptimiseArguments, file: SceneFile) -> Result<GivenStarts, CommandFailure> {
    let mut module = file
        .module()
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", arguments.input)))?;
    if module.functions.len() != 1 {
        opt::select(
            &mut module,
            arguments.function.as_deref().unwrap_or("dirdyna"),
        )?;
    }
    let (formulations, left) = match &file.subject {
        SceneSubject::Model(subject) => {
            let scene = Some(&file.scene);
            start::formulations(&module, &subject.model, subject.function, scene)
        }
        SceneSubject::Equations(_) => (Vec::new(), Vec::new()),
    };
    let mut starts = vec![OptimisationStart::given(module)];
    starts.extend(formulations);
    Ok(GivenStarts {
        starts,
        left,
        scene: Some(file.scene),
        model: String::new(),
        file: None,
    })
}

/// Equations of a file or a model, with the formulations of the model.
fn equations(
    arguments: &OptimiseArguments,
    function: Option<&str>,
    mut scene: Option<Scene>,
) -> Result<GivenStarts, CommandFailure> {
    let (_, model) = subjects::named_model(&arguments.input)?;
    let wanted = function.unwrap_or("dirdyna");
    let (mut module, model, words) = match (model, &arguments.model) {
        (Some(_), Some(path)) => {
            let note = format!("leave '--model {}' out", path.display());
            let message = "the input is a model itself";
            return Err(CommandFailure::advised(message, vec![note]));
        }
        (Some(model), None) => {
            let kind = FunctionKind::with_name(wanted);
            let kind = kind.ok_or_else(|| input::no_such_kind(wanted))?;
            let request = GenerationRequest::new(kind);
            let module = generate_asked(&model, &request)
                .map_err(|error| CommandFailure::plain(format!("{}: {error}", arguments.input)))?;
            (module, Some(model), arguments.input.clone())
        }
        (None, path) => {
            let read = input::equations_of(Path::new(&arguments.input), None, function)?;
            scene = input::scene_of(&read, scene);
            let module = read.module;
            let model: Option<Model> = match path {
                Some(path) => Some(input::model(path)?.model),
                None => None,
            };
            let words = path.as_ref().map(|path| path.display().to_string());
            (module, model, words.unwrap_or_default())
        }
    };
    opt::select_one(&mut module, &arguments.input, function)?;
    let (mut formulations, mut left) = (Vec::new(), Vec::new());
    if let (Some(model), Some(kind)) = (&model, FunctionKind::with_name(&module.functions[0].name))
    {
        (formulations, left) = start::formulations(&module, model, kind, scene.as_ref());
    }
    let mut starts = vec![OptimisationStart::given(module)];
    starts.append(&mut formulations);
    Ok(GivenStarts {
        starts,
        left,
        scene,
        model: words,
        file: Some(PathBuf::from(&arguments.input))
            .filter(|path| path.extension().is_some_and(|extension| extension == "c")),
    })
}
