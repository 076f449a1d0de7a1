//! The writer of Robotran's files: the inverse of the reader.
//!
//! A module becomes the files of Robotran, with the same names and signatures,
//! so that they replace Robotran's in a project of MBsysC, MBsysLab or MBsysPy;
//! reading them gives the functions back, node by node.
//!
//! **Omissions.** Only the elements that the function sets are set, as in
//! Robotran's files. Elements of `M` and `Jac` that are zero in all states keep
//! the caller's zeros: MBsysC allocates both zeroed, once, and nothing else
//! writes to them; Matlab's files begin by `M = zeros(n,n)`. A caller that does
//! not clear its arrays needs [`WriteOptions::zeros`]. `frc` and `trq` are
//! added to, and cleared by MBsysC before each evaluation.
//!
//! **Memory.** In C and Python the `frc` given and the `frc` given back are one
//! array, and so are the coordinates of `accelred`. All definitions therefore
//! are before the first output, and values that a later output reads are copied
//! first ([`plan`]).
//!
//! **Names.** One identifier for every language ([`names`]); an operator
//! ends a line that grows too long ([`text`]); parentheses are where the
//! order of evaluation needs them and nowhere else ([`expression`]).
//!
//! Everything is linear in the size of the function, and nothing recurses.

mod arrays;
mod body;
mod error;
mod expression;
mod file;
mod function_text;
mod names;
mod plan;
mod prologue;
mod text;

pub use error::RobotranWriteError;

use super::Language;
use file::{EquationKind, RobotranFile};
use hashbrown::HashMap;
use robovec_ir::{Function, Module};
use rustc_hash::FxBuildHasher;

/// Options of the writer.
#[derive(Clone, Default, Debug)]
pub struct WriteOptions {
    /// Name of the model for files and headers; else the metadata's or `model`.
    pub model: Option<String>,
    /// Set also the elements of outputs that the function leaves alone, to 0.
    /// Reading such a file gives a function with more outputs.
    pub zeros: bool,
}

/// A function and its place among the files.
#[derive(Clone, Copy, Debug)]
struct Member<'a> {
    kind: EquationKind,
    case: Option<u32>,
    function: &'a Function,
}

/// Writes every function of a module: a file for each kind of function, with
/// all sensors (`sensor_1`, `sensor_2` …) in one, and beside each C file the
/// header that declares its temporaries. Gives names and texts of the files.
///
/// # Errors
///
/// Fails when the module has parts that Robotran's files cannot express.
pub fn write(
    module: &Module,
    language: Language,
    options: &WriteOptions,
) -> Result<Vec<(String, String)>, RobotranWriteError> {
    let mut groups: Vec<Vec<Member<'_>>> = Vec::new();
    let mut places: HashMap<(&str, Option<u32>), &str, FxBuildHasher> = HashMap::default();
    for function in &module.functions {
        let member = place(function)?;
        let kind = member.kind.name;
        let same = places.insert((kind, member.case), &function.name);
        let mut known = groups.iter_mut();
        let group = known.find(|group| group[0].kind == member.kind);
        // A file has either one function or numbered ones.
        let mixed = group.as_ref().map(|group| group[0]);
        let mixed = mixed.filter(|first| first.case.is_some() != member.case.is_some());
        if let Some(first) = same.or(mixed.map(|first| first.function.name.as_str())) {
            return Err(RobotranWriteError::Twice {
                first: first.to_owned(),
                second: function.name.clone(),
            });
        }
        match group {
            None => groups.push(vec![member]),
            Some(group) => group.push(member),
        }
    }
    if groups.is_empty() {
        return Err(RobotranWriteError::Empty);
    }
    let mut files = Vec::new();
    for group in groups {
        files.extend(RobotranFile::new(module, &group, language, options)?.write()?);
    }
    Ok(files)
}

/// File of a function: by metadata of the file it came from, else by its name.
fn place(function: &Function) -> Result<Member<'_>, RobotranWriteError> {
    if function.metadata("part").is_some() {
        return Err(RobotranWriteError::Part {
            function: function.name.clone(),
        });
    }
    let (kind, number) = EquationKind::of(function).ok_or_else(|| RobotranWriteError::Kind {
        function: function.name.clone(),
    })?;
    Ok(Member {
        kind,
        case: number,
        function,
    })
}
