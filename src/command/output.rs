//! Results to files and to the standard output, mistakes as messages; names of
//! files that promise another content than they would get.

use super::CommandFailure;
use robovec_io::files::{self, FileWriteError, Replace};
use robovec_present::{DataTable, Figure, plot};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file of results whole or not at all, never over the user's own.
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

/// The files of a table of results: itself, its data, and its figure.
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

/// Refuses, before any work, files that its result may not replace.
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

/// Ends of names of files that robovec's own text is not.
const OTHER_LANGUAGES: [&str; 14] = [
    "c", "h", "m", "py", "rs", "mlir", "ll", "v", "sv", "mif", "hex", "json", "toml", "mbs",
];

/// Refuses to put a result into a file whose name promises another language.
pub(super) fn refuse_wrong(path: &Path, is_text: bool) -> Result<(), CommandFailure> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
    let path = path.display();
    if is_text && OTHER_LANGUAGES.contains(&end) {
        let advice = match end {
            "c" | "h" => "for C, end the pipeline with codegen{target=c} and name a folder",
            "mif" | "hex" => "for images, end the pipeline with place,codegen{target=mif}",
            "v" | "sv" => "for hardware, end the pipeline with place,codegen{target=rtl}",
            "rs" => "for Rust, end the pipeline with codegen{target=rust}",
            "mlir" => "for MLIR, end the pipeline with codegen{target=mlir}",
            "ll" => "for LLVM IR, end the pipeline with codegen{target=llvm}",
            "m" | "py" => "'robovec gen' writes Matlab and Python",
            _ => "reports go into other files: --report FILE",
        };
        let notes = vec![
            "robovec's text goes into a file whose name ends in .rvir".to_owned(),
            advice.to_owned(),
        ];
        let message = format!(
            "the result is robovec's text, which cannot be written to a file with the name {path}"
        );
        return Err(CommandFailure::advised(message, notes));
    }
    if !is_text && end == "rvir" {
        return Err(CommandFailure::advised(
            format!("the result is generated code, but the name {path} is for robovec's text"),
            vec![
                "give it the ending of its language, for example x.c, or leave 'codegen' out"
                    .to_owned(),
            ],
        ));
    }
    Ok(())
}

/// Refuses to make a folder with the name of a file.
pub(super) fn refuse_for_several(folder: &Path, count: usize) -> Result<(), CommandFailure> {
    let end = folder.extension().and_then(|end| end.to_str());
    let is_file = end.is_some_and(|end| end == "rvir" || OTHER_LANGUAGES.contains(&end));
    if !is_file || folder.is_dir() {
        return Ok(());
    }
    Err(CommandFailure::advised(
        format!(
            "the pipeline made {count} files, and {} is a name for one",
            folder.display()
        ),
        vec!["name a folder for them: -o FOLDER".to_owned()],
    ))
}
