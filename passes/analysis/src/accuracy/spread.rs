//! A few places in a distribution of errors.

use serde::Serialize;

/// The spread of the errors of one thing over all states.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct StateSpread {
    /// Half of the states are at or below it.
    pub median: f64,
    /// 99 of 100 states are at or below it; the largest of fewer.
    pub percentile_99: f64,
    /// The largest.
    pub worst: f64,
    /// The number of the state with this error, in the numbering of
    /// [`robovec_ir::states::States::draw`]; the first of several.
    pub worst_state: u32,
}

impl StateSpread {
    /// The spread without any state.
    pub const NOWHERE: StateSpread = StateSpread {
        median: f64::NAN,
        percentile_99: f64::NAN,
        worst: f64::NAN,
        worst_state: 0,
    };

    /// The spread of errors with their states; NaN is left out.
    /// [`StateSpread::NOWHERE`] of nothing.
    pub fn of(errors: impl Iterator<Item = (u32, f64)>) -> StateSpread {
        let mut errors: Vec<(u32, f64)> = errors.filter(|(_, error)| !error.is_nan()).collect();
        let order = |a: &(u32, f64), b: &(u32, f64)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
        let count = errors.len();
        if count == 0 {
            return StateSpread::NOWHERE;
        }
        // The lower median of an even number.
        let places = [(count - 1) / 2, (count * 99).div_ceil(100) - 1, count - 1];
        let [median, percentile_99, worst] = places.map(|place| {
            let (_, error, _) = errors.select_nth_unstable_by(place, order);
            *error
        });
        StateSpread {
            median: median.1,
            percentile_99: percentile_99.1,
            worst: worst.1,
            worst_state: worst.0,
        }
    }

    /// The same with an increasing function applied to every error.
    #[must_use]
    pub fn map(self, of: impl Fn(f64) -> f64) -> StateSpread {
        StateSpread {
            median: of(self.median),
            percentile_99: of(self.percentile_99),
            worst: of(self.worst),
            ..self
        }
    }

    /// For errors in ulps: the number of lost bits, `log2(1 + ulps)`, which is
    /// 0 for an exact result and at most 0.6 for one that was rounded once.
    #[must_use]
    pub fn bits(self) -> StateSpread {
        self.map(|ulps| ulps.ln_1p() / std::f64::consts::LN_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_sorted_errors() {
        let errors = (0..1000u32).map(|state| (state, f64::from((state * 7) % 1000)));
        let spread = StateSpread::of(errors);
        assert_eq!((spread.median, spread.percentile_99), (499.0, 989.0));
        assert_eq!((spread.worst, spread.worst_state), (999.0, 857));
        let few = StateSpread::of([(3, 1.0), (4, f64::NAN), (5, 2.0), (6, 2.0)].into_iter());
        assert_eq!((few.median, few.percentile_99, few.worst), (2.0, 2.0, 2.0));
        assert_eq!(few.worst_state, 5, "the first of equals");
        assert!(StateSpread::of(std::iter::empty()).worst.is_nan());
        let bits = few.bits();
        assert!((bits.worst - 3f64.log2()).abs() < 1e-12 && bits.worst_state == 5);
    }
}
