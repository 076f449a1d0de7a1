//! The writer of Robotran's files: what it writes reads back as the function
//! it was, in every language, and compiles to the same numbers.

mod command;
mod evaluated;
mod round_trips;
mod same;

use crate::compiled::{Outcome, Subject, compare, has_gcc};
use crate::support::files::{compare_with_record, each};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{FunctionKind, Language, read};
use robovec_codegen::c::{Options, Real, Signature as CSignature, Sines, files as c_files};
use robovec_framework::manager::{self, Config};
use robovec_framework::rewrite::lay_out;
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_ir::parse::parse_module;
use robovec_ir::print::{print_module, print_output};
use robovec_ir::verify::verify;
use robovec_ir::{
    Array, Assignment, Function, Input, Machine, Module, Name, Node, Operand, OperandKind, Output,
    Symbol, View, same_equations,
};
use robovec_num::arithmetic::Binary64;
use robovec_passes::registry::REGISTRY;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;

fn read_file(path: &Path) -> Option<Module> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    let bytes = std::fs::read(path).ok()?;
    Some(read(&name, &bytes, None).ok()?.module)
}

/// Writes a module whose functions are of one kind and reads the result.
fn around(module: &Module, language: Language) -> Module {
    let files = match write(module, language, &WriteOptions::default()) {
        Ok(files) => files,
        Err(error) => panic!("{error}"),
    };
    let (name, text) = &files[0];
    match read(name, text.as_bytes(), None) {
        Ok(read) => read.module,
        Err(error) => panic!("{}\n{text}", error.report.render_plain()),
    }
}

fn equation_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            equation_files(&path, files);
            continue;
        }
        let name = path
            .file_name()
            .expect("an entry has a name")
            .to_string_lossy();
        let extension = name.rsplit('.').next().unwrap_or_default();
        if name.starts_with("mbs_") && ["c", "m", "py"].contains(&extension) {
            files.push(path);
        }
    }
    files.sort();
}
