//! New states from bad ones: nearer and further, with inputs of others, at the
//! ends of ranges, at zero, and where rounding to the format moves them most.
//!
//! **Invariant.** Every state lies in the ranges.

use robovec_analysis::adjoint::half_ulp;
use robovec_ir::{Format, Input, View};
use robovec_num::random::{mix, unit};
use robovec_num::soft_float::FormatArithmetic;

/// Operators that make new states of a function from known ones.
pub struct StateBreeder {
    /// The range of every input; inputs without one keep the values drawn.
    ranges: Vec<Option<[f64; 2]>>,
    /// The array of every input.
    arrays: Vec<usize>,
    /// The inputs with a range of more than one number.
    free: Vec<usize>,
    /// The format that inputs are rounded to.
    format: Format,
}

impl StateBreeder {
    /// Operators for a function that is computed in a format, given the range
    /// of every input element, by its number from 0.
    pub fn new(
        (view, format): (View<'_>, Format),
        range: impl Fn(u32) -> Option<[f64; 2]>,
    ) -> StateBreeder {
        let function = view.function;
        let inputs = 0..function.input_len() as u32;
        let ranges: Vec<Option<[f64; 2]>> = inputs.clone().map(range).collect();
        let array = |input: u32| {
            let (own, _, _) = function.input_element(Input(input));
            let same = |array: &robovec_ir::Array| array.name == own.name;
            function.inputs().iter().position(same)
        };
        let is_free = |input: &usize| ranges[*input].is_some_and(|[low, high]| low < high);
        StateBreeder {
            arrays: inputs
                .map(|input| array(input).expect("an input belongs to an array"))
                .collect(),
            free: (0..ranges.len()).filter(is_free).collect(),
            ranges,
            format,
        }
    }

    /// A state with all digits of binary64: drawn ones are rounded to binary32.
    pub fn refined(&self, mut state: Vec<f64>, seed: u64) -> Vec<f64> {
        for &input in &self.free {
            let step = state[input].abs() * f64::from(f32::EPSILON);
            let place = unit(mix(seed ^ input as u64)) - 0.5;
            self.set(&mut state, input, |number| number + step * place);
        }
        state
    }

    /// A state with all or some inputs at the ends of their ranges and at zero.
    pub fn corner(&self, mut state: Vec<f64>, seed: u64) -> Vec<f64> {
        let kinds = 2 + seed % 3;
        for &input in &self.free {
            let [low, high] = self.ranges[input].expect("a free input has a range");
            let kind = mix(seed ^ mix(input as u64)) % kinds;
            self.set(&mut state, input, |number| {
                [low, high, 0.0, number][kind as usize]
            });
        }
        state
    }

    /// A new state from one and, in part, from another of bad ones.
    pub fn child(&self, parent: &[f64], others: &[Vec<f64>], seed: u64) -> Vec<f64> {
        let mut random = mix(seed);
        let mut next = || {
            random = mix(random);
            random
        };
        let mut state = parent.to_vec();
        if self.free.is_empty() || next().is_multiple_of(8) {
            // Whole arrays of another state: what belongs together stays so.
            let other = &others[(next() % others.len() as u64) as usize];
            let taken = next();
            for (input, number) in state.iter_mut().enumerate() {
                if mix(taken ^ self.arrays[input] as u64).is_multiple_of(2) {
                    *number = other[input];
                }
            }
            return state;
        }
        for _ in 0..1 + next() % 3 {
            let input = self.free[(next() % self.free.len() as u64) as usize];
            let [low, high] = self.ranges[input].expect("a free input has a range");
            let (kind, place, depth) = (next() % 9, unit(next()), next() % 40);
            let other = &others[(next() % others.len() as u64) as usize];
            self.set(&mut state, input, |number| match kind {
                0 => low,
                1 => high,
                2 => 0.0,
                3 => low + (high - low) * place,
                4 => other[input],
                5 => self.between_numbers(number, place),
                // From half of the range down to the last digits.
                _ => number + (high - low) * 0.5f64.powi(depth as i32) * (place - 0.5),
            });
        }
        state
    }

    /// A state near another, free inputs rounded to the side of larger errors.
    pub(super) fn aligned(&self, mut state: Vec<f64>, slopes: &[f64]) -> Vec<f64> {
        for &input in &self.free {
            let slope = slopes[input];
            if slope != 0.0 {
                // A number that is rounded up adds to what grows with it.
                self.set(&mut state, input, |number| {
                    self.between_numbers(number, 0.5 - slope)
                });
            }
        }
        state
    }

    /// A number just above or below the middle of two neighbours of the format.
    fn between_numbers(&self, number: f64, place: f64) -> f64 {
        let held = FormatArithmetic::new(self.format).convert(number);
        let most = half_ulp(self.format, held) * (1.0 - f64::from(f32::EPSILON));
        if most.is_finite() {
            held + most.copysign(place - 0.5)
        } else {
            number
        }
    }

    fn set(&self, state: &mut [f64], input: usize, change: impl FnOnce(f64) -> f64) {
        let [low, high] = self.ranges[input].expect("a free input has a range");
        state[input] = change(state[input]).clamp(low, high);
    }
}
