//! Exact equality at random points of the prime field.

use super::pairing::Pairs;
use robovec_ir::Output;
use robovec_ir::batch::Batch;
use robovec_ir::evaluate::evaluate;
use robovec_ir::field::PrimeField;
use std::array;

/// How the comparison ended.
pub(super) enum Comparison {
    /// Equal at every point; these pairs (indices into [`Pairs::list`]) were
    /// undefined everywhere before the pass.
    Equal { undefined: Vec<usize> },
    /// An output differs.
    Different {
        output: Output,
        field: PrimeField,
        before: u64,
        after: u64,
    },
}

/// Points drawn beyond those asked for when some are undefined. Random
/// denominators vanish with probability 2⁻⁶¹, so one that vanishes this often
/// always does.
const EXTRA_POINTS: u32 = 4;

/// Points evaluated at a time.
const LANES: usize = 4;

/// Compares all outputs until each was defined on both sides at `points`
/// points, or always undefined. Points come in fours: the last four are used
/// up.
pub(super) fn compare(pairs: &Pairs<'_>, circle: bool, points: u32, seed: u64) -> Comparison {
    let mut tallies = vec![Tally::default(); pairs.list.len()];
    let mut point = 0;
    while point < points.saturating_add(EXTRA_POINTS)
        && (point == 0 || tallies.iter().any(|tally| tally.both < points))
    {
        let fields: [PrimeField; LANES] = array::from_fn(|lane| PrimeField {
            seed: super::nth_seed(seed, point + lane as u32),
            circle,
        });
        let points = fields.map(|field| pairs.point(&field));
        let versions = [(pairs.before, 0), (pairs.after, 1)];
        let [before, after] = versions.map(|(view, version)| {
            let inputs: [Vec<u64>; LANES] = array::from_fn(|lane| points[lane][version].clone());
            evaluate(
                view.function,
                &Batch(fields),
                &Batch::<PrimeField, LANES>::gather(&inputs),
            )
        });
        for (pair, tally) in pairs.list.iter().zip(&mut tallies) {
            let lanes = before[pair.before].into_iter().zip(after[pair.after]);
            for ((before, after), field) in lanes.zip(fields) {
                if tally.add(before, after) && before != after {
                    return Comparison::Different {
                        output: pair.output,
                        field,
                        before,
                        after,
                    };
                }
            }
        }
        point += LANES as u32;
    }
    judge_undefined(pairs, &tallies, circle, seed)
}

/// How often an output was defined.
#[derive(Clone, Copy, Default)]
struct Tally {
    before: u32,
    after: u32,
    both: u32,
}

impl Tally {
    /// Counts a point; true when it can be compared.
    fn add(&mut self, before: u64, after: u64) -> bool {
        let defined = [before, after].map(|number| !PrimeField::is_undefined(number));
        self.before += u32::from(defined[0]);
        self.after += u32::from(defined[1]);
        let both = defined[0] && defined[1];
        self.both += u32::from(both);
        both
    }
}

/// An output that could never be compared was undefined to begin with (then
/// anything may follow), or has become so, which is a difference.
fn judge_undefined(pairs: &Pairs<'_>, tallies: &[Tally], circle: bool, seed: u64) -> Comparison {
    let mut undefined = Vec::new();
    for (index, (pair, tally)) in pairs.list.iter().zip(tallies).enumerate() {
        if tally.both > 0 {
            continue;
        }
        if tally.before == 0 {
            undefined.push(index);
            continue;
        }
        let field = PrimeField {
            seed: super::nth_seed(seed, 0),
            circle,
        };
        let [before, after] = pairs.point(&field);
        return Comparison::Different {
            output: pair.output,
            field,
            before: evaluate(pairs.before.function, &field, &before)[pair.before],
            after: evaluate(pairs.after.function, &field, &after)[pair.after],
        };
    }
    Comparison::Equal { undefined }
}
