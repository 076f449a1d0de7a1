//! Resolving sweeps: names become indices, lists become placements.

use super::file::{ElementsEntry, SweepEntry};
use super::resolve::{HEADLINE, MAX_PLACEMENTS, PlanResolver, suggestion};
use super::{DEFAULT_MACHINE, ELEMENTS, NamedMachine, PlacementRequest};
use crate::axes::Axes;
use crate::study::couples;
use robovec_ir::Operation;
use robovec_ir::diagnostic::{Diagnostic, Report, did_you_mean};
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
        let elements = self.sweep_elements(sweep);
        let mut elements = elements;
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
        let mut found = Vec::new();
        for name in names {
            let position = match name.get_ref().as_str() {
                // The first model that is left may be one for other sweeps.
                HEADLINE => {
                    let headline = self.plan.models.get(self.plan.headline);
                    let is_chosen = self.selection.models.is_none();
                    let is_meant = headline.is_some_and(|model| is_chosen || !model.by_name);
                    is_meant.then_some(self.plan.headline)
                }
                wanted => self
                    .plan
                    .models
                    .iter()
                    .position(|model| model.name == wanted),
            };
            match position {
                Some(position) => found.push(position),
                // Models the command line leaves out leave sweeps too.
                None if self.selection.models.is_some() => {}
                None => {
                    let known = self.plan.models.iter().map(|model| model.name.as_str());
                    let near = did_you_mean(name.get_ref(), known);
                    let message = format!("there is no model '{}' in this plan", name.get_ref());
                    self.problem(name.span(), message, suggestion(near));
                }
            }
        }
        found
    }

    fn sweep_pipelines(&mut self, sweep: &SweepEntry) -> Vec<usize> {
        let Some(names) = &sweep.pipelines else {
            return (0..self.plan.pipelines.len()).collect();
        };
        let mut found = Vec::new();
        for name in names {
            let mut known = self.plan.pipelines.iter();
            match known.position(|pipeline| pipeline.name == *name.get_ref()) {
                Some(position) => found.push(position),
                None if self.selection.pipelines.is_some() => {}
                None => {
                    let known = self.plan.pipelines.iter();
                    let known = known.map(|pipeline| pipeline.name.as_str());
                    let near = did_you_mean(name.get_ref(), known);
                    let message = format!("there is no pipeline '{}' in this plan", name.get_ref());
                    self.problem(name.span(), message, suggestion(near));
                }
            }
        }
        found
    }

    fn sweep_machines(&mut self, sweep: &SweepEntry) -> Vec<usize> {
        let wanted = self.selection.machines.as_ref();
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
            if name == couples::ALL {
                found.extend(couples::machines().map(|machine| self.add_machine(machine)));
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
        let position = self
            .plan
            .machines
            .iter()
            .position(|machine| machine.name == known);
        if let Some(position) = position {
            return Ok(position);
        }
        let machine = match couples::machine_named(name) {
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
            let mut report = Report::new();
            report.push(Diagnostic::error().with_message(format!(
                "the machine '{name}' needs one kind of elements that adds and another that multiplies"
            )));
            return Err(report);
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
        match &self.selection.elements {
            Some(wanted) if sweep.grid.is_none() => {
                elements.extend(wanted.iter().map(|&count| [count; 2]));
            }
            Some(_) | None => {
                for entry in &sweep.elements {
                    let pair = match *entry.get_ref() {
                        ElementsEntry::Equal(count) => [count; 2],
                        ElementsEntry::Pair(pair) => pair,
                    };
                    self.check_elements(&pair, &entry.span());
                    elements.push(pair);
                }
            }
        }
        if let Some(grid) = &sweep.grid {
            self.check_elements(grid.get_ref(), &grid.span());
            // Each number once, so that a long list is not squared.
            let counts: BTreeSet<u32> = grid.get_ref().iter().copied().collect();
            // What is beyond the limit was refused, and is not made either.
            let allowed = |count: &u32| ELEMENTS.admits(Amount::Whole(u64::from(*count)));
            let counts: Vec<u32> = counts.into_iter().filter(allowed).collect();
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
