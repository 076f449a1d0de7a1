//! Sines and cosines of all angles at once.
//!
//! The C library computes them one by one, some ten nanoseconds for an angle;
//! a loop without branches over an array of angles becomes vector
//! instructions in every compiler. Only angles that need no other sine can be
//! in the array, which is all of them in a mechanism's equations.
//!
//! **Method.** The angle is reduced to an eighth of a turn with pi/2 in three
//! pieces (Cody and Waite, 1980), the first two of 33 bits, so that their
//! products with the number of quarter turns are exact; what is rounded off
//! in the difference is carried along as a second number. Polynomials of
//! degree 13 and 14 have the smallest largest error there, 2^-58 and 2^-64.
//! The result is within 0.8 units in the last place (1.1 where it nearly
//! vanishes), and zero has no sign; angles of more than 2^19
//! radians, infinities and NaN go to the C library.

use hashbrown::HashMap;
use robovec_ir::{Function, Operand, Operation, Value};
use rustc_hash::FxBuildHasher;

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
    /// compiler needs a loop for what is left over. With short vectors what
    /// is left over is less than the slots that stay empty.
    pub(super) fn padded(&self) -> u32 {
        let angles = self.angles.len() as u32;
        angles.next_multiple_of(if angles > 4 { 8 } else { 4 })
    }

    /// The number of words taken of the work array.
    pub(super) fn words(&self) -> u32 {
        3 * self.padded()
    }

    /// The words of the angles.
    pub(super) fn angle_words(&self) -> std::ops::Range<u32> {
        2 * self.padded()..3 * self.padded()
    }

    /// The C function `name(real *work)` that computes them.
    pub(super) fn source(&self, name: &str, real: &str) -> String {
        KERNEL
            .replace("NAME", name)
            .replace("REAL", real)
            .replace("COUNT", &self.padded().to_string())
            .replace("EXACT", &self.angles.len().to_string())
    }
}

/// The loop. `shifted` has the number of quarter turns in its last bits.
const KERNEL: &str = r"
/* Sines and cosines of EXACT angle(s), within 1.1 units in the last place. */
#undef ROBOVEC_ANGLES
#if defined(__AVX2__) || defined(ROBOVEC_CLONED)
#define ROBOVEC_ANGLES COUNT
#else
#define ROBOVEC_ANGLES EXACT
#endif
#if defined(__FAST_MATH__) || (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0)
static void NAME(REAL *restrict work)
{
    for (int i = 0; i < ROBOVEC_ANGLES; i++) {
        const double angle = work[2 * COUNT + i];
        work[i] = (REAL)sin(angle);
        work[COUNT + i] = (REAL)cos(angle);
    }
}
#else
ROBOVEC_CLONES ROBOVEC_APART static void NAME(REAL *restrict work)
{
    int large = 0;
    for (int i = 0; i < ROBOVEC_ANGLES; i++) {
        const double angle = work[2 * COUNT + i];
        const double shifted = angle * 0.6366197723675814 + 6755399441055744.0;
        const double turns = shifted - 6755399441055744.0;
        uint64_t bits, sine, cosine;
        /* Quarter turns taken away: the rest is rest + tail. */
        const double first = angle - turns * 1.5707963267341256;
        const double second = turns * 6.077100506303966e-11;
        const double third = first - second;
        const double more = turns * 2.0222662487959506e-21 - ((first - third) - second);
        const double rest = third - more;
        const double tail = (third - rest) - more;
        const double square = rest * rest;
        const double half = 0.5 * square;
        const double one = 1.0 - half;
        const double odd = square * (-0.16666666666666632 + square * (0.008333333333322422 + square * (-0.00019841269829815465
            + square * (2.755731369472794e-06 + square * (-2.5050758576480244e-08 + square * 1.589682350501512e-10)))));
        const double even = square * square * (0.0416666666666666 + square * (-0.0013888888888874138 + square * (2.4801587289490797e-05
            + square * (-2.755731435493541e-07 + square * (2.0875723641529234e-09 + square * -1.1359667580936628e-11)))));
        const double s = rest + (rest * odd + tail * one);
        const double c = one + (((1.0 - one) - half) + (even - rest * tail));
        memcpy(&bits, &shifted, sizeof bits);
        memcpy(&sine, &s, sizeof sine);
        memcpy(&cosine, &c, sizeof cosine);
        const uint64_t swap = (sine ^ cosine) & (0 - (bits & 1));
        const uint64_t up = (sine ^ swap) ^ ((bits & 2) << 62);
        const uint64_t across = (cosine ^ swap) ^ (((bits + 1) & 2) << 62);
        double up_number, across_number;
        memcpy(&up_number, &up, sizeof up);
        memcpy(&across_number, &across, sizeof across);
        work[i] = (REAL)up_number;
        work[COUNT + i] = (REAL)across_number;
        large |= !(fabs(angle) < 524288.0);
    }
    if (large) {
        for (int i = 0; i < ROBOVEC_ANGLES; i++) {
            const double angle = work[2 * COUNT + i];
            if (!(fabs(angle) < 524288.0)) {
                work[i] = (REAL)sin(angle);
                work[COUNT + i] = (REAL)cos(angle);
            }
        }
    }
}
#endif
";
