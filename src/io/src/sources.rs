//! Files that hold equations, models, machines and other texts, from path to value.
//!
//! **Invariant.** A file is read up to the limit of its kind, and a failure is
//! a report that points into the text where it can. Remarks of a reader are
//! returned; the caller prints them.

use crate::files::limited::{self, FileLimit};
use robovec_ir::diagnostic::{Diagnostic, Label, Report, suggestion};
use robovec_ir::machine::{self, MachineError};
use robovec_ir::states::Ranges;
use robovec_ir::{Format, Machine, Module, parse};
use robovec_model::mbs::{ReadModel, read_mbs};
use robovec_model::robot::{RobotBase, RobotReading, read_robot, with_includes};
use robovec_model::{Model, family};
use robovec_robotran::Language;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A language that equations are written in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EquationLanguage {
    /// robovec's own text.
    Rvir,
    /// FPCore, which tools for rounding errors exchange.
    Fpcore,
    /// One written by Robotran.
    Robotran(Language),
}

/// Equations as read.
#[derive(Debug)]
pub struct ReadEquations {
    /// The functions.
    pub module: Module,
    /// Place of the file; `-` for the standard input.
    pub path: PathBuf,
    /// Name of the file, without its folder.
    pub name: String,
    /// The ranges that the file gives its inputs.
    pub ranges: Ranges,
    /// The format that the file computes in, where it names one.
    pub format: Option<Format>,
    /// Remarks of the reader.
    pub warnings: Report,
}

impl ReadEquations {
    /// A module not read as equations: one without ranges, format and remarks.
    pub fn of(path: &Path, module: Module) -> ReadEquations {
        ReadEquations {
            module,
            path: path.to_owned(),
            name: display_name(path),
            ranges: Ranges::default(),
            format: None,
            warnings: Report::new(),
        }
    }

    /// The text of the file once more, for a message that points into it, which
    /// saves memory; `None` when it cannot be had again.
    pub fn text(&self) -> Option<String> {
        if self.path == Path::new("-") {
            return None;
        }
        let bytes = limited::read(&self.path, &limited::EQUATIONS).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// Name of a file in messages: its last part; `<stdin>` for `-`.
pub fn display_name(path: &Path) -> String {
    if path == Path::new("-") {
        return "<stdin>".to_owned();
    }
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Reads equations; without a language, in the one that name and text show: of
/// FPCore only a function of a given name, else all functions.
///
/// # Errors
///
/// Reports why the file is not read, is wrong, or sets no output.
pub fn equations(
    path: &Path,
    language: Option<EquationLanguage>,
    function: Option<&str>,
) -> Result<ReadEquations, Report> {
    let read = equations_or_stubs(path, language, function)?;
    let functions = &read.module.functions;
    if functions
        .iter()
        .any(|function| !function.assignments.is_empty())
    {
        return Ok(read);
    }
    let note = if functions.iter().all(|function| function.nodes().is_empty()) {
        "the generator leaves such a stub when the model has nothing for this function"
    } else {
        "an equation sets an output when it sets an element of an array, as 'c[1] = …'; other \
             names are temporaries"
    };
    let message = format!("{} sets no output", read.name);
    Err(Report::error(message, vec![note.to_owned()]))
}

/// Does as [`equations`], and takes files whose functions set no output.
pub fn equations_or_stubs(
    path: &Path,
    language: Option<EquationLanguage>,
    function: Option<&str>,
) -> Result<ReadEquations, Report> {
    let bytes = limited::read(path, &limited::EQUATIONS)?;
    let name = display_name(path);
    let looks_own = || name.ends_with(".rvir") || bytes.starts_with(b"// robovec ");
    let looks_core = || name.ends_with(".fpcore") || bytes.starts_with(b"(FPCore");
    let language = match language {
        Some(EquationLanguage::Robotran(language)) => Some(language),
        Some(EquationLanguage::Rvir) => return own_text(path, bytes),
        Some(EquationLanguage::Fpcore) => return core(path, bytes, function),
        None if looks_own() => return own_text(path, bytes),
        None if looks_core() => return core(path, bytes, function),
        None => None,
    };
    let read = robovec_robotran::read(&name, &bytes, language).map_err(|error| error.report)?;
    Ok(ReadEquations {
        warnings: read.warnings,
        ..ReadEquations::of(path, read.module)
    })
}

fn core(path: &Path, bytes: Vec<u8>, function: Option<&str>) -> Result<ReadEquations, Report> {
    let name = display_name(path);
    let text = utf8(&name, bytes).map_err(|message| Report::error(message, Vec::new()))?;
    let read = robovec_fpcore::read(&name, &text, function)?;
    Ok(ReadEquations {
        ranges: read.ranges,
        format: read.format,
        warnings: read.warnings,
        ..ReadEquations::of(path, read.module)
    })
}

fn own_text(path: &Path, bytes: Vec<u8>) -> Result<ReadEquations, Report> {
    let name = display_name(path);
    let text = utf8(&name, bytes).map_err(|message| {
        let note = "robovec's own text is UTF-8; is this another kind of file?".to_owned();
        Report::error(message, vec![note])
    })?;
    match parse::parse_module(&name, &text) {
        Ok(module) if module.functions.is_empty() => {
            let note = "robovec's own text holds functions; see docs/text-format.md".to_owned();
            Err(Report::error(
                format!("{name} holds no function"),
                vec![note],
            ))
        }
        Ok(module) => Ok(ReadEquations::of(path, module)),
        Err(diagnostics) => Err(Report::of(&name, text, diagnostics)),
    }
}

/// True while robots move freely.
static FLOATING: AtomicBool = AtomicBool::new(false);

/// The bits of [`RobotReading::right_angle`].
static RIGHT_ANGLE: AtomicU64 = AtomicU64::new(0);

/// Sets the options for reading robots, for the whole process.
pub fn set_reading(reading: RobotReading) {
    FLOATING.store(reading.base == RobotBase::Floating, Ordering::Relaxed);
    RIGHT_ANGLE.store(reading.right_angle.to_bits(), Ordering::Relaxed);
}

/// Reads a model, a `.mbs` or a URDF file, a robot as [`set_reading`] set.
pub fn model(path: &Path) -> Result<ReadModel, Report> {
    let base = if FLOATING.load(Ordering::Relaxed) {
        RobotBase::Floating
    } else {
        RobotBase::Fixed
    };
    let right_angle = f64::from_bits(RIGHT_ANGLE.load(Ordering::Relaxed));
    model_as(path, RobotReading { base, right_angle })
}

/// Reads a model, a robot with its own options.
pub fn model_as(path: &Path, robot: RobotReading) -> Result<ReadModel, Report> {
    if let Some(model) = built_in_name(path).and_then(family::built_in) {
        return Ok(ReadModel {
            model,
            warnings: Report::new(),
            left_out: Report::new(),
        });
    }
    let bytes = limited::read(path, &limited::MODEL)?;
    let name = display_name(path);
    let read = if is_robot(&name, &bytes) {
        let bytes = with_includes(bytes, |file| {
            limited::read(&path.with_file_name(file), &limited::MODEL)
        })?;
        read_robot(&name, &bytes, robot)
    } else {
        read_mbs(&name, &bytes)
    };
    read.map_err(|error| error.report)
}

/// True for the name of a model file, or of a built-in model.
pub fn is_model_path(path: &Path) -> bool {
    let is = |kind: &str| {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case(kind))
    };
    is("mbs") || is("urdf") || is("xml") || built_in_name(path).is_some()
}

/// Name of a built-in model in place of a file, which has priority.
fn built_in_name(path: &Path) -> Option<&str> {
    let name = path.to_str()?;
    (family::is_built_in(name) && !path.exists()).then_some(name)
}

/// The ranges of positions that a model limits, those of the model's joints.
pub fn limits_of_joints(model: &Model) -> Ranges {
    let mut ranges = Ranges::default();
    for (index, joint) in model.joints.iter().enumerate() {
        if let Some([least, most]) = joint.limits {
            ranges.set("q", [index as u32 + 1, 0], least, most);
        }
    }
    ranges
}

/// Number of first bytes of a file in which its first element is searched.
const HEAD: usize = 4096;

/// True for a URDF or MJCF file, by its name or else its first element.
pub fn is_robot(name: &str, bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
    let is_first = head.contains("<robot") || head.contains("<mujoco");
    name.ends_with(".urdf") || name.ends_with(".xml") || !name.ends_with(".mbs") && is_first
}

/// Reads a text of a kind.
pub fn text(path: &Path, limit: &FileLimit) -> Result<String, Report> {
    let bytes = limited::read(path, limit)?;
    let name = path.display().to_string();
    utf8(&name, bytes).map_err(|message| Report::error(message, Vec::new()))
}

/// The machine of a name, or of a file.
pub fn machine(name: &str) -> Result<Machine, Report> {
    if let Some(machine) = Machine::built_in(name) {
        return Ok(machine);
    }
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        let names: Vec<&str> = machine::BUILT_IN.iter().map(|(name, _)| *name).collect();
        let mut notes: Vec<String> = suggestion(name, names.iter().copied())
            .into_iter()
            .collect();
        notes.push(format!("machines: {}, or a .toml file", names.join(", ")));
        return Err(Report::error(
            format!("there is no machine '{name}'"),
            notes,
        ));
    }
    let text = String::from_utf8_lossy(&limited::read(path, &limited::MACHINE)?).into_owned();
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
        Report::of(&display_name(path), text, vec![diagnostic])
    })
}

fn utf8(name: &str, bytes: Vec<u8>) -> Result<String, String> {
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        format!("{name} is not UTF-8 text: byte {} is not valid", valid + 1)
    })?;
    Ok(robovec_robotran::with_line_feeds(text.into()).into_owned())
}
