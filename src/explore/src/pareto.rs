//! Points that no other point beats.
//!
//! A point *dominates* another that is in no measure smaller and in some
//! larger; small is good. A measure that is not a number compares with
//! nothing: such a point neither dominates nor is dominated.

/// True when the first point is nowhere worse and somewhere better.
pub fn dominates<const N: usize>(first: &[f64; N], second: &[f64; N]) -> bool {
    covers(first, second) && first.iter().zip(second).any(|(a, b)| a < b)
}

/// True when the first point is nowhere worse.
fn covers<const N: usize>(first: &[f64; N], second: &[f64; N]) -> bool {
    first.iter().zip(second).all(|(a, b)| a <= b)
}

/// Choice of the points that are kept among equal ones.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EqualPoints {
    /// All points.
    All,
    /// The first.
    First,
}

/// Places of the points that no other dominates, by measures in their order.
///
/// A point is compared with the kept ones alone: in this order no later point
/// dominates it, and a dropped point that dominated it was itself dominated by
/// a kept one. The work is n log n, at most n times the points kept.
pub fn front<const N: usize>(points: &[[f64; N]], ties: EqualPoints) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        // Both zeros are one number.
        let pairs = points[a].iter().zip(&points[b]);
        let mut orders = pairs.map(|(a, b)| (a + 0.0).total_cmp(&(b + 0.0)));
        orders.find(|order| order.is_ne()).unwrap_or(a.cmp(&b))
    });
    let mut kept: Vec<usize> = Vec::new();
    for index in order {
        let beaten = |&known: &usize| match ties {
            EqualPoints::All => dominates(&points[known], &points[index]),
            EqualPoints::First => covers(&points[known], &points[index]),
        };
        // The last one kept is the likeliest to beat its neighbour.
        if !kept.iter().rev().any(beaten) {
            kept.push(index);
        }
    }
    kept
}

/// Items that no other beats in two criteria, by the first; of equal ones one.
pub fn steps<T: Copy>(items: impl IntoIterator<Item = (T, [f64; 2])>) -> Vec<T> {
    let is_finite = |criteria: &[f64; 2]| criteria.iter().all(|number| number.is_finite());
    let items = items
        .into_iter()
        .filter(|(_, criteria)| is_finite(criteria));
    let (items, criteria): (Vec<T>, Vec<[f64; 2]>) = items.unzip();
    let kept = front(&criteria, EqualPoints::First).into_iter();
    kept.map(|place| items[place]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_comparing_all_pairs_leaves() {
        let value = |seed: usize| (seed * 7919 % 13) as f64;
        let points: Vec<[f64; 3]> = (0..200)
            .map(|index| [value(index), value(index * index + 3), value(index / 3 + 5)])
            .collect();
        let mut expected: Vec<usize> = (0..points.len())
            .filter(|&index| !points.iter().any(|other| dominates(other, &points[index])))
            .collect();
        let mut found = front(&points, EqualPoints::All);
        assert!(found.is_sorted_by(|&a, &b| points[a] <= points[b]));
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn steps_are_finite_and_ordered() {
        let items = [('a', [2.0, 1.0]), ('b', [1.0, 3.0]), ('c', [1.5, 4.0])];
        let endless = [('d', [0.0, f64::INFINITY]), ('e', [f64::NAN, 0.0])];
        assert_eq!(steps(items.into_iter().chain(endless)), ['b', 'a']);
    }

    #[test]
    fn equal_points_are_kept_as_asked_and_zeros_are_equal() {
        let points = [[1.0, 2.0], [1.0, 2.0], [2.0, 1.0], [2.0, 2.0]];
        assert_eq!(front(&points, EqualPoints::All), [0, 1, 2]);
        assert_eq!(front(&points, EqualPoints::First), [0, 2]);
        assert_eq!(front(&[[-0.0, 5.0], [0.0, 4.0]], EqualPoints::All), [1]);
        assert_eq!(
            front(&[[f64::NAN, 0.0], [1.0, 1.0]], EqualPoints::All),
            [1, 0]
        );
    }
}
