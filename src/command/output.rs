//! Results to files and to the standard output, mistakes as messages.

use super::CommandFailure;
use robovec_io::files::{self, FileWriteError, Replace};
use robovec_present::{DataTable, Figure, plot};
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

/// As [`write_file`], with another message.
pub(crate) fn write_over(
    path: &Path,
    replace: Replace,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CommandFailure> {
    files::write_whole(path, replace, write).map_err(|error| failure(&error))
}

/// Writes files that belong together, given as (name, text), into a folder.
pub(crate) fn write_folder(
    folder: &Path,
    files: &[(&str, &str)],
    replace: Replace,
) -> Result<(), CommandFailure> {
    files::sealed::write_folder(folder, files, replace).map_err(|error| failure(&error))
}

/// Writes files, given as (name, text), into a folder, which is made.
pub(crate) fn write_files<N: AsRef<str>>(
    folder: &Path,
    files: &[(N, String)],
) -> Result<(), CommandFailure> {
    let files: Vec<(&str, &str)> = files
        .iter()
        .map(|(name, text)| (name.as_ref(), text.as_str()))
        .collect();
    write_folder(folder, &files, Replace::Results)
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

/// Refuses, before any work, files of a folder that may not be replaced by its
/// result.
pub(crate) fn refuse_foreign(
    folder: Option<&Path>,
    names: &[&str],
    replace: Replace,
) -> Result<(), CommandFailure> {
    let paths = folder.into_iter().flat_map(|folder| {
        let join = |name: &&str| {
            if name.is_empty() {
                folder.to_owned()
            } else {
                folder.join(name)
            }
        };
        names.iter().map(join)
    });
    for path in paths {
        files::refuse_foreign(&path, replace).map_err(|error| failure(&error))?;
    }
    Ok(())
}

fn failure(error: &FileWriteError) -> CommandFailure {
    let notes = match error {
        FileWriteError::System(..) => Vec::new(),
        FileWriteError::Foreign(_) => {
            vec!["name another place, or replace it with --force".to_owned()]
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
