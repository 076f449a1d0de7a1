//! Folders of files that belong together.
//!
//! Such a folder has a file that names the others with their hashes: the
//! manifest of memory images, the description of hardware. It is removed before
//! any file is overwritten and written last, so that a folder with it was once
//! complete, and its hashes show whether it still is.

use super::write::{FileWriteError, Replace, make_folder, refuse_foreign, write_whole};
use robovec_fpga::manifest::FileHash;
use robovec_fpga::rtl::DESCRIPTION;
use robovec_num::fnv::Fnv;
use std::fs;
use std::io;
use std::path::Path;

/// The last part of the name of a manifest.
const MANIFEST: &str = "manifest.json";

/// The rank of a file in the order of writing: files that seal others come
/// last, and the one that represents hardware and images after those of images.
fn turn(name: &str) -> u8 {
    let base = name.rsplit('/').next();
    let base = base.expect("a text has a last part");
    match base {
        DESCRIPTION => 2,
        _ if base.ends_with(MANIFEST) => 1,
        _ => 0,
    }
}

/// Writes files, given as (name, text), below a folder, those that seal last.
///
/// # Errors
///
/// Fails when a file may not be replaced, which is found before any is written,
/// or the system refuses; the folder has then no seal.
pub fn write_folder(
    folder: &Path,
    files: &[(&str, &str)],
    replace: Replace,
) -> Result<(), FileWriteError> {
    let system = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| FileWriteError::System(path, error)
    };
    for (name, _) in files {
        refuse_foreign(&folder.join(name), replace)?;
    }
    for (name, _) in files.iter().filter(|(name, _)| turn(name) > 0) {
        let path = folder.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(system(&path)(error));
            }
            Ok(()) | Err(_) => {}
        }
    }
    make_folder(folder).map_err(system(folder))?;
    let mut order: Vec<&(&str, &str)> = files.iter().collect();
    order.sort_by_key(|(name, _)| turn(name));
    for (name, text) in order {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            make_folder(parent).map_err(system(parent))?;
        }
        write_whole(&path, Replace::Anything, |writer| {
            writer.write_all(text.as_bytes())
        })?;
    }
    Ok(())
}

/// A file that differs from the seal of its folder.
#[derive(Debug, thiserror::Error)]
pub enum SealError {
    /// A file is absent.
    #[error("'{0}' is missing")]
    Missing(String),
    /// It cannot be read.
    #[error("'{0}' cannot be read: {1}")]
    System(String, io::Error),
    /// Its content has changed.
    #[error("'{file}' was changed: it has the hash {found} instead of {expected}")]
    Changed {
        /// The file.
        file: String,
        /// The hash of its content.
        found: Fnv,
        /// The hash that was written beside it.
        expected: String,
    },
}

/// Compares the files of a folder with the hashes in its seal.
pub fn check_folder(folder: &Path, files: &[FileHash]) -> Result<(), SealError> {
    for one in files {
        let file = one.file.clone();
        let bytes = match fs::read(folder.join(&file)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(SealError::Missing(file));
            }
            Err(error) => return Err(SealError::System(file, error)),
            Ok(bytes) => bytes,
        };
        let found = Fnv::of(&bytes);
        if found.text() != one.hash {
            let expected = one.hash.clone();
            return Err(SealError::Changed {
                file,
                found,
                expected,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seals_are_written_last_and_removed_first() {
        let names = ["rtl/machine.json", "img/f.manifest.json", "rtl/top.v"];
        let mut sorted = names;
        sorted.sort_by_key(|name| turn(name));
        assert_eq!(sorted, [names[2], names[1], names[0]]);

        let folder = tempfile::tempdir().expect("a temporary folder");
        let files = [("f.manifest.json", "seal"), ("f.add0.mif", "words")];
        write_folder(folder.path(), &files, Replace::Own).expect("written");
        // A folder in the place of a file stops the second writing half way.
        fs::remove_file(folder.path().join("f.add0.mif")).expect("removed");
        fs::create_dir(folder.path().join("f.add0.mif")).expect("made");
        assert!(write_folder(folder.path(), &files, Replace::Anything).is_err());
        assert!(!folder.path().join("f.manifest.json").exists());
    }

    #[test]
    fn files_that_are_other_than_their_seal_says_are_found() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("top.v");
        fs::write(&path, "module").expect("written");
        let seal = [FileHash {
            file: "top.v".to_owned(),
            hash: Fnv::of(b"module").text(),
        }];
        assert!(check_folder(folder.path(), &seal).is_ok());
        fs::write(&path, "modulo").expect("written");
        let changed = check_folder(folder.path(), &seal);
        assert!(matches!(changed, Err(SealError::Changed { .. })));
        fs::remove_file(&path).expect("removed");
        let missing = check_folder(folder.path(), &seal);
        assert!(matches!(missing, Err(SealError::Missing(_))));
    }
}
