//! Affine functions through points.
//!
//! An address that a statement reads or writes is known for every pass of its
//! loop. Most often it is affine in the iterations of the loops around; where
//! a few passes differ, at the ends of a chain, the function that most of them
//! agree on shows where their values should be put.

/// `base + factors . iterations`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct AffineFit {
    pub(super) base: i64,
    /// For each loop, the outermost first.
    pub(super) factors: Vec<i64>,
}

impl AffineFit {
    /// The value at a pass.
    pub(super) fn at(&self, iterations: &[u32]) -> i64 {
        assert_eq!(
            iterations.len(),
            self.factors.len(),
            "one iteration per loop around"
        );
        let terms = self.factors.iter().zip(iterations);
        self.base
            + terms
                .map(|(factor, &index)| factor * i64::from(index))
                .sum::<i64>()
    }
}

/// The element of more than half of all, if there is one.
struct Vote {
    candidate: i64,
    lead: u32,
}

impl Vote {
    fn new() -> Vote {
        Vote {
            candidate: 0,
            lead: 0,
        }
    }

    fn cast(&mut self, ballot: i64) {
        if self.lead == 0 {
            self.candidate = ballot;
        }
        if self.candidate == ballot {
            self.lead += 1;
        } else {
            self.lead -= 1;
        }
    }
}

/// The affine function that most known values lie on; `iterations` has `depth`
/// entries for each value. If the values are those of an affine function, the
/// function is found.
pub(super) fn fit(depth: usize, iterations: &[u32], values: &[Option<i64>]) -> AffineFit {
    assert_eq!(
        iterations.len(),
        depth * values.len(),
        "every value has an iteration of each loop"
    );
    let row = |pass: usize| &iterations[pass * depth..(pass + 1) * depth];
    let mut factors = vec![0i64; depth];
    for level in (0..depth).rev() {
        let mut vote = Vote::new();
        let mut last: Option<(usize, i64)> = None;
        for (pass, value) in values.iter().enumerate() {
            let Some(value) = *value else { continue };
            let here = row(pass);
            let inner = factors[level + 1..].iter().zip(&here[level + 1..]);
            let rest = value
                - inner
                    .map(|(factor, &index)| factor * i64::from(index))
                    .sum::<i64>();
            if let Some((before, other)) = last.replace((pass, rest)) {
                let there = row(before);
                let step = i64::from(here[level]) - i64::from(there[level]);
                if step > 0 && here[..level] == there[..level] && (rest - other) % step == 0 {
                    vote.cast((rest - other) / step);
                }
            }
        }
        factors[level] = vote.candidate;
    }
    let mut fit = AffineFit { base: 0, factors };
    let mut vote = Vote::new();
    for (pass, value) in values.iter().enumerate() {
        if let Some(value) = value {
            vote.cast(value - fit.at(row(pass)));
        }
    }
    fit.base = vote.candidate;
    fit
}

/// The affine function through all values, if there is one.
pub(super) fn exact(depth: usize, iterations: &[u32], values: &[i64]) -> Option<AffineFit> {
    let known: Vec<Option<i64>> = values.iter().map(|&value| Some(value)).collect();
    let fit = fit(depth, iterations, &known);
    let agrees = |(pass, &value): (usize, &i64)| {
        fit.at(&iterations[pass * depth..(pass + 1) * depth]) == value
    };
    values.iter().enumerate().all(agrees).then_some(fit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn affine_functions_of_two_loops_are_found_in_spite_of_an_outlier() {
        let mut iterations = Vec::new();
        let mut values = Vec::new();
        for outer in 0..6u32 {
            for inner in 0..outer + 3 {
                iterations.extend([outer, inner]);
                values.push(i64::from(outer) * 7 - i64::from(inner) * 2 + 40);
            }
        }
        let expected = AffineFit {
            base: 40,
            factors: vec![7, -2],
        };
        assert_eq!(exact(2, &iterations, &values).as_ref(), Some(&expected));
        let mut known: Vec<Option<i64>> = values.iter().map(|&value| Some(value)).collect();
        known[5] = None;
        known[9] = Some(3);
        assert_eq!(fit(2, &iterations, &known), expected);
        values[4] += 1;
        assert_eq!(exact(2, &iterations, &values), None);
    }
}
