//! Resolving sweeps: names become indices, lists become placements.

use super::file::{ElementsEntry, SweepEntry};
use super::resolve::{HEADLINE, MAX_PLACEMENTS, PlanResolver, suggestion};
use super::{DEFAULT_MACHINE, ELEMENTS, NamedMachine, PlacementRequest};
use crate::axes::Axes;
use crate::operators::{Couple, couples, with_stages};
use robovec_ir::diagnostic::{Report, did_you_mean};
use robovec_ir::machine::ClockOrigin;
use robovec_ir::{Machine, Operation};
use robovec_num::limits::Amount;
use robovec_schedule::PlaceOptions;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

impl PlanResolver<'_> {
    /// Adds the placements of a sweep.
    pub(super) fn sweep(&mut self, sweep: &SweepEntry, requests: &mut BTreeSet<PlacementRequest>) {
        let models = self.sweep_models(sweep);
        let pipelines = self.sweep_pipelines(sweep);
        let machines = self.sweep_machines(sweep);
        let mut elements = self.sweep_elements(sweep);
        elements.sort_unstable();
        elements.dedup();
        let usual = PlaceOptions::default();
        let priorities = sweep.priority.clone().unwrap_or(vec![usual.priority]);
        let choices = sweep.choice.clone().unwrap_or(vec![usual.choice]);
        // Counted before they are made.
        let axes = Axes([
            models.len(),
            pipelines.len(),
            machines.len(),
            elements.len(),
            priorities.len(),
            choices.len(),
        ]);
        let count = axes.count();
        if count > MAX_PLACEMENTS as u64 {
            let message =
                format!("a sweep asks for {count} placements; there can be {MAX_PLACEMENTS}");
            self.problem(0..0, message, Vec::new());
            return;
        }
        let combinations = axes.combinations();
        requests.extend(combinations.map(
            |[model, pipeline, machine, numbers, priority, choice]| PlacementRequest {
                model: models[model],
                pipeline: pipelines[pipeline],
                machine: machines[machine],
                n_add: elements[numbers][0],
                n_multi: elements[numbers][1],
                options: PlaceOptions {
                    priority: priorities[priority],
                    choice: choices[choice],
                },
            },
        ));
    }

    fn sweep_models(&mut self, sweep: &SweepEntry) -> Vec<usize> {
        let Some(names) = &sweep.models else {
            let models = &self.plan.models;
            let all = (0..models.len()).filter(|&model| !models[model].by_name);
            return all.collect();
        };
        let is_chosen = !self.selection.models.is_empty();
        let known = self.plan.models.iter();
        let known: Vec<String> = known.map(|one| one.name.clone()).collect();
        let headline = self.plan.headline;
        // The first model that is left may be one for other sweeps.
        let model = self.plan.models.get(headline);
        let is_meant = model.is_some_and(|model| !is_chosen || !model.by_name);
        let mut found = Vec::new();
        for name in names {
            match name.get_ref().as_str() {
                HEADLINE if is_meant => found.push(headline),
                _ => found.extend(self.named("model", &known, name, is_chosen)),
            }
        }
        found
    }

    fn sweep_pipelines(&mut self, sweep: &SweepEntry) -> Vec<usize> {
        let Some(names) = &sweep.pipelines else {
            return (0..self.plan.pipelines.len()).collect();
        };
        let is_chosen = !self.selection.pipelines.is_empty();
        let known = self.plan.pipelines.iter();
        let known: Vec<String> = known.map(|one| one.name.clone()).collect();
        let place = |name| self.named("pipeline", &known, name, is_chosen);
        names.iter().filter_map(place).collect()
    }

    /// The place of a name in a list, without the entries excluded.
    fn named(
        &mut self,
        what: &str,
        known: &[String],
        name: &Spanned<String>,
        is_chosen: bool,
    ) -> Option<usize> {
        let (span, name) = (name.span(), name.get_ref());
        let place = known.iter().position(|known| known == name);
        if place.is_none() && !is_chosen {
            let near = did_you_mean(name, known.iter().map(String::as_str));
            let message = format!("there is no {what} '{name}' in this plan");
            self.problem(span, message, suggestion(near));
        }
        place
    }

    fn sweep_machines(&mut self, sweep: &SweepEntry) -> Vec<usize> {
        let wanted = Some(self.selection.machines).filter(|wanted| !wanted.is_empty());
        let names: Vec<(String, Option<Range<usize>>)> = match (&sweep.machines, wanted) {
            (None, None) => vec![(DEFAULT_MACHINE.to_owned(), None)],
            (None, Some(wanted)) => wanted.iter().map(|name| (name.clone(), None)).collect(),
            (Some(names), wanted) => {
                let kept = |name: &&Spanned<String>| {
                    wanted.is_none_or(|wanted| wanted.contains(name.get_ref()))
                };
                let names = names.iter().filter(kept);
                let spanned = names.map(|name| (name.get_ref().clone(), Some(name.span())));
                spanned.collect()
            }
        };
        let mut found = Vec::new();
        for (name, span) in names {
            if name == COUPLES {
                found.extend(couple_machines().map(|machine| self.add_machine(machine)));
                continue;
            }
            match self.machine(&name) {
                Ok(index) => found.push(index),
                Err(report) => match span {
                    Some(span) => {
                        let message = format!("the machine '{name}' cannot be used");
                        let notes = report.diagnostics().iter();
                        let notes = notes.map(|diagnostic| diagnostic.message.clone());
                        self.problem(span, message, notes.collect());
                    }
                    None => self.foreign = report,
                },
            }
        }
        found
    }

    fn machine(&mut self, name: &str) -> Result<usize, Report> {
        let file_name = Path::new(name)
            .file_stem()
            .map(|stem| stem.to_string_lossy());
        let known = file_name.as_deref().unwrap_or(name);
        let mut machines = self.plan.machines.iter();
        if let Some(position) = machines.position(|machine| machine.name == known) {
            return Ok(position);
        }
        let machine = match couple_named(name) {
            Some(machine) => machine,
            None => NamedMachine {
                name: known.to_owned(),
                machine: (self.read_machine)(name)?,
                couple: None,
            },
        };
        let kind = |operation| machine.machine.kind_of(operation);
        if kind(Operation::Add).is_none()
            || kind(Operation::Mul).is_none()
            || kind(Operation::Add) == kind(Operation::Mul)
        {
            let message = format!(
                "the machine '{name}' needs one kind of elements that adds and another that \
                 multiplies"
            );
            return Err(Report::error(message, Vec::new()));
        }
        Ok(self.add_machine(machine))
    }

    fn add_machine(&mut self, machine: NamedMachine) -> usize {
        let machines = &mut self.plan.machines;
        let known = machines.iter().position(|known| known.name == machine.name);
        known.unwrap_or_else(|| {
            machines.push(machine);
            machines.len() - 1
        })
    }

    fn sweep_elements(&mut self, sweep: &SweepEntry) -> Vec<[u32; 2]> {
        let mut elements = Vec::new();
        let wanted = self.selection.elements;
        if !wanted.is_empty() && sweep.grid.is_none() {
            elements.extend(wanted.iter().map(|&count| [count; 2]));
        } else {
            for entry in &sweep.elements {
                let pair = match *entry.get_ref() {
                    ElementsEntry::Equal(count) => [count; 2],
                    ElementsEntry::Pair(pair) => pair,
                };
                self.check_elements(&pair, &entry.span());
                elements.push(pair);
            }
        }
        if let Some(grid) = &sweep.grid {
            self.check_elements(grid.get_ref(), &grid.span());
            // Each number once, so that a long list is not squared.
            // What is beyond the limit was refused, and is not made either.
            let allowed = |count: &u32| ELEMENTS.admits(Amount::Whole(u64::from(*count)));
            let counts = grid.get_ref().iter().copied().filter(allowed);
            let counts: BTreeSet<u32> = counts.collect();
            for &adders in &counts {
                elements.extend(counts.iter().map(|&multipliers| [adders, multipliers]));
            }
        }
        elements
    }

    fn check_elements(&mut self, counts: &[u32], span: &Range<usize>) {
        let checks = counts
            .iter()
            .map(|&count| ELEMENTS.check(Amount::Whole(u64::from(count))));
        if let Some(reason) = checks.filter_map(Result::err).next() {
            self.problem(
                span.clone(),
                format!("elements of a kind: {reason}"),
                Vec::new(),
            );
        }
    }
}

/// The word for all couples in lists of machines.
const COUPLES: &str = "couples";

/// Machines of all couples: the thesis' machine with their stages and clock.
fn couple_machines() -> impl Iterator<Item = NamedMachine> {
    couples().into_iter().map(couple_machine)
}

/// The machine of a name like `couple-7-4`.
fn couple_named(name: &str) -> Option<NamedMachine> {
    couple_machines().find(|machine| machine.name == name)
}

fn couple_machine(couple: Couple) -> NamedMachine {
    let thesis = Machine::built_in("thesis").expect("it ships, and a test parses it");
    let [add, multi] = couple.stages();
    let mut machine = with_stages(&thesis, [add, multi]);
    let name = format!("couple-{}", couple.name());
    machine.name.clone_from(&name);
    machine.description = format!(
        "adders of {add} stages, multipliers of {multi}, at {} MHz (thesis, Table 1.3)",
        couple.mhz()
    );
    machine.clock_mhz = Some(f64::from(couple.mhz()));
    machine.clock_origin = ClockOrigin::Published;
    NamedMachine {
        name,
        machine,
        couple: Some([add, multi]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_couple_is_a_machine() {
        assert_eq!(couple_machines().count(), 15);
        let machine = couple_named("couple-10-5").expect("it is a couple");
        let thesis = Machine::built_in("thesis").expect("it ships");
        assert_eq!(machine.machine.elements, thesis.elements);
        assert_eq!(machine.machine.clock_mhz, thesis.clock_mhz);
        assert_eq!(couple_named("couple-10-9"), None);
    }
}
