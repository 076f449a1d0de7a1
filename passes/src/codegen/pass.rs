//! Code generation as a pass.

use super::c::{Real, c_files};
use super::images::foreign_format;
use super::{Artifacts, ImageError, write_images};
use crate::options::OptionValue;
use crate::pass::{Artifact, Context, Gives, Pass, PassError};
use crate::{declare_pass, option_words};
use robovec_ir::{Format, Function, View};
use std::io;

option_words! {
    /// What code is generated for.
    pub enum Target {
        /// Memory images and their manifest, for the machine of elements.
        Mif = "mif",
        /// C99, for a processor.
        C = "c",
    }
}

impl OptionValue for Real {
    fn type_name() -> String {
        "double | float".to_owned()
    }
    fn parse(text: &str) -> Result<Real, String> {
        [Real::Double, Real::Float]
            .into_iter()
            .find(|real| real.name() == text)
            .ok_or_else(|| format!("'{text}' is not one of {}", Real::type_name()))
    }
    fn print(&self) -> String {
        self.name().to_owned()
    }
}

declare_pass! {
    /// Writes the function out for the machine or for a processor.
    ///
    /// `target=mif` turns a placed function into memory images: for every
    /// processing element an instruction image with one word per cycle, for
    /// every memory an image of its initial data, and `manifest.json`, which
    /// lays out the instruction words and gives the address of every input,
    /// constant and output. `docs/images.md` is the contract with hardware
    /// and simulator. The images decide nothing that the placed text does not
    /// say, and are refused where the machine's words cannot say it.
    ///
    /// `target=c` writes a C99 function and its header from any level; arrays
    /// count from 1, as in Robotran. Compiled with `-ffp-contract=off` it
    /// gives the evaluator's results bit for bit.
    ///
    /// The function itself stays as it is.
    pub struct Codegen("codegen") {
        /// What code is generated for.
        pub target: Target = Target::Mif,
        /// The type C code computes in; images follow the machine file.
        pub number: Real = Real::Double,
    }
    takes: [Equations, Atomic, Scheduled, Placed],
    gives: Gives::Same,
    class: Exact,
    requires: [],
    sets: [],
    destroys: [],
}

impl Artifacts for Vec<Artifact> {
    fn file(
        &mut self,
        name: &str,
        content: &mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut files: Vec<(String, String)> = Vec::new();
        files.file(name, content)?;
        self.extend(
            files
                .into_iter()
                .map(|(name, text)| Artifact { name, text }),
        );
        Ok(())
    }
}

impl Pass for Codegen {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let before = context.artifacts.len();
        let view = View {
            tables: context.tables,
            function,
        };
        match self.target {
            Target::Mif => {
                write_images(view, context.machine, None, context.artifacts).map_err(explain)?;
            }
            Target::C => {
                let own = match self.number {
                    Real::Double => Format::BINARY64,
                    Real::Float => Format::BINARY32,
                };
                if let Some((value, format)) = foreign_format(view, own) {
                    let message = format!(
                        "'%{value}' is computed as {format}, and the C code computes in {}",
                        self.number.name()
                    );
                    let help = "give values their formats for a machine only";
                    return Err(PassError::new(message).help(help));
                }
                let files = c_files(view, self.number);
                context.artifacts.extend(
                    files
                        .into_iter()
                        .map(|(name, text)| Artifact { name, text }),
                );
            }
        }
        let new = &context.artifacts[before..];
        let bytes = new.iter().map(|file| file.text.len() as u64).sum();
        context.statistics.push(("files", new.len() as u64));
        context.statistics.push(("bytes", bytes));
        Ok(())
    }
}

fn explain(error: ImageError) -> PassError {
    let help = match &error {
        ImageError::NotPlaced { .. } => Some("run 'place' before, or choose target=c"),
        ImageError::OtherMachine { .. } => {
            Some("place for this machine, or choose the machine of the schedule")
        }
        _ => None,
    };
    let explained = PassError::new(error.to_string());
    match help {
        Some(help) => explained.help(help),
        None => explained,
    }
}
