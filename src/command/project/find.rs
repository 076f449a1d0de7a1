//! The parts of a Robotran project.

use super::calls::{self, ProjectCalls};
use crate::command::CommandFailure;
use robovec_cgen::kind::file_stem;
use robovec_io::sources;
use robovec_robotran::{FunctionKind, Language};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of results, drawings, builds, or MBsysC, which has empty equations.
const PASSED_OVER: [&str; 7] = [
    "mbs_common",
    "animationR",
    "resultsR",
    "build",
    "target",
    "doc",
    "figures",
];

/// Maximum depth of folders.
const DEPTH: usize = 12;

/// Maximum number of files; those beyond it are passed over.
const FILES: usize = 50_000;

pub(super) struct FoundProject {
    pub(super) root: PathBuf,
    /// The name in the equations' file names.
    pub(super) name: String,
    pub(super) symbolic: PathBuf,
    pub(super) language: Language,
    /// Function and file, in the order of Robotran's numbers.
    pub(super) equations: Vec<(FunctionKind, PathBuf)>,
    pub(super) model: Option<PathBuf>,
    /// Models that may be meant where none has the name of the equations.
    pub(super) candidates: Vec<PathBuf>,
    /// Folders with equations of other models, and others with those of this one.
    pub(super) others: Vec<String>,
    pub(super) calls: ProjectCalls,
    /// All its files, without results, drawings and what was built.
    pub(super) files: Vec<PathBuf>,
}

impl FoundProject {
    /// Folder of the equations, from that of the project.
    pub(super) fn symbolic_inside(&self) -> &Path {
        self.symbolic
            .strip_prefix(&self.root)
            .unwrap_or(&self.symbolic)
    }

    /// A path for messages, from the folder of the project.
    pub(super) fn shown(&self, path: &Path) -> String {
        match path.strip_prefix(&self.root) {
            Ok(inside) if inside != Path::new("") => inside.display().to_string(),
            _ => path.display().to_string(),
        }
    }
}

/// Equations of one model in one folder and language.
type EquationFolder = (String, PathBuf, &'static str);

pub(super) fn project(root: &Path, model: Option<&Path>) -> Result<FoundProject, CommandFailure> {
    let mut files = Vec::new();
    walk(root, 0, &PASSED_OVER, &mut files)
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", root.display())))?;
    let mut groups: BTreeMap<EquationFolder, Vec<(FunctionKind, PathBuf)>> = BTreeMap::new();
    for file in &files {
        if let Some((kind, stem, end)) = equation_name(file) {
            let folder = file.parent().unwrap_or(root).to_owned();
            groups
                .entry((stem, folder, end))
                .or_default()
                .push((kind, file.clone()));
        }
    }
    let wanted = model.map(stems).transpose()?;
    let fits = |stem: &String| wanted.as_ref().is_none_or(|names| names.contains(stem));
    let largest = groups
        .iter()
        .filter(|((stem, _, _), _)| fits(stem))
        // Of equally many those with a model of their name, else the first.
        .rev()
        .max_by_key(|((stem, ..), group)| (group.len(), has_model(&files, stem)));
    let Some(((name, symbolic, end), equations)) = largest else {
        return Err(CommandFailure::advised(
            format!(
                "{} holds no equations of Robotran{}",
                root.display(),
                match &wanted {
                    Some(names) => format!(" for the model '{}'", names[0]),
                    None => String::new(),
                }
            ),
            vec![
                "they are files such as symbolicR/mbs_dirdyna_NAME.c; without them, \
                 'robovec gen MODEL.mbs' makes them"
                    .to_owned(),
            ],
        ));
    };
    let mut equations = equations.clone();
    equations.sort_by_key(|(kind, _)| FunctionKind::ALL.iter().position(|one| one == kind));
    let others = groups
        .keys()
        .filter(|(stem, folder, _)| (stem, folder) != (name, symbolic));
    let mut others: Vec<String> = others
        .map(|(stem, folder, _)| {
            let folder = folder.strip_prefix(root).unwrap_or(folder);
            format!("{stem} in {}", folder.display())
        })
        .collect();
    others.dedup();
    let (model, candidates) = match model {
        Some(path) => (Some(path.to_owned()), Vec::new()),
        None => model_of(&files, name, symbolic),
    };
    let sources = files.iter().filter(|file| file.parent() != Some(symbolic));
    Ok(FoundProject {
        root: root.to_owned(),
        language: match *end {
            "m" => Language::Matlab,
            "py" => Language::Python,
            _ => Language::C,
        },
        calls: calls::read(sources),
        name: name.clone(),
        symbolic: symbolic.clone(),
        equations,
        model,
        candidates,
        others,
        files,
    })
}

/// All files below a folder, sorted, without those in folders of some names.
pub(super) fn walk(
    folder: &Path,
    depth: usize,
    passed_over: &[&str],
    files: &mut Vec<PathBuf>,
) -> std::io::Result<()> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    entries.sort();
    for path in entries {
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        if name.starts_with('.') || files.len() >= FILES {
            continue;
        }
        // A link may lead back to where it is.
        let kind = fs::symlink_metadata(&path)?.file_type();
        if kind.is_dir() && depth < DEPTH && !passed_over.contains(&name.as_str()) {
            walk(&path, depth + 1, passed_over, files)?;
        } else if kind.is_file() {
            files.push(path);
        }
    }
    Ok(())
}

/// Function, model and ending of a name like `mbs_dirdyna_X.c`.
fn equation_name(path: &Path) -> Option<(FunctionKind, String, &'static str)> {
    let end = ["c", "m", "py"]
        .into_iter()
        .find(|end| path.extension().is_some_and(|extension| extension == *end))?;
    let stem = path.file_stem()?.to_str()?;
    let rest = stem.strip_prefix("mbs_").unwrap_or(stem);
    FunctionKind::ALL.into_iter().find_map(|kind| {
        let name = rest.strip_prefix(kind.name())?.strip_prefix('_')?;
        let is_usual = !kind.is_special() && !name.is_empty();
        is_usual.then(|| (kind, name.to_owned(), end))
    })
}

/// Names under which equations of a model's file may be found.
fn stems(path: &Path) -> Result<Vec<String>, CommandFailure> {
    let model = sources::model(path)?.model;
    let file = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(vec![file_stem(&model.name), file_stem(&file), model.name])
}

/// True where a model among the files has the name of equations.
fn has_model(files: &[PathBuf], name: &str) -> bool {
    files
        .iter()
        .any(|path| is_model(path) && has_name(path, name))
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "mbs")
}

fn has_name(path: &Path, name: &str) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem == name || file_stem(&stem) == name
}

/// The model of a name among the files, of several that nearest to the
/// equations; else the only model. Without it those that may be meant.
fn model_of(files: &[PathBuf], name: &str, near: &Path) -> (Option<PathBuf>, Vec<PathBuf>) {
    let models: Vec<&PathBuf> = files.iter().filter(|path| is_model(path)).collect();
    let shared = |path: &&&PathBuf| {
        let parts = path.components().zip(near.components());
        parts.take_while(|(one, other)| one == other).count()
    };
    // Of equally near ones the first.
    let named = models
        .iter()
        .filter(|path| has_name(path, name))
        .rev()
        .max_by_key(shared);
    let only = (models.len() == 1).then(|| models.first()).flatten();
    match named.or(only) {
        Some(path) => (Some((*path).clone()), Vec::new()),
        None => (None, models.into_iter().cloned().collect()),
    }
}
