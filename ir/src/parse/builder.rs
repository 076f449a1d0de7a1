//! The state of the reader, which the actions of the grammar change.
//!
//! There is always a function being read: outside the braces it is a discarded
//! one, so that no action needs a test. Nodes are pushed as their expressions
//! are reduced; the head of a statement shows where its nodes start, its end
//! gives the last of them the name.

use super::VerificationTarget;
use super::names::{NameTable, Recent};
use super::parts::{Attributes, FastMap, Head, PendingAssignment, PendingPreload, Span, Undefined};
use super::problems::{Problems, also, error};
use crate::diagnostic::{Diagnostic, clip};
use crate::entity::Value;
use crate::function::{Function, Level};
use crate::history::History;
use crate::module::Module;
use crate::placement::Write;
use crate::source::SourceSet;
use robovec_num::fnv::Fnv;
use robovec_num::limits::NumberLimit;

/// Cycles of a schedule, and times of values.
pub(super) const CYCLE: NumberLimit = NumberLimit::whole(
    0,
    1 << 30,
    "images have a line for every cycle, and sums of cycles are numbers of 32 bits",
);

/// Addresses of memories and buffers.
pub(super) const ADDRESS: NumberLimit = NumberLimit::whole(
    0,
    1 << 24,
    "images have a line for every word, and the simulator loads 2^24 words",
);

/// Elements of a kind in a schedule.
pub(super) const ELEMENT: NumberLimit = crate::machine::fields::count::LIMIT;

/// The function being read.
pub(super) struct Open<'t> {
    pub(super) function: Function,
    /// The `function` line; `None` outside the braces.
    pub(super) head: Option<Span>,
    /// The number of errors before it.
    pub(super) problems_before: usize,
    pub(super) inputs: FastMap<&'t str, usize>,
    pub(super) outputs: FastMap<&'t str, usize>,
    /// Arrays whose declaration was refused: their uses are no errors.
    pub(super) broken: FastMap<&'t str, ()>,
    pub(super) input_spans: Vec<Span>,
    pub(super) output_spans: Vec<Span>,
    pub(super) boundary_spans: Vec<Span>,
    pub(super) schedule_span: Span,
    /// The place of each node: an expression, or a definition from its name
    /// to the end of its expression.
    pub(super) spans: Vec<Span>,
    pub(super) sets: FastMap<u32, (SourceSet, Span)>,
    pub(super) histories: FastMap<u32, (History, Span)>,
    pub(super) assignments: Vec<PendingAssignment>,
    /// The place where each output element was first set.
    pub(super) written: FastMap<u32, Span>,
    pub(super) preloads: Vec<PendingPreload>,
    pub(super) undefined: Undefined,
    /// True when the nodes are not yet in the order of the text form.
    pub(super) disordered: bool,
}

impl Open<'_> {
    pub(super) fn new(name: &str, level: Level, head: Option<Span>) -> Self {
        Open {
            function: Function::new(name, level),
            head,
            problems_before: 0,
            inputs: FastMap::default(),
            outputs: FastMap::default(),
            broken: FastMap::default(),
            input_spans: Vec::new(),
            output_spans: Vec::new(),
            boundary_spans: Vec::new(),
            schedule_span: Span::default(),
            spans: Vec::new(),
            sets: FastMap::default(),
            histories: FastMap::default(),
            assignments: Vec::new(),
            written: FastMap::default(),
            preloads: Vec::new(),
            undefined: Undefined::default(),
            disordered: false,
        }
    }

    pub(super) fn node_count(&self) -> u32 {
        self.function.nodes().len() as u32
    }

    /// The place of the name of a defined value.
    pub(super) fn name_span(&self, value: Value, text: &str) -> Span {
        let span = self.spans[value.index()];
        let length = text[span.range()]
            .find(|character: char| character.is_whitespace() || character == '=')
            .unwrap_or(span.range().len());
        Span::new(span.start, span.start + length as u32)
    }
}

/// The parts of the module read so far.
pub(super) struct ModuleBuilder<'t> {
    pub(super) text: &'t str,
    pub(super) module: Module,
    pub(super) problems: Problems,
    pub(super) functions: FastMap<&'t str, Span>,
    pub(super) open: Open<'t>,
    pub(super) names: NameTable,
    pub(super) recent: Recent<'t>,
    /// Number of nodes before the statement being read.
    pub(super) start: u32,
    pub(super) head: Head,
    pub(super) attributes: Attributes,
    pub(super) writes: Vec<Write>,
    pub(super) members: Vec<SourceSet>,
    pub(super) arguments: Vec<String>,
    pub(super) kinds: Vec<(Span, u32)>,
    pub(super) machine_hash: Option<Fnv>,
    /// The machine that placements are verified against.
    pub(super) target: Option<VerificationTarget<'t>>,
}

impl<'t> ModuleBuilder<'t> {
    pub(super) fn new(text: &'t str) -> ModuleBuilder<'t> {
        ModuleBuilder {
            text,
            module: Module::new(),
            problems: Problems::default(),
            functions: FastMap::default(),
            open: Open::new("", Level::Equations, None),
            names: NameTable::default(),
            recent: Recent::new(),
            start: 0,
            head: Head::Other,
            attributes: Attributes::default(),
            writes: Vec::new(),
            members: Vec::new(),
            arguments: Vec::new(),
            kinds: Vec::new(),
            machine_hash: None,
            target: None,
        }
    }

    /// The text of a token.
    pub(super) fn slice(&self, span: Span) -> &'t str {
        &self.text[span.range()]
    }

    /// Records an error.
    pub(super) fn error(&mut self, span: Span, message: impl Into<String>) {
        self.problems.push(error(span, message));
    }

    /// Records an error with advice.
    pub(super) fn advise(&mut self, span: Span, message: impl Into<String>, help: &str) {
        let diagnostic = error(span, message).with_note(format!("help: {help}"));
        self.problems.push(diagnostic);
    }

    /// Records an error that refers to a second place.
    pub(super) fn conflict(
        &mut self,
        span: Span,
        message: impl Into<String>,
        first: Span,
        label: &str,
    ) {
        let diagnostic = error(span, message).with_label(also(first, label));
        self.problems.push(diagnostic);
    }

    /// True when no further error would be shown.
    pub(super) fn is_full(&self) -> bool {
        self.problems.is_full()
    }

    /// A whole number of 32 bits; 0 after an error.
    pub(super) fn integer(&mut self, span: Span) -> u32 {
        let digits = self.slice(span);
        match digits.parse() {
            Ok(number) => number,
            Err(_) => {
                self.error(span, format!("the number {} is too large", clip(digits)));
                0
            }
        }
    }

    /// An integer within a limit.
    pub(super) fn limited(&mut self, span: Span, what: &str, limit: NumberLimit) -> u32 {
        let digits = self.slice(span);
        match limit.read_whole(digits) {
            Ok(number) => number as u32,
            Err(reason) => {
                self.error(span, format!("the {what} {reason}"));
                0
            }
        }
    }

    /// The content of a quoted text.
    pub(super) fn string(&mut self, span: Span) -> String {
        let quoted = self.slice(span);
        let inner = &quoted[1..quoted.len() - 1];
        if !inner.contains('\\') {
            return inner.to_owned();
        }
        let mut content = String::with_capacity(inner.len());
        let mut characters = inner.chars();
        while let Some(character) = characters.next() {
            if character != '\\' {
                content.push(character);
                continue;
            }
            match characters.next() {
                Some('n') => content.push('\n'),
                Some('r') => content.push('\r'),
                Some('t') => content.push('\t'),
                Some(same @ ('"' | '\\')) => content.push(same),
                other => {
                    let shown = other.map(String::from).unwrap_or_default();
                    self.advise(
                        span,
                        format!("a text in quotes has no '\\{shown}'"),
                        "what can follow a backslash is n, r, t, \" or another backslash",
                    );
                    return content;
                }
            }
        }
        content
    }

    /// Discards the parts of a statement read so far.
    pub(super) fn next_statement(&mut self) {
        self.head = Head::Other;
        self.start = self.open.node_count();
        self.attributes = Attributes::default();
        self.writes.clear();
        self.members.clear();
        self.arguments.clear();
        self.kinds.clear();
        self.machine_hash = None;
    }

    /// The module, or the faults of the text.
    pub(super) fn finish(mut self) -> Result<Module, Vec<Diagnostic>> {
        if let Some(head) = self.open.head {
            if !self.is_full() {
                let end = self.text.len() as u32;
                let diagnostic = error(Span::new(end, end), "the text ends inside a function")
                    .with_label(also(head, "the function starts here"))
                    .with_note("help: a function ends with '}' on a separate line");
                self.problems.push(diagnostic);
            }
            self.close_function();
        }
        if self.problems.is_empty() {
            Ok(self.module)
        } else {
            Err(self.problems.into_sorted())
        }
    }
}
