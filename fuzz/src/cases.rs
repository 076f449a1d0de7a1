//! Cases for the tests of the bodies: the same on every machine, however busy
//! it is; more of them, at random, for as long as `ARBTEST_BUDGET_MS` states.

use arbitrary::{Result, Unstructured};

/// Tries a property with this number of cases, each of this number of bytes.
pub(crate) fn of_one_size(
    count: u64,
    size: u64,
    property: impl FnMut(&mut Unstructured<'_>) -> Result<()>,
) {
    of_seeds((0..count).map(|case| case << 32 | size), property);
}

/// As [`of_one_size`], the same cases on all cores, for a property that would
/// run alone when all other tests have ended.
pub(crate) fn on_all_cores(
    count: u64,
    size: u64,
    property: impl Fn(&mut Unstructured<'_>) -> Result<()> + Sync,
) {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64);
    std::thread::scope(|scope| {
        for core in 0..cores {
            let property = &property;
            scope.spawn(move || {
                let own = (core..count).step_by(cores as usize);
                of_seeds(own.map(|case| case << 32 | size), property);
            });
        }
    });
}

/// Tries a property with this number of cases of up to this number of bytes,
/// and at least half of it.
pub(crate) fn of_sizes(
    count: u64,
    size: u64,
    property: impl FnMut(&mut Unstructured<'_>) -> Result<()>,
) {
    let seeds = (0..count).map(|case| {
        let bits = (case + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) << 32;
        bits | (size - case % 16 * size / 32)
    });
    of_seeds(seeds, property);
}

/// The lower half of a seed is the number of bytes it represents.
fn of_seeds(
    seeds: impl Iterator<Item = u64>,
    mut property: impl FnMut(&mut Unstructured<'_>) -> Result<()>,
) {
    for seed in seeds {
        arbtest::arbtest(&mut property).seed(seed);
    }
    if std::env::var_os("ARBTEST_BUDGET_MS").is_some() {
        arbtest::arbtest(&mut property);
    }
}

/// Damages sound text at up to this number of places, where pieces of up to
/// this number of bytes are repeated.
pub(crate) fn damage(
    bytes: &mut Unstructured<'_>,
    text: &mut Vec<u8>,
    places: u32,
    longest: usize,
) -> Result<()> {
    for _ in 0..bytes.int_in_range(1..=places)? {
        let place = bytes.choose_index(text.len())?;
        match bytes.int_in_range(0..=3)? {
            0 => text.truncate(place.max(1)),
            1 => text[place] = bytes.arbitrary()?,
            2 => {
                text.remove(place);
            }
            _ => {
                let end = (place + longest).min(text.len());
                let piece = text[place..end].to_vec();
                let at = bytes.choose_index(text.len())?;
                text.splice(at..at, piece);
            }
        }
        if text.is_empty() {
            break;
        }
    }
    Ok(())
}
