//! A share of the work of an exploration, for several workers on one folder.

use std::str::FromStr;

/// A share of the work: the `k`-th of `n`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WorkShare {
    k: usize,
    n: usize,
}

impl WorkShare {
    /// All of the work.
    pub const ALL: WorkShare = WorkShare { k: 1, n: 1 };

    /// Whether the share holds a piece of work, by its number from 0.
    pub fn holds(self, number: usize) -> bool {
        number % self.n == self.k - 1
    }
}

impl FromStr for WorkShare {
    type Err = String;

    fn from_str(text: &str) -> Result<WorkShare, String> {
        let wrong = || "a share is K/N with K from 1 to N, as 2/8".to_owned();
        let (k, n) = text.split_once('/').ok_or_else(wrong)?;
        let read = |text: &str| text.parse::<usize>().map_err(|_| wrong());
        let (k, n) = (read(k)?, read(n)?);
        match (1..=n).contains(&k) {
            true => Ok(WorkShare { k, n }),
            false => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_work_is_in_one_share() {
        let shares: Vec<WorkShare> = (1..=3)
            .map(|k| format!("{k}/3").parse().expect("a share"))
            .collect();
        for number in 0..10 {
            let holders = shares.iter().filter(|share| share.holds(number));
            assert_eq!(holders.count(), 1, "{number}");
            assert!(WorkShare::ALL.holds(number));
        }
        for wrong in ["0/3", "4/3", "1", "1/0", "-1/2", "a/b"] {
            assert!(wrong.parse::<WorkShare>().is_err(), "{wrong}");
        }
    }
}
