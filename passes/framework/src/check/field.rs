//! Exact equality at random points of two prime fields.

use super::pairing::Pairs;
use robovec_ir::evaluate::evaluate;
use robovec_num::batch::Batch;
use robovec_num::field::{Field, FieldPoint, Prime};
use std::array;

/// The end of the comparison.
pub(super) enum FieldComparison<F> {
    /// Equal at every point; these pairs (indices into [`Pairs::list`]) were
    /// undefined everywhere before the pass.
    Equal { undefined: Vec<usize> },
    /// An output differs.
    Different {
        /// Index into [`Pairs::list`].
        pair: usize,
        /// Field of the residue.
        field: F,
    },
}

/// Points drawn beyond those requested when some are undefined. Random
/// denominators vanish with probability 2⁻⁶⁰, so one that vanishes at all these
/// points always does.
const EXTRA_POINTS: u32 = 4;

/// Fields evaluated at a time: two points in both fields.
const LANES: usize = 4;

/// The field of a lane of a batch of points.
fn lane_field<F: Field>(primes: [Prime; 2], seed: u64, first: u32, lane: usize) -> F {
    let point = first + (lane / 2) as u32;
    let seed = super::nth_seed(seed, point);
    F::at(primes[lane % 2], FieldPoint { seed })
}

/// Compares all outputs until each was defined on both sides at `points`
/// points of both fields, or always undefined. Points come in twos: the last
/// two are used up.
pub(super) fn compare<F: Field>(pairs: &Pairs<'_>, points: u32, seed: u64) -> FieldComparison<F> {
    let primes = pairs.primes(seed);
    let wanted = points.saturating_mul(2);
    let mut tallies = vec![DefinitionTally::default(); pairs.list.len()];
    let mut point = 0;
    while point < points.saturating_add(EXTRA_POINTS)
        && (point == 0 || tallies.iter().any(|tally| tally.both < wanted))
    {
        let fields: [F; LANES] = array::from_fn(|lane| lane_field(primes, seed, point, lane));
        let inputs = fields.each_ref().map(|field| pairs.point(field));
        let fields = Batch(fields);
        let [before, after] = [(pairs.before, 0), (pairs.after, 1)].map(|(view, version)| {
            let inputs: [Vec<F::Number>; LANES] =
                array::from_fn(|lane| inputs[lane][version].clone());
            evaluate(view.function, &fields, &Batch::<F, LANES>::gather(&inputs))
        });
        for (index, (pair, tally)) in pairs.list.iter().zip(&mut tallies).enumerate() {
            let lanes = before[pair.before].into_iter().zip(after[pair.after]);
            for (lane, (before, after)) in lanes.enumerate() {
                if tally.add::<F>(before, after) && before != after {
                    return FieldComparison::Different {
                        pair: index,
                        field: lane_field(primes, seed, point, lane),
                    };
                }
            }
        }
        point += (LANES / 2) as u32;
    }
    judge_undefined(pairs, &tallies, lane_field(primes, seed, 0, 0))
}

/// The number of points at which an output was defined.
#[derive(Clone, Copy, Default)]
struct DefinitionTally {
    before: u32,
    after: u32,
    both: u32,
}

impl DefinitionTally {
    /// Counts a point; true when it can be compared.
    fn add<F: Field>(&mut self, before: F::Number, after: F::Number) -> bool {
        let defined = [before, after].map(|number| !F::is_undefined(number));
        self.before += u32::from(defined[0]);
        self.after += u32::from(defined[1]);
        let both = defined[0] && defined[1];
        self.both += u32::from(both);
        both
    }
}

/// An output that could never be compared was undefined to begin with (then
/// anything may follow), or has become so, which is a difference.
fn judge_undefined<F: Field>(
    pairs: &Pairs<'_>,
    tallies: &[DefinitionTally],
    field: F,
) -> FieldComparison<F> {
    let mut undefined = Vec::new();
    for (index, (_, tally)) in pairs.list.iter().zip(tallies).enumerate() {
        if tally.both > 0 {
            continue;
        }
        if tally.before > 0 {
            return FieldComparison::Different { pair: index, field };
        }
        undefined.push(index);
    }
    FieldComparison::Equal { undefined }
}

/// The residues of an output in a field, before and after; `None` where it is
/// undefined.
pub(super) fn residues<F: Field>(pairs: &Pairs<'_>, pair: usize, field: &F) -> [Option<u64>; 2] {
    let [before, after] = pairs.point(field);
    let pair = &pairs.list[pair];
    let residue = |number: F::Number| field.residue(F::value(number));
    [
        residue(evaluate(pairs.before.function, field, &before)[pair.before]),
        residue(evaluate(pairs.after.function, field, &after)[pair.after]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::field::PrimeField;

    #[test]
    fn neighbouring_lanes_compute_in_both_fields_at_one_point() {
        let primes = Prime::pair(7);
        let prime = |lane| lane_field::<PrimeField>(primes, 1, 0, lane).prime();
        assert_eq!([prime(0), prime(1)], primes);
        assert_eq!([prime(2), prime(3)], primes);
    }
}
