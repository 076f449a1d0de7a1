//! The states at which versions are compared in numbers.

use super::pairing::Pairs;
use robovec_ir::states::States;
use robovec_num::random::mix;
use std::fmt;

/// The size of the inputs of a state.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum StateScale {
    /// As the arrays of Robotran mean them ([`States`]).
    Usual,
    /// Within ±2.
    Near,
    /// Of every size from a thousandth to ten thousand, of either sign.
    Far,
    /// Whole numbers within ±9.
    Whole,
    /// Up to half as much again as a constant of the versions, of either
    /// sign.
    Constants,
    /// A constant of the versions itself, of either sign, or a whole number.
    Special,
    /// Between 0 and 4.
    Positive,
    /// Usual ones again: the intended use of programs has double weight.
    UsualAgain,
    /// Zero: all inputs, then each array in turn, the others as usual.
    Zero,
    /// Found by a search; number 1 is next to a point without binary64
    /// coordinates.
    Found,
}

/// The scales of a round.
pub(super) const SCALES: [StateScale; 8] = [
    StateScale::Usual,
    StateScale::Near,
    StateScale::Far,
    StateScale::Whole,
    StateScale::Constants,
    StateScale::Special,
    StateScale::Positive,
    StateScale::UsualAgain,
];

/// A state: of one scale, by its number from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StatePlace {
    /// The size of its inputs.
    pub scale: StateScale,
    /// The number of the state among those of that scale.
    pub number: u32,
}

impl StatePlace {
    pub(super) fn usual(number: u32) -> StatePlace {
        let scale = if number.is_multiple_of(2) {
            StateScale::Usual
        } else {
            StateScale::UsualAgain
        };
        StatePlace {
            scale,
            number: number / 2,
        }
    }
}

impl fmt::Display for StatePlace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.scale {
            StateScale::Usual => return write!(formatter, "random state {}", 2 * self.number),
            StateScale::UsualAgain => {
                return write!(formatter, "random state {}", 2 * self.number + 1);
            }
            StateScale::Near => "near state",
            StateScale::Far => "far state",
            StateScale::Whole => "whole state",
            StateScale::Constants => "state near constants",
            StateScale::Special => "state of constants",
            StateScale::Positive => "positive state",
            StateScale::Zero => "state with zeros",
            StateScale::Found if self.number == 1 => {
                return formatter.write_str("a place next to a state found by a search");
            }
            StateScale::Found => return formatter.write_str("a state found by a search"),
        };
        write!(formatter, "{name} {}", self.number)
    }
}

/// The inputs of a state of one of the scales that no array sets.
pub(super) fn draw(sizes: &[f64], seed: u64, place: StatePlace, count: usize) -> Vec<f64> {
    let salt = mix(seed ^ mix((place.scale as u64) << 32 | u64::from(place.number)));
    (0..count as u64)
        .map(|element| {
            let bits = mix(salt.wrapping_add(element));
            let sign = if bits & 1 == 1 { -1.0 } else { 1.0 };
            // The upper 52 bits, as a number from 0 to 1.
            let unit = (bits >> 12) as f64 / (1u64 << 52) as f64;
            let whole = (bits >> 8 & 0xff) as f64;
            let constant = match sizes.len() as u64 {
                0 => 1.0,
                count => sizes[(mix(bits) % count) as usize],
            };
            match place.scale {
                StateScale::Near => sign * 2.0 * unit,
                StateScale::Far => {
                    let octaves = 24.0 * unit;
                    sign * 2f64.powi(octaves as i32 - 10) * (1.0 + octaves.fract())
                }
                StateScale::Whole => sign * (whole % 10.0),
                StateScale::Constants => sign * constant * 1.5 * unit,
                StateScale::Special if bits >> 16 & 3 == 0 => sign * (whole % 4.0),
                StateScale::Special => sign * constant,
                StateScale::Positive => 4.0 * unit,
                StateScale::Usual
                | StateScale::UsualAgain
                | StateScale::Zero
                | StateScale::Found => {
                    unreachable!("arrays set these states")
                }
            }
        })
        .collect()
}

impl Pairs<'_> {
    /// The inputs of both versions at a place.
    pub(super) fn numbers(&self, source: &States, place: StatePlace) -> [Vec<f64>; 2] {
        match place.scale {
            StateScale::Usual => self.state(source, 2 * place.number),
            StateScale::UsualAgain => self.state(source, 2 * place.number + 1),
            StateScale::Zero => self.with_zeros(source, place.number),
            _ => {
                let count = self.before.function.input_len();
                let at = |seed: u64| draw(self.sizes(), seed, place, count);
                let other = |instance: u32| at(mix(source.seed() ^ u64::from(instance)));
                self.both(at(source.seed()), |number| number, other)
            }
        }
    }

    /// The number of states with different sets of zeros.
    pub(super) fn zero_states(&self) -> u32 {
        1 + self.before.function.inputs().len() as u32
    }

    /// A state in which all inputs are zero or, beyond the first of
    /// [`Pairs::zero_states`], one array.
    fn with_zeros(&self, source: &States, number: u32) -> [Vec<f64>; 2] {
        let arrays = self.before.function.inputs();
        let place = (number % self.zero_states()) as usize;
        let zeroed = match place.checked_sub(1) {
            None => 0..self.before.function.input_len(),
            Some(array) => {
                let first = arrays[array].offset as usize;
                first..first + arrays[array].shape.len()
            }
        };
        let mut inputs = source.draw(self.before, number);
        inputs[zeroed].fill(0.0);
        self.beside(inputs, source, number)
    }
}
