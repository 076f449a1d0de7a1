//! Agreement of the sides of a rule at points of prime fields.
//!
//! Without roots sixteen points decide (Schwartz and Zippel), eight of each
//! prime. A root of a square is one of two, and in the field the choice is
//! random: each distribution of the squares and others over `k` different roots
//! occurs at one point in `2^k`, so `64 * 2^k` points are taken, and the sides
//! must agree at all of them, whatever the signs. When that fails, signs that
//! are known for all real numbers are required of the points as well.

use super::field::RuleResidue;
use super::joined::Joined;
use robovec_ir::Operation;

/// The verdict of points of the fields.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Agreement {
    /// The sides agree at this number of points.
    Equal(u32),
    /// They differ somewhere.
    Different,
    /// They are hardly ever both defined.
    Never,
}

/// Points at which both sides must agree, in both fields together.
const POINTS: u32 = 16;
/// Points per way of distributing signs.
const POINTS_PER_SIGN: u32 = 64;
/// More different roots than in any rule that makes sense.
const MAX_ROOTS: usize = 6;
/// Points tried at most, for those that are defined.
pub(super) const MAX_TRIED: u64 = 1 << 15;

/// The points that a rule with roots needs, when these are the values of its
/// nodes somewhere; `None` for a rule without roots, or with too many.
pub(super) fn points_for(joined: &Joined<'_>, values: &[RuleResidue]) -> Option<u32> {
    let operands = joined.operands(Operation::Sqrt, 0..values.len());
    let mut roots: Vec<u64> = operands.map(|[operand, _]| values[operand].value).collect();
    roots.sort_unstable();
    roots.dedup();
    let counts = 1..=MAX_ROOTS;
    counts
        .contains(&roots.len())
        .then(|| POINTS_PER_SIGN << roots.len())
}

/// Compares the sides, on the circle or with sines and cosines independent of
/// each other, at points where nodes have given signs (1 or −1).
pub(super) fn agree(joined: &Joined<'_>, circle: bool, signs: &[(usize, i32)]) -> Agreement {
    let [left, right] = joined.roots();
    let all = 0..joined.pattern.nodes.len();
    let with_roots = joined.uses(Operation::Sqrt, all);
    let (mut needed, mut seen) = (POINTS, [0; 2]);
    let mut limit = 64 * u64::from(POINTS);
    if with_roots {
        limit = MAX_TRIED;
    }
    for point in 0..limit {
        let field = joined.field(point).on_circle(circle);
        let values = joined.values(&field);
        if values[left].is_undefined() || values[right].is_undefined() {
            continue;
        }
        let has_sign = |&(node, sign): &(usize, i32)| {
            let found = field.sign(values[node]);
            found == sign || found == 0
        };
        if !signs.iter().all(has_sign) {
            continue;
        }
        if values[left].value != values[right].value {
            return Agreement::Different;
        }
        if with_roots && seen == [0; 2] {
            match points_for(joined, &values) {
                Some(points) => needed = points,
                None => return Agreement::Never,
            }
        }
        // Each field has to say so by itself.
        seen[(point % 2) as usize] += 1;
        if seen.iter().all(|&seen| seen >= needed / 2) {
            return Agreement::Equal(needed);
        }
    }
    Agreement::Never
}
