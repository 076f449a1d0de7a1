//! Passes run on a function, and the user calls that split it.

use super::PassRunRecord;
use robovec_analysis::accuracy::ErrorSummary;
use robovec_analysis::rounding::{MedianChange, Quantiles, RoundingErrors, UNIT};
use robovec_framework::check::{CheckVerdict, Deviation, DomainVerdict, ErrorChange, FailureKind};
use robovec_ir::print::print_output;
use robovec_ir::{Boundary, View};
use serde::Serialize;
use std::sync::Arc;

/// One run of a pass.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct PassReport {
    /// The pass as written in the pipeline.
    pub name: String,
    /// Processor time, in seconds.
    pub cpu_s: f64,
    /// Largest memory so far, in MB.
    pub peak_mb: Option<f64>,
    /// Operations afterwards.
    pub operations: usize,
    /// The longest chain afterwards, in cycles.
    pub asap_cycle: u32,
    /// The semantic check, if it was requested.
    pub check: Option<CheckReport>,
    /// Its effect on the rounding errors in binary32.
    pub rounding: Option<RoundingReport>,
}

impl PassReport {
    pub(super) fn new(record: &PassRunRecord, view: View<'_>) -> PassReport {
        PassReport {
            name: record.name.clone(),
            cpu_s: record.cpu_s,
            peak_mb: record.peak_mb,
            operations: record.operations,
            asap_cycle: record.asap_cycle,
            check: record
                .verdict
                .as_ref()
                .map(|verdict| CheckReport::new(verdict, view)),
            rounding: record.rounding.as_ref().map(RoundingReport::new),
        }
    }
}

/// The semantic check of a pass.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CheckReport {
    /// The numeric class the pass claims.
    pub class: &'static str,
    /// Points and states tested.
    pub points: u32,
    /// Seed of the states.
    pub seed: u64,
    /// `bit-equal`, `equal` (in the prime field), `measured` (approximating)
    /// or `failed`.
    pub result: &'static str,
    /// Place where the function after is defined beside the one before: `same`,
    /// `wider`, or `open` where a condition was neither proved nor refuted.
    pub domain: &'static str,
    /// The condition that only one of them has.
    pub condition: Option<String>,
    /// Number of states that decided about the least decided output.
    pub decided: Option<u32>,
    /// Failure.
    pub failure: Option<String>,
    /// The output it failed at.
    pub output: Option<String>,
    /// Kind of the failure: `signature`, `field`, `distance` or `bits`.
    pub kind: Option<&'static str>,
    /// Largest difference by an approximating pass, over the largest element.
    pub deviation: Option<f64>,
    /// Rounding errors in binary32 before and after.
    pub binary32: Option<CheckErrors>,
    /// Rounding errors in binary64 before and after.
    pub binary64: Option<CheckErrors>,
}

/// Effect of a pass on the rounding errors.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CheckErrors {
    /// Before it.
    pub before: SummaryReport,
    /// After it.
    pub after: SummaryReport,
}

/// The rounding errors of a function in a few numbers.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SummaryReport {
    /// The median over all outputs of their median relative error.
    pub median_relative: f64,
    /// The largest error of an array over its largest element.
    pub worst_normwise: f64,
    /// The largest error of an element in units in its last place.
    pub worst_ulps: f64,
    /// The element with that error.
    pub worst_output: Option<String>,
}

impl CheckReport {
    fn new(verdict: &CheckVerdict, view: View<'_>) -> CheckReport {
        use robovec_analysis::class::NumericClass::{Approximating, Exact, Real, RealTrig};
        let result = match (verdict.holds(), verdict.class) {
            (false, _) => "failed",
            (true, Exact) => "bit-equal",
            (true, Real | RealTrig) => "equal",
            (true, Approximating) => "measured",
        };
        let (domain, condition) = match &verdict.domain {
            DomainVerdict::Same => ("same", None),
            DomainVerdict::Wider(condition) => ("wider", Some(condition.clone())),
            DomainVerdict::Open(condition) => ("open", Some(condition.clone())),
        };
        let failure = verdict.failure.as_ref();
        let change = |index: usize| {
            let changes = verdict.errors.as_ref()?;
            Some(CheckErrors::new(&changes[index], view))
        };
        CheckReport {
            class: verdict.class.name(),
            points: verdict.points,
            seed: verdict.seed,
            result,
            domain,
            condition,
            decided: verdict.fewest.as_ref().map(|(_, decided)| *decided),
            failure: failure.map(ToString::to_string),
            output: failure.map(|failure| failure.name.clone()),
            kind: failure.map(|failure| match failure.kind {
                FailureKind::Signature { .. } => "signature",
                FailureKind::Field { .. } => "field",
                FailureKind::Numbers(_) => "numbers",
                FailureKind::Pole(_) | FailureKind::Hole(_) => "pole",
                FailureKind::Derivative(_) => "derivative",
                FailureKind::Promise(_) => "promise",
                FailureKind::Bits { .. } => "bits",
                FailureKind::Constants { .. } => "constants",
            }),
            deviation: verdict
                .deviation
                .map(|Deviation { worst_normwise, .. }| worst_normwise),
            binary32: change(0),
            binary64: change(1),
        }
    }
}

impl CheckErrors {
    fn new(change: &ErrorChange, view: View<'_>) -> CheckErrors {
        CheckErrors {
            before: SummaryReport::new(&change.before, view),
            after: SummaryReport::new(&change.after, view),
        }
    }
}

impl SummaryReport {
    pub(super) fn new(summary: &ErrorSummary, view: View<'_>) -> SummaryReport {
        SummaryReport {
            median_relative: summary.median_relative,
            worst_normwise: summary.worst_normwise,
            worst_ulps: summary.worst_ulps,
            worst_output: summary
                .worst_output
                .map(|output| print_output(view, output)),
        }
    }
}

/// A user call that splits the function: the caller evaluates the arguments,
/// makes the call, and evaluates the rest with its result.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct BoundaryReport {
    /// The user's function.
    pub callee: String,
    /// Its arguments as written.
    pub arguments: Vec<String>,
    /// Those of them that this function computes: its output arrays.
    pub outputs: Vec<String>,
    /// The input array that takes the result.
    pub result: Option<String>,
}

impl BoundaryReport {
    pub(super) fn collect(view: View<'_>) -> Vec<BoundaryReport> {
        let is_output = |argument: &&String| {
            let mut outputs = view.function.outputs().iter();
            outputs.any(|array| view.tables.symbols.text(array.name) == argument.as_str())
        };
        let describe = |boundary: &Boundary| BoundaryReport {
            callee: boundary.callee.clone(),
            arguments: boundary.arguments.clone(),
            outputs: boundary
                .arguments
                .iter()
                .filter(is_output)
                .cloned()
                .collect(),
            result: boundary.result.clone(),
        };
        view.function.boundaries.iter().map(describe).collect()
    }
}

/// Rounding errors before and after a pass, of all outputs in all states.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RoundingReport {
    /// Unit of the errors: the rounding of one operation.
    pub unit: f64,
    /// Number of states.
    pub states: u32,
    /// Seed of the states.
    pub seed: u64,
    /// Relative to the element.
    pub relative: BeforeAfter,
    /// The largest error of an array over its largest element.
    pub normwise: BeforeAfter,
}

/// Two distributions, and how their medians compare.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct BeforeAfter {
    /// Before the pass.
    pub before: Quantiles,
    /// After it.
    pub after: Quantiles,
    /// The median after the pass over that before.
    pub ratio: f64,
    /// The standard error of the ratio, as a part of the ratio.
    pub noise: f64,
    /// `better`, `same` or `worse`.
    pub trend: &'static str,
    #[serde(skip)]
    pub(super) change: MedianChange,
}

impl RoundingReport {
    pub(super) fn new([before, after]: &[Arc<RoundingErrors>; 2]) -> RoundingReport {
        let both = |pick: fn(&RoundingErrors) -> Quantiles, change: MedianChange| BeforeAfter {
            before: pick(before),
            after: pick(after),
            ratio: change.ratio,
            noise: change.noise,
            trend: change.trend.name(),
            change,
        };
        RoundingReport {
            unit: UNIT,
            states: before.states,
            seed: before.seed,
            relative: both(
                |rounding| rounding.relative,
                MedianChange::relative(before, after),
            ),
            normwise: both(
                |rounding| rounding.normwise,
                MedianChange::normwise(before, after),
            ),
        }
    }
}
