//! Robotran's file, unchanged.
//!
//! The file is compiled unchanged, beside its own header, against a data
//! structure that has the fields it reads and no others. Matlab, Python and a
//! model's equations are written as one C function first.

use super::BenchQuestion;
use super::contestant::{Contestant, ContestantFamily};
use super::functions::outputs;
use super::harness::{self, Callee, CallingConvention, Parameter};
use super::own::ContestantPlan;
use super::tools::{BuildStep, Compiler};
use robovec_cgen::c::{self, Real};
use robovec_cgen::superword::SuperwordLanes;
use robovec_ir::{Module, View};
use robovec_robotran::Language;
use robovec_robotran::write::{WriteOptions, write};
use std::fmt::Write;
use std::path::Path;

/// Flags of the comparison.
pub const FLAGS: &str = "-O3 -march=native";

/// Robotran's C file, with the files beside it.
pub fn file(question: &BenchQuestion<'_>, compiler: &Compiler, path: &Path) -> Contestant {
    let text = match std::fs::read(path) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) => return missing(question, error.to_string()),
    };
    let folder = path.parent().expect("a file lies in a folder");
    let beside = |name: &str| std::fs::read(folder.join(name)).ok();
    contestant(&plan(question, compiler, "Robotran's file"), &text, &beside)
}

/// Equations written as one C function, as Robotran prints them.
pub fn printed(question: &BenchQuestion<'_>, compiler: &Compiler, module: &Module) -> Contestant {
    let files = match write(module, Language::C, &WriteOptions::default()) {
        Ok(files) => files,
        Err(error) => return missing(question, error.to_string()),
    };
    let Some((_, text)) = files.iter().find(|(name, _)| name.ends_with(".c")) else {
        return missing(question, "there is no C file".to_owned());
    };
    let beside = |wanted: &str| {
        let found = files.iter().find(|(name, _)| name == wanted);
        found.map(|(_, text)| text.clone().into_bytes())
    };
    contestant(
        &plan(question, compiler, "as Robotran prints it"),
        text,
        &beside,
    )
}

/// The equations of a question as Robotran's.
fn plan<'a>(
    question: &'a BenchQuestion<'a>,
    compiler: &'a Compiler,
    name: &'a str,
) -> ContestantPlan<'a> {
    ContestantPlan {
        question,
        compiler,
        family: ContestantFamily::Robotran,
        name,
        view: question.view,
        superwords: SuperwordLanes::None,
    }
}

/// Robovec's C with Robotran's signature, in its place.
pub fn drop_in(plan: &ContestantPlan<'_>) -> Contestant {
    let options = c::Options {
        superwords: plan.superwords,
        ..c::Options::default()
    };
    let [(_, text), (header, declaration)] = match c::files(plan.view, &options) {
        Ok(files) => files,
        Err(error) => return plan.missing(error.to_string()),
    };
    let beside = |wanted: &str| (wanted == header).then(|| declaration.clone().into_bytes());
    contestant(plan, &text, &beside)
}

/// Robotran's file that cannot take part, and why.
pub fn missing(question: &BenchQuestion<'_>, message: String) -> Contestant {
    Contestant {
        missing: Some(message),
        ..Contestant::named(
            "Robotran's file",
            ContestantFamily::Robotran,
            outputs(question.view),
        )
    }
}

/// A C file with a signature of Robotran's, beside files of some names.
fn contestant(
    plan: &ContestantPlan<'_>,
    text: &str,
    beside: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Contestant {
    let ContestantPlan {
        question,
        compiler,
        view,
        ..
    } = *plan;
    let flags = question.flags_or(FLAGS);
    let Some((function, declaration, parameters)) = signature(text) else {
        return missing(
            question,
            "its signature is not that of a function of Robotran".to_owned(),
        );
    };
    let mut files = vec![("function.c".to_owned(), text.as_bytes().to_vec())];
    let mut data = None;
    for header in included(text) {
        let own = beside(&header);
        let is_data = header.to_ascii_lowercase().contains("data");
        let content = match own {
            Some(content) if !is_data => content,
            _ if is_data && data.is_none() => {
                data = Some(header.clone());
                harness::data_header(view).into_bytes()
            }
            _ if header.contains(&function) || header.contains("dirdyna") => temporaries(view),
            _ => Vec::new(),
        };
        files.push((header, content));
    }
    let Some(data) = data else {
        return missing(question, "it includes no header of data".to_owned());
    };
    let header = format!("#include \"{data}\"\n{declaration};");
    let call = CallingConvention::Robotran(parameters);
    let callee = Callee {
        view,
        real: Real::Double,
        call: &call,
        header: &header,
        name: &function,
    };
    let command = &compiler.command;
    let steps = vec![
        BuildStep::new(command, flags)
            .with("-w")
            .with("-c")
            .with("function.c")
            .function("function.o"),
        BuildStep::new(command, "-O2 -o program main.c function.o -lm"),
    ];
    plan.program(&callee, files, flags, steps)
}

/// The headers that a file includes in quotes.
fn included(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for line in text.lines() {
        let rest = line.trim_start().strip_prefix("#include");
        let Some(rest) = rest.and_then(|rest| rest.trim_start().strip_prefix('"')) else {
            continue;
        };
        if let Some((name, _)) = rest.split_once('"')
            && !name.contains(['/', '\\'])
            && !names.iter().any(|known| known == name)
        {
            names.push(name.to_owned());
        }
    }
    names
}

/// A header that declares every named value.
fn temporaries(view: View<'_>) -> Vec<u8> {
    let mut text = String::new();
    for (_, node) in view.function.values() {
        if !node.name.is_none() {
            let name = node.name.display(&view.tables.symbols);
            let _ = writeln!(text, "double {};", name.replace('.', "_"));
        }
    }
    text.into_bytes()
}

/// Name, declaration and parameters of a file's first function in Robotran's
/// interface: it takes the data structure, and is not local to the file.
fn signature(text: &str) -> Option<(String, String, Vec<Parameter>)> {
    let code: String = text
        .lines()
        .map(|line| line.split("//").next().expect("a text has a first part"))
        .collect::<Vec<_>>()
        .join("\n");
    let starts = code.match_indices('\n').map(|(place, _)| place + 1);
    let mut lines = [0].into_iter().chain(starts).map(|place| &code[place..]);
    lines.find_map(declaration)
}

/// The declaration a text begins with; a function may return a success flag.
fn declaration(text: &str) -> Option<(String, String, Vec<Parameter>)> {
    let returned = ["void", "int"]
        .into_iter()
        .find_map(|word| text.strip_prefix(word));
    let start = text.len()
        - returned
            .filter(|rest| rest.starts_with(char::is_whitespace))?
            .len();
    let open = text.find('(')?;
    let close = text.find(')')?;
    let name = text[start..open.max(start)].trim().to_owned();
    if open > close || name.is_empty() || name.contains(char::is_whitespace) {
        return None;
    }
    let mut parameters = Vec::new();
    for parameter in text[open + 1..close].split(',') {
        let stars = parameter.matches('*').count();
        let words: Vec<&str> = parameter
            .split(|character: char| character == '*' || character.is_whitespace())
            .filter(|word| !word.is_empty() && *word != "restrict")
            .collect();
        parameters.push(match (words.as_slice(), stars) {
            (["MbsData" | "MBSdataStruct", _], 1) => Parameter::Data,
            (["double", name], 0) => Parameter::Scalar((*name).to_owned()),
            (["double", name], 1 | 2) => Parameter::Output((*name).to_owned()),
            _ => return None,
        });
    }
    let declaration = text[..=close].to_owned();
    let is_robotrans = parameters.contains(&Parameter::Data);
    is_robotrans.then_some((name, declaration, parameters))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_of_both_generators_are_understood() {
        let text = "// void no(void)\nstatic void part(double *work)\n{}\n#include <math.h>\n#include \"MBSdataStructR7.h\"\nvoid dirdyna(double **M,double *c,\nMBSdataStruct *s, double tsim)\n\n// double M[3][3];\n{ ";
        let (name, declaration, parameters) =
            signature(text).expect("it is a signature of Robotran's");
        assert_eq!(name, "dirdyna");
        assert!(declaration.starts_with("void dirdyna(double **M,"));
        let output = |name: &str| Parameter::Output(name.to_owned());
        let time = Parameter::Scalar("tsim".to_owned());
        assert_eq!(
            parameters,
            [output("M"), output("c"), Parameter::Data, time]
        );
        assert_eq!(included(text), ["MBSdataStructR7.h"]);
    }

    #[test]
    fn results_can_be_left_in_the_data() {
        let text = "int mbs_accelred(MbsData *s, double tsim)\n{";
        let (name, declaration, parameters) =
            signature(text).expect("it is a signature of Robotran's");
        assert_eq!(name, "mbs_accelred");
        assert_eq!(declaration, "int mbs_accelred(MbsData *s, double tsim)");
        let time = Parameter::Scalar("tsim".to_owned());
        assert_eq!(parameters, [Parameter::Data, time]);
    }

    #[test]
    fn other_functions_are_refused() {
        assert_eq!(signature("void user(int n, MbsData *s) {"), None);
        assert_eq!(signature("nothing"), None);
    }
}
