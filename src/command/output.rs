//! Files that appear whole or not at all.

use super::Failure;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Writes a file through a temporary one beside it, which takes its name only
/// when all is written. What is there and is no ordinary file (a device such
/// as `/dev/null`, a pipe) is written into as it is: taking its name would
/// remove it.
pub(crate) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let attempt = || -> io::Result<()> {
        if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            let mut special = fs::OpenOptions::new().write(true).open(path)?;
            write(&mut special)?;
            return special.flush();
        }
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let mut file = NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
        write(&mut file)?;
        file.flush()?;
        make_readable(&file)?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    attempt().map_err(|error| Failure::plain(format!("cannot write {}: {error}", path.display())))
}

/// Temporary files are private; results have the usual permissions.
#[cfg(unix)]
fn make_readable(file: &NamedTempFile) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file()
        .set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_file: &NamedTempFile) -> io::Result<()> {
    Ok(())
}

/// Makes a folder, with those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| {
        Failure::plain(format!(
            "cannot make the folder {}: {error}",
            path.display()
        ))
    })
}

/// Writes to the standard output; a reader that has gone away is no error.
pub(crate) fn write_stdout(
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match write(&mut stdout).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::plain(format!(
            "cannot write to the standard output: {error}"
        ))),
        Ok(()) | Err(_) => Ok(()),
    }
}
