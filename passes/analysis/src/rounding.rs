//! Distribution of rounding errors in binary32, and its change by a pass.
//!
//! [`accuracy`](super::accuracy) describes every output; here all outputs in
//! all states are one population, of which the median, the 99th percentile
//! and the largest are reported, relative to the element (*relative*) and to the
//! largest element of its array (*normwise*), both in units of the rounding
//! of one operation, 2⁻²⁴: one rounding costs 0.5 in the median.
//!
//! # Larger, or only other
//!
//! A pass that reassociates gives every output another error, so the median
//! of a sample changes even where that of the population does not. Both
//! versions are therefore evaluated at the same states, in [`BLOCKS`] blocks;
//! each block gives a ratio of the two medians, and the scatter of these
//! ratios is the noise of their mean. A median counts as worse when it grew
//! by more than [`SIGNIFICANT`] times its noise and by more than
//! [`NOTICEABLE`]: with eight blocks the first alone would be wrong in about
//! one of two hundred comparisons of equals, in either direction (Student's
//! t with seven degrees of freedom, one-sided).

use super::accuracy::samples;
use robovec_ir::View;
use robovec_ir::states::States;
use robovec_num::format::Format;
use serde::Serialize;
use std::cmp::Ordering;
use std::fmt;
use std::ops::Range;

/// The rounding of one operation in binary32, relative to its result: 2⁻²⁴.
pub const UNIT: f64 = 1.0 / (1u32 << 24) as f64;

/// Into this number of blocks the states are divided to find the noise.
pub const BLOCKS: usize = 8;

/// A change of the median by less than this many times its noise is none.
pub const SIGNIFICANT: f64 = 3.5;

/// A change of the median by less than this part of it is none.
pub const NOTICEABLE: f64 = 0.02;

/// The number of states is chosen so that about this number of operations is
/// evaluated, within [`MIN_STATES`] and [`MAX_STATES`].
const OPERATIONS: usize = 8_000_000;
const MIN_STATES: usize = 16;
const MAX_STATES: usize = 256;

/// Three places in a distribution of errors, in units of [`UNIT`]; NaN where
/// nothing has such an error.
#[derive(Clone, Copy, PartialEq, Default, Debug, Serialize)]
pub struct Quantiles {
    /// Half of the errors are at or below it.
    pub median: f64,
    /// 99 of 100 errors are at or below it.
    pub percentile_99: f64,
    /// The largest.
    pub worst: f64,
}

/// The errors of all outputs of a function in all states.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct RoundingErrors {
    /// The number of states.
    pub states: u32,
    /// The seed they come from.
    pub seed: u64,
    /// Of every element, relative to its exact value.
    pub relative: Quantiles,
    /// Of every array, its largest error over its largest element.
    pub normwise: Quantiles,
    /// The medians of the relative and of the normwise errors in each block
    /// of states.
    blocks: [Vec<f64>; 2],
}

robovec_num::named! {
    /// The trend of an error.
    #[derive(Clone, Copy, PartialEq, Eq, Debug)]
    pub enum Trend {
        /// It became smaller.
        Better = "better",
        /// It did not change, or only within the noise.
        Same = "same",
        /// It grew.
        Worse = "worse",
    }
}

/// A median compared with another one at the same states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MedianChange {
    /// The median afterwards over that before.
    pub ratio: f64,
    /// The standard error of the ratio, as a part of the ratio.
    pub noise: f64,
    /// The verdict.
    pub trend: Trend,
}

/// The number of states used for a function of this number of operations: the
/// more the smaller it is, so that small functions are not judged by a few
/// numbers and large ones in reasonable time.
pub fn usual_states(operations: usize) -> u32 {
    (OPERATIONS / operations.max(1)).clamp(MIN_STATES, MAX_STATES) as u32
}

/// Measures the errors of a function over a number of states. Takes some ten
/// nanoseconds per operation and state.
pub fn rounding(view: View<'_>, states: &States, count: u32) -> RoundingErrors {
    let samples = samples(view, states, count, Format::BINARY32);
    let drawn = count;
    let count = count as usize;
    let relative = |states: Range<usize>| -> Vec<f64> {
        states.flat_map(|state| samples.relative(state)).collect()
    };
    let normwise = |states: Range<usize>| -> Vec<f64> {
        states.flat_map(|state| samples.normwise(state)).collect()
    };
    let block = |block: usize| block * count / BLOCKS..(block + 1) * count / BLOCKS;
    let blocks = (0..BLOCKS).map(block);
    RoundingErrors {
        states: drawn,
        seed: states.seed(),
        relative: Quantiles::of(&mut relative(0..count)),
        normwise: Quantiles::of(&mut normwise(0..count)),
        blocks: [
            blocks
                .clone()
                .map(|states| place(&mut relative(states), 1, 2))
                .collect(),
            blocks
                .map(|states| place(&mut normwise(states), 1, 2))
                .collect(),
        ],
    }
}

/// The smallest error that this part of all does not exceed, if there is one.
pub fn quantile(errors: &mut [f64], part: usize, of: usize) -> Option<f64> {
    let index = (errors.len() * part).div_ceil(of).checked_sub(1)?;
    let (_, error, _) = errors.select_nth_unstable_by(index, f64::total_cmp);
    Some(*error)
}

/// The quantile in units of rounding; NaN without errors.
fn place(errors: &mut [f64], part: usize, of: usize) -> f64 {
    quantile(errors, part, of).map_or(f64::NAN, |error| error / UNIT)
}

impl Quantiles {
    fn of(errors: &mut [f64]) -> Quantiles {
        Quantiles {
            median: place(errors, 1, 2),
            percentile_99: place(errors, 99, 100),
            worst: place(errors, 1, 1),
        }
    }
}

impl MedianChange {
    /// The medians of the relative errors of two versions of a function,
    /// measured at the same states.
    pub fn relative(before: &RoundingErrors, after: &RoundingErrors) -> MedianChange {
        MedianChange::of(&before.blocks[0], &after.blocks[0])
    }

    /// The medians of the normwise errors of two versions of a function,
    /// measured at the same states.
    pub fn normwise(before: &RoundingErrors, after: &RoundingErrors) -> MedianChange {
        MedianChange::of(&before.blocks[1], &after.blocks[1])
    }

    /// Compares medians block by block, those where both have errors.
    fn of(before: &[f64], after: &[f64]) -> MedianChange {
        assert_eq!(
            before.len(),
            after.len(),
            "both versions have the same blocks"
        );
        let known = before.iter().zip(after);
        let known = known.filter(|(before, after)| !before.is_nan() && !after.is_nan());
        let (before, after): (Vec<f64>, Vec<f64>) = known.unzip();
        let same = MedianChange {
            ratio: 1.0,
            noise: 0.0,
            trend: Trend::Same,
        };
        if before == after {
            return same;
        }
        let usable = |error: f64| error.is_finite() && error > 0.0;
        let blocks = before.iter().zip(&after);
        let logarithms: Vec<f64> = blocks
            .filter(|(before, after)| usable(**before) && usable(**after))
            .map(|(before, after)| (after / before).ln())
            .collect();
        if logarithms.len() < 2 {
            // Half of all errors are zero, before or after, or not finite:
            // there is nothing to divide by.
            let (before, after) = (before.iter().sum::<f64>(), after.iter().sum::<f64>());
            return MedianChange {
                ratio: after / before,
                noise: f64::INFINITY,
                trend: match before.total_cmp(&after) {
                    Ordering::Less => Trend::Worse,
                    Ordering::Equal => Trend::Same,
                    Ordering::Greater => Trend::Better,
                },
            };
        }
        let count = logarithms.len() as f64;
        let mean = logarithms.iter().sum::<f64>() / count;
        let squares = logarithms.iter().map(|log| (log - mean) * (log - mean));
        let noise = (squares.sum::<f64>() / (count - 1.0) / count).sqrt();
        let threshold = (SIGNIFICANT * noise).max(NOTICEABLE.ln_1p());
        MedianChange {
            ratio: mean.exp(),
            noise,
            trend: if mean > threshold {
                Trend::Worse
            } else if mean < -threshold {
                Trend::Better
            } else {
                Trend::Same
            },
        }
    }
}

impl fmt::Display for MedianChange {
    /// `same`, or by how much the median is better or worse.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.trend.name())?;
        if self.trend == Trend::Same && self.ratio == 1.0 {
            return Ok(());
        }
        let [change, noise] = [self.ratio - 1.0, self.noise].map(|part| part * 100.0);
        write!(formatter, " ({change:+.1} %, noise {noise:.1} %)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse::parse_module;

    fn measured(expression: &str, states: u32) -> RoundingErrors {
        let text = format!(
            "function f equations {{\n  in q[1..9]\n  out c[1..2]\n  c[1] = {expression}\n  c[2] = q[2]*q[1]\n}}\n"
        );
        let module = parse_module("f", &text).expect("it is sound");
        let view = module.tables.view(&module.functions[0]);
        rounding(view, &States::new(5), states)
    }

    #[test]
    fn one_rounding_is_a_fraction_of_the_unit() {
        let product = measured("q[1]*q[2]", 256);
        let Quantiles {
            median,
            percentile_99,
            worst,
        } = product.relative;
        assert!((0.2..0.6).contains(&median), "{median}");
        assert!(median < percentile_99 && percentile_99 <= worst && worst <= 1.0);
        assert!(product.normwise.median <= 1.0);
    }

    #[test]
    fn a_longer_product_is_worse_and_the_same_one_in_another_order_is_not() {
        let short = measured("q[1]*q[2]", 256);
        let long = measured("q[1]*q[2]*q[3]*q[4]*q[5]*q[6]*q[7]*q[8]", 256);
        let turned = measured("q[5]*q[6]*q[7]*q[8]*q[1]*q[2]*q[3]*q[4]", 256);
        assert_eq!(MedianChange::relative(&short, &long).trend, Trend::Worse);
        assert_eq!(MedianChange::relative(&long, &short).trend, Trend::Better);
        let other = MedianChange::relative(&long, &turned);
        assert!(
            other.ratio != 1.0 && other.trend == Trend::Same,
            "{other:?}"
        );
        assert_eq!(MedianChange::relative(&long, &long).noise, 0.0);
    }

    #[test]
    fn places_in_a_distribution_are_those_of_sorted_numbers() {
        let mut errors: Vec<f64> = (1..=1000).rev().map(|n| f64::from(n) * UNIT).collect();
        let quantiles = Quantiles::of(&mut errors);
        assert_eq!(
            (quantiles.median, quantiles.percentile_99, quantiles.worst),
            (500.0, 990.0, 1000.0)
        );
        assert!(Quantiles::of(&mut []).worst.is_nan());
    }

    #[test]
    fn large_functions_get_fewer_states() {
        assert_eq!(usual_states(0), 256);
        assert_eq!(usual_states(80_000), 100);
        assert_eq!(usual_states(600_000), 16);
    }
}
