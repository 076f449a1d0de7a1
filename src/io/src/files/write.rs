//! One file, written whole.
//!
//! The content goes to a temporary file beside the target, which then takes the
//! target's name: a reader of the target sees the old content or the new one,
//! never half of it. Where replacing the name would change the kind of the
//! target (a device, or a file of other names or of another owner), the target
//! is written into. Symbolic links are followed first.

use super::temporary;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::NamedTempFile;

/// Reason why a file was not written. The old content is then unchanged.
#[derive(Debug, thiserror::Error)]
pub enum FileWriteError {
    /// There is a file that may not be replaced ([`Replace`]).
    #[error("{0} already exists, and robovec did not write it")]
    Foreign(PathBuf),
    /// The system refuses.
    #[error("cannot write {0}: {1}")]
    System(PathBuf, io::Error),
}

/// Maximum number of symbolic links in a chain, as on Linux.
const MAX_LINKS: usize = 40;

/// Removes a file, or a folder with all that is in it, if it is there.
pub fn remove(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        fs::remove_dir_all(path)
    } else if path.exists() {
        fs::remove_file(path)
    } else {
        Ok(())
    }
}

/// Makes a folder, with those above it.
pub fn make_folder(path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)
}

/// Writes a file whole or not at all.
///
/// A target that is no ordinary file (a device such as `/dev/null`, a pipe) is
/// written into while the content is made: replacing its name would remove it.
/// A symbolic link is followed. A file that has other names (hard links) or
/// another owner, or is in a folder where no other file can be made, is written
/// into as well, but only when the content is complete.
///
/// # Errors
///
/// Fails when the name exists and must not be replaced, or the system refuses.
pub fn write_whole(
    path: &Path,
    replace: Replace,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileWriteError> {
    let fail = |error: io::Error| FileWriteError::System(path.to_owned(), error);
    // Names in these folders lead to devices and open files
    // (`/dev/stdout`, `/proc/self/fd/1`), which can look like ordinary files.
    let is_of_system = path.starts_with("/dev") || path.starts_with("/proc");
    match fs::metadata(path) {
        Ok(there) if is_of_system || !there.is_file() => {
            let file = OpenOptions::new()
                .write(true)
                .truncate(there.is_file())
                .open(path);
            file.and_then(|mut file| {
                write(&mut file)?;
                file.flush()
            })
            .map_err(fail)
        }
        Ok(there) => {
            refuse_foreign(path, replace)?;
            let target = fs::canonicalize(path).map_err(fail)?;
            replace_file(&target, &there, write).map_err(fail)
        }
        // Nothing is there, or a link that leads to nothing.
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            create_file(path, write).map_err(fail)
        }
        Err(error) => Err(fail(error)),
    }
}

/// An error when an existing file must not be replaced, before any work.
pub fn refuse_foreign(path: &Path, replace: Replace) -> Result<(), FileWriteError> {
    let is_there = fs::metadata(path).is_ok_and(|there| there.is_file());
    let system = |error: io::Error| FileWriteError::System(path.to_owned(), error);
    if !is_there || may_replace(path, replace).map_err(system)? {
        Ok(())
    } else {
        Err(FileWriteError::Foreign(path.to_owned()))
    }
}

/// Writes a file that does not exist yet.
fn create_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let path = end_of_links(path)?;
    let mut file = temporary::file_in(parent(&path))?;
    write(&mut file)?;
    file.flush()?;
    file.persist(&path).map_err(|error| error.error)?;
    Ok(())
}

/// The final target of symbolic links, even if it does not exist yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        if !fs::symlink_metadata(&path).is_ok_and(|there| there.is_symlink()) {
            return Ok(path);
        }
        let next = fs::read_link(&path)?;
        // A relative link starts at its own folder; an absolute one replaces it.
        path = parent(&path).join(next);
    }
    Err(io::Error::other("too many symbolic links"))
}

/// The folder of a file; the current one for a bare name.
fn parent(path: &Path) -> &Path {
    let folder = path.parent();
    folder
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Writes a file instead of one that is there and may be replaced.
fn replace_file(
    path: &Path,
    there: &Metadata,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    // A file that may not be written is not to be replaced either, though a
    // folder that may be written would allow it.
    OpenOptions::new().write(true).open(path)?;
    let mut file = match temporary::file_in(parent(path)) {
        Ok(file) => file,
        // No file can be made in the folder: the content waits in memory, so
        // that a writer that fails leaves the file as it was.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
            let mut all = Vec::new();
            write(&mut all)?;
            return overwrite(path, &mut all.as_slice());
        }
        Err(error) => return Err(error),
    };
    write(&mut file)?;
    file.flush()?;
    if takes_owner_and_permissions(&file, there)? {
        file.persist(path).map_err(|error| error.error)?;
        return Ok(());
    }
    file.as_file_mut().rewind()?;
    overwrite(path, file.as_file_mut())
}

/// Writes new content into an existing file, which stays the same file.
fn overwrite(path: &Path, from: &mut dyn io::Read) -> io::Result<()> {
    let mut target = File::options().write(true).truncate(true).open(path)?;
    io::copy(from, &mut target)?;
    target.flush()
}

/// Gives a new file the owner and the permissions of the existing file; false
/// when that cannot be, or the existing file has other names (hard links).
#[cfg(unix)]
fn takes_owner_and_permissions(file: &NamedTempFile, there: &Metadata) -> io::Result<bool> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let new = file.as_file().metadata()?;
    if there.nlink() > 1 {
        return Ok(false);
    }
    let owners_differ = (new.uid(), new.gid()) != (there.uid(), there.gid());
    if owners_differ && fchown(file.as_file(), Some(there.uid()), Some(there.gid())).is_err() {
        return Ok(false);
    }
    file.as_file().set_permissions(there.permissions())?;
    Ok(true)
}

/// Gives a new file the permissions of the existing one.
#[cfg(not(unix))]
fn takes_owner_and_permissions(file: &NamedTempFile, there: &Metadata) -> io::Result<bool> {
    file.as_file().set_permissions(there.permissions())?;
    Ok(true)
}

/// Files that a written file may replace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Replace {
    /// Anything: the user requested it, or it is in a folder of robovec's.
    Anything,
    /// Results: all but files of programs and models of others than robovec.
    Results,
    /// Files that robovec wrote, known by a line they carry, and empty files.
    Own,
    /// Files that are empty.
    Nothing,
}

/// Ends of the names of files that people write by hand.
const WRITTEN_BY_HAND: [&str; 19] = [
    "c", "h", "cc", "cpp", "hpp", "m", "py", "rs", "v", "sv", "vhd", "sh", "mbs", "rvir", "rules",
    "toml", "md", "tex", "tcl",
];

/// Number of bytes at the beginning of a file that are searched for its mark.
const HEAD: u64 = 4096;

/// Parts of lines that the files written by robovec have in their head: the
/// text form, C of every kind, Robotran's languages, hardware, projects and
/// scripts, manifests and descriptions, and reproducers.
const MARKS: [&str; 7] = [
    "// robovec ",
    " by robovec",
    "robovec - Version ",
    "Generated by robovec",
    "Written by robovec",
    "\"robovec\":",
    "// reproduce: robovec-opt ",
];

/// True while any file may be replaced.
static FORCED: AtomicBool = AtomicBool::new(false);

/// Sets whether any file may be replaced from now on, in the whole process.
pub fn set_force(force: bool) {
    FORCED.store(force, Ordering::Relaxed);
}

/// True when an existing file may be replaced: of a link, name and target.
pub(super) fn may_replace(path: &Path, replace: Replace) -> io::Result<bool> {
    if FORCED.load(Ordering::Relaxed) {
        return Ok(true);
    }
    let is_hand = |path: &Path| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|end| WRITTEN_BY_HAND.contains(&end))
    };
    match replace {
        Replace::Anything => Ok(true),
        Replace::Results if !is_hand(path) && !is_hand(&fs::canonicalize(path)?) => Ok(true),
        Replace::Results | Replace::Own => {
            let head = head(path)?;
            Ok(head.is_empty() || is_own(&head))
        }
        Replace::Nothing => Ok(head(path)?.is_empty()),
    }
}

fn head(path: &Path) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    File::open(path)?.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

/// True when the head of a file has a mark of robovec's.
fn is_own(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    let mut lines = head.lines();
    lines.any(|line| MARKS.iter().any(|mark| line.contains(mark)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(path: &Path, replace: Replace, text: &str) -> Result<(), FileWriteError> {
        write_whole(path, replace, |writer| writer.write_all(text.as_bytes()))
    }

    fn read(path: &Path) -> String {
        fs::read_to_string(path).expect("it can be read")
    }

    #[test]
    fn a_writer_that_fails_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("x.txt");
        fs::write(&path, "before").expect("written");
        let failed = write_whole(&path, Replace::Anything, |writer| {
            writer.write_all(b"half")?;
            Err(io::Error::other("no more"))
        });
        assert!(matches!(failed, Err(FileWriteError::System(..))));
        assert_eq!(read(&path), "before");
        let left = fs::read_dir(folder.path()).expect("it is there").count();
        assert_eq!(left, 1, "nothing but the file");
    }

    #[cfg(unix)]
    #[test]
    fn modes_links_and_names_stay() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| folder.path().join(name);
        fs::write(at("x"), "before").expect("written");
        fs::set_permissions(at("x"), fs::Permissions::from_mode(0o750)).expect("set");
        symlink("x", at("link")).expect("made");
        text(&at("link"), Replace::Anything, "after").expect("written");
        assert!(
            fs::symlink_metadata(at("link"))
                .expect("there")
                .is_symlink()
        );
        assert_eq!(read(&at("x")), "after");
        let mode = fs::metadata(at("x")).expect("there").mode();
        assert_eq!(mode & 0o7777, 0o750);
        fs::hard_link(at("x"), at("other")).expect("made");
        text(&at("x"), Replace::Anything, "short").expect("written");
        assert_eq!(read(&at("other")), "short");
        symlink("nothing/there", at("lost")).expect("made");
        assert!(text(&at("lost"), Replace::Anything, "").is_err());
        symlink("new", at("first")).expect("made");
        text(&at("first"), Replace::Anything, "made").expect("written");
        assert_eq!(read(&at("new")), "made");
        symlink("round", at("round")).expect("made");
        assert!(text(&at("round"), Replace::Anything, "").is_err());
    }

    #[test]
    fn what_others_wrote_stays() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("x.c");
        for (content, replace, replaced) in [
            ("int x;", Replace::Own, false),
            ("int x;", Replace::Results, false),
            ("int x;", Replace::Nothing, false),
            ("int x;", Replace::Anything, true),
            ("// robovec 1\n", Replace::Own, true),
            ("// robovec 1\n", Replace::Results, true),
            ("// robovec 1\n", Replace::Nothing, false),
            ("", Replace::Own, true),
            ("", Replace::Nothing, true),
        ] {
            fs::write(&path, content).expect("written");
            let done = text(&path, replace, "new");
            assert_eq!(done.is_ok(), replaced, "{content:?} {replace:?}");
            let expected = if replaced { "new" } else { content };
            assert_eq!(read(&path), expected);
        }
        let table = folder.path().join("table.csv");
        fs::write(&table, "1,2").expect("written");
        text(&table, Replace::Results, "3,4").expect("a result");
        assert!(text(&table, Replace::Own, "5,6").is_err());
    }

    #[test]
    fn files_of_others_are_known() {
        let robotran = "//\n//\tROBOTRAN - Version 6.6\n//\n//\t==> Project name : robovec\n";
        for foreign in [
            robotran,
            "double x;\n",
            "-- by hand\n",
            "#include \"robovec.h\"\n",
        ] {
            assert!(!is_own(foreign.as_bytes()), "{foreign}");
        }
        for own in [
            "// robovec 1\n",
            "//\n//\trobovec - Version 0.1.0\n",
            "%\n%\trobovec - Version 0.1.0\n",
            "/* dirdyna by robovec. Arrays count from 1 */\n",
            "// RUN: cse\n// reproduce: robovec-opt FILE --passes=cse\n",
            "{\n  \"robovec\": \"0.1.0\",\n",
        ] {
            assert!(is_own(own.as_bytes()), "{own}");
        }
    }
}
