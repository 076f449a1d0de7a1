//! The fewest operations by trying everything, to measure extraction against.

use super::alternatives::{Alternatives, Times};
use super::extract::Demand;

/// Searches all covers that keep the required times, with bounds.
pub(crate) struct Exact<'a> {
    alternatives: &'a Alternatives,
    times: Times<'a>,
    demands: &'a [Demand],
    choice: Vec<Option<u32>>,
    best: u32,
    steps: u64,
}

impl<'a> Exact<'a> {
    /// The fewest operations below `known` with which every demand is met in
    /// time, or `known`; `None` when the search takes more than so many steps.
    pub(crate) fn fewest(
        alternatives: &'a Alternatives,
        times: Times<'a>,
        demands: &'a [Demand],
        known: u32,
        steps: u64,
    ) -> Option<u32> {
        let mut search = Exact {
            alternatives,
            times,
            demands,
            choice: vec![None; alternatives.classes.len()],
            best: known,
            steps,
        };
        let open: Vec<u32> = demands.iter().map(|demand| demand.class).collect();
        search.branch(&open, 0);
        (search.steps > 0).then_some(search.best)
    }

    /// Chooses a form for the last open class, and goes on. Depth is bounded
    /// by the number of classes.
    fn branch(&mut self, open: &[u32], operations: u32) {
        if self.steps == 0 || operations >= self.best {
            return;
        }
        self.steps -= 1;
        let Some((&class, rest)) = open.split_last() else {
            if self.in_time() {
                self.best = operations;
            }
            return;
        };
        if self.choice[class as usize].is_some() {
            return self.branch(rest, operations);
        }
        let alternatives = self.alternatives;
        for (index, form) in alternatives.classes[class as usize].iter().enumerate() {
            self.choice[class as usize] = Some(index as u32);
            let mut open = rest.to_vec();
            open.extend(&form.children);
            self.branch(&open, operations + form.operations());
        }
        self.choice[class as usize] = None;
    }

    /// Whether the choice is without circles and meets all demands.
    fn in_time(&self) -> bool {
        let count = self.choice.len();
        let mut arrivals: Vec<Option<u32>> = vec![None; count];
        let mut scratch = Vec::new();
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
                    arrivals[class] = Some(form.arrival_of(&self.times, &mut scratch, &known));
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
