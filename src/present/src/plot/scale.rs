//! From values to places along an axis, and which values are marked.

use crate::number::{exponential, trimmed};
use crate::{AxisScale, PlotAxis};

/// An axis with a range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ruler {
    scale: AxisScale,
    from: f64,
    to: f64,
}

impl Ruler {
    /// The ruler that shows an axis and all these values.
    pub(super) fn new(axis: &PlotAxis, values: impl Iterator<Item = f64>) -> Ruler {
        let is_log = axis.scale != AxisScale::Linear;
        let shown = values.chain(axis.from).chain(axis.to);
        let shown = shown.filter(|value| value.is_finite() && (!is_log || *value > 0.0));
        let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (low, high) = if low <= high { (low, high) } else { (1.0, 2.0) };
        let (from, to) = match axis.scale {
            AxisScale::Linear => linear_range(low, high, axis),
            AxisScale::PowersOfTwo => {
                let margin = if low < high { 1.12 } else { 1.5 };
                (low / margin, high * margin)
            }
            AxisScale::Decades => (below(low * 0.98), above(high * 1.02)),
        };
        Ruler {
            scale: axis.scale,
            from,
            to,
        }
    }

    /// Position of a value: 0 at the start of the axis, 1 at its end.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            AxisScale::Linear => (value - self.from) / (self.to - self.from),
            AxisScale::PowersOfTwo | AxisScale::Decades => {
                (value.max(f64::MIN_POSITIVE) / self.from).ln() / (self.to / self.from).ln()
            }
        }
    }

    /// The values to mark, ascending.
    pub(super) fn ticks(&self) -> Vec<f64> {
        // Numbers near zero matter on a linear axis only by its length.
        let slack = match self.scale {
            AxisScale::Linear => 1e-9 * (self.to - self.from),
            AxisScale::PowersOfTwo | AxisScale::Decades => 0.0,
        };
        let within = |value: &f64| {
            *value >= self.from * (1.0 - 1e-9) - slack && *value <= self.to * (1.0 + 1e-9) + slack
        };
        match self.scale {
            AxisScale::Linear => {
                let step = linear_step(self.to - self.from);
                let first = (self.from / step).ceil();
                let count = ((self.to - self.from) / step) as u32 + 1;
                let values = (0..=count).map(|index| (first + f64::from(index)) * step);
                values.filter(within).collect()
            }
            AxisScale::PowersOfTwo => {
                let values = (-10..40).map(|exponent| 2f64.powi(exponent));
                values.filter(within).collect()
            }
            AxisScale::Decades => {
                let decades = (self.to / self.from).log10();
                let factors: &[f64] = if decades > 3.5 {
                    &[1.0]
                } else {
                    &[1.0, 2.0, 5.0]
                };
                let values = (-40..15).flat_map(|exponent| {
                    factors
                        .iter()
                        .map(move |factor| factor * 10f64.powi(exponent))
                });
                values.filter(within).collect()
            }
        }
    }

    /// The label of a mark.
    pub(super) fn text(&self, value: f64) -> String {
        let step = linear_step(self.to - self.from);
        if self.scale == AxisScale::Decades && value < SMALLEST_STEP {
            return format!("{value:.0e}");
        }
        if self.scale != AxisScale::Linear || step >= SMALLEST_STEP {
            return tick_text(value);
        }
        // The marks of a short axis differ in later decimals.
        match self.from.abs().max(self.to.abs()) {
            largest if largest < 10.0 * SMALLEST_STEP => exponential(value),
            _ => format!("{value:.*}", (-step.log10()).ceil() as usize),
        }
    }
}

/// A range that starts and ends at marks; from 0 when that is near.
fn linear_range(low: f64, high: f64, axis: &PlotAxis) -> (f64, f64) {
    let low = if low > 0.0 && low < 0.5 * high && axis.from.is_none() {
        0.0
    } else {
        low
    };
    let high = if high > low { high } else { low + 1.0 };
    let step = linear_step(high - low);
    let end = if axis.to == Some(high) {
        high
    } else {
        (high / step).ceil() * step
    };
    ((low / step).floor() * step, end)
}

/// 1, 2 or 5 times a power of ten, for about five marks.
fn linear_step(range: f64) -> f64 {
    let raw = (range / 5.0).max(f64::MIN_POSITIVE);
    let decade = 10f64.powf(raw.log10().floor());
    let factor = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|factor| factor * decade >= raw * 0.999);
    factor.unwrap_or(10.0) * decade
}

/// The nearest 1, 2 or 5 times a power of ten below.
fn below(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let factor = [5.0, 2.0]
        .into_iter()
        .find(|factor| factor * decade <= value);
    factor.unwrap_or(1.0) * decade
}

/// The nearest 1, 2 or 5 times a power of ten above.
fn above(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let factor = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|factor| factor * decade >= value);
    factor.unwrap_or(10.0) * decade
}

/// Steps of linear axes below this one need more than the usual decimals.
const SMALLEST_STEP: f64 = 1e-4;

/// The text of a tick, with separators between thousands.
fn tick_text(value: f64) -> String {
    if value >= 1e4 && value % 1.0 == 0.0 {
        let digits = format!("{value:.0}");
        let mut text = String::new();
        for (index, digit) in digits.chars().enumerate() {
            if index > 0 && (digits.len() - index) % 3 == 0 {
                text.push('\u{202f}');
            }
            text.push(digit);
        }
        return text;
    }
    trimmed(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ruler(scale: AxisScale, values: &[f64]) -> Ruler {
        Ruler::new(&PlotAxis::new("x", scale), values.iter().copied())
    }

    #[test]
    fn marks_of_small_decades_are_told() {
        let errors = ruler(AxisScale::Decades, &[3e-17, 4e-14]);
        let texts: Vec<String> = errors.ticks().iter().map(|&at| errors.text(at)).collect();
        assert!(
            texts.len() >= 3 && texts.contains(&"1e-15".to_owned()),
            "{texts:?}"
        );
        let mut distinct = texts.clone();
        distinct.dedup();
        assert_eq!(distinct, texts);
    }

    #[test]
    fn marks_are_round() {
        assert_eq!(
            ruler(AxisScale::Linear, &[0.0, 1.0]).ticks(),
            [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]
        );
        assert_eq!(
            ruler(AxisScale::PowersOfTwo, &[2.0, 16.0]).ticks(),
            [2.0, 4.0, 8.0, 16.0]
        );
        assert_eq!(
            ruler(AxisScale::Decades, &[737.0, 3200.0]).ticks(),
            [500.0, 1000.0, 2000.0, 5000.0]
        );
    }

    #[test]
    fn places_run_from_the_start_to_the_end() {
        for scale in [
            AxisScale::Linear,
            AxisScale::PowersOfTwo,
            AxisScale::Decades,
        ] {
            let ruler = ruler(scale, &[3.0, 70.0, 900.0]);
            let places: Vec<f64> = [3.0, 70.0, 900.0].map(|value| ruler.place(value)).to_vec();
            assert!(
                places.is_sorted() && places[0] >= 0.0 && places[2] <= 1.0,
                "{places:?}"
            );
        }
    }

    #[test]
    fn nothing_at_all_has_an_axis_too() {
        for scale in [
            AxisScale::Linear,
            AxisScale::PowersOfTwo,
            AxisScale::Decades,
        ] {
            for values in [&[][..], &[0.0], &[5.0], &[f64::NAN, f64::INFINITY]] {
                let ruler = ruler(scale, values);
                assert!(ruler.place(1.0).is_finite());
                assert!(ruler.ticks().len() < 50);
            }
        }
    }
}
