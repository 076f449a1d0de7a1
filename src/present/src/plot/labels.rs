//! Labels at the ends of curves, moved apart where they would overlap.

/// The smallest distance of two labels, in pixels.
const SPACING: f64 = 12.5;

/// New heights for labels near the given ones, at least [`SPACING`] apart and
/// inside a range as far as they fit, in the order of the input.
///
/// Labels that overlap form a block around the mean of their preferred
/// positions; overlapping blocks are merged.
pub(super) fn spread(wanted: &[f64], from: f64, to: f64) -> Vec<f64> {
    debug_assert!(from <= to, "labels have room");
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]).then(a.cmp(&b)));
    // Blocks of labels: number, and sum of the places their first ones want.
    let mut blocks: Vec<(usize, f64)> = Vec::new();
    let top = |block: &(usize, f64)| {
        let height = (block.0 - 1) as f64 * SPACING;
        (block.1 / block.0 as f64).min(to - height).max(from)
    };
    for &index in &order {
        let mut block = (1, wanted[index]);
        while let Some(before) = blocks.last() {
            let end = top(before) + before.0 as f64 * SPACING;
            if end <= top(&block) {
                break;
            }
            let shift = (block.0 * before.0) as f64 * SPACING;
            block = (before.0 + block.0, before.1 + block.1 - shift);
            blocks.pop();
        }
        blocks.push(block);
    }
    let mut heights = vec![0.0; wanted.len()];
    let mut next = order.iter();
    for block in &blocks {
        for (place, &index) in next.by_ref().take(block.0).enumerate() {
            heights[index] = top(block) + place as f64 * SPACING;
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_room_stay_and_others_move_apart() {
        assert_eq!(spread(&[100.0, 20.0], 0.0, 200.0), [100.0, 20.0]);
        assert_eq!(spread(&[50.0, 50.0], 0.0, 200.0), [43.75, 56.25]);
        assert_eq!(spread(&[], 0.0, 1.0), Vec::<f64>::new());
    }

    #[test]
    fn crowds_stay_apart_and_inside() {
        let heights = spread(&[199.0; 8], 0.0, 200.0);
        let gaps = heights.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(gaps.into_iter().all(|gap| gap >= SPACING - 1e-9));
        assert!(
            heights
                .iter()
                .all(|&height| (0.0..=200.0).contains(&height))
        );
    }
}
