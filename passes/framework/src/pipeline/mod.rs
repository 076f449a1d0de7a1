//! Pipelines: the text of `-passes`, its structure, and its laws.
//!
//! A pipeline is a list of passes with options, and of groups repeated until
//! nothing changes:
//!
//! ```text
//! atomise,balance{sharing=false},fixpoint{max=8}(fold,cse,dce),$fpga
//! ```
//!
//! The structure is a flat list of steps, groups marked by their ends, so
//! that neither reading nor dropping a hostile pipeline recurses. Law:
//! `parse(print(p)) == p`.

mod read;
mod token;

pub use read::PipelineError;

use crate::pass::{PassInfo, Registry};
use robovec_num::limits::NumberLimit;
use std::fmt;
use std::ops::Range;

/// One step of a pipeline.
#[derive(Clone, Debug)]
pub enum PipelineStep {
    /// Run a pass.
    Pass(PassStep),
    /// Start of a group repeated until nothing changes, at most `max` times.
    Open {
        /// The largest number of rounds.
        max: u32,
    },
    /// End of the innermost group.
    Close,
}

/// A pass with its options.
#[derive(Clone, Debug)]
pub struct PassStep {
    /// The pass.
    pub info: &'static PassInfo,
    /// The options written, in order: name and value as text.
    pub options: Vec<(String, String)>,
    /// Place in the pipeline's text, in bytes.
    pub span: Range<usize>,
}

/// Number of times a group is repeated when the pipeline does not specify it.
pub const DEFAULT_ROUNDS: u32 = 8;

/// Number of times a group can be repeated.
pub const ROUNDS: NumberLimit =
    NumberLimit::whole(1, 1000, "every round runs all passes of the group again");

/// The deepest nesting of groups.
pub const DEEPEST: usize = 16;

/// A pipeline, read and checked: its passes exist and take their options.
#[derive(Clone, Debug)]
pub struct Pipeline {
    /// The steps.
    pub steps: Vec<PipelineStep>,
    /// The passes it could name.
    pub registry: &'static Registry,
}

impl Default for Pipeline {
    fn default() -> Pipeline {
        Pipeline {
            steps: Vec::new(),
            registry: Registry::EMPTY,
        }
    }
}

impl Pipeline {
    /// The passes, in order of appearance.
    pub fn passes(&self) -> impl Iterator<Item = &PassStep> {
        self.steps.iter().filter_map(|step| match step {
            PipelineStep::Pass(pass) => Some(pass),
            PipelineStep::Open { .. } | PipelineStep::Close => None,
        })
    }

    /// Tests whether it has a group that is repeated up to a fixed point.
    pub fn repeats(&self) -> bool {
        self.steps
            .iter()
            .any(|step| matches!(step, PipelineStep::Close))
    }
}

impl PartialEq for Pipeline {
    fn eq(&self, other: &Pipeline) -> bool {
        self.to_string() == other.to_string()
    }
}

/// Tests whether a value needs no quotes.
fn is_word(value: &str) -> bool {
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "_.+-".contains(letter);
    !value.is_empty() && value.chars().all(plain)
}

impl fmt::Display for PassStep {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.info.name)?;
        if !self.options.is_empty() {
            let options = self.options.iter();
            let options: Vec<String> = options
                .map(|(name, value)| {
                    if is_word(value) {
                        format!("{name}={value}")
                    } else {
                        format!("{name}=\"{value}\"")
                    }
                })
                .collect();
            write!(formatter, "{{{}}}", options.join(" "))?;
        }
        Ok(())
    }
}

impl fmt::Display for Pipeline {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for step in &self.steps {
            if !first && !matches!(step, PipelineStep::Close) {
                formatter.write_str(",")?;
            }
            first = false;
            match step {
                PipelineStep::Pass(pass) => pass.fmt(formatter)?,
                PipelineStep::Open { max } => {
                    write!(formatter, "fixpoint{{max={max}}}(")?;
                    first = true;
                }
                PipelineStep::Close => formatter.write_str(")")?,
            }
        }
        Ok(())
    }
}
