//! Reading what the user names: equations, pipelines, machines.

use super::Failure;
use super::arguments::InputLanguage;
use super::files::{self, FileLimit};
use crate::generate::{FunctionKind, Request, generate};
use crate::model::mbs::{ReadModel, read_mbs};
use crate::robotran::{self, Language};
use robovec_ir::diagnostic::{Diagnostic, Label, Report};
use robovec_ir::machine::{self, MachineError};
use robovec_ir::{Machine, Module, parse};
use robovec_passes::pipeline::{self, Pipeline};
use std::path::{Path, PathBuf};

/// Equations as read, with the text messages point into.
pub(crate) struct Input {
    /// The functions.
    pub(crate) module: Module,
    /// Name of the file.
    pub(crate) name: String,
    /// Where its text can be read again for a message.
    pub(crate) path: PathBuf,
    /// What the reader remarked.
    pub(crate) warnings: Report,
}

fn display_name(path: &Path) -> String {
    if path == Path::new("-") {
        "<stdin>".to_owned()
    } else {
        // Only the last part, so that results do not depend on where one
        // stands.
        path.file_name()
            .unwrap_or(path.as_os_str())
            .to_string_lossy()
            .into_owned()
    }
}

impl Input {
    /// The text of the file once more, for a message that points into it;
    /// keeping it from the start would double the memory of a large file.
    /// `None` when it cannot be had again.
    pub(crate) fn text(&self) -> Option<String> {
        if self.path == Path::new("-") {
            return None;
        }
        let bytes = files::read(&self.path, &files::EQUATIONS).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// Reads equations in any language, or generates them from a model: the
/// function asked for, else direct dynamics.
pub(crate) fn equations_or_model(
    path: &Path,
    language: Option<InputLanguage>,
    function: Option<&str>,
) -> Result<Input, Failure> {
    let is_model = path.extension().is_some_and(|extension| extension == "mbs");
    if !is_model || language.is_some() {
        return equations(path, language);
    }
    let read = model(path)?;
    let kind = function.map_or(Some(FunctionKind::Dirdyna), |name| {
        // Cases of sensors are chosen from all.
        let bare = name.trim_end_matches(|c: char| c.is_ascii_digit());
        FunctionKind::from_name(name)
            .or_else(|| FunctionKind::from_name(bare.trim_end_matches('_')))
    });
    let Some(kind) = kind else {
        let names = FunctionKind::ALL.map(FunctionKind::name).join(", ");
        return Err(Failure::advised(
            format!(
                "no function '{}' is generated",
                function.unwrap_or_default()
            ),
            vec![format!("functions of a model: {names}")],
        ));
    };
    let module = generate(&read.model, &Request::new(kind))
        .map_err(|error| Failure::plain(format!("{}: {error}", path.display())))?;
    Ok(Input {
        module,
        name: display_name(path),
        path: path.to_owned(),
        warnings: read.warnings_for(kind),
    })
}

/// Reads equations in any language.
pub(crate) fn equations(path: &Path, language: Option<InputLanguage>) -> Result<Input, Failure> {
    let bytes = files::read(path, &files::EQUATIONS)?;
    let name = display_name(path);
    let is_own = match language {
        Some(language) => language == InputLanguage::Rvir,
        None => name.ends_with(".rvir") || bytes.starts_with(b"// robovec "),
    };
    if is_own {
        return own_text(path, name, bytes);
    }
    let language = match language {
        Some(InputLanguage::C) => Some(Language::C),
        Some(InputLanguage::Matlab) => Some(Language::Matlab),
        Some(InputLanguage::Python) => Some(Language::Python),
        Some(InputLanguage::Rvir) | None => None,
    };
    let read = robotran::read(&name, &bytes, language).map_err(|error| Failure(error.report))?;
    Ok(Input {
        module: read.module,
        name,
        path: path.to_owned(),
        warnings: read.warnings,
    })
}

fn own_text(path: &Path, name: String, bytes: Vec<u8>) -> Result<Input, Failure> {
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        Failure::advised(
            format!(
                "{name} is not UTF-8 text: byte {} does not belong",
                valid + 1
            ),
            vec!["robovec's own text is UTF-8; is this another kind of file?".to_owned()],
        )
    })?;
    match parse::parse_module(&name, &text) {
        Ok(module) => Ok(Input {
            module,
            name,
            path: path.to_owned(),
            warnings: Report::new(),
        }),
        Err(diagnostics) => Err(Failure(Report::of(&name, text, diagnostics))),
    }
}

/// Reads a model.
pub(crate) fn model(path: &Path) -> Result<ReadModel, Failure> {
    let bytes = files::read(path, &files::MODEL)?;
    read_mbs(&display_name(path), &bytes).map_err(|error| Failure(error.report))
}

/// Reads a text of a kind.
pub(crate) fn text(path: &Path, limit: &FileLimit) -> Result<String, Failure> {
    String::from_utf8(files::read(path, limit)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let name = path.display();
        Failure::plain(format!(
            "{name} is not UTF-8 text: byte {} does not belong",
            valid + 1
        ))
    })
}

/// Reads a pipeline, from a file when it starts with `@`.
pub(crate) fn passes(text: &str) -> Result<Pipeline, Failure> {
    let content = match text.strip_prefix('@') {
        None => text.to_owned(),
        Some(file) => {
            String::from_utf8_lossy(&files::read(Path::new(file), &files::PIPELINE)?).into_owned()
        }
    };
    pipeline::parse(&content).map_err(|error| Failure(error.0))
}

/// The machine of a name, or of a file.
pub(crate) fn machine(name: &str) -> Result<Machine, Failure> {
    if let Some(machine) = Machine::built_in(name) {
        return Ok(machine);
    }
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        let names: Vec<&str> = machine::BUILT_IN.iter().map(|(name, _)| *name).collect();
        let mut notes: Vec<String> =
            robovec_ir::diagnostic::did_you_mean(name, names.iter().copied())
                .map(|near| format!("did you mean '{near}'?"))
                .into_iter()
                .collect();
        notes.push(format!("machines: {}, or a .toml file", names.join(", ")));
        return Err(Failure::advised(
            format!("there is no machine '{name}'"),
            notes,
        ));
    }
    let text = String::from_utf8_lossy(&files::read(path, &files::MACHINE)?).into_owned();
    Machine::parse(&text).map_err(|error| {
        let diagnostic = Diagnostic::error().with_message(error.to_string());
        let diagnostic = match error {
            MachineError::Syntax {
                span: Some(span), ..
            } => diagnostic.with_labels(vec![Label::primary(0, span)]),
            MachineError::Syntax { span: None, .. } | MachineError::Meaning(_) => diagnostic
                .with_labels(vec![
                    Label::primary(0, 0..0).with_message("in this machine file"),
                ]),
        };
        Failure(Report::of(&display_name(path), text, vec![diagnostic]))
    })
}

/// The pipeline of an option that may be absent.
pub(crate) fn passes_or_empty(text: Option<&str>) -> Result<Pipeline, Failure> {
    match text {
        None => Ok(Pipeline::default()),
        Some(text) => passes(text),
    }
}
