//! The report of a compilation: cost and error.
//!
//! One structure, written as JSON ([`ModuleReport::to_json`]) for programs and
//! as text ([`ModuleReport::to_text`]) for users. The names of the JSON form
//! are an interface, documented in `docs/report.md`; a field may be added and
//! none renamed. Numbers that are not finite are `null`.

mod error;
mod records;
mod schedule;
mod text;

pub use error::{ArrayReport, ElementReport, ErrorReport, FormatReport, MatrixReport};
pub use records::{BoundaryReport, CheckErrors, CheckReport, PassReport, RoundingReport};

use robovec_analysis::critical_path::critical_path;
use robovec_analysis::rounding::RoundingErrors;
use robovec_error::errors::Heat;
use robovec_framework::check::CheckVerdict;
use robovec_framework::manager::RunOutcome;
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Function, Level, Machine, Module, View};
use robovec_present::json::json_text;
pub use schedule::{ByKind, KindReport, ScheduleReport, TransferReport};
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// Record of the pass manager about one run of a pass on one function.
#[derive(Clone, PartialEq, Debug)]
pub struct PassRunRecord {
    /// The function's name.
    pub function: String,
    /// The pass as written in the pipeline, options included.
    pub name: String,
    /// Processor time, in seconds.
    pub cpu_s: f64,
    /// Largest memory of the process so far, MB; absent if it is not reported.
    pub peak_mb: Option<f64>,
    /// Operations after the pass, minus signs included, sine and cosine not.
    pub operations: usize,
    /// The longest chain after the pass, in cycles.
    pub asap_cycle: u32,
    /// The semantic check of the pass; absent when it was not requested.
    pub verdict: Option<CheckVerdict>,
    /// Rounding errors in binary32 before and after the pass, if measured.
    pub rounding: Option<[Arc<RoundingErrors>; 2]>,
}

impl PassRunRecord {
    /// The records of all passes of a run.
    pub fn of(outcome: &RunOutcome) -> Vec<PassRunRecord> {
        let records = outcome.records.iter();
        let records = records.map(|record| PassRunRecord {
            function: record.function.clone(),
            name: record.name.clone(),
            cpu_s: record.cpu_s,
            peak_mb: (record.peak_mb > 0.0).then_some(record.peak_mb),
            operations: record.operations as usize,
            asap_cycle: record.asap_cycle,
            verdict: record.check.clone(),
            rounding: record.rounding.clone(),
        });
        records.collect()
    }
}

/// Measurements of a report.
#[derive(Clone, PartialEq, Debug)]
pub struct ReportOptions {
    /// Source of the states over which rounding errors are measured.
    pub states: States,
    /// Number of them.
    pub count: u32,
    /// The counts of functions that were read; others are counted now.
    pub read: Vec<ReadCounts>,
}

/// Counts of a function as read, before passes split its equations.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ReadCounts {
    function: String,
    equations: usize,
    vectors: usize,
}

impl ReadCounts {
    /// The counts of all functions.
    pub fn of(module: &Module) -> Vec<ReadCounts> {
        let count = |function: &Function| {
            let counts = Counts::of(function);
            ReadCounts {
                function: function.name.clone(),
                equations: counts.equations,
                vectors: counts.vectors,
            }
        };
        module.functions.iter().map(count).collect()
    }
}

impl Default for ReportOptions {
    fn default() -> ReportOptions {
        ReportOptions {
            states: States::new(1),
            count: 16,
            read: Vec::new(),
        }
    }
}

/// The report of a module.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ModuleReport {
    /// The version of robovec.
    pub robovec: String,
    /// One entry per function, in the module's order.
    pub functions: Vec<FunctionReport>,
}

/// The report of a function.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FunctionReport {
    /// Its name.
    pub name: String,
    /// The model it belongs to, from the header of its file.
    pub model: Option<String>,
    /// The level it was lowered to.
    #[serde(serialize_with = "level_name")]
    pub level: Level,
    /// The numbers of its operations.
    #[serde(flatten)]
    pub counts: Counts,
    /// The longest chain, in operations.
    pub asap: u32,
    /// The longest chain, in cycles of the machine.
    pub asap_cycle: u32,
    /// Operations per cycle of the longest chain: the most processing elements
    /// that can be busy (the thesis' Y). Absent without a chain.
    pub number_y: Option<f64>,
    /// User calls that split the function.
    pub boundaries: Vec<BoundaryReport>,
    /// Passes that were run on it, in order.
    pub passes: Vec<PassReport>,
    /// Cycles and processing elements; absent before `place`.
    pub schedule: Option<ScheduleReport>,
    /// Rounding errors of the outputs.
    pub error: ErrorReport,
    /// Equations that these come from, in the machine's number format.
    pub heat: Heat,
}

impl ModuleReport {
    /// Measures and counts all figures of a report about a module after the
    /// recorded passes were run on it for a machine.
    pub fn collect(
        module: &Module,
        machine: &Machine,
        passes: &[PassRunRecord],
        options: &ReportOptions,
    ) -> ModuleReport {
        let describe = |function: &Function| {
            let view = module.tables.view(function);
            FunctionReport::collect(view, machine, passes, options)
        };
        ModuleReport {
            robovec: env!("CARGO_PKG_VERSION").to_owned(),
            functions: module.functions.iter().map(describe).collect(),
        }
    }

    /// The report as JSON, indented, with a line end after it.
    pub fn to_json(&self) -> String {
        json_text(self)
    }

    /// The report for a user, at most 100 columns wide.
    pub fn to_text(&self) -> String {
        text::print(self)
    }
}

impl FunctionReport {
    fn collect(
        view: View<'_>,
        machine: &Machine,
        passes: &[PassRunRecord],
        options: &ReportOptions,
    ) -> FunctionReport {
        let function = view.function;
        let mut counts = Counts::of(function);
        if let Some(read) = (options.read.iter()).find(|read| read.function == function.name) {
            (counts.equations, counts.vectors) = (read.equations, read.vectors);
        }
        let path = critical_path(function, machine);
        let own = passes.iter().filter(|pass| pass.function == function.name);
        FunctionReport {
            name: function.name.clone(),
            model: function.metadata("model").map(str::to_owned),
            level: function.level,
            counts,
            asap: path.asap,
            asap_cycle: path.asap_cycle,
            number_y: (path.asap_cycle > 0)
                .then(|| counts.operations as f64 / f64::from(path.asap_cycle)),
            boundaries: BoundaryReport::collect(view),
            passes: own.map(|record| PassReport::new(record, view)).collect(),
            schedule: ScheduleReport::collect(function, machine),
            error: ErrorReport::new(view, options),
            heat: Heat::measure(view, machine.number, &options.states),
        }
    }
}

fn level_name<S: Serializer>(level: &Level, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(level.name())
}

#[cfg(test)]
mod tests;
