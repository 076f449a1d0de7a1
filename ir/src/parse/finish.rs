//! The end of a function: the steps that need the complete function.

use super::builder::{ModuleBuilder, Open};
use super::parts::{PendingAssignment, Span};
use super::problems::error;
use crate::entity::{Operand, Value};
use crate::function::{Function, Level, Node, Timing};
use crate::history::History;
use crate::module::View;
use crate::placement::Preload;
use crate::verify::{Violation, ViolationSubject, verify, verify_placement};

impl<'t> ModuleBuilder<'t> {
    /// Ends the function being read and adds it to the module if it is sound.
    pub(super) fn close_function(&mut self) {
        if let Some(head) = self.open.head {
            self.finish_function(head);
        }
        self.open = Open::new("", Level::Equations, None);
        self.names.clear();
        self.recent.clear();
    }

    fn finish_function(&mut self, head: Span) {
        self.report_undefined();
        let preload_spans = self.finish_preloads();
        let level = self.open.function.level;
        if level >= Level::Scheduled && self.open.function.schedule.is_none() {
            self.advise(
                head,
                format!("this {level} function has no schedule"),
                "a line like 'schedule \"thesis\" add*4 multi*4 cycles 806 bound 799' comes before the definitions",
            );
        }
        let spans = self.finish_assignments();
        self.complete_tables();
        let open = std::mem::replace(&mut self.open, Open::new("", Level::Equations, None));
        if self.problems.len() == open.problems_before {
            let view = self.module.tables.view(&open.function);
            for violation in self.violations(view) {
                let span = place(&open, head, &spans, &preload_spans, &violation);
                self.problems.push(error(span, violation.message));
            }
        }
        if self.problems.is_empty() {
            self.module.functions.push(open.function);
        }
    }

    /// The violations of a function, also on the machine if there is one.
    fn violations(&self, view: View<'_>) -> Vec<Violation> {
        let found = verify(view);
        let (Some(target), Some(schedule), []) = (self.target, &view.function.schedule, &found[..])
        else {
            return found;
        };
        if !(target.wanted)(&view.function.name) {
            return found;
        }
        if let Err(mismatch) = schedule.check_machine(target.machine) {
            return vec![Violation {
                subject: ViolationSubject::Schedule,
                message: mismatch.to_string(),
            }];
        }
        match view.function.level {
            Level::Placed => verify_placement(view, target.machine),
            Level::Equations | Level::Atomic | Level::Scheduled => found,
        }
    }

    /// Finds the values that preloads name, and sorts the preloads by word.
    fn finish_preloads(&mut self) -> Vec<Span> {
        let mut pending = std::mem::take(&mut self.open.preloads);
        pending.sort_by_key(|preload| preload.word);
        let mut spans = Vec::with_capacity(pending.len());
        for preload in pending {
            let operand = match preload.operand {
                Ok(operand) => operand,
                Err(span) => self.value_now(span),
            };
            spans.push(preload.span);
            if let Some(placement) = &mut self.open.function.placement {
                placement.preloads.push(Preload {
                    word: preload.word,
                    operand,
                });
            }
        }
        spans
    }

    /// A value by its name, now that all are known.
    fn value_now(&mut self, span: Span) -> Operand {
        let operand = self.value(span);
        if operand.value().is_none() {
            self.report_undefined();
        }
        operand
    }

    /// Sorts the assignments and their nodes as in the text form; where the
    /// outputs are, in that order.
    fn finish_assignments(&mut self) -> Vec<Span> {
        let mut pending = std::mem::take(&mut self.open.assignments);
        if self.open.disordered && self.open.function.level == Level::Equations {
            pending.sort_by_key(|assignment| assignment.output);
            self.reorder(&mut pending);
        } else {
            pending.sort_by_key(|assignment| assignment.output);
        }
        for assignment in &pending {
            self.open
                .function
                .assign(assignment.output, assignment.operand, assignment.sources);
        }
        if let Some(histories) = &mut self.open.function.histories {
            let outputs = pending.iter().map(|assignment| assignment.history);
            histories.outputs = outputs.collect();
        }
        if let Some(placement) = &mut self.open.function.placement {
            placement.homes = pending.iter().map(|assignment| assignment.home).collect();
        }
        pending.iter().map(|assignment| assignment.span).collect()
    }

    /// Moves the nodes of assignments after those of definitions, in the
    /// order of the assignments.
    fn reorder(&mut self, pending: &mut [PendingAssignment]) {
        let count = self.open.node_count();
        let mut is_tree = vec![false; count as usize];
        for node in pending
            .iter()
            .flat_map(|assignment| assignment.nodes.clone())
        {
            is_tree[node as usize] = true;
        }
        let definitions = (0..count).filter(|&node| !is_tree[node as usize]);
        let trees = pending
            .iter()
            .flat_map(|assignment| assignment.nodes.clone());
        let order: Vec<u32> = definitions.chain(trees).collect();
        let mut moved = vec![0; count as usize];
        for (new, &old) in order.iter().enumerate() {
            moved[old as usize] = new as u32;
        }
        let rename = |operand: Operand| match operand.value() {
            Some(value) => Value(moved[value.index()]).into(),
            None => operand,
        };
        let histories = self.open.function.histories.take().map(|mut histories| {
            histories.values.resize(order.len(), History::NONE);
            let values = order.iter().map(|&old| histories.values[old as usize]);
            let values = values.collect();
            histories.with_subjects(values, Vec::new())
        });
        let old = &self.open.function;
        let mut new: Function = old.skeleton(old.level);
        for &number in old.constants() {
            new.constant(number);
        }
        new.reserve(order.len());
        for &index in &order {
            let node = old.node(Value(index));
            new.push(Node {
                operands: node.operands.map(rename),
                ..*node
            });
        }
        self.open.spans = order
            .iter()
            .map(|&index| self.open.spans[index as usize])
            .collect();
        self.open.function = new;
        self.open.function.histories = histories;
        for assignment in pending {
            assignment.operand = rename(assignment.operand);
        }
    }

    /// Nodes of assignments have no histories, times or slots; the verifier
    /// rejects them, but requires tables of full length.
    fn complete_tables(&mut self) {
        let count = self.open.node_count() as usize;
        let function = &mut self.open.function;
        if let Some(timing) = &mut function.timing {
            timing.resize(count, Timing::default());
        }
        if let Some(formats) = &mut function.formats {
            formats.resize(count);
        }
        if let Some(histories) = &mut function.histories {
            histories.values.resize(count, History::NONE);
        }
        if let Some(schedule) = &mut function.schedule {
            schedule.slots.resize(count, None);
        }
        if let Some(placement) = &mut function.placement {
            placement.reads.resize(count, [None; Operand::MAX_COUNT]);
            placement.buffers.resize(count, None);
            placement
                .write_starts
                .resize(count + 1, placement.writes.len() as u32);
        }
    }
}

/// The place of a violation in the text.
fn place(
    open: &Open<'_>,
    head: Span,
    assignments: &[Span],
    preloads: &[Span],
    violation: &Violation,
) -> Span {
    let found = match violation.subject {
        ViolationSubject::Function => None,
        ViolationSubject::Input(index) => open.input_spans.get(index),
        ViolationSubject::Output(index) => open.output_spans.get(index),
        ViolationSubject::Boundary(index) => open.boundary_spans.get(index),
        ViolationSubject::Constant(_) => None,
        ViolationSubject::Value(value) => open.spans.get(value.index()),
        ViolationSubject::Assignment(index) => assignments.get(index),
        ViolationSubject::Preload(index) => preloads.get(index),
        ViolationSubject::Schedule => Some(&open.schedule_span),
    };
    found.copied().unwrap_or(head)
}
