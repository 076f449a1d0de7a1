//! `--dump-dir`: every state of every function in a numbered file.

use super::CommandFailure;
use super::output::{make_folder, write_file};
use robovec_framework::manager::{Dump, DumpState};
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};

/// Writes states in the order of the passes and an index at the end.
pub(crate) struct DumpFolder {
    folder: PathBuf,
    entries: Vec<DumpEntry>,
}

/// One line of the index.
#[derive(Serialize)]
struct DumpEntry {
    /// Number of the state, from 0.
    number: usize,
    function: String,
    pass: String,
    changed: bool,
    /// The file; that of the state before when the pass changed nothing.
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    cpu_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operations: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    asap_cycle: Option<u32>,
}

impl DumpFolder {
    pub(crate) fn create(folder: &Path) -> Result<DumpFolder, CommandFailure> {
        make_folder(folder)?;
        Ok(DumpFolder {
            folder: folder.to_owned(),
            entries: Vec::new(),
        })
    }

    pub(crate) fn finish(self) -> Result<(), CommandFailure> {
        write_file(&self.folder.join("index.json"), |writer| {
            serde_json::to_writer_pretty(&mut *writer, &self.entries)?;
            writer.write_all(b"\n")
        })
    }
}

impl Dump for DumpFolder {
    fn dump(&mut self, state: DumpState<'_>) -> io::Result<()> {
        let number = self.entries.len();
        let pass = state
            .pass
            .split('{')
            .next()
            .expect("a split has a first part");
        let file = match (state.text, self.entries.last()) {
            (None, Some(before)) => before.file.clone(),
            (text, _) => {
                let name = format!("{number:04}.{}.{pass}.rvir", state.function);
                write_file(&self.folder.join(&name), |writer| {
                    let text = text.expect("only a state like the one before has no text");
                    writer.write_all(text.as_bytes())
                })
                .map_err(|failure| io::Error::other(failure.0.render_plain()))?;
                name
            }
        };
        self.entries.push(DumpEntry {
            number,
            function: state.function.to_owned(),
            pass: state.pass.to_owned(),
            changed: state.text.is_some(),
            file,
            cpu_s: state.record.map(|record| record.cpu_s),
            operations: state.record.map(|record| record.operations),
            asap_cycle: state.record.map(|record| record.asap_cycle),
        });
        Ok(())
    }
}
