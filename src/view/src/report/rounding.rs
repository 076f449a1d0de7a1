//! Effect of a pass on the rounding errors in binary32.

use robovec_analysis::rounding::{MedianChange, Quantiles, RoundingErrors, UNIT};
use serde::Serialize;
use std::sync::Arc;

/// Rounding errors before and after a pass, all outputs in all states being
/// one population.
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
