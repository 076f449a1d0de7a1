//! The times of a study's programs on one core of a processor.

use crate::processor::{Computer, contest};
use robovec_bench::own::operations;
use robovec_ir::View;
use robovec_ir::print::print_file;
use robovec_num::fnv::Fnv;
use robovec_present::number::round;
use serde::{Deserialize, Serialize};

/// Measured times, or why there are none.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CpuTime {
    /// The model.
    pub model: String,
    /// The pipeline, or the formulation of a program made for processors.
    pub pipeline: String,
    /// Hash of the text of the functions, in hexadecimal.
    pub program: String,
    /// Operations of the function, without sines and cosines.
    pub operations: usize,
    /// Time of one evaluation in binary64 by straight-line C, sines and cosines
    /// included: the smallest over many repetitions, µs of processor time.
    pub microseconds: Option<f64>,
    /// The same by C with loops.
    pub rolled: Option<f64>,
    /// Time per state when eight are evaluated at once.
    pub batch: Option<f64>,
    /// Reason why there is no time.
    pub remark: String,
    /// The compiler and its options.
    pub compiler: String,
    /// The processor.
    pub processor: String,
}

impl CpuTime {
    /// True when this program was measured by the same compiler and processor.
    pub fn is_of(&self, job: &CpuJob<'_>, computer: &Computer) -> bool {
        self.model == job.model
            && self.pipeline == job.pipeline
            && self.program == job.program()
            && self.compiler == computer.compiler
            && self.processor == computer.processor
            && self.microseconds.is_some()
    }

    /// The same times for a job of the same functions under other names.
    pub fn of(&self, job: &CpuJob<'_>) -> CpuTime {
        CpuTime {
            model: job.model.to_owned(),
            pipeline: job.pipeline.to_owned(),
            ..self.clone()
        }
    }

    /// The time of one evaluation by the faster C.
    pub fn single(&self) -> Option<f64> {
        let both = self.microseconds.into_iter().chain(self.rolled);
        both.min_by(f64::total_cmp)
    }
}

/// A function to be timed.
#[derive(Clone, Copy, Debug)]
pub struct CpuJob<'a> {
    /// The model.
    pub model: &'a str,
    /// The pipeline or formulation.
    pub pipeline: &'a str,
    /// The function, in whose order loops are found.
    pub view: View<'a>,
    /// The same for straight-line code and batches.
    pub shorter: View<'a>,
}

impl CpuJob<'_> {
    /// Hash of the text of both functions.
    pub fn program(&self) -> String {
        let mut hash = Fnv::new();
        for view in [self.view, self.shorter] {
            hash.update(print_file(view).as_bytes());
        }
        hash.text()
    }
}

/// Measures a function; one at a time, or the figures mean nothing.
pub fn time(job: &CpuJob<'_>, computer: &Computer, largest: usize) -> CpuTime {
    let operations = operations(job.view);
    let result = if computer.compiler.is_empty() {
        Err("not measured, there is no C compiler 'cc'".to_owned())
    } else if operations > largest {
        Err(format!(
            "not measured, it has more than {largest} operations, which take a C compiler minutes"
        ))
    } else {
        contest(job.view, job.shorter)
    };
    let times = result.as_ref().copied().unwrap_or_default();
    let microseconds = |time: Option<f64>| time.map(|time| round(time * 1e-3, 4));
    CpuTime {
        model: job.model.to_owned(),
        pipeline: job.pipeline.to_owned(),
        program: job.program(),
        operations,
        microseconds: microseconds(times.straight),
        rolled: microseconds(times.rolled),
        batch: microseconds(times.batch),
        remark: result.err().unwrap_or_default(),
        compiler: computer.compiler.clone(),
        processor: computer.processor.clone(),
    }
}
