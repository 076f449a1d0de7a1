//! The time a group takes.
//!
//! Combining the two earliest operands first is optimal for one associative
//! operation of constant weight (Golumbic 1976, Parker 1979): Huffman's
//! algorithm on arrival times, with `max + weight` in place of the sum.

/// When the last operation of a group is done if the two earliest operands
/// are combined first; `arrivals` must be sorted and is used up.
pub(crate) fn finish(arrivals: &mut [u32], weight: u32) -> u32 {
    debug_assert!(arrivals.is_sorted(), "arrivals are sorted");
    let mut first = 0;
    while first + 1 < arrivals.len() {
        let combined = arrivals[first + 1] + weight;
        first += 1;
        // Move the combined operand up to its place among the later ones.
        let mut at = first;
        while at + 1 < arrivals.len() && arrivals[at + 1] < combined {
            arrivals[at] = arrivals[at + 1];
            at += 1;
        }
        arrivals[at] = combined;
    }
    arrivals.get(first).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best finish over all trees, by trying every first pair.
    fn best(arrivals: &[u32], weight: u32) -> u32 {
        if arrivals.len() <= 1 {
            return arrivals.first().copied().unwrap_or(0);
        }
        let mut best = u32::MAX;
        for i in 0..arrivals.len() {
            for j in i + 1..arrivals.len() {
                let mut rest: Vec<u32> = (0..arrivals.len())
                    .filter(|&k| k != i && k != j)
                    .map(|k| arrivals[k])
                    .collect();
                rest.push(arrivals[i].max(arrivals[j]) + weight);
                best = best.min(self::best(&rest, weight));
            }
        }
        best
    }

    #[test]
    fn earliest_first_is_optimal() {
        let mut state = 1u32;
        for round in 0..60 {
            let mut arrivals: Vec<u32> = (0..2 + round % 5)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 16) % 60
                })
                .collect();
            arrivals.sort_unstable();
            let expected = best(&arrivals, 12);
            assert_eq!(finish(&mut arrivals, 12), expected);
        }
        assert_eq!(finish(&mut [], 12), 0);
        assert_eq!(finish(&mut [5], 12), 5);
    }
}
