//! Answer of a front: speed relative to the thesis, error, and cost.

use super::measure::FrontPoint;
use super::{Front, FrontVerdict};
use crate::pareto;
use robovec_error::yardstick::account::{measure_text, random_states};
use robovec_fpga::hardware;
use robovec_present::number::{exponential, share_percent};
use robovec_present::text::{cut, distinct};
use std::collections::BTreeSet;

/// Indices of the points compared with a number of elements.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaceAnswer {
    /// Index of the number of elements.
    pub(super) place: usize,
    /// The fastest choice of the thesis, the most exact of equally fast ones.
    pub(super) thesis: usize,
    /// The fastest of ours that is worse nowhere, and better somewhere.
    pub(super) best: Option<usize>,
}

impl PlaceAnswer {
    /// Cycles of the thesis over those of ours; 1 where ours is no better.
    fn gain(self, front: &Front) -> f64 {
        let cycles = |index: usize| front.cycles(index, self.place);
        let best = self.best.unwrap_or(self.thesis);
        cycles(self.thesis) / cycles(best).max(1.0)
    }
}

/// Maximum number of characters of a reason.
const REASON: usize = 160;

impl Front {
    /// Cycles of a point; infinite where it does not fit.
    fn cycles(&self, index: usize, place: usize) -> f64 {
        self.points[index].cycles[place].map_or(f64::INFINITY, f64::from)
    }

    /// Cycles and worst error of a point.
    fn plane(&self, index: usize, place: usize) -> [f64; 2] {
        let error = self.points[index].normwise.worst;
        [self.cycles(index, place), error]
    }

    /// Pareto front of cycles and worst error, fastest first, no duplicates.
    pub(super) fn steps(&self, place: usize) -> Vec<usize> {
        let points = 0..self.points.len();
        pareto::steps(points.map(|index| (index, self.plane(index, place))))
    }

    /// The comparison with the thesis for a number of elements.
    pub(super) fn answer(&self, place: usize) -> Option<PlaceAnswer> {
        let order = |&a: &usize, &b: &usize| {
            let (a, b) = (self.plane(a, place), self.plane(b, place));
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
        };
        let fits = |index: &usize| self.points[*index].cycles[place].is_some();
        let by = |thesis: bool| {
            let points = (0..self.points.len()).filter(fits);
            points.filter(move |&index| self.points[index].thesis == thesis)
        };
        let thesis = by(true).min_by(order)?;
        let measures = |index: usize| {
            let [cycles, error] = self.plane(index, place);
            let share = self.points[index].shares[place].unwrap_or(f64::INFINITY);
            [cycles, error, share]
        };
        let better = |index: &usize| pareto::dominates(&measures(*index), &measures(thesis));
        Some(PlaceAnswer {
            place,
            thesis,
            best: by(false).filter(better).min_by(order),
        })
    }

    /// The comparisons, by number of elements.
    fn answers(&self) -> Vec<PlaceAnswer> {
        let places = 0..self.elements.len();
        places.filter_map(|place| self.answer(place)).collect()
    }

    /// Points whose largest errors are searched for: answers and steps.
    pub(super) fn searched(&self) -> BTreeSet<usize> {
        let compared = self.answers().into_iter();
        let compared = compared.flat_map(|answer| [Some(answer.thesis), answer.best]);
        let places = 0..self.elements.len();
        let steps = places.flat_map(|place| self.steps(place));
        compared.flatten().chain(steps).collect()
    }

    /// The comparison with the largest gain.
    pub(super) fn headlined(&self) -> Option<PlaceAnswer> {
        let answers = self.answers().into_iter().rev();
        answers.max_by(|a, b| a.gain(self).total_cmp(&b.gain(self)))
    }

    pub(super) fn gain_text(&self) -> String {
        let Some(answer) = self.headlined() else {
            return "no choice of the thesis fits on the machine".to_owned();
        };
        let count = self.elements[answer.place];
        let before = self.cycles(answer.thesis, answer.place);
        let Some(best) = answer.best else {
            return format!("no choice is better than the thesis' {before} cycles");
        };
        let after = self.cycles(best, answer.place);
        let gain = match answer.gain(self) {
            gain if gain > 1.005 => format!("{gain:.2} times faster than the thesis"),
            _ => "not faster than the thesis, but more exact or smaller".to_owned(),
        };
        format!("{gain}: {before} -> {after} cycles, {count}+{count} elements")
    }

    /// Lines after the gain, with their labels.
    pub(super) fn evidence(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(answer) = self.headlined() {
            let (thesis, best) = (&self.points[answer.thesis], answer.best);
            let best = best.map(|best| &self.points[best]);
            let named = |point: &FrontPoint| format!("{}, {}", point.choice, point.format);
            lines.push(("thesis", named(thesis)));
            lines.extend(best.map(|best| ("ours", named(best))));
            let best = best.unwrap_or(thesis);
            lines.push(("worst error", self.error_text(thesis, best)));
            if let (Some(before), Some(after)) = (thesis.found, best.found) {
                let [before, after] = [before, after].map(exponential);
                let text = format!("{before} -> {after}, found by a directed search");
                lines.push(("", text));
            }
        }
        let mut label = "elements";
        for answer in self.answers() {
            lines.push((label, self.place_text(answer)));
            label = "";
        }
        let device = &self.machine.device.device().name;
        let clock = hardware::clock(&self.machine).text();
        let machine = format!("{}, {clock}, shares of {device}", self.machine.name);
        lines.push(("machine", machine));
        lines.push(("beaten", self.beaten()));
        if let Some((_, reason)) = self.left.first() {
            let names = distinct(self.left.iter().map(|(name, _)| name.as_str()));
            let reason = cut(reason, REASON);
            lines.push(("left out", format!("formulation {names}: {reason}")));
        }
        lines
    }

    fn error_text(&self, thesis: &FrontPoint, best: &FrontPoint) -> String {
        let drawn = random_states(self.states as usize, self.seed, self.has_ranges);
        let [before, after] = [thesis, best].map(|point| exponential(point.normwise.worst));
        let median = exponential(best.normwise.median);
        format!(
            "{before} -> {after}, median {median}, {}",
            measure_text(&drawn)
        )
    }

    /// Cycles, time and share of the device of both.
    fn place_text(&self, answer: PlaceAnswer) -> String {
        let (place, count) = (answer.place, self.elements[answer.place]);
        let best = answer.best.unwrap_or(answer.thesis);
        let [before, after] = [answer.thesis, best].map(|index| {
            let point = &self.points[index];
            let share = share_percent(point.shares[place].unwrap_or(f64::NAN));
            let time = point.microseconds[place].unwrap_or(f64::NAN);
            (self.cycles(index, place), format!("{time:.2}"), share)
        });
        format!(
            "{count}+{count}: {} -> {} cycles, {} -> {} us, {} -> {} of the device (estimated)",
            before.0, after.0, before.1, after.1, before.2, after.2
        )
    }

    /// Number of choices of the thesis that are worse in all measures.
    fn beaten(&self) -> String {
        let count = |by: fn(&FrontVerdict) -> Option<usize>| {
            let verdicts = self.verdicts.iter();
            verdicts.filter(|verdict| by(verdict).is_some()).count()
        };
        format!(
            "{} of {} choices of the thesis in speed, errors and cost at once, {} of them within \
             their own number format",
            count(|verdict| verdict.by),
            self.verdicts.len(),
            count(|verdict| verdict.in_its_format),
        )
    }
}
