//! Sines and cosines of all angles at once.
//!
//! The C library computes them one by one, some ten nanoseconds for an angle;
//! a loop without branches over an array of angles becomes vector
//! instructions in every compiler. Only angles that need no other sine can be
//! in the array, which is all of them in a mechanism's equations.
//!
//! **Method.** The angle is reduced to an eighth of a turn with pi/2 in three
//! pieces (Cody and Waite, 1980), the first two of 33 bits, so that their
//! products with the number of quarter turns are exact; the rounding error of
//! the difference is kept as a second number. Polynomials of degree 13 and 14
//! have the smallest largest error there, 2^-58 and 2^-64. The result is within
//! 0.8 units in the last place (1.1 where it nearly vanishes), and zero has no
//! sign; angles of more than 2^19 radians, infinities and NaN go to the C
//! library.

use hashbrown::HashMap;
use robovec_framework::template::fill;
use robovec_ir::{Function, Operand, Operation, Value};
use rustc_hash::FxBuildHasher;
use std::fmt::Display;

/// The place of each sine in the work array: sines first, then cosines, then
/// angles.
pub(super) struct Slots {
    angles: Vec<Operand>,
    /// For each node its word, if it has one.
    words: Vec<Option<u32>>,
}

impl Slots {
    /// No sine is computed in an array.
    pub(super) fn none(function: &Function) -> Slots {
        Slots {
            angles: Vec::new(),
            words: vec![None; function.nodes().len()],
        }
    }

    /// The sines of a function that need no other sine.
    pub(super) fn new(function: &Function, live: &[bool]) -> Slots {
        let mut slots = Slots::none(function);
        let mut known: HashMap<Operand, u32, FxBuildHasher> = HashMap::default();
        let mut late = vec![false; live.len()];
        let mut found = Vec::new();
        for (value, node) in function.values() {
            let mut values = node.operands().iter().filter_map(|operand| operand.value());
            let waits = values.any(|value| late[value.index()]);
            let trigonometric = node.operation.is_trigonometric();
            late[value.index()] = waits || trigonometric;
            if trigonometric && !waits && live[value.index()] {
                let angle = node.operands[0];
                let slot = *known.entry(angle).or_insert_with(|| {
                    slots.angles.push(angle);
                    slots.angles.len() as u32 - 1
                });
                found.push((value, node.operation == Operation::Cos, slot));
            }
        }
        let padded = slots.padded();
        for (value, is_cosine, slot) in found {
            slots.words[value.index()] = Some(if is_cosine { padded + slot } else { slot });
        }
        slots
    }

    /// The angles, in order of their slots.
    pub(super) fn angles(&self) -> &[Operand] {
        &self.angles
    }

    /// The word that holds a sine.
    pub(super) fn of(&self, value: Value) -> Option<u32> {
        self.words[value.index()]
    }

    /// The number of slots, a multiple of a long vector's length, so that no
    /// compiler needs a loop for a remainder. With short vectors the remainder
    /// is smaller than the number of empty slots.
    pub(super) fn padded(&self) -> u32 {
        let angles = self.angles.len() as u32;
        angles.next_multiple_of(if angles > 4 { 8 } else { 4 })
    }

    /// The number of words taken of the work array.
    pub(super) fn words(&self) -> u32 {
        3 * self.padded()
    }

    pub(super) fn angle_words(&self) -> std::ops::Range<u32> {
        2 * self.padded()..3 * self.padded()
    }

    /// The C function `name(real *work)` that computes them.
    pub(super) fn source(&self, name: &str, real: &str) -> String {
        let words: [(&str, &dyn Display); 4] = [
            ("name", &name),
            ("real", &real),
            ("count", &self.padded()),
            ("exact", &self.angles.len()),
        ];
        fill(KERNEL, &words)
    }
}

/// The loop. `shifted` has the number of quarter turns in its last bits.
const KERNEL: &str = include_str!("sines.c");
