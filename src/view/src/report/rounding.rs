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
    pub before: QuantilesReport,
    /// After it.
    pub after: QuantilesReport,
    /// The median after the pass over that before.
    pub ratio: f64,
    /// The standard error of the ratio, as a part of the ratio.
    pub noise: f64,
    /// `better`, `same` or `worse`.
    pub trend: &'static str,
    #[serde(skip)]
    pub(super) change: MedianChange,
}

/// Three places in a distribution, in units of rounding.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct QuantilesReport {
    /// Half of the errors are at or below it.
    pub median: f64,
    /// 99 of 100 errors are at or below it.
    pub percentile_99: f64,
    /// The largest.
    pub worst: f64,
}

impl From<Quantiles> for QuantilesReport {
    fn from(quantiles: Quantiles) -> QuantilesReport {
        QuantilesReport {
            median: quantiles.median,
            percentile_99: quantiles.percentile_99,
            worst: quantiles.worst,
        }
    }
}

impl RoundingReport {
    pub(super) fn new([before, after]: &[Arc<RoundingErrors>; 2]) -> RoundingReport {
        let both = |pick: fn(&RoundingErrors) -> Quantiles, change: MedianChange| BeforeAfter {
            before: pick(before).into(),
            after: pick(after).into(),
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
