//! Combinations of the values of axes.

/// The lengths of the lists that are combined; the last one varies fastest.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Axes<const N: usize>(pub [usize; N]);

impl<const N: usize> Axes<N> {
    /// Number of combinations, without making them.
    pub fn count(&self) -> u64 {
        let lengths = self.0.iter().map(|&length| length as u64);
        lengths.fold(1, u64::saturating_mul)
    }

    /// All combinations, each as places in the lists, in order.
    pub fn combinations(self) -> impl Iterator<Item = [usize; N]> {
        (0..self.count()).map(move |number| {
            let mut rest = number;
            let mut places = [0; N];
            for (place, &length) in places.iter_mut().zip(&self.0).rev() {
                *place = (rest % length as u64) as usize;
                rest /= length as u64;
            }
            places
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_list_varies_fastest() {
        let all: Vec<[usize; 2]> = Axes([2, 3]).combinations().collect();
        assert_eq!(all, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
        assert_eq!(Axes([2, 0, 3]).combinations().count(), 0);
        assert_eq!(Axes([usize::MAX, 2]).count(), u64::MAX);
    }
}
