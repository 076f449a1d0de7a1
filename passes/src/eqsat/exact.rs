//! The fewest operations by trying everything, as far as steps reach.
//!
//! Small e-graphs are searched to the end, so that the extracted form is the
//! optimum; larger ones keep the form found before the search.

use super::alternatives::{Alternatives, RequiredResult, SurroundingTimes};

/// A search among all covers that keep the required times.
pub(crate) struct ExactExtractor<'a> {
    alternatives: &'a Alternatives,
    times: SurroundingTimes<'a>,
    demands: &'a [RequiredResult],
    choice: Vec<Option<u32>>,
    best: u32,
    best_choice: Option<Vec<u32>>,
    steps: u32,
}

impl<'a> ExactExtractor<'a> {
    /// A choice with fewer operations than the best known and every demand met
    /// in time, the best if the search was complete; and a flag: true for a
    /// complete search.
    pub(crate) fn search(
        alternatives: &'a Alternatives,
        times: SurroundingTimes<'a>,
        demands: &'a [RequiredResult],
        known: u32,
        steps: u32,
    ) -> (Option<Vec<u32>>, bool) {
        let mut search = ExactExtractor {
            alternatives,
            times,
            demands,
            choice: vec![None; alternatives.classes.len()],
            best: known,
            best_choice: None,
            steps,
        };
        let open: Vec<u32> = demands.iter().map(|demand| demand.class).collect();
        search.branch(&open, 0);
        (search.best_choice, search.steps > 0)
    }

    /// Chooses a form for the last open class, and continues. Depth is bounded
    /// by the number of classes.
    fn branch(&mut self, open: &[u32], operations: u32) {
        if self.steps == 0 || operations >= self.best {
            return;
        }
        self.steps -= 1;
        let Some((&class, rest)) = open.split_last() else {
            if self.in_time() {
                self.best = operations;
                let chosen = self.choice.iter().map(|index| index.unwrap_or(0));
                self.best_choice = Some(chosen.collect());
            }
            return;
        };
        if self.choice[class as usize].is_some() {
            return self.branch(rest, operations);
        }
        let alternatives = self.alternatives;
        for (index, form) in alternatives.classes[class as usize].iter().enumerate() {
            if operations + form.operations() >= self.best {
                continue;
            }
            self.choice[class as usize] = Some(index as u32);
            let mut open = rest.to_vec();
            open.extend(&form.children);
            self.branch(&open, operations + form.operations());
        }
        self.choice[class as usize] = None;
    }

    /// Tests whether the choice is without circles and meets all demands.
    fn in_time(&self) -> bool {
        let count = self.choice.len();
        let mut arrivals: Vec<Option<u32>> = vec![None; count];
        // Each sweep settles at least one class more, or none is left.
        loop {
            let mut settled = false;
            for class in 0..count {
                let (None, Some(index)) = (arrivals[class], self.choice[class]) else {
                    continue;
                };
                let form = &self.alternatives.classes[class][index as usize];
                let known: Option<Vec<u32>> = form
                    .children
                    .iter()
                    .map(|&child| arrivals[child as usize])
                    .collect();
                if let Some(known) = known {
                    arrivals[class] = Some(form.arrival_of(&self.times, &known));
                    settled = true;
                }
            }
            if !settled {
                break;
            }
        }
        self.demands.iter().all(|demand| {
            arrivals[demand.class as usize].is_some_and(|arrival| arrival <= demand.required)
        })
    }
}
