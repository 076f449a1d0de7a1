//! Programs and pipelines from random bytes.

use crate::equations::{Contents, equations};
use crate::generate::{Kind, module};
use crate::passes;
use arbitrary::{Result, Unstructured};
use robovec_ir::{Machine, Module};

/// Passes of a pipeline.
const PASSES: u32 = 5;

/// A program and the pipeline that is run on it.
pub(super) struct Case {
    pub(super) steps: Vec<String>,
    pub(super) machine: Machine,
    pub(super) seed: u64,
    pub(super) module: Module,
}

impl Case {
    pub(super) fn draw(bytes: &mut Unstructured<'_>, without: &[String]) -> Result<Case> {
        let mut steps: Vec<String> = Vec::new();
        for step in passes::steps(bytes, PASSES)? {
            let name = step.split('{').next().unwrap_or_default();
            if without.iter().any(|other| other == name) {
                // What follows may need another level than the program's.
                break;
            }
            steps.push(match name {
                // Its claim is known where the error is asked for; fitting
                // polynomials takes longer than all other passes together.
                "trigonometry" => {
                    let method = bytes.choose(&["taylor", "taylor", "taylor", "minimax"])?;
                    let range = bytes.choose(&["0.5", "2", "3"])?;
                    let error = bytes.choose(&["1e-2", "1e-5", "1e-9"])?;
                    format!("trigonometry{{method={method} range={range} error={error}}}")
                }
                _ => step,
            });
        }
        let machine = bytes.choose(&["ideal", "thesis", "fused"])?;
        Ok(Case {
            steps,
            machine: Machine::built_in(machine).expect("it ships"),
            seed: bytes.arbitrary()?,
            module: match bytes.int_in_range(0..=3)? {
                0 => module(bytes, Kind::Hostile)?,
                _ => equations(bytes, CONTENTS)?,
            },
        })
    }
}

const CONTENTS: Contents = Contents {
    definitions: 8,
    divisions: true,
    hostile: true,
};
