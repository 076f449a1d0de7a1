//! Reading of files named by a user: finite ones, up to their kind's limit.
//!
//! A device has no end, and a pipe in a folder has no content until another
//! process writes into it; both are refused. The standard input (`-`) and pipes
//! that a shell makes (`<(…)`) have a writer, and are read up to the limit.

use super::look::{FileKind, FileLook, look};
use robovec_ir::diagnostic::Report;
use robovec_num::limits::NumberLimit;
use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::Path;

/// The largest file of a kind, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct FileLimit {
    /// The kind.
    pub kind: FileKind,
    /// Name of such files.
    pub what: &'static str,
    /// Bytes.
    pub bytes: NumberLimit,
}

const fn limit(kind: FileKind, what: &'static str, most: u64, reason: &'static str) -> FileLimit {
    FileLimit {
        kind,
        what,
        bytes: NumberLimit::whole(0, most, reason),
    }
}

/// Equations, in any language.
pub const EQUATIONS: FileLimit = limit(
    FileKind::Equations,
    "file of equations",
    1 << 30,
    "10^6 operations take 100 MB, and places in a text are numbers of 32 bits",
);
/// Models.
pub const MODEL: FileLimit = limit(
    FileKind::Model,
    "model",
    16 << 20,
    "a model of 2000 joints takes 3 MB",
);
/// Pipelines.
pub const PIPELINE: FileLimit = limit(
    FileKind::Pipeline,
    "pipeline",
    1 << 20,
    "every pass of it runs",
);
/// Machines.
pub const MACHINE: FileLimit = limit(
    FileKind::Machine,
    "machine",
    1 << 20,
    "the largest takes 2 kB",
);
/// Scenes.
pub const SCENE: FileLimit = limit(
    FileKind::Scene,
    "scene",
    16 << 20,
    "a line for every input of 2000 joints takes 1 MB",
);
/// Laws of forces.
pub const LAWS: FileLimit = limit(
    FileKind::Laws,
    "file of laws",
    16 << 20,
    "a law for each of 2000 joints takes 1 MB",
);
/// Plans of studies.
pub const PLAN: FileLimit = limit(FileKind::Plan, "plan", 1 << 20, "the thesis takes 8 kB");
/// Rules.
pub const RULES: FileLimit = limit(
    FileKind::Rules,
    "file of rules",
    16 << 20,
    "every rule is proved",
);
/// Rules of other tools.
pub const FOREIGN_RULES: FileLimit = FileLimit {
    kind: FileKind::ForeignRules,
    ..RULES
};
/// States.
pub const STATES: FileLimit = limit(
    FileKind::States,
    "file of states",
    1 << 28,
    "all states are kept while functions are evaluated",
);
/// Descriptions of hardware.
pub const HARDWARE: FileLimit = FileLimit {
    kind: FileKind::Hardware,
    ..IMAGE
};
/// Memory images, and manifests.
pub const IMAGE: FileLimit = limit(
    FileKind::Image,
    "memory image",
    1 << 28,
    "a run loads 2^24 words",
);

/// Descriptions of targets.
pub const TARGET: FileLimit = limit(
    FileKind::Target,
    "description of a target",
    1 << 20,
    "the longest that ships takes 2 kB",
);
/// Templates of targets.
pub const TEMPLATE: FileLimit = limit(
    FileKind::Template,
    "template",
    1 << 20,
    "the longest that ships takes 2 kB",
);

/// All kinds.
pub const ALL: [FileLimit; 12] = [
    EQUATIONS, MODEL, PIPELINE, MACHINE, SCENE, LAWS, PLAN, RULES, STATES, IMAGE, TARGET, TEMPLATE,
];

/// Reads a file whole; `-` is the standard input.
pub fn read(path: &Path, limit: &FileLimit) -> Result<Vec<u8>, Report> {
    let fail = |reason: String| {
        let message = format!("cannot read {}: {reason}", path.display());
        Report::error(message, Vec::new())
    };
    let too_large = || {
        fail(format!(
            "it has more than {} bytes, the most of a {}, since {}",
            limit.bytes.most(),
            limit.what,
            limit.bytes.reason()
        ))
    };
    let most = limit.bytes.most_whole();
    let attempt = || -> io::Result<Result<Vec<u8>, Report>> {
        if path == Path::new("-") {
            return up_to(io::stdin(), 0, most).map(|bytes| bytes.ok_or_else(too_large));
        }
        // Asked before it is opened: opening a pipe waits for its writer.
        let there = fs::metadata(path)?;
        if let Some(kind) = endless(path, there.file_type()) {
            return Ok(Err(fail(kind.to_owned())));
        }
        if there.is_file() && there.len() > most {
            return Ok(Err(too_large()));
        }
        // Memory for a file of known size is had at once.
        let known = if there.is_file() { there.len() } else { 0 };
        up_to(File::open(path)?, known, most).map(|bytes| bytes.ok_or_else(too_large))
    };
    let bytes = attempt().map_err(|error| fail(error.to_string()))??;
    refuse_others(path, &bytes, limit.kind)?;
    Ok(bytes)
}

/// An error for a file of another kind than the one that is read.
fn refuse_others(path: &Path, bytes: &[u8], wanted: FileKind) -> Result<(), Report> {
    // Images are read with files beside them; templates are of any language.
    if matches!(wanted, FileKind::Image | FileKind::Template) {
        return Ok(());
    }
    let name = path.display();
    let other = |what: &str| format!("{name} is not {}: it looks like {what}", wanted.name());
    let (message, note) = match look(&name.to_string(), bytes) {
        FileLook::Empty => (
            format!("{name} is empty"),
            format!("expected {}", wanted.name()),
        ),
        FileLook::Known(kind) if kind != wanted => (other(kind.name()), kind.takers().to_owned()),
        FileLook::Toml if !wanted.is_toml() => (other("TOML"), "no command takes it".to_owned()),
        FileLook::Json if wanted != FileKind::Hardware => {
            (other("JSON"), "no command takes it".to_owned())
        }
        FileLook::Xml if wanted != FileKind::Model => (
            other("XML that is no model"),
            "no command takes it".to_owned(),
        ),
        FileLook::Foreign(what) => (other(what), "no command takes it".to_owned()),
        _ => return Ok(()),
    };
    Err(Report::error(message, vec![note]))
}

/// All bytes of a reader, or `None` beyond the limit.
fn up_to(reader: impl Read, known: u64, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::with_capacity(known as usize + 1);
    reader.take(most + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

/// Reason why a file of this type is not read.
#[cfg(unix)]
fn endless(path: &Path, kind: FileType) -> Option<&'static str> {
    use std::os::unix::fs::FileTypeExt;
    // Pipes of a shell, and the standard input by another name.
    let is_shells = path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd");
    let is_stdin = path == Path::new("/dev/stdin");
    if kind.is_dir() {
        Some("it is a folder")
    } else if kind.is_block_device()
        || (kind.is_char_device() && path != Path::new("/dev/null") && !is_stdin)
    {
        Some("it is a device, which has no end")
    } else if kind.is_fifo() && !is_shells && !is_stdin {
        Some("it is a named pipe, which waits for a writer; give its content to '-' instead")
    } else if kind.is_socket() {
        Some("it is a socket")
    } else {
        None
    }
}

/// Reason why a file of this type is not read.
#[cfg(not(unix))]
fn endless(_: &Path, kind: FileType) -> Option<&'static str> {
    kind.is_dir().then_some("it is a folder")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(path: &Path, limit: &FileLimit) -> String {
        read(path, limit).expect_err("it is refused").render_plain()
    }

    #[test]
    fn a_file_is_read_up_to_its_limit_and_not_beyond() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("some.toml");
        let limit = limit(FileKind::Plan, "plan", 8, "8 bytes are enough");
        fs::write(&path, "12345678").expect("written");
        assert_eq!(read(&path, &limit).ok().as_deref(), Some(&b"12345678"[..]));
        fs::write(&path, "123456789").expect("written");
        let message = message(&path, &limit);
        assert!(message.contains("more than 8 bytes"), "{message}");
        assert!(message.contains("since 8 bytes are enough"), "{message}");
    }

    #[test]
    #[cfg(unix)]
    fn what_has_no_end_is_refused() {
        for (path, part) in [
            ("/", "a folder"),
            ("/dev/zero", "a device"),
            ("/dev/full", "a device"),
        ] {
            let message = message(Path::new(path), &EQUATIONS);
            assert!(message.contains(part), "{message}");
        }
        assert!(message(Path::new("/dev/null"), &EQUATIONS).contains("is empty"));
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if made.is_ok_and(|status| status.success()) {
            assert!(message(&pipe, &PIPELINE).contains("a named pipe"));
        }
    }
}
