//! Results to files and to the standard output, mistakes as messages.

use super::CommandFailure;
use crate::files::{self, FileWriteError, Replace};
use crate::present::{DataTable, Figure, plot};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file of results whole or not at all; files of programs and models
/// that robovec did not write stay.
pub(crate) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CommandFailure> {
    write_over(path, Replace::Results, write)
}

/// As [`write_file`], replacing what is said.
pub(crate) fn write_over(
    path: &Path,
    replace: Replace,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CommandFailure> {
    files::write_whole(path, replace, write).map_err(|error| failure(&error, replace))
}

/// Writes files that belong together, given as (name, text), into a folder.
pub(crate) fn write_folder(
    folder: &Path,
    files: &[(&str, &str)],
    replace: Replace,
) -> Result<(), CommandFailure> {
    files::sealed::write_folder(folder, files, replace).map_err(|error| failure(&error, replace))
}

/// Writes files, given as (name, text), into a folder, which is made.
pub(crate) fn write_files<N: AsRef<str>>(
    folder: &Path,
    files: &[(N, String)],
) -> Result<(), CommandFailure> {
    make_folder(folder)?;
    for (name, text) in files {
        write_file(&folder.join(name.as_ref()), |writer| {
            writer.write_all(text.as_bytes())
        })?;
    }
    Ok(())
}

/// The files of a table of results, all under its name: itself, its data for
/// programs, and its figure.
pub(crate) fn result_files(
    table: &DataTable,
    data: String,
    figure: &Figure,
) -> Vec<(String, String)> {
    let name = &table.name;
    vec![
        (format!("{name}.csv"), table.to_csv()),
        (format!("{name}.json"), data),
        (format!("{name}.svg"), plot::draw(figure)),
    ]
}

/// What an option `--force` makes of what may be replaced without it.
pub(crate) fn forced(force: bool, usual: Replace) -> Replace {
    match force {
        true => Replace::Anything,
        false => usual,
    }
}

fn failure(error: &FileWriteError, replace: Replace) -> CommandFailure {
    let notes = match (error, replace) {
        (FileWriteError::System(..), _) => Vec::new(),
        (FileWriteError::Foreign(_), Replace::Own | Replace::Nothing) => {
            vec!["name another place, or replace it with --force".to_owned()]
        }
        (FileWriteError::Foreign(_), Replace::Results | Replace::Anything) => {
            vec!["name another place, or remove the file first".to_owned()]
        }
    };
    CommandFailure::advised(error.to_string(), notes)
}

/// Makes a folder, with those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), CommandFailure> {
    files::make_folder(path).map_err(|error| {
        CommandFailure::plain(format!(
            "cannot make the folder {}: {error}",
            path.display()
        ))
    })
}

/// Writes to the standard output; a reader that has gone away is no error.
pub(crate) fn write_stdout(
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CommandFailure> {
    let mut stdout = io::stdout().lock();
    match write(&mut stdout).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CommandFailure::plain(
            format!("cannot write to the standard output: {error}"),
        )),
        Ok(()) | Err(_) => Ok(()),
    }
}
