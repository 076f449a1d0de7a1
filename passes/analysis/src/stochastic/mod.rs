//! Stochastic rounding: the error of every output from a handful of runs
//! whose operations round up or down by chance.
//!
//! Every run has other rounding errors of the same sizes, so the spread of an
//! output over the runs estimates the error of rounding to nearest, without the
//! exact value (Parker, *Monte Carlo Arithmetic*, 1997; Vignes' CESTAC method
//! takes three runs). It costs [`SAMPLES`] evaluations for all outputs
//! together, where adjoints cost a sweep for every few of them, and it takes
//! into account cancellations and correlations, which a bound adds up in size.
//! It is no bound: it limits the error with a certain probability.
//!
//! Interpretation of sigma: an operation with stochastic rounding has an error
//! of variance ulp²/6 on average, one that rounds to nearest ulp²/12, so the
//! standard deviation of the samples is about √2 times that of the errors to be
//! judged, and 3 sigma is about 4.2 of theirs. It is kept as a margin, for
//! errors of the outputs of one function are correlated: one bad estimate comes
//! with hundreds. The deviation of [`SAMPLES`] runs is itself uncertain by 18 %
//! (with three runs by 52 %); it is multiplied by 1.2, because Student's
//! distribution with 15 degrees of freedom has as much beyond 3.59 deviations
//! as the normal one beyond three. Where all runs agree because the last
//! operation's result is nearly representable, the last rounding is still
//! unknown; so sigma is never less than the standard deviation of one rounding
//! to nearest of the output, ulp/√12.
//!
//! Random bits are a function of the seed, the sample and the place in the
//! function: the same call gives the same bits everywhere, up to the sine and
//! cosine of the platform.

mod rounder;
#[cfg(test)]
mod tests;

pub use rounder::MAX_BITS;

use super::adjoint::{Tape, half_ulp};
use robovec_ir::Format;
use robovec_num::arithmetic::{Arithmetic, Binary64};
use robovec_num::batch::Batch;
use robovec_num::random::bits_at;
use rounder::Rounder;

/// Runs that roundings are sampled in.
pub const SAMPLES: usize = 16;

/// The factor that makes three deviations of [`SAMPLES`] runs as wide as three
/// of infinitely many: 3.59 / 3, by Student's distribution.
const SMALL_SAMPLE: f64 = 1.196;

/// Samples computed at a time: one cache line of binary64 numbers.
const LANES: usize = 8;

/// The format holds too many bits for its roundings to be sampled in
/// binary64.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("roundings to {format} cannot be sampled: it has more than {MAX_BITS} bits of mantissa")]
pub struct Unsupported {
    /// The format.
    pub format: Format,
}

/// The statistics of the samples of one output.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sampled {
    /// The mean of the samples, an estimate of the exact value.
    pub mean: f64,
    /// The standard deviation that an error is judged by; NaN when a sample
    /// was not finite.
    pub sigma: f64,
}

/// Tests whether roundings to a format can be sampled.
///
/// # Errors
///
/// Fails when the format has more than [`MAX_BITS`] bits.
pub fn supports(format: Format) -> Result<(), Unsupported> {
    Rounder::new(format).map(|_| ())
}

/// Samples the roundings of a function at one state and gives the statistics of
/// slots of the tape.
///
/// # Errors
///
/// Fails when the format has more than [`MAX_BITS`] bits.
///
/// # Panics
///
/// Panics when there is not one number per input element.
pub fn stochastic(
    tape: &Tape,
    format: Format,
    inputs: &[f64],
    seed: u64,
    slots: &[usize],
) -> Result<Vec<Sampled>, Unsupported> {
    let rounder = Rounder::new(format)?;
    let mut samples = vec![[0.0; SAMPLES]; slots.len()];
    let mut values = vec![[0.0; LANES]; tape.slots()];
    for first in (0..SAMPLES).step_by(LANES) {
        let seed = bits_at(seed ^ bits_at(first as u64));
        sample(tape, &rounder, inputs, seed, &mut values);
        for (samples, &slot) in samples.iter_mut().zip(slots) {
            samples[first..][..LANES].copy_from_slice(&values[slot]);
        }
    }
    Ok(samples
        .iter()
        .map(|samples| judge(format, samples))
        .collect())
}

/// One run of [`LANES`] samples.
fn sample(tape: &Tape, rounder: &Rounder, inputs: &[f64], seed: u64, values: &mut [[f64; LANES]]) {
    assert_eq!(inputs.len(), tape.inputs(), "one number per input element");
    let leaves = inputs.iter().chain(tape.constants());
    for ((slot, values), &number) in (tape.nodes()..)
        .zip(&mut values[tape.nodes()..])
        .zip(leaves)
    {
        *values = rounder.round([number; LANES], random(seed, slot));
    }
    for node in 0..tape.nodes() {
        // The rounding errors of binary64 itself are below the last place of
        // the format by twelve bits at least.
        let operands = tape.operands(node).map(|slot| &values[slot]);
        let exact = Batch([Binary64; LANES]).apply_read(tape.operation(node), operands);
        // What is representable stays: copies need no rounding of their own.
        values[node] = rounder.round(exact, random(seed, node));
    }
}

/// Random bits for a place.
#[inline]
fn random(seed: u64, slot: usize) -> [u32; LANES] {
    let mut bits = [0; LANES];
    let place = seed.wrapping_add((slot as u64).wrapping_mul(LANES as u64 / 2));
    for (pair, two) in bits.chunks_exact_mut(2).enumerate() {
        let random = bits_at(place.wrapping_add(pair as u64));
        two[0] = random as u32;
        two[1] = (random >> 32) as u32;
    }
    bits
}

/// Mean and sigma of the samples of an output.
fn judge(format: Format, samples: &[f64; SAMPLES]) -> Sampled {
    let count = SAMPLES as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let squares = samples
        .iter()
        .map(|sample| (sample - mean) * (sample - mean));
    let deviation = (squares.sum::<f64>() / (count - 1.0)).sqrt();
    let deviation = SMALL_SAMPLE * deviation;
    let last = half_ulp(format, mean) / 3f64.sqrt();
    Sampled {
        mean,
        sigma: if deviation.is_nan() {
            f64::NAN
        } else {
            deviation.max(last)
        },
    }
}
