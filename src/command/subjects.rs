//! Subjects of a study: files, model files, built-in models.

use super::{CommandFailure, generation, input};
use robovec_dynamics::generate::{Formulation, Options, TermOrder};
use robovec_explore::study::ProgramSources;
use robovec_explore::study::plan::StudySubject;
use robovec_io::sources;
use robovec_ir::Module;
use robovec_ir::diagnostic::{Report, suggestion};
use robovec_model::Model;
use robovec_model::family::{JOINTS, ModelFamily, built_in};
use robovec_robotran::FunctionKind;
use std::path::{Path, PathBuf};

/// Programs from files and from built-in models.
pub(super) struct SubjectFiles;

impl ProgramSources for SubjectFiles {
    fn equations(&self, subject: &StudySubject) -> Result<Module, Report> {
        equations(subject).map_err(|failure| failure.0)
    }
}

/// A model, or a file of equations.
pub(super) enum SubjectSource {
    Model(Box<Model>),
    ModelFile(PathBuf),
    Equations(PathBuf),
}

pub(super) fn locate(subject: &StudySubject) -> Result<SubjectSource, CommandFailure> {
    if let Some(model) = built_in(&subject.source) {
        return Ok(SubjectSource::Model(Box::new(model)));
    }
    check_number(&subject.source)?;
    let near = subject.folder.as_ref();
    let near = near.map(|folder| folder.join(&subject.source));
    let near = near.filter(|path| path.is_file());
    let path = near.unwrap_or_else(|| PathBuf::from(&subject.source));
    let extension = path.extension();
    if extension.is_none() && !path.exists() {
        return Err(unknown(&subject.source));
    }
    if !path.is_file() {
        return Err(CommandFailure::plain(format!(
            "model '{}': there is no file {}",
            subject.name,
            path.display()
        )));
    }
    if sources::is_model_path(&path) {
        return Ok(SubjectSource::ModelFile(path));
    }
    Ok(SubjectSource::Equations(path))
}

/// The formulation that needs the smallest time on a processor.
pub(super) const FOR_PROCESSORS: &str = "composite-base";

/// Direct dynamics of a model for processors by composite bodies, as it is and
/// after the passes for straight-line code; `None` for anything else.
pub(super) fn for_processors(
    subject: &StudySubject,
) -> Result<Option<[Module; 2]>, CommandFailure> {
    let kind = Some(FunctionKind::Dirdyna);
    let model = match locate(subject)? {
        SubjectSource::Model(model) => *model,
        SubjectSource::ModelFile(path) => input::model_for(&path, kind)?.model,
        SubjectSource::Equations(_) => return Ok(None),
    };
    if subject.function.as_deref().unwrap_or("dirdyna") != "dirdyna" {
        return Ok(None);
    }
    let options = Options {
        external_forces: false,
        ..Options::default()
    };
    let formulation = Formulation::from_name(FOR_PROCESSORS).expect("a formulation that there is");
    let module = generation::functions(&model, &[FunctionKind::Dirdyna], formulation, &options)?;
    let mut shorter = module.clone();
    generation::transform(&mut shorter, &input::passes("$cpu")?)?;
    Ok(Some([module, shorter]))
}

fn equations(subject: &StudySubject) -> Result<Module, CommandFailure> {
    let wanted = subject.function.as_deref().unwrap_or("dirdyna");
    let kind = FunctionKind::with_name(wanted);
    let model = match locate(subject)? {
        SubjectSource::Model(model) => *model,
        SubjectSource::ModelFile(path) => input::model_for(&path, kind)?.model,
        SubjectSource::Equations(path) => {
            return input::without_ranges(input::equations(&path, None)?, "explore --plan");
        }
    };
    let Some(kind) = kind else {
        let names = FunctionKind::ALL.map(FunctionKind::name);
        let note = suggestion(wanted, names.iter().copied())
            .unwrap_or_else(|| format!("functions: {}", names.join(", ")));
        let name = &subject.name;
        let message = format!("model '{name}': there is no function '{wanted}' to generate");
        return Err(CommandFailure::advised(message, vec![note]));
    };
    let style = &subject.style;
    let options = Options {
        order: if style.child_first {
            TermOrder::ChildFirst
        } else {
            TermOrder::OwnFirst
        },
        all_parameters: style.all_parameters,
        external_forces: style.forces,
        leading_signs: style.leading_signs,
        expanded: style.expanded,
        true_angles: !style.any_angles,
        multipliers: false,
        ..Options::default()
    };
    let formulation = Formulation::from_name(&style.formulation)
        .expect("the reader of plans has checked the formulation");
    generation::functions(&model, &[kind], formulation, &options)
}

/// The name of a subject, and its model; `None` for a file of equations.
pub(super) fn named_model(subject: &str) -> Result<(String, Option<Model>), CommandFailure> {
    check_number(subject)?;
    let path = Path::new(subject);
    let is_model = sources::is_model_path(path);
    let model = match built_in(subject) {
        Some(model) => Some(model),
        None if is_model => Some(input::model_for(path, Some(FunctionKind::Dirdyna))?.model),
        None => None,
    };
    Ok((input::stem(path), model))
}

/// Refuses a name like `serial-1000000`, which is none of a file.
pub(super) fn check_number(name: &str) -> Result<(), CommandFailure> {
    let Some((family, joints)) = name.rsplit_once('-') else {
        return Ok(());
    };
    let is_family = ModelFamily::from_name(family).is_some_and(|family| family.joints().is_none());
    if !is_family || !joints.bytes().all(|byte| byte.is_ascii_digit()) {
        return Ok(());
    }
    match JOINTS.read_whole(joints) {
        Ok(_) => Ok(()),
        Err(reason) => Err(CommandFailure::plain(format!(
            "the joints of '{name}': {reason}"
        ))),
    }
}

fn unknown(name: &str) -> CommandFailure {
    let names: Vec<String> = ModelFamily::ALL
        .iter()
        .map(|family| match family.joints() {
            Some(_) => family.name().to_owned(),
            None => format!("{}-N", family.name()),
        })
        .collect();
    let note = suggestion(name, names.iter().map(String::as_str))
        .unwrap_or_else(|| format!("models: {} with N joints, or a file", names.join(", ")));
    CommandFailure::advised(
        format!("there is no file or built-in model '{name}'"),
        vec![note],
    )
}
