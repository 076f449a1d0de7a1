//! Statements that come before the definitions: functions, arrays, places,
//! user calls, schedules.

use super::builder::{ADDRESS, CYCLE, ELEMENT, ModuleBuilder, Open};
use super::parts::{Indices, PendingPreload, Span};
use super::problems::{also, error};
use crate::diagnostic::{clip, did_you_mean};
use crate::entity::Operand;
use crate::function::{Boundary, Level, MAX_INPUT_ELEMENTS, MAX_OUTPUT_ELEMENTS, Shape};
use crate::history::{History, HistoryStep};
use crate::placement::{Address, Bank, Element, ElementKind, Placement, Schedule, Word};
use robovec_num::limits::{Amount, NumberLimit};

pub(super) const INPUT_ELEMENTS: NumberLimit = NumberLimit::whole(
    0,
    MAX_INPUT_ELEMENTS,
    "every evaluation, check and placement keeps hundreds of bytes for each",
);

pub(super) const OUTPUT_ELEMENTS: NumberLimit = NumberLimit::whole(
    0,
    MAX_OUTPUT_ELEMENTS,
    "a mass matrix of 2000 joints has fewer",
);

impl ModuleBuilder<'_> {
    /// `source 0 "file"`.
    pub(super) fn source(&mut self, number: Span, name: Span) {
        let index = self.integer(number);
        let expected = self.module.tables.sources.files.len();
        if index as usize != expected {
            self.advise(
                number,
                format!("the source files are not numbered in order: {index} is here"),
                &format!("the next source file is number {expected}"),
            );
        }
        let file = self.string(name);
        self.module.tables.sources.files.push(file);
        self.next_statement();
    }

    /// `function dirdyna equations {`.
    pub(super) fn begin_function(&mut self, name: Span, level: Span) {
        if let Some(head) = self.open.head {
            self.problems.push(
                error(name, "a function starts inside another")
                    .with_label(also(head, "this function has not ended"))
                    .with_note("help: a function ends with '}' on a separate line"),
            );
        }
        self.close_function();
        let text = self.slice(name);
        if let Some(first) = self.functions.insert(text, name) {
            let message = format!("there are two functions '{}'", clip(text));
            self.conflict(name, message, first, "the first one is here");
        }
        let word = self.slice(level);
        let level = Level::from_name(word).unwrap_or_else(|| {
            let nearest = did_you_mean(word, Level::ALL.map(Level::name));
            let help = match nearest {
                Some(nearest) => format!("did you mean '{nearest}'?"),
                None => "the levels are equations, atomic, scheduled and placed".to_owned(),
            };
            self.advise(level, format!("there is no level '{}'", clip(word)), &help);
            Level::Equations
        });
        self.open = Open::new(text, level, Some(name));
        self.open.problems_before = self.problems.len();
        self.next_statement();
    }

    /// `}`.
    pub(super) fn end_function(&mut self, start: u32) {
        if self.open.head.is_none() {
            self.error(
                Span::new(start, start + 1),
                "this brace closes nothing: no function is open",
            );
        }
        self.close_function();
        self.next_statement();
    }

    /// Complains about a statement outside the braces; true when it is
    /// inside.
    pub(super) fn inside(&mut self, span: Span) -> bool {
        if self.open.head.is_none() {
            self.advise(
                span,
                "this statement is outside any function",
                "a function begins with a line like 'function NAME equations {'",
            );
        }
        self.open.head.is_some()
    }

    /// `meta model "Suspension"`.
    pub(super) fn meta(&mut self, key: Span, content: Span) {
        if self.inside(key) {
            let entry = (self.slice(key).to_owned(), self.string(content));
            self.open.function.metadata.push(entry);
        }
        self.next_statement();
    }

    /// `1..6`: the last index.
    pub(super) fn extent(&mut self, low: Span, high: Span) -> u32 {
        if self.integer(low) != 1 {
            self.error(low, "the indices of an array start at 1");
        }
        self.integer(high)
    }

    /// `in q[1..6]`.
    pub(super) fn input(&mut self, name: Span, extents: Indices) {
        self.array(name, extents, true);
    }

    /// `out M[1..6,1..6]`.
    pub(super) fn output(&mut self, name: Span, extents: Indices) {
        self.array(name, extents, false);
    }

    fn array(&mut self, name: Span, extents: Indices, is_input: bool) {
        if !self.inside(name) {
            return self.next_statement();
        }
        let shape = match *extents.list() {
            [] => Shape::Scalar,
            [length] => Shape::Vector(length),
            [rows, columns, ..] => Shape::Matrix(rows, columns),
        };
        if extents.count > 2 {
            self.error(name, "an array has at most two indices");
        }
        let text = self.slice(name);
        let open = &mut self.open;
        let (kind, limit, table, spans, total) = if is_input {
            let total = open.function.input_len();
            let spans = &mut open.input_spans;
            ("input", INPUT_ELEMENTS, &mut open.inputs, spans, total)
        } else {
            let total = open.function.output_len();
            let spans = &mut open.output_spans;
            ("output", OUTPUT_ELEMENTS, &mut open.outputs, spans, total)
        };
        if let Some(&first) = table.get(text) {
            let first = spans[first];
            let message = format!("the {kind} array '{}' is declared twice", clip(text));
            self.conflict(name, message, first, "first declared here");
            return self.next_statement();
        }
        let elements = (total as u64).saturating_add(shape.len() as u64);
        if let Err(reason) = limit.check(Amount::Whole(elements)) {
            let message = format!("elements of all {kind} arrays: {reason}");
            open.broken.insert(text, ());
            self.error(name, message);
            return self.next_statement();
        }
        table.insert(text, spans.len());
        spans.push(name);
        let symbol = self.module.tables.symbols.intern(text);
        if is_input {
            open.function.add_input(symbol, shape);
        } else {
            open.function.add_output(symbol, shape);
        }
        self.next_statement();
    }

    /// `places !0 = @43:3-20 @57:3-31`, its places read before.
    pub(super) fn place_set(&mut self, number: Span) {
        if self.inside(number) {
            let digits = Span::new(number.start + 1, number.end);
            let index = self.integer(digits);
            let set = self.module.tables.sources.union(&self.members);
            if let Some((_, first)) = self.open.sets.insert(index, (set, number)) {
                let message = format!("the set of places !{index} is declared twice");
                self.conflict(number, message, first, "first declared here");
            }
        }
        self.next_statement();
    }

    /// `history 2 = 1 "balance" "rule"`, its rules read before.
    pub(super) fn step(&mut self, number: Span, before: Option<Span>, pass: Span, span: Span) {
        if self.inside(span) {
            let before = before.map_or(History::NONE, |before| self.history_of(before));
            let step = HistoryStep {
                before,
                pass: self.string(pass),
                rules: std::mem::take(&mut self.arguments),
            };
            let histories = self.open.function.histories.get_or_insert_default();
            let history = histories.add(step);
            let index = self.integer(number);
            if let Some((_, first)) = self.open.histories.insert(index, (history, number)) {
                let message = format!("the history {index} is declared twice");
                self.conflict(number, message, first, "first declared here");
            }
        }
        self.next_statement();
    }

    /// A quoted argument of a call, or a rule of a history.
    pub(super) fn argument(&mut self, argument: Span) {
        let content = self.string(argument);
        self.arguments.push(content);
    }

    /// `call "user_LinkForces"("Z1", "tsim") -> "Flink1" @40:3-50`.
    pub(super) fn boundary(&mut self, callee: Span, result: Option<Span>, span: Span) {
        if self.inside(span) {
            let boundary = Boundary {
                callee: self.string(callee),
                arguments: std::mem::take(&mut self.arguments),
                result: result.map(|result| self.string(result)),
                sources: self.attributes.sources(),
            };
            self.open.function.boundaries.push(boundary);
            self.open.boundary_spans.push(span);
        }
        self.next_statement();
    }

    /// `add*4` of a schedule.
    pub(super) fn kind(&mut self, name: Span, count: Span) {
        let count = self.limited(count, "number of elements", ELEMENT);
        self.kinds.push((name, count));
    }

    /// `(hash "2f1c…")` of a schedule.
    pub(super) fn machine_hash(&mut self, word: Span, hash: Span) {
        if self.slice(word) != "hash" {
            let message = format!(
                "'{}' is not a memory or processing element of a machine",
                clip(self.slice(word))
            );
            self.advise(word, message, "write '(hash \"…\")', or leave it out");
            return;
        }
        match self.string(hash).parse() {
            Ok(found) => self.machine_hash = Some(found),
            Err(error) => {
                let help = "leave it out where it is not known: the machine is then the one of \
                            the name";
                self.advise(hash, format!("this is not a hash: {error}"), help);
            }
        }
    }

    /// `schedule "thesis" (hash "2f1c…") add*4 multi*4 cycles 806 bound 799`.
    pub(super) fn schedule(&mut self, machine: Span, cycles: Span, bound: Span, span: Span) {
        let level = self.open.function.level;
        let machine_hash = self.machine_hash.take();
        if self.inside(span) && level < Level::Scheduled {
            self.error(
                span,
                format!("a function of the level {level} has no schedule"),
            );
        } else if self.open.function.schedule.is_some() {
            let first = self.open.schedule_span;
            self.conflict(span, "there are two schedules", first, "the first one");
        } else {
            let kinds = std::mem::take(&mut self.kinds).into_iter();
            self.open.schedule_span = span;
            self.open.function.schedule = Some(Schedule {
                machine: self.string(machine),
                machine_hash,
                kinds: kinds
                    .map(|(name, count)| ElementKind {
                        name: self.slice(name).to_owned(),
                        count,
                    })
                    .collect(),
                slots: Vec::new(),
                cycles: self.limited(cycles, "number of cycles", CYCLE),
                lower_bound: self.limited(bound, "bound", CYCLE),
            });
            if level == Level::Placed {
                self.open.function.placement = Some(Placement {
                    write_starts: vec![0],
                    ..Placement::default()
                });
            }
        }
        self.next_statement();
    }

    /// `preload add0[3] = q[3]`; a value represents itself until all are
    /// known.
    pub(super) fn preload(
        &mut self,
        element: Span,
        address: Span,
        operand: Result<Operand, Span>,
        span: Span,
    ) {
        let level = self.open.function.level;
        if self.inside(span) && level < Level::Placed {
            let message = format!("a function of the level {level} has no memories to fill");
            self.error(span, message);
        } else if let Some(word) = self.word(element, address) {
            self.open.preloads.push(PendingPreload {
                word,
                operand,
                span,
            });
        }
        self.next_statement();
    }

    /// A memory word, `add0[13]` or `add0.left[3]`.
    pub(super) fn word(&mut self, element: Span, address: Span) -> Option<Word> {
        let text = self.slice(element);
        let (name, bank) = match text.split_once('.') {
            None => (element, Bank::Unified),
            Some((name, side)) => {
                let bank = match side {
                    "left" => Bank::Left,
                    "right" => Bank::Right,
                    _ => {
                        let message = format!("there is no memory '{}'", clip(text));
                        let help = "the memories of a side-split element are '.left' and '.right'";
                        self.advise(element, message, help);
                        return None;
                    }
                };
                let end = element.start + name.len() as u32;
                (Span::new(element.start, end), bank)
            }
        };
        Some(Word {
            element: self.element(name)?,
            bank,
            address: Address::new(self.limited(address, "address", ADDRESS)),
        })
    }

    /// A processing element, `add0`.
    pub(super) fn element(&mut self, span: Span) -> Option<Element> {
        let text = self.slice(span);
        let Some(schedule) = &self.open.function.schedule else {
            self.advise(
                span,
                format!("the processing element '{}' is not declared", clip(text)),
                "a line like 'schedule \"thesis\" add*4 multi*4 cycles 806 bound 799' comes first",
            );
            return None;
        };
        let kind = text.trim_end_matches(|character: char| character.is_ascii_digit());
        let number = text[kind.len()..].parse().ok();
        let element = number.and_then(|number| schedule.element(kind, number));
        let canonical = !text[kind.len()..].starts_with('0') || text.len() == kind.len() + 1;
        if element.is_none() || !canonical {
            let known: Vec<String> = schedule
                .kinds
                .iter()
                .filter(|known| known.count > 0)
                .map(|known| match known.count {
                    1 => format!("{}0", known.name),
                    count => format!("{0}0 to {0}{1}", known.name, count - 1),
                })
                .collect();
            let message = format!("there is no processing element '{}'", clip(text));
            let declared = self.open.schedule_span;
            self.problems.push(
                error(span, message)
                    .with_label(also(declared, "the schedule"))
                    .with_note(format!("help: there are {}", known.join(", "))),
            );
            return None;
        }
        element
    }
}
