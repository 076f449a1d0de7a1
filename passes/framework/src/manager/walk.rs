//! The order in which the passes of a pipeline run: in sequence, groups
//! repeated until a fixed point.

use super::{measure, plan};
use crate::pass::{Context, PassError};
use crate::pipeline::{PassStep, Pipeline, PipelineStep};
use robovec_ir::Function;

/// A way through a pipeline.
pub(super) struct PipelineWalk<'p> {
    pipeline: &'p Pipeline,
    next: usize,
    rounds: Vec<RepeatedGroup>,
}

/// A group that is being repeated.
struct RepeatedGroup {
    /// Index of its first step.
    first: usize,
    left: u32,
    fingerprint: u64,
}

impl<'p> PipelineWalk<'p> {
    /// Before the first step.
    pub(super) fn new(pipeline: &'p Pipeline) -> PipelineWalk<'p> {
        PipelineWalk {
            pipeline,
            next: 0,
            rounds: Vec::new(),
        }
    }

    /// The next pass, given the fingerprint of the current function, which only
    /// repeated groups use.
    pub(super) fn next(&mut self, fingerprint: u64) -> Option<&'p PassStep> {
        loop {
            let step = self.pipeline.steps.get(self.next)?;
            self.next += 1;
            match step {
                PipelineStep::Pass(step) => return Some(step),
                PipelineStep::Open { max } => self.rounds.push(RepeatedGroup {
                    first: self.next,
                    left: *max,
                    fingerprint,
                }),
                PipelineStep::Close => {
                    let round = self.rounds.last_mut();
                    let round = round.expect("a group that ends was begun");
                    round.left -= 1;
                    if round.left > 0 && fingerprint != round.fingerprint {
                        round.fingerprint = fingerprint;
                        self.next = round.first;
                    } else {
                        self.rounds.pop();
                    }
                }
            }
        }
    }
}

/// Runs a pipeline over one function with no instrument at all: for a pass that
/// tries others. The caller verifies the result.
///
/// # Errors
///
/// Fails when the pipeline cannot work at the function's level, or a pass gives
/// up.
pub fn apply(
    pipeline: &Pipeline,
    function: &mut Function,
    context: &mut Context<'_>,
) -> Result<(), PassError> {
    plan::check_function(function, pipeline)
        .map_err(|error| PassError::new(error.message).help(error.help))?;
    let mut walk = PipelineWalk::new(pipeline);
    // Only groups ask whether something changed.
    let repeats = pipeline.repeats();
    let fingerprint = |function: &Function| {
        if repeats {
            measure::fingerprint(function)
        } else {
            0
        }
    };
    while let Some(step) = walk.next(fingerprint(function)) {
        let pass = (step.info.build)(&step.options)
            .map_err(|error| PassError::new(format!("{step}: {error}")))?;
        let formats = function.formats.is_some();
        pass.run(function, context)?;
        measure::check_formats(formats, function)?;
        measure::forget_stale_properties(step.info, function);
    }
    Ok(())
}
