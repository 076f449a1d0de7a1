//! Conversion of the text of a scene file into a scene and its function.

use super::arrays::SceneArrays;
use super::document::{
    DocumentProblems, DocumentRange, DocumentTable, get, limited, only_keys, parse, string,
    strings, table,
};
use super::inputs::InputReader;
use super::known::ElementStatements;
use super::{DEADLINE, ERROR, ModelSubject, SCALE, SceneFile, SceneSubject};
use robovec_dynamics::generate::{Formulation, Options};
use robovec_framework::scene::{Hold, Measure, NeededOutputs, OutputTolerance, Scene};
use robovec_io::sources;
use robovec_ir::diagnostic::{Report, clip};
use robovec_ir::states::Ranges;
use robovec_ir::{Module, Shape, View};
use robovec_robotran::FunctionKind;
use std::path::{Path, PathBuf};
use toml::de::DeValue;

/// The keys of a scene file.
const KEYS: [&str; 19] = [
    "name",
    "description",
    "model",
    "equations",
    "function",
    "formulation",
    "machine",
    "trigonometry",
    "deadline",
    "parameters",
    "free",
    "driven",
    "locked",
    "small",
    "output",
    "bind",
    "range",
    "motion",
    "neglect",
];

/// Reads the text of a scene; the files it names are looked for in a folder.
///
/// # Errors
///
/// Messages that point into the text, or into that of a file it names.
pub fn read(name: &str, text: &str, folder: &Path) -> Result<SceneFile, Report> {
    let failed = |problems: DocumentProblems| Report::of(name, text, problems.into_diagnostics());
    let document = parse(text).map_err(|message| Report::of(name, text, vec![message]))?;
    let file = document.get_ref();
    let mut problems = DocumentProblems::default();
    only_keys(file, &KEYS, &mut problems);
    let mut scene = wishes(name, file, folder, &mut problems)?;
    let found = subject(file, &scene, folder, &mut problems)?;
    let (Some((mut subject, warnings, ranges)), true) = (found, problems.is_empty()) else {
        return Err(failed(problems));
    };
    let arrays = match &subject {
        SceneSubject::Model(subject) => SceneArrays::of_model(&subject.general),
        SceneSubject::Equations(module) => SceneArrays::of_module(module),
    };
    let mut reader = InputReader {
        arrays: &arrays,
        model: match &subject {
            SceneSubject::Model(subject) => Some(&subject.general),
            SceneSubject::Equations(_) => None,
        },
        words: ElementStatements::default(),
        problems: &mut problems,
    };
    scene.joints = reader.read(file);
    scene.small = reader.small(file);
    let motion = get(file, "motion").and_then(|value| reader.motion(value));
    let neglect = get(file, "neglect").and_then(|value| reader.neglect(value));
    let words = reader.words;
    if let SceneSubject::Model(subject) = &mut subject {
        subject.hold(&scene.joints);
        subject.keep_needed_symbols(&words);
        let small = scene.small.iter().map(|&number| number as usize - 1);
        subject.options.small_angles = small.collect();
    } else if let Some(joint) = scene.joints.iter().find(|joint| joint.hold == Hold::Driven) {
        let message = format!(
            "the equations of the joint '{}' are made already: only a model's joints can be driven",
            joint.name
        );
        let span = get(file, "driven").map_or(0..0, |value| value.span());
        problems.add(span, message);
    }
    if !problems.is_empty() {
        return Err(failed(problems));
    }
    (scene.bound, scene.ranges) = words.split();
    scene.ranges.add_missing(&ranges);
    let mut complete = SceneFile {
        scene,
        subject,
        warnings,
        motion,
        neglect: neglect.unwrap_or_default(),
    };
    let module = complete.module().map_err(|error| {
        let key = get(file, "function").or_else(|| get(file, "model"));
        problems.add(key.map_or(0..0, |value| value.span()), error.to_string());
        failed(std::mem::take(&mut problems))
    })?;
    complete.scene.outputs = outputs(file, &arrays, &module, &mut problems);
    complete.watch_what_is_needed();
    if problems.is_empty() {
        Ok(complete)
    } else {
        Err(failed(problems))
    }
}

/// Wishes of a scene about itself and its compilation.
fn wishes(
    name: &str,
    file: &DocumentTable<'_>,
    folder: &Path,
    problems: &mut DocumentProblems,
) -> Result<Scene, Report> {
    let mut text = |key: &str| -> Option<String> {
        get(file, key)
            .and_then(|value| string(value, problems))
            .map(str::to_owned)
    };
    let stem = name.trim_end_matches(".toml").trim_end_matches(".scene");
    let mut scene = Scene {
        name: text("name").unwrap_or_else(|| stem.to_owned()),
        description: text("description").unwrap_or_default(),
        function: text("function"),
        formulation: text("formulation"),
        machine: text("machine"),
        ..Scene::default()
    };
    if let Some(value) = get(file, "trigonometry") {
        match string(value, problems) {
            Some("elements") => scene.series = true,
            Some("host") | None => {}
            Some(other) => {
                let known = ["host", "elements"];
                problems.unknown(value.span(), "sines cannot be computed on", other, &known);
            }
        }
    }
    scene.deadline =
        get(file, "deadline").and_then(|value| limited(value, ("deadline", DEADLINE), problems));
    if let (Some(value), Some(wish)) = (get(file, "formulation"), &scene.formulation)
        && Formulation::from_name(wish).is_none()
    {
        let what = "there is no formulation";
        problems.unknown(value.span(), what, wish, &Formulation::names());
    }
    if let (Some(value), Some(wish)) = (get(file, "machine"), &scene.machine)
        && robovec_ir::Machine::built_in(wish).is_none()
    {
        let path = folder.join(wish);
        if path.is_file() {
            let path = path.to_string_lossy().into_owned();
            sources::machine(&path)?;
            scene.machine = Some(path);
        } else {
            let names: Vec<&str> = robovec_ir::machine::BUILT_IN
                .iter()
                .map(|(name, _)| *name)
                .collect();
            problems.unknown(value.span(), "there is no machine", wish, &names);
        }
    }
    Ok(scene)
}

/// A subject, the remarks of its reader, and the ranges that its file gives.
type ReadSubject = (SceneSubject, Report, Ranges);

/// The model or the equations that a scene names.
fn subject(
    file: &DocumentTable<'_>,
    scene: &Scene,
    folder: &Path,
    problems: &mut DocumentProblems,
) -> Result<Option<ReadSubject>, Report> {
    let (model, equations) = (get(file, "model"), get(file, "equations"));
    let (key, value) = match (model, equations) {
        (Some(value), None) => ("model", value),
        (None, Some(value)) => ("equations", value),
        (Some(_), Some(value)) => {
            return Ok(problems.refuse(value.span(), "a scene has a model or equations, not both"));
        }
        (None, None) => {
            let note = "write: model = \"FILE.mbs\", or: equations = \"FILE.c\"".to_owned();
            let message = "the scene names neither a model nor equations";
            problems.advise(0..0, message, Some(note));
            return Ok(None);
        }
    };
    let Some(written) = string(value, problems) else {
        return Ok(None);
    };
    let path: PathBuf = folder.join(written);
    if !path.is_file() {
        let message = format!("there is no file '{}'", clip(written));
        let note = "files are looked for beside the scene".to_owned();
        problems.advise(value.span(), message, Some(note));
        return Ok(None);
    }
    let span = get(file, "function").map_or_else(|| value.span(), |value| value.span());
    if key == "model" {
        return model_subject(&path, scene, file, span, problems);
    }
    let read = sources::equations(&path, None, scene.function.as_deref())?;
    let mut module = read.module;
    let names: Vec<String> = module.functions.iter().map(|f| f.name.clone()).collect();
    match &scene.function {
        Some(wish) if names.contains(wish) => {
            module.functions.retain(|function| function.name == *wish);
        }
        Some(wish) => {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            problems.unknown(span, "the file has no function", wish, &names);
        }
        None if names.len() != 1 => {
            let message = format!("the file has {} functions: name one", names.len());
            let note = format!("write: function = one of {}", names.join(", "));
            problems.advise(span, message, Some(note));
        }
        None => {}
    }
    Ok(Some((
        SceneSubject::Equations(Box::new(module)),
        read.warnings,
        read.ranges,
    )))
}

fn model_subject(
    path: &Path,
    scene: &Scene,
    file: &DocumentTable<'_>,
    span: DocumentRange,
    problems: &mut DocumentProblems,
) -> Result<Option<ReadSubject>, Report> {
    let wish = scene.function.as_deref().unwrap_or("dirdyna");
    let Some(kind) = FunctionKind::with_name(wish) else {
        let names = FunctionKind::ALL.map(FunctionKind::name);
        problems.unknown(span, "no model has a function", wish, &names);
        return Ok(None);
    };
    let wished = scene.formulation.as_deref();
    if let (Some(formulation), Some(value)) = (
        wished.and_then(Formulation::from_name),
        get(file, "formulation"),
    ) && !formulation.gives(kind)
    {
        let message = format!("'{}' does not give {wish}", formulation.name());
        return Ok(problems.refuse(value.span(), message));
    }
    let read = sources::model(path)?;
    let warnings = read.warnings_for(kind);
    let subject = ModelSubject {
        model: read.model.clone(),
        general: read.model,
        function: kind,
        name: wish.to_owned(),
        options: Options::default(),
    };
    let subject = SceneSubject::Model(Box::new(subject));
    Ok(Some((subject, warnings, Ranges::default())))
}

fn outputs(
    file: &DocumentTable<'_>,
    arrays: &SceneArrays,
    module: &Module,
    problems: &mut DocumentProblems,
) -> Vec<NeededOutputs> {
    let Some(value) = get(file, "output") else {
        return Vec::new();
    };
    let entries = match value.get_ref() {
        DeValue::Array(list) if list.is_empty() => {
            let note = "leave the list out if every output is needed".to_owned();
            problems.advise(value.span(), "the list of outputs is empty", Some(note));
            return Vec::new();
        }
        DeValue::Array(list) => list.as_ref(),
        _ => std::slice::from_ref(value),
    };
    let known: Vec<(String, Shape)> = module
        .functions
        .iter()
        .flat_map(|function| function.outputs())
        .map(|array| {
            (
                module.tables.symbols.text(array.name).to_owned(),
                array.shape,
            )
        })
        .collect();
    let mut needs: Vec<(NeededOutputs, DocumentRange)> = Vec::new();
    for entry in entries {
        let Some(section) = table(entry, problems) else {
            continue;
        };
        only_keys(
            section,
            &["elements", "error", "measure", "scale"],
            problems,
        );
        let tolerance = tolerance(section, problems);
        let Some(elements) = get(section, "elements") else {
            let message = "this output names no elements";
            let note = "write: elements = [\"qdd[3]\"]".to_owned();
            problems.advise(entry.span(), message, Some(note));
            continue;
        };
        let texts = strings(elements, problems);
        if texts.is_empty() && problems.is_empty() {
            problems.add(elements.span(), "the list of elements is empty");
        }
        for (text, span) in texts {
            let pattern = arrays.output_pattern(&known, text);
            let Some(pattern) = problems.take(&span, pattern) else {
                continue;
            };
            let need = NeededOutputs { pattern, tolerance };
            check_need(module, &needs, (&need, &span), problems);
            needs.push((need, span));
        }
    }
    needs.into_iter().map(|(need, _)| need).collect()
}

/// Complains of outputs that do not exist or come twice.
fn check_need(
    module: &Module,
    before: &[(NeededOutputs, DocumentRange)],
    (need, span): (&NeededOutputs, &DocumentRange),
    problems: &mut DocumentProblems,
) {
    let set = module.functions.iter().any(|function| {
        let tables = &module.tables;
        !need.pattern.outputs(View { tables, function }).is_empty()
    });
    if !set {
        let message = format!("the function does not set '{}'", need.pattern);
        problems.add(span.clone(), message);
    }
    let measure = |need: &NeededOutputs| need.tolerance.map(|tolerance| tolerance.measure);
    let twin = before
        .iter()
        .find(|(other, _)| other.pattern == need.pattern && measure(other) == measure(need));
    if let Some((_, other)) = twin {
        let message = format!("'{}' is listed already", need.pattern);
        let other = Some((other.clone(), "here"));
        problems.point(span.clone(), message, None, other);
    }
}

/// The error that is allowed.
fn tolerance(
    section: &DocumentTable<'_>,
    problems: &mut DocumentProblems,
) -> Option<OutputTolerance> {
    let measure = get(section, "measure").and_then(|value| {
        let name = string(value, problems)?;
        let measure = Measure::from_name(name);
        if measure.is_none() {
            let names = Measure::ALL.map(Measure::name);
            problems.unknown(value.span(), "there is no measure", name, &names);
        }
        measure
    });
    let value = get(section, "error");
    for key in ["measure", "scale"] {
        if let (Some(other), None) = (get(section, key), value) {
            let message = format!("a {key} without an error has no effect");
            problems.add(other.span(), message);
        }
    }
    let measure = measure.unwrap_or_default();
    let scale = get(section, "scale").and_then(|value| {
        if measure == Measure::Absolute {
            let message = "an absolute error has no scale";
            problems.add(value.span(), message);
        }
        limited(value, ("scale", SCALE), problems)
    });
    let bound = limited(value?, ("error", ERROR), problems)?;
    Some(OutputTolerance {
        measure,
        bound,
        scale,
    })
}
