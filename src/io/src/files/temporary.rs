//! Temporary files and folders, and the removal of those left by killed runs.
//!
//! A temporary file or folder has a name of one pattern and is locked as long
//! as its run lives; the system opens the lock when the run ends, however it
//! ends. So a name of the pattern without a lock has no owner, and the next run
//! removes it. Where the file system has no locks no file is removed.
//!
//! **Invariant.** Only files that match the pattern, belong to the same user
//! and are not locked are removed.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::{Builder, NamedTempFile, TempDir};

const PREFIX: &str = ".robovec-";
const SUFFIX: &str = ".part";
const FOLDER_PREFIX: &str = "robovec-";
const LOCK: &str = ".robovec-lock";

/// Number of trials of names that other runs take before they are locked.
const TRIES: usize = 64;

/// Folders in which this run has removed leftovers, with the prefix of these.
static CLEANED: Mutex<BTreeSet<(&str, PathBuf)>> = Mutex::new(BTreeSet::new());

/// True the first time a folder is requested for names with a prefix.
fn is_first(prefix: &'static str, folder: &Path) -> bool {
    let mut cleaned = CLEANED.lock().unwrap_or_else(PoisonError::into_inner);
    cleaned.insert((prefix, folder.to_owned()))
}

/// A locked temporary file in a folder, with permissions by the user's mask.
pub(super) fn file_in(folder: &Path) -> io::Result<NamedTempFile> {
    for _ in 0..TRIES {
        let mut builder = Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(10);
        #[cfg(unix)]
        builder.permissions({
            use std::os::unix::fs::PermissionsExt;
            fs::Permissions::from_mode(0o666)
        });
        let file = builder.tempfile_in(folder)?;
        if !lock(file.as_file()) || fs::symlink_metadata(file.path()).is_err() {
            continue;
        }
        if is_first(PREFIX, folder) {
            remove_files(folder, &file.as_file().metadata()?);
        }
        return Ok(file);
    }
    Err(io::Error::other("no temporary file stays where it is made"))
}

/// False when another run has the lock; true also where there are no locks.
fn lock(file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// A file that no run had locked, locked as long as this value lives, so that no
/// run takes it while it is removed.
fn left(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    file.try_lock().is_ok().then_some(file)
}

/// Removes leftovers in a folder of the owner of `own`, where that is allowed.
fn remove_files(folder: &Path, own: &Metadata) {
    for path in entries(folder, own, PREFIX, Metadata::is_file) {
        if path.to_string_lossy().ends_with(SUFFIX)
            && let Some(_locked) = left(&path)
        {
            let _ = fs::remove_file(path);
        }
    }
}

/// Entries of a folder with the prefix, of the kind and of the same owner.
fn entries(
    folder: &Path,
    own: &Metadata,
    prefix: &'static str,
    kind: fn(&Metadata) -> bool,
) -> impl Iterator<Item = PathBuf> {
    let own = own.clone();
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter(move |entry| entry.file_name().to_string_lossy().starts_with(prefix))
        .map(|entry| entry.path())
        .filter(move |path| {
            fs::symlink_metadata(path).is_ok_and(|there| kind(&there) && same_owner(&there, &own))
        })
}

#[cfg(unix)]
fn same_owner(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    one.uid() == other.uid()
}

#[cfg(not(unix))]
fn same_owner(_one: &Metadata, _other: &Metadata) -> bool {
    true
}

/// A folder for the files of a tool, which goes with this value.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    _lock: File,
}

impl TemporaryFolder {
    /// A new one among the temporary files of the system.
    pub fn new() -> io::Result<TemporaryFolder> {
        TemporaryFolder::new_in(&std::env::temp_dir())
    }

    fn new_in(parent: &Path) -> io::Result<TemporaryFolder> {
        for _ in 0..TRIES {
            let folder = Builder::new().prefix(FOLDER_PREFIX).tempdir_in(parent)?;
            let path = folder.path().join(LOCK);
            let Ok(file) = File::create_new(&path) else {
                continue;
            };
            if !lock(&file) || fs::symlink_metadata(&path).is_err() {
                continue;
            }
            if is_first(FOLDER_PREFIX, parent) {
                remove_folders(parent, &file.metadata()?);
            }
            return Ok(TemporaryFolder {
                folder,
                _lock: file,
            });
        }
        Err(io::Error::other(
            "no temporary folder stays where it is made",
        ))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// As [`remove_files`], for folders, which hold their lock.
fn remove_folders(parent: &Path, own: &Metadata) {
    for path in entries(parent, own, FOLDER_PREFIX, Metadata::is_dir) {
        let lock = path.join(LOCK);
        if fs::symlink_metadata(&lock).is_ok_and(|lock| lock.is_file())
            && let Some(_locked) = left(&lock)
        {
            let _ = fs::remove_dir_all(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_holds_goes_and_the_rest_stays() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| folder.path().join(name);
        for name in [
            ".robovec-abcdefghij.part",
            ".robovec-held.part",
            ".robovec-notes",
            "robovec-x.part",
        ] {
            fs::write(at(name), "left").expect("written");
        }
        let held = File::open(at(".robovec-held.part")).expect("it is there");
        held.try_lock().expect("nobody else has it");
        let file = file_in(folder.path()).expect("made");
        assert!(!at(".robovec-abcdefghij.part").exists());
        for name in [".robovec-held.part", ".robovec-notes", "robovec-x.part"] {
            assert!(at(name).exists(), "{name}");
        }
        assert!(file.path().exists(), "its own is locked");
    }

    #[test]
    fn folders_of_killed_runs_go() {
        let parent = tempfile::tempdir().expect("a temporary folder");
        let at = |name: &str| parent.path().join(name);
        for name in ["robovec-left", "robovec-held", "robovec-other"] {
            fs::create_dir(at(name)).expect("made");
            fs::write(at(name).join("main.c"), "int x;").expect("written");
        }
        for name in ["robovec-left", "robovec-held"] {
            fs::write(at(name).join(LOCK), "").expect("written");
        }
        drop(file_in(parent.path()).expect("made"));
        let held = File::open(at("robovec-held").join(LOCK)).expect("it is there");
        held.try_lock().expect("nobody else has it");
        let own = TemporaryFolder::new_in(parent.path()).expect("made");
        assert!(
            !at("robovec-left").exists(),
            "also after files were removed"
        );
        assert!(at("robovec-held").exists());
        assert!(
            at("robovec-other").exists(),
            "without a lock it is not ours"
        );
        let path = own.path().to_owned();
        assert!(path.exists());
        drop(own);
        assert!(!path.exists());
    }
}
