//! A file: header comments, prologue, statements, end.
//!
//! Robotran's files do not declare their arrays: the reader knows those by
//! joint and infers others from the largest index. Any other extent is in a
//! line of the header, which Robotran ignores.
//!
//! C files are those of [`robovec_cgen::kind`], Matlab files those of generator
//! 6.6, the only one that writes Matlab. Where Robotran has no such file in a
//! language (`accelred` in Matlab and Python) the signature is the natural
//! counterpart.

use super::arrays::{ArrayRole, FileArrays};
use super::error::RobotranWriteError;
use super::function_text::FunctionText;
use super::names::{FileIdentifiers, identifiers, kept};
use super::plan::{WrittenStatement, plan};
use super::prologue::Prologue;
use super::text::{FileText, comment_mark};
use super::{Member, WriteOptions};
use crate::Language;
use crate::conventions::least_extent;
use hashbrown::{HashMap, HashSet};
use robovec_cgen::c::SignatureError;
use robovec_cgen::kind::{Generation, file_stem};
use robovec_ir::{Function, Input, Module, Shape, Symbols};
use rustc_hash::FxBuildHasher;
use std::fmt::Write;

pub(super) struct RobotranFile<'a> {
    pub(super) kind: EquationKind,
    pub(super) language: Language,
    pub(super) symbols: &'a Symbols,
    pub(super) model: String,
    /// The model's name as part of a file name.
    pub(super) stem: String,
    pub(super) joints: Option<u32>,
    pub(super) functions: Vec<&'a Function>,
    /// The number of each, for sensors.
    pub(super) cases: Vec<Option<u32>>,
    pub(super) plans: Vec<Vec<WrittenStatement>>,
    pub(super) arrays: FileArrays,
    pub(super) names: FileIdentifiers,
    /// Per function the temporaries of input elements that are overwritten.
    pub(super) kept: Vec<HashMap<Input, Box<str>, FxBuildHasher>>,
    pub(super) zeros: bool,
    pub(super) all_parameter_symbols: bool,
}

impl<'a> RobotranFile<'a> {
    pub(super) fn new(
        module: &'a Module,
        members: &[Member<'a>],
        language: Language,
        options: &WriteOptions,
    ) -> Result<RobotranFile<'a>, RobotranWriteError> {
        let symbols = &module.tables.symbols;
        let kind = members[0].kind;
        let functions: Vec<&Function> = members.iter().map(|member| member.function).collect();
        let first = functions[0];
        let is_old = Generation::of(first) == Generation::Old;
        if language == Language::C && is_old && kind.has_status() {
            let error = SignatureError::OldStatus(first.name.clone());
            return Err(RobotranWriteError::Signature(error));
        }
        let unnumbered = members.iter().find(|member| {
            kind.is_sensor() && member.case.is_none() && !member.function.assignments.is_empty()
        });
        if let Some(member) = unnumbered {
            return Err(RobotranWriteError::Case {
                function: member.function.name.clone(),
            });
        }
        let mut functions_of_numbers = functions.iter();
        if let Some(function) = functions_of_numbers.find(|function| {
            function
                .constants()
                .iter()
                .any(|number| !number.is_finite())
        }) {
            return Err(RobotranWriteError::Number {
                function: function.name.clone(),
            });
        }
        let arrays = FileArrays::new(&functions, kind, symbols, language)?;
        let shared = language != Language::Matlab;
        let plans: Vec<Vec<WrittenStatement>> = functions
            .iter()
            .map(|function| plan(function, symbols, shared))
            .collect::<Result<_, _>>()?;
        let mut names = identifiers(&functions, symbols, &arrays);
        let kept = (functions.iter().zip(&plans))
            .map(|(function, plan)| kept(function, plan, &mut names, symbols))
            .collect();
        let model = options.model.as_deref().or(first.metadata("model"));
        let model: String = model
            .unwrap_or("model")
            .chars()
            .filter(|character| !character.is_control())
            .collect();
        Ok(RobotranFile {
            kind,
            language,
            symbols,
            stem: file_stem(&model),
            model,
            joints: joints(first, &arrays),
            cases: members.iter().map(|member| member.case).collect(),
            plans,
            functions,
            arrays,
            names,
            kept,
            zeros: options.zeros,
            all_parameter_symbols: first.metadata("all_parameter_symbols").is_some(),
        })
    }

    /// The files: the equations, and in C the header beside them.
    pub(super) fn write(&self) -> Result<Vec<(String, String)>, RobotranWriteError> {
        let mut body = FunctionText::new(self.language);
        self.statements(&mut body)?;
        let most = body.text.most_continuations();
        let (statements, _) = body.text.finish();
        let mut text = FileText::new(self.language);
        self.header(&mut text, body.printer.count());
        Prologue {
            kind: self.kind,
            stem: &self.stem,
            joints: self.joints,
            arrays: &self.arrays,
            function: self.functions[0],
        }
        .write(&mut text);
        let (mut file, _) = text.finish();
        file.push_str(&statements);
        let mark = comment_mark(self.language);
        if self.language == Language::C && self.kind.has_status() {
            file.push_str("\nreturn 0;\n");
        }
        file.push_str(&format!("\n{mark} Number of continuation lines = {most}\n"));
        if self.language == Language::C {
            file.push_str("\n}\n");
        }
        let stem = format!("mbs_{}_{}", self.kind.name, self.stem);
        let extension = match self.language {
            Language::C => "c",
            Language::Matlab => "m",
            Language::Python => "py",
        };
        let mut files = vec![(format!("{stem}.{extension}"), file)];
        if self.language == Language::C {
            let mut header = FileText::new(self.language);
            own_mark(&mut header);
            let (header, _) = header.finish();
            files.push((format!("{stem}.h"), header + &body.declarations));
        }
        Ok(files)
    }

    fn header(&self, text: &mut FileText, flops: usize) {
        text.comment("");
        own_mark(text);
        text.comment("");
        text.comment(&format!("\t==> Project name : {}", self.model));
        if self.all_parameter_symbols {
            text.comment("\t==> All Parameter Symbols included");
        }
        if let Some(joints) = self.joints {
            text.comment(&format!("\t==> Number of joints : {joints}"));
        }
        let number = match self.kind.number {
            0 => String::new(),
            number => format!("F {number} : "),
        };
        text.comment(&format!("\t==> Function : {number}{}", self.kind.title));
        text.comment(&format!("\t==> Flops complexity : {flops}"));
        let extents = line(&self.functions, &self.arrays, self.joints.unwrap_or(0));
        if let Some(extents) = extents {
            text.comment(&format!("\t==> Array extents : {extents}"));
        }
        text.comment("");
        text.line("");
    }
}

/// The line by which files written by robovec are known.
fn own_mark(text: &mut FileText) {
    text.comment(&format!(
        "\trobovec - Version {}",
        env!("CARGO_PKG_VERSION")
    ));
}

/// The header's number of joints, else the length of an array by joint.
fn joints(function: &Function, arrays: &FileArrays) -> Option<u32> {
    let said = function
        .metadata("joints")
        .and_then(|text| text.parse().ok());
    let per_joint = ["q", "qd", "qdd", "c", "Qq", "m"];
    let mut known = arrays
        .all
        .iter()
        .filter(|array| per_joint.contains(&array.name.as_str()));
    said.or_else(|| match known.next()?.shape {
        Shape::Vector(length) => Some(length),
        Shape::Scalar | Shape::Matrix(..) => None,
    })
}

/// The entry of the header, `dpt(3,12) h(4)`; `None` when no entry is needed.
pub(super) fn line(functions: &[&Function], arrays: &FileArrays, joints: u32) -> Option<String> {
    let forces = forces(functions);
    let mut line = String::new();
    for array in arrays.all.iter().filter(|array| array.is_used()) {
        let (rows, columns) = array.largest;
        let (known_rows, known_columns) = least_extent(&array.name, joints);
        let force = array.role == ArrayRole::Result && forces.contains(array.name.as_str());
        let nine = if force { 9 } else { 0 };
        let rows = rows.max(known_rows).max(nine).max(1);
        let columns = columns.max(known_columns).max(1);
        // Writing to a string cannot fail.
        let _ = match array.shape {
            Shape::Vector(length) if length != rows => write!(line, " {}({length})", array.name),
            Shape::Matrix(m, n) if (m, n) != (rows, columns) => {
                write!(line, " {}({m},{n})", array.name)
            }
            Shape::Scalar | Shape::Vector(_) | Shape::Matrix(..) => Ok(()),
        };
    }
    (!line.is_empty()).then(|| line.trim_start().to_owned())
}

/// The results of external forces, which have nine numbers.
fn forces<'a>(functions: &[&'a Function]) -> HashSet<&'a str, FxBuildHasher> {
    let calls = functions.iter().flat_map(|function| &function.boundaries);
    let external = calls.filter(|call| {
        matches!(
            call.callee.as_str(),
            "user_ExtForces" | "user_call_ExtForces" | "usrfun.fext"
        )
    });
    external.filter_map(|call| call.result.as_deref()).collect()
}

pub(super) use robovec_cgen::kind::EquationKind;

/// Name of the function of a kind in Matlab or Python; C's have a prefix.
pub(super) fn function_name(kind: EquationKind, language: Language) -> String {
    match (language, kind.name) {
        // MBsysPy finds a `sensor` in both modules.
        (Language::Python, "gensensor") => "sensor".to_owned(),
        (_, name) => name.to_owned(),
    }
}
