//! Check of a whole pipeline before it runs.

use crate::pass::{Gives, PassInfo, Property, Registry};
use crate::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_ir::{Function, Level, Module};
use std::ops::Range;

/// A pass at a place where it cannot work.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct PlanError {
    /// The message about the fault.
    pub message: String,
    /// The advice to the user.
    pub help: String,
    /// The place of the pass in the pipeline's text, in bytes.
    pub span: Range<usize>,
}

/// Follows levels and properties through the pipeline for every function.
pub(super) fn check(module: &Module, pipeline: &Pipeline) -> Result<(), PlanError> {
    module
        .functions
        .iter()
        .try_for_each(|function| check_function(function, pipeline))
}

/// Follows levels and properties for one function.
pub(super) fn check_function(function: &Function, pipeline: &Pipeline) -> Result<(), PlanError> {
    let mut state = PipelineState {
        registry: pipeline.registry,
        level: function.level,
        maker: None,
        properties: Vec::new(),
    };
    if function.timing.is_some() {
        state.properties.push(Property::Timed);
    }
    for step in &pipeline.steps {
        if let PipelineStep::Pass(step) = step {
            state.step(&function.name, step)?;
        }
    }
    Ok(())
}

struct PipelineState {
    registry: &'static Registry,
    level: Level,
    /// The pass that gave the level.
    maker: Option<&'static str>,
    properties: Vec<Property>,
}

impl PipelineState {
    fn step(&mut self, function: &str, step: &PassStep) -> Result<(), PlanError> {
        let info = step.info;
        if !info.takes.contains(&self.level) {
            return Err(self.wrong_level(function, step));
        }
        for required in info.requires {
            if !self.properties.contains(required) {
                return Err(PlanError {
                    message: format!(
                        "'{}' needs a function that is {}",
                        info.name,
                        required.name()
                    ),
                    help: format!(
                        "put {} before it",
                        self.makers(|other| other.sets.contains(required))
                    ),
                    span: step.span.clone(),
                });
            }
        }
        if let Gives::Level(level) = info.gives {
            if level != self.level {
                self.maker = Some(info.name);
            }
            self.level = level;
        }
        self.properties
            .retain(|property| !info.destroys.contains(property));
        self.properties.extend(info.sets);
        Ok(())
    }

    fn wrong_level(&self, function: &str, step: &PassStep) -> PlanError {
        let info = step.info;
        let takes: Vec<&str> = info.takes.iter().map(|level| level.name()).collect();
        let origin = match self.maker {
            Some(pass) => format!("after '{pass}'"),
            None => "as it was read".to_owned(),
        };
        let help = if info.takes.iter().any(|&level| level > self.level) {
            let reaches = |other: &PassInfo| {
                matches!(other.gives, Gives::Level(level)
                    if info.takes.contains(&level) && other.takes.iter().any(|&l| l < level))
            };
            format!("put {} before it", self.makers(reaches))
        } else {
            format!(
                "put it before '{}'",
                self.maker.unwrap_or("the passes that lower")
            )
        };
        PlanError {
            message: format!(
                "'{}' takes functions at the level {}; '{function}' is at the level {} {origin}",
                info.name,
                takes.join(" or "),
                self.level,
            ),
            help,
            span: step.span.clone(),
        }
    }

    /// The passes that fit, for advice.
    fn makers(&self, is_maker: impl Fn(&PassInfo) -> bool) -> String {
        let passes = self.registry.passes.iter();
        let names: Vec<String> = passes
            .filter(|info| is_maker(info))
            .map(|info| format!("'{}'", info.name))
            .collect();
        names.join(" or ")
    }
}
