//! Errors of one format, state after state.

use super::{ArrayError, ElementError, FormatAccuracy, StateSpread};
use robovec_ir::{Output, View};
use robovec_num::double_double::Double;
use robovec_num::format::Format;

/// Elements smaller than this part of their array's largest are zero except for
/// rounding: 2⁻⁷⁰, far above the rounding of double-double and far below that
/// of binary64.
pub const VANISHING: f64 = 1.0 / (1u128 << 70) as f64;

/// One output in one state.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The size of the exact value.
    size: f64,
    /// The [`distance`] of the computed number from it.
    distance: f64,
    /// The floor that the mixed error adds to the size.
    floor: f64,
    /// True when it is zero except for rounding.
    small: bool,
    /// True for an element without a relative error here: see
    /// [`Samples::settle`].
    vanished: bool,
    /// The computed number is below the normal ones, or zero in their place.
    subnormal: bool,
}

impl Sample {
    /// True for an exact value of zero, up to rounding, that was not computed
    /// as zero.
    fn vanishes(&self) -> bool {
        self.small && self.distance > 0.0
    }

    fn relative(&self) -> f64 {
        if self.vanished {
            f64::NAN
        } else {
            quotient(self.distance, self.size)
        }
    }

    fn mixed(&self) -> f64 {
        if self.vanished {
            f64::NAN
        } else {
            quotient(self.distance, self.size + self.floor)
        }
    }

    fn ulps(&self, format: Format) -> f64 {
        if self.vanished {
            f64::NAN
        } else {
            self.distance / ulp(format, self.size)
        }
    }
}

/// Errors of one format.
pub(crate) struct Samples {
    pub(super) format: Format,
    /// For each state its number and all assignments.
    states: Vec<Vec<Sample>>,
    /// For each state the largest error and the largest exact value of every
    /// output array.
    norms: Vec<Vec<(f64, f64)>>,
    /// The output array of every assignment.
    arrays: Vec<usize>,
}

impl Samples {
    pub(super) fn new(view: View<'_>, format: Format) -> Samples {
        let assignments = view.function.assignments.iter();
        Samples {
            format,
            states: Vec::new(),
            norms: Vec::new(),
            arrays: assignments
                .map(|a| view.function.output_array(a.output))
                .collect(),
        }
    }

    /// Adds a state: the exact outputs, the computed ones, and the floors of
    /// the mixed error, none for zero.
    pub(super) fn add(
        &mut self,
        view: View<'_>,
        exact: impl Iterator<Item = Double>,
        computed: impl Iterator<Item = f64>,
        floors: &[f64],
    ) {
        let mut norms = vec![(0.0f64, 0.0f64); view.function.outputs().len()];
        let mut samples = Vec::with_capacity(self.arrays.len());
        for (place, ((exact, computed), &array)) in
            exact.zip(computed).zip(&self.arrays).enumerate()
        {
            let size = exact.high.abs();
            let distance = distance(exact, computed);
            let floor = match floors {
                [] => 0.0,
                floors => floors[place],
            };
            samples.push(Sample {
                size,
                distance,
                floor: if floor.is_finite() { floor } else { 0.0 },
                small: false,
                vanished: false,
                subnormal: computed.abs() < smallest(self.format) && size != 0.0,
            });
            if !distance.is_nan() {
                let norm = &mut norms[array];
                *norm = (norm.0.max(distance), norm.1.max(size));
            }
        }
        assert_eq!(
            samples.len(),
            self.arrays.len(),
            "every output has an exact and a computed number"
        );
        for (sample, &array) in samples.iter_mut().zip(&self.arrays) {
            sample.small = sample.size <= norms[array].1 * VANISHING;
        }
        self.states.push(samples);
        self.norms.push(norms);
    }

    /// Takes the relative error from every element that is zero except for
    /// rounding and was computed otherwise in some state: that it was computed
    /// as zero in other states is luck, and no relative error of 0. Follows the
    /// last state.
    pub(super) fn settle(&mut self) {
        for place in 0..self.arrays.len() {
            let vanishes = |samples: &Vec<Sample>| samples[place].vanishes();
            if self.states.iter().any(vanishes) {
                for samples in &mut self.states {
                    samples[place].vanished = samples[place].small;
                }
            }
        }
    }

    /// The relative errors of a state, of the outputs that have one.
    pub(crate) fn relative(&self, state: usize) -> impl Iterator<Item = f64> + '_ {
        let errors = self.states[state].iter().map(Sample::relative);
        errors.filter(|error| !error.is_nan())
    }

    /// The normwise errors of a state, of the arrays that have one.
    pub(crate) fn normwise(&self, state: usize) -> impl Iterator<Item = f64> + '_ {
        // Arrays without an assignment, and those that are all zero, have
        // none.
        let norms = self.norms[state].iter();
        let present = norms.filter(|(error, size)| *error > 0.0 || *size > 0.0);
        present.map(|&(error, size)| quotient(error, size))
    }

    /// The size of an assignment's exact value in a state.
    pub(super) fn size(&self, state: u32, place: usize) -> f64 {
        self.states[state as usize][place].size
    }

    /// A measure over the states.
    fn spread(&self, measure: impl Fn(usize) -> f64) -> StateSpread {
        StateSpread::of((0..self.states.len()).map(|state| (state as u32, measure(state))))
    }

    /// A measure over all outputs and states.
    fn population(&self, measure: impl Fn(&Sample) -> f64) -> StateSpread {
        let states = self.states.iter().enumerate();
        StateSpread::of(
            states
                .flat_map(|(state, samples)| {
                    samples.iter().map(move |sample| (state as u32, sample))
                })
                .map(|(state, sample)| (state, measure(sample))),
        )
    }

    fn count(&self, place: usize, of: impl Fn(&Sample) -> bool) -> u32 {
        let states = self.states.iter();
        states.filter(|samples| of(&samples[place])).count() as u32
    }

    fn element(&self, place: usize, output: Output) -> ElementError {
        let of = |measure: &dyn Fn(&Sample) -> f64| {
            self.spread(|state| measure(&self.states[state][place]))
        };
        let relative = of(&Sample::relative);
        ElementError {
            output,
            absolute: of(&|sample| sample.distance),
            relative,
            ulps: of(&|sample| sample.ulps(self.format)),
            mixed: of(&Sample::mixed),
            sensitivity: of(&|sample| sample.floor / sample.size).median,
            worst_state: relative.worst_state,
            vanishing: self.count(place, Sample::vanishes),
            subnormal: self.count(place, |sample| sample.subnormal),
            overflowed: self.count(place, |sample| sample.distance == f64::INFINITY),
            conditioned: None,
        }
    }

    fn array(&self, array: usize) -> ArrayError {
        let largest = |measure: fn(&Sample) -> f64| {
            self.spread(|state| {
                let samples = self.states[state].iter().zip(&self.arrays);
                let own = samples.filter(|(_, of)| **of == array);
                // NaN is no number to be larger than.
                own.map(|(sample, _)| measure(sample))
                    .fold(f64::NAN, f64::max)
            })
        };
        ArrayError {
            array,
            normwise: self.spread(|state| {
                let (error, size) = self.norms[state][array];
                quotient(error, size)
            }),
            componentwise: largest(Sample::relative),
            mixed: largest(Sample::mixed),
        }
    }

    pub(super) fn finish(&mut self, view: View<'_>) -> FormatAccuracy {
        self.settle();
        let assignments = view.function.assignments.iter().enumerate();
        let mut present = vec![false; view.function.outputs().len()];
        for &array in &self.arrays {
            present[array] = true;
        }
        let all = (self.arrays.len() * self.states.len()).max(1) as f64;
        let share = |of: fn(&Sample) -> bool| {
            let samples = self.states.iter().flatten();
            samples.filter(|sample| of(sample)).count() as f64 / all
        };
        FormatAccuracy {
            format: self.format,
            relative: self.population(Sample::relative),
            mixed: self.population(Sample::mixed),
            subnormal: share(|sample| sample.subnormal),
            overflowed: share(|sample| sample.distance == f64::INFINITY),
            elements: assignments
                .map(|(place, assignment)| self.element(place, assignment.output))
                .collect(),
            arrays: (0..present.len())
                .filter(|&array| present[array])
                .map(|array| self.array(array))
                .collect(),
        }
    }
}

/// The distance of a computed number from the exact one: NaN where that is not
/// finite, infinite where only the computed one is not.
pub fn distance(exact: Double, computed: f64) -> f64 {
    match (exact.high.is_finite(), computed.is_finite()) {
        (false, _) => f64::NAN,
        (true, false) => f64::INFINITY,
        (true, true) => exact.distance(computed),
    }
}

/// The error over the size; no error is 0 for any size.
fn quotient(error: f64, size: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / size }
}

/// The unit in the last place of a number in a format.
fn ulp(format: Format, size: f64) -> f64 {
    let float = match format {
        Format::Float(float) => float,
        Format::Fixed(fixed) => return 2f64.powi(-(fixed.fraction as i32)),
    };
    let smallest = float.smallest_exponent();
    let exponent = match size.to_bits() >> 52 {
        // Zero and subnormals.
        0 => smallest,
        biased => (biased as i32 - 1023).max(smallest),
    };
    2f64.powi(exponent - float.mantissa as i32)
}

/// The smallest normal number; fixed point has no others.
fn smallest(format: Format) -> f64 {
    match format {
        Format::Float(float) => 2f64.powi(float.smallest_exponent()),
        Format::Fixed(_) => 0.0,
    }
}
