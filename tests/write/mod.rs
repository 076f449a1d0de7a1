//! The writer of Robotran's files: its files read back as the same function, in
//! every language, and compile to the same numbers.

mod command;
mod evaluated;
mod round_trips;
mod same;

use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_ir::Module;
use std::path::{Path, PathBuf};

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
