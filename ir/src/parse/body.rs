//! Definitions, assignments and their expressions.

use super::builder::ModuleBuilder;
use super::parts::{Head, Indices, PendingAssignment, Span};
use super::problems::{also, error};
use crate::diagnostic::{clip, did_you_mean};
use crate::entity::{Input, Operand, Output, Value};
use crate::function::{Array, Level, Node, Shape, Timing};
use crate::history::History;
use crate::source::SourceSet;
use crate::symbol::Name;
use robovec_num::decimal;
use robovec_num::operation::Operation;

/// The operations that are written as functions.
const FUNCTIONS: [Operation; 6] = [
    Operation::Sin,
    Operation::Cos,
    Operation::Sqrt,
    Operation::Fma,
    Operation::Fms,
    Operation::Fnma,
];

/// The arguments of a function: the first ones, and their number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arguments {
    operands: [Operand; Operand::MAX_COUNT],
    count: u32,
}

impl Arguments {
    pub(super) fn first(operand: Operand) -> Arguments {
        Arguments {
            operands: Operand::list([operand]),
            count: 1,
        }
    }

    /// The list with one more.
    pub(super) fn and(mut self, operand: Operand) -> Arguments {
        if let Some(place) = self.operands.get_mut(self.count as usize) {
            *place = operand;
        }
        self.count = self.count.saturating_add(1);
        self
    }
}

fn argument_count(count: u32) -> String {
    match count {
        1 => "one argument".to_owned(),
        _ => format!("{count} arguments"),
    }
}

impl ModuleBuilder<'_> {
    /// `%x =`.
    pub(super) fn begin_definition(&mut self, span: Span) {
        self.inside(span);
        let text = &self.slice(span)[1..];
        let (base, suffix) = Name::split(text);
        let base = self.module.tables.symbols.intern(base);
        self.head = Head::Definition(Name { base, suffix }, span);
    }

    /// `M[1,2] =`.
    pub(super) fn begin_assignment(&mut self, name: Span, indices: Option<Indices>) {
        let indices = indices.unwrap_or_default();
        let span = Span::new(name.start, name.end.max(indices.span.end));
        let mut output = None;
        if self.inside(span) {
            match self.open.outputs.get(self.slice(name)) {
                None => self.unknown_array(name, false),
                Some(&index) => {
                    let array = self.open.function.outputs()[index];
                    let declared = self.open.output_spans[index];
                    output = self.offset(array, declared, indices, span).map(Output);
                }
            }
        }
        if let Some(output) = output
            && let Some(first) = self.open.written.insert(output.0, span)
        {
            let message = format!("{} is set twice", clip(self.slice(span)));
            self.conflict(span, message, first, "first set here");
        }
        self.head = Head::Assignment(output, span);
    }

    fn push(
        &mut self,
        operation: Operation,
        operands: [Operand; Operand::MAX_COUNT],
        span: Span,
    ) -> Operand {
        let node = Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands,
            operation,
        };
        self.open.spans.push(span);
        self.open.function.push(node).into()
    }

    /// `a + b` and its like.
    pub(super) fn binary(
        &mut self,
        operation: Operation,
        a: Operand,
        b: Operand,
        span: Span,
    ) -> Operand {
        self.push(operation, Operand::list([a, b]), span)
    }

    /// `-a`.
    pub(super) fn unary(&mut self, operation: Operation, a: Operand, span: Span) -> Operand {
        self.push(operation, Operand::list([a]), span)
    }

    /// `sin(a)`, `fma(a, b, c)` and their like.
    pub(super) fn call(&mut self, name: Span, given: Arguments, end: u32) -> Operand {
        let text = self.slice(name);
        let mut functions = FUNCTIONS.iter();
        let Some(&operation) = functions.find(|operation| operation.name() == text) else {
            let message = format!("there is no function '{}'", clip(text));
            self.advise(
                name,
                message,
                "the functions are sin, cos, sqrt, fma, fms and fnma",
            );
            return self.nothing();
        };
        let span = Span::new(name.start, end);
        if given.count as usize != operation.arity() {
            let message = format!(
                "{text} takes {}, not {}",
                argument_count(operation.arity() as u32),
                given.count
            );
            let help = if operation.is_fused() {
                "fma(a, b, c) is a*b + c, fms(a, b, c) is a*b - c, fnma(a, b, c) is c - a*b"
            } else {
                "an angle or a number is in the parentheses"
            };
            self.advise(span, message, help);
            return self.nothing();
        }
        self.push(operation, given.operands, span)
    }

    /// A number, with the minus before it.
    pub(super) fn literal(&mut self, span: Span, negative: bool) -> Operand {
        let number = self.slice(span).parse();
        let number: f64 = number.expect("the lexer passes only digits that can be read");
        if !number.is_finite() {
            self.advise(
                span,
                format!("the number {} is too large", clip(self.slice(span))),
                "numbers reach to about 1.8e308",
            );
            return self.nothing();
        }
        if decimal::is_lost(self.slice(span), number) {
            let message = format!("the number {} is too small", clip(self.slice(span)));
            self.advise(span, message, decimal::LOST);
            return self.nothing();
        }
        let number = if negative { -number } else { number };
        self.open.function.constant(number).into()
    }

    /// A placeholder for an operand that could not be read.
    pub(super) fn nothing(&mut self) -> Operand {
        self.open.function.constant(0.0).into()
    }

    /// `%x` in an expression.
    pub(super) fn value(&mut self, span: Span) -> Operand {
        let text = &self.slice(span)[1..];
        if let Some(value) = self.recent.get(text) {
            return value.into();
        }
        let (base, suffix) = Name::split(text);
        let base = self.module.tables.symbols.find(base);
        let value = base.and_then(|base| self.names.get(Name { base, suffix }));
        match value {
            Some(value) => {
                self.recent.set(text, value);
                value.into()
            }
            None => {
                if self.open.head.is_some() {
                    let node = self.open.node_count();
                    self.open.undefined.push(span, node);
                }
                self.nothing()
            }
        }
    }

    /// `q[3]` in an expression.
    pub(super) fn input_element(&mut self, name: Span, indices: Option<Indices>) -> Operand {
        let Some(&index) = self.open.inputs.get(self.slice(name)) else {
            if self.open.head.is_some() {
                self.unknown_array(name, true);
            }
            return self.nothing();
        };
        let indices = indices.unwrap_or_default();
        let array = self.open.function.inputs()[index];
        let declared = self.open.input_spans[index];
        let span = Span::new(name.start, name.end.max(indices.span.end));
        match self.offset(array, declared, indices, span) {
            Some(offset) => Input(offset).into(),
            None => self.nothing(),
        }
    }

    /// The offset of an element among the flattened ones; reports a wrong
    /// index and returns `None`.
    fn offset(
        &mut self,
        array: Array,
        declared: Span,
        indices: Indices,
        span: Span,
    ) -> Option<u32> {
        let rank = match array.shape {
            Shape::Scalar => 0,
            Shape::Vector(_) => 1,
            Shape::Matrix(..) => 2,
        };
        if indices.count == rank
            && let Some(offset) = array.shape.offset(indices.list())
        {
            return Some(array.offset + offset);
        }
        if self.is_full() {
            return None;
        }
        let name = clip(self.module.tables.symbols.text(array.name)).into_owned();
        let message = match (array.shape, indices.count == rank) {
            (Shape::Scalar, _) => format!("'{name}' is a single number and has no index"),
            (Shape::Vector(_), false) => format!("'{name}' has one index, not {}", indices.count),
            (Shape::Matrix(..), false) => {
                format!("'{name}' has two indices, not {}", indices.count)
            }
            (Shape::Vector(length), true) => {
                format!(
                    "the index {} of '{name}' is not in 1..{length}",
                    indices.values[0]
                )
            }
            (Shape::Matrix(rows, columns), true) => {
                let [i, j] = indices.values;
                format!("the indices {i},{j} of '{name}' are not in 1..{rows},1..{columns}")
            }
        };
        let label = also(declared, "declared here");
        self.problems.push(error(span, message).with_label(label));
        None
    }

    fn unknown_array(&mut self, name: Span, is_input: bool) {
        let text = self.slice(name);
        let open = &self.open;
        if self.is_full() || open.broken.contains_key(text) {
            return;
        }
        let (arrays, others) = if is_input {
            (open.function.inputs(), &open.outputs)
        } else {
            (open.function.outputs(), &open.inputs)
        };
        let symbols = &self.module.tables.symbols;
        let names = arrays.iter().map(|array| symbols.text(array.name));
        let nearest = did_you_mean(text, names).map(str::to_owned);
        let kind = if is_input { "input" } else { "output" };
        let message = format!("there is no {kind} array '{}'", clip(text));
        let help = if matches!(
            text.to_ascii_lowercase().as_str(),
            "nan" | "inf" | "infinity"
        ) {
            "a literal is a finite number".to_owned()
        } else if others.contains_key(text) && is_input {
            format!("'{text}' is an output: it can be set but not read")
        } else if others.contains_key(text) {
            format!("'{text}' is an input: it can be read but not set")
        } else if let Some(nearest) = nearest {
            format!("did you mean '{nearest}'?")
        } else if is_input {
            "an input is declared by a line like 'in q[1..6]', and a value has a % before its name"
                .to_owned()
        } else {
            "an output is declared by a line like 'out M[1..6,1..6]'".to_owned()
        };
        self.advise(name, message, &help);
    }

    /// The end of a definition's line.
    pub(super) fn end_definition(&mut self, root: Operand, end: u32) {
        let Head::Definition(name, span) = self.head else {
            return;
        };
        let root = match root.value() {
            Some(value) if value.0 >= self.start => value,
            Some(_) | None => {
                let copy = self.unary(Operation::Copy, root, span);
                copy.value()
                    .expect("a node that was just pushed is a value")
            }
        };
        self.open.spans[root.index()] = Span::new(span.start, end);
        if let Some(first) = self.names.get(name) {
            let first = self.open.name_span(first, self.text);
            let message = format!("{} is defined twice", clip(self.slice(span)));
            self.conflict(span, message, first, "first defined here");
        }
        self.names.set(name, root);
        self.recent.set(&self.slice(span)[1..], root);
        self.open.function.node_mut(root).name = name;
        self.open.disordered |= self.trees_came_before();
        if let Some((_, home)) = self.attributes.home {
            self.error(
                home,
                "only an output has a final place; values of operations are written with 'write'",
            );
        }
        self.set_sources();
        self.end_timing(span);
        self.end_slot(span);
        self.end_history(root);
        self.end_format(root);
        self.next_statement();
    }

    fn trees_came_before(&self) -> bool {
        let last = self.open.assignments.last();
        last.is_some_and(|assignment| !assignment.nodes.is_empty())
    }

    /// Gives every node of a statement the sources of the statement.
    fn set_sources(&mut self) {
        let sources = self.attributes.sources();
        if sources != SourceSet::EMPTY {
            for node in self.start..self.open.node_count() {
                self.open.function.node_mut(Value(node)).sources = sources;
            }
        }
    }

    fn end_timing(&mut self, span: Span) {
        let help = "either all definitions have {asap … alap …}, or none has";
        let Some((timing, at)) = self.attributes.timing else {
            if self.open.function.timing.is_some() {
                let message = format!("{} has no times", clip(self.slice(span)));
                self.advise(span, message, help);
            }
            return;
        };
        let is_first = self.start == 0;
        if !is_first && self.open.function.timing.is_none() {
            let message = "the definitions before this one have no times";
            self.advise(at, message, help);
        }
        let count = self.open.node_count() as usize;
        let times = self.open.function.timing.get_or_insert_default();
        times.resize(count - 1, Timing::default());
        times.push(timing);
    }

    fn end_history(&mut self, root: Value) {
        if let Some((history, _)) = self.attributes.history
            && let Some(histories) = &mut self.open.function.histories
        {
            histories.values.resize(root.index() + 1, History::NONE);
            histories.values[root.index()] = history;
        }
    }

    fn end_format(&mut self, root: Value) {
        if let Some((format, _)) = self.attributes.format {
            let formats = self.open.function.formats.get_or_insert_default();
            formats.resize(root.index() + 1);
            formats.set(root, Some(format));
        }
    }

    fn end_slot(&mut self, span: Span) {
        if self.open.function.level < Level::Scheduled || self.open.head.is_none() {
            return;
        }
        let Some((slot, _)) = self.attributes.slot else {
            let message = format!("{} has no processing element", clip(self.slice(span)));
            let level = self.open.function.level;
            let help = format!(
                "at the level {level} every definition has 'on ELEMENT at CYCLE' or 'on host'"
            );
            return self.advise(span, message, &help);
        };
        let count = self.open.node_count() as usize;
        let Some(schedule) = &mut self.open.function.schedule else {
            return;
        };
        // More than one node is an error that the verifier reports.
        schedule.slots.resize(count - 1, slot);
        schedule.slots.push(slot);
        let Some(placement) = &mut self.open.function.placement else {
            return;
        };
        let none = [None; Operand::MAX_COUNT];
        placement.reads.resize(count - 1, none);
        placement
            .reads
            .push(self.attributes.reads.map_or(none, |(reads, _)| reads));
        placement.buffers.resize(count - 1, None);
        placement
            .buffers
            .push(self.attributes.buffer.map(|(word, _)| word));
        placement
            .write_starts
            .resize(count, placement.writes.len() as u32);
        self.writes.sort_by_key(|write| (write.cycle, write.word));
        placement.writes.append(&mut self.writes);
        placement.write_starts.push(placement.writes.len() as u32);
    }

    /// The end of an assignment's line.
    pub(super) fn end_assignment(&mut self, operand: Operand) {
        let Head::Assignment(output, span) = self.head else {
            return;
        };
        let misplaced = [
            self.attributes.slot.map(|(_, span)| span),
            self.attributes.reads.map(|(_, span)| span),
            self.attributes.buffer.map(|(_, span)| span),
            self.attributes.write,
            self.attributes.timing.map(|(_, span)| span),
            self.attributes.format.map(|(_, span)| span),
        ];
        if let Some(misplaced) = misplaced.into_iter().flatten().next() {
            self.error(
                misplaced,
                "this attribute belongs to a definition, not to an output",
            );
        }
        self.set_sources();
        if let Some(output) = output {
            let last = self.open.assignments.last();
            self.open.disordered |= last.is_some_and(|last| last.output >= output);
            self.open.assignments.push(PendingAssignment {
                output,
                operand,
                sources: self.attributes.sources(),
                home: self.attributes.home.map(|(word, _)| word),
                history: self
                    .attributes
                    .history
                    .map_or(History::NONE, |(history, _)| history),
                span,
                nodes: self.start..self.open.node_count(),
            });
        }
        self.next_statement();
    }
}
