//! Blocks: which statements belong to which function, sensor case or part.
//!
//! The grammar gives a flat list of statements. Here it is cut into runs of
//! straight-line statements, with an explicit stack of the open blocks.

use super::Language;
use super::explain::refusal;
use super::places::LineIndex;
use super::syntax::{StatementKind, SyntaxStatement, SyntaxTree};
use super::token::{RobotranName, SourceSpan};
use robovec_ir::Symbols;
use robovec_ir::diagnostic::{Diagnostic, Label};
use std::ops::Range;

/// Where a run of statements stands.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Region {
    /// Outside any control structure.
    Common,
    /// In these cases of `switch(isens)`.
    Cases(Vec<u32>),
    /// In the `else` behind conditions on these cases: in all others.
    Others(Vec<u32>),
    /// In a loop or a condition, whose head this is.
    Control(SourceSpan),
    /// Where control never comes: `default`, or behind a `return`.
    Dead,
}

/// Consecutive statements of one region.
#[derive(Clone, Debug)]
pub(super) struct StatementRun {
    pub(super) region: Region,
    pub(super) statements: Range<usize>,
}

/// A function of the file.
#[derive(Clone, Debug)]
pub(super) struct FunctionBlock {
    /// The entry of [`SyntaxTree::heads`]; `None` for a file without a head.
    pub(super) head: Option<u32>,
    pub(super) span: SourceSpan,
    pub(super) runs: Vec<StatementRun>,
}

impl FunctionBlock {
    pub(super) fn has_control(&self) -> bool {
        let mut regions = self.runs.iter().map(|run| &run.region);
        regions.any(|region| matches!(region, Region::Control(_)))
    }

    /// The sensor cases, in order of appearance.
    pub(super) fn cases(&self) -> Vec<u32> {
        let mut cases = Vec::new();
        let mut known = hashbrown::HashSet::new();
        for run in &self.runs {
            if let Region::Cases(numbers) = &run.region {
                cases.extend(numbers.iter().copied().filter(|&case| known.insert(case)));
            }
        }
        cases
    }
}

#[derive(Clone, Debug)]
enum BlockKind {
    Function,
    /// Braces that mean nothing more.
    Plain,
    Switch {
        cases: Vec<u32>,
        dead: bool,
        /// The current case has statements.
        filled: bool,
    },
    SensorCase(u32),
    /// The `else` behind the conditions on these cases.
    Others(Vec<u32>),
    Control(SourceSpan),
    Dead,
}

struct OpenBlock {
    block: BlockKind,
    /// Where it starts: its column in Python, its statement's span for errors.
    column: u32,
    span: SourceSpan,
    /// True for the body of an `if` without braces.
    single: bool,
    /// The place in the stack of the innermost block that is not plain.
    meaning: usize,
    /// Inside a switch or a sensor case; inside a loop or condition.
    inside: (bool, bool),
}

/// Cuts a file into functions.
pub(super) fn functions(
    syntax: &SyntaxTree,
    language: Language,
    places: &mut LineIndex<'_>,
    symbols: &Symbols,
    text: &str,
) -> Result<Vec<FunctionBlock>, Vec<Diagnostic>> {
    let mut cutter = Cutter {
        syntax,
        language,
        symbols,
        text,
        functions: Vec::new(),
        stack: Vec::new(),
        pending: None,
        returned: false,
        chain: None,
        earlier: Vec::new(),
        current: None,
        errors: Vec::new(),
    };
    for index in 0..syntax.statements.len() {
        let column = match language {
            Language::Python => places.location(syntax.statements[index].span.start).1,
            Language::C | Language::Matlab => 0,
        };
        cutter.statement(index, column);
        if cutter.errors.len() >= super::ERROR_LIMIT {
            break;
        }
    }
    cutter.finish()
}

struct Cutter<'a> {
    syntax: &'a SyntaxTree,
    language: Language,
    symbols: &'a Symbols,
    text: &'a str,
    functions: Vec<FunctionBlock>,
    stack: Vec<OpenBlock>,
    /// A block whose `{` is to come, or its only statement.
    pending: Option<(BlockKind, SourceSpan)>,
    returned: bool,
    /// The cases of the conditions that the statement before closed, to which
    /// an `else` may belong.
    chain: Option<Vec<u32>>,
    /// The cases of the conditions before the one whose block is open.
    earlier: Vec<u32>,
    current: Option<StatementRun>,
    errors: Vec<Diagnostic>,
}

impl Cutter<'_> {
    fn statement(&mut self, index: usize, column: u32) {
        let SyntaxStatement { kind, span, .. } = self.syntax.statements[index];
        if self.language == Language::Python {
            self.close_to_column(column);
        }
        if !matches!(kind, StatementKind::BlockOpen) {
            self.open_pending_without_brace();
        }
        if !matches!(
            kind,
            StatementKind::BlockOpen
                | StatementKind::BlockClose
                | StatementKind::Else
                | StatementKind::ElseIf
        ) {
            self.chain = None;
        }
        match kind {
            StatementKind::Head(head) => self.head(index, head, span, column),
            StatementKind::BlockOpen => {
                let (block, from) = self.pending.take().unwrap_or((BlockKind::Plain, span));
                self.open(block, 0, from, false);
            }
            StatementKind::BlockClose => self.block_close(span),
            StatementKind::Switch(name) => self.block(
                BlockKind::Switch {
                    cases: Vec::new(),
                    dead: false,
                    filled: false,
                },
                span,
                column,
                Some(name),
            ),
            StatementKind::Case(number) => self.case(number, span),
            StatementKind::DefaultCase => self.default_case(span),
            StatementKind::Break => self.leave(),
            StatementKind::Return => {
                self.give_back(span);
                self.close_single();
            }
            StatementKind::While => self.block(BlockKind::Control(span), span, column, None),
            StatementKind::If => {
                let block = match self.sensor_case(span) {
                    Some(number) => BlockKind::SensorCase(number),
                    None => BlockKind::Control(span),
                };
                self.block(block, span, column, None);
            }
            StatementKind::ElseIf => {
                self.close_for_else();
                let chain = self.chain.take();
                let block = match (self.sensor_case(span), chain) {
                    (Some(number), Some(chain)) if !chain.contains(&number) => {
                        self.earlier = chain;
                        BlockKind::SensorCase(number)
                    }
                    (Some(_), Some(_)) => BlockKind::Dead,
                    _ => BlockKind::Control(span),
                };
                self.block(block, span, column, None);
            }
            StatementKind::Else => {
                self.close_for_else();
                let block = match self.chain.take() {
                    Some(chain) => BlockKind::Others(chain),
                    None => BlockKind::Control(span),
                };
                self.block(block, span, column, None);
            }
            StatementKind::Equation { .. }
            | StatementKind::Call(_)
            | StatementKind::Extent(_)
            | StatementKind::Counter(_)
            | StatementKind::Pointer(_)
            | StatementKind::Prologue => {
                self.plain(index, span);
                self.close_single();
            }
        }
    }

    /// The number of a condition `isens == 3`.
    fn sensor_case(&self, span: SourceSpan) -> Option<u32> {
        let text = self.text.get(span.range())?;
        let condition = text.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let bare: String = condition
            .chars()
            .filter(|c| !c.is_whitespace() && !matches!(c, '(' | ')' | ':'))
            .collect();
        let number = bare.strip_prefix("isens==")?;
        // `010` is 8 in C, and no number in Python.
        let decimal = number.len() == 1 || !number.starts_with('0');
        number.parse().ok().filter(|_| decimal)
    }

    /// A `return`: nothing behind it in the function is reached. Within a case
    /// it would also skip what stands behind all cases.
    fn give_back(&mut self, span: SourceSpan) {
        let innermost = self.stack.last().map(|open| open.meaning);
        match innermost.map(|place| &self.stack[place].block) {
            Some(BlockKind::Function) => {
                self.end_run();
                self.returned = true;
            }
            Some(
                BlockKind::Switch { dead: false, .. }
                | BlockKind::SensorCase(_)
                | BlockKind::Others(_),
            ) => {
                self.errors.push(refusal(
                    "a `return` within the equations of a sensor",
                    span,
                    "skips what stands behind the cases",
                    "end the case with `break`, or remove the `return`",
                ));
                self.leave();
            }
            Some(
                BlockKind::Plain
                | BlockKind::Switch { .. }
                | BlockKind::Control(_)
                | BlockKind::Dead,
            )
            | None => {}
        }
    }

    /// Matlab closes `if`, `elseif`, `else` by one `end`.
    fn close_for_else(&mut self) {
        if self.language == Language::Matlab
            && matches!(
                self.stack.last(),
                Some(OpenBlock {
                    block: BlockKind::SensorCase(_)
                        | BlockKind::Others(_)
                        | BlockKind::Control(_)
                        | BlockKind::Dead,
                    ..
                })
            )
        {
            self.close();
        }
    }

    fn head(&mut self, index: usize, head: u32, span: SourceSpan, column: u32) {
        if self.language == Language::C {
            let next = self.syntax.statements.get(index + 1).map(|next| next.kind);
            if !matches!(next, Some(StatementKind::BlockOpen)) {
                return; // A prototype.
            }
        }
        if self.language == Language::Matlab {
            while matches!(
                self.stack.last(),
                Some(OpenBlock {
                    block: BlockKind::Function,
                    ..
                })
            ) {
                self.close();
            }
        }
        if !self.stack.is_empty() {
            self.errors.push(refusal(
                "a function inside another block",
                span,
                "starts here",
                "close the block before, or move the function out of it",
            ));
            return;
        }
        self.end_run();
        self.returned = false;
        self.functions.push(FunctionBlock {
            head: Some(head),
            span,
            runs: Vec::new(),
        });
        match self.language {
            Language::C => self.pending = Some((BlockKind::Function, span)),
            Language::Matlab | Language::Python => {
                self.open(BlockKind::Function, column, span, false)
            }
        }
    }

    fn block(
        &mut self,
        block: BlockKind,
        span: SourceSpan,
        column: u32,
        selector: Option<RobotranName>,
    ) {
        let outer = self.stack.last();
        let (nested, inside_control) = outer.map_or((false, false), |open| open.inside);
        let sensor = matches!(block, BlockKind::SensorCase(_) | BlockKind::Switch { .. });
        if nested || (sensor && inside_control) {
            self.errors.push(refusal(
                "nested control flow around sensor cases",
                span,
                "starts here",
                "each case of a sensor file must be straight-line code",
            ));
        } else if matches!(block, BlockKind::Control(_)) && !self.may_decide() {
            self.errors.push(refusal(
                "a condition or loop around equations",
                span,
                "robovec compiles straight-line code, and this decides what is computed",
                "write the function without it; only the reduced functions (accelred, invdynared) are cut into parts at their loops",
            ));
        }
        let parameters = self
            .functions
            .last()
            .and_then(|function| function.head)
            .map(|head| &self.syntax.heads[head as usize].parameters);
        if let (Some(name), Some(parameters)) = (selector, parameters)
            && !parameters.contains(&name)
        {
            self.errors.push(refusal(
                "a switch over something that is not a parameter",
                span,
                "only the number of the sensor can select equations",
                "write the equations out without the switch",
            ));
        }
        match self.language {
            Language::C => self.pending = Some((block, span)),
            Language::Matlab | Language::Python => self.open(block, column, span, false),
        }
    }

    /// True outside functions, and in those that are cut into parts at loops
    /// and conditions: Robotran closes the loops of a model in them.
    fn may_decide(&self) -> bool {
        if self.stack.is_empty() {
            return !self.syntax.heads.is_empty();
        }
        let head = self.functions.last().and_then(|function| function.head);
        head.is_some_and(|head| {
            let name = self.symbols.text(self.syntax.heads[head as usize].name);
            matches!(
                name.strip_prefix("mbs_").unwrap_or(name),
                "accelred" | "invdynared"
            )
        })
    }

    fn open(&mut self, block: BlockKind, column: u32, span: SourceSpan, single: bool) {
        self.end_run();
        let outer = self.stack.last();
        let (sensor, control) = outer.map_or((false, false), |open| open.inside);
        let is_sensor = matches!(block, BlockKind::SensorCase(_) | BlockKind::Switch { .. });
        let is_control = matches!(block, BlockKind::Control(_));
        let meaning = match (&block, outer) {
            (BlockKind::Plain, Some(outer)) => outer.meaning,
            _ => self.stack.len(),
        };
        self.stack.push(OpenBlock {
            block,
            column,
            span,
            single,
            meaning,
            inside: (sensor || is_sensor, control || is_control),
        });
    }

    fn close(&mut self) {
        self.end_run();
        match self.stack.pop().map(|open| open.block) {
            Some(BlockKind::Function) => self.returned = false,
            Some(BlockKind::SensorCase(number)) => {
                let mut chain = std::mem::take(&mut self.earlier);
                chain.push(number);
                self.chain = Some(chain);
            }
            // `else if` of C: a condition within an `else`.
            Some(BlockKind::Others(mut chain)) => {
                chain.extend(self.chain.take().unwrap_or_default());
                self.chain = Some(chain);
            }
            Some(
                BlockKind::Plain
                | BlockKind::Switch { .. }
                | BlockKind::Control(_)
                | BlockKind::Dead,
            )
            | None => {}
        }
    }

    fn open_pending_without_brace(&mut self) {
        if let Some((block, span)) = self.pending.take() {
            self.open(block, 0, span, true);
        }
    }

    fn close_single(&mut self) {
        while matches!(self.stack.last(), Some(open) if open.single) {
            self.close();
        }
    }

    fn close_to_column(&mut self, column: u32) {
        while matches!(self.stack.last(), Some(open) if open.column >= column) {
            self.close();
        }
    }

    fn block_close(&mut self, span: SourceSpan) {
        if self.stack.is_empty() {
            self.errors.push(refusal(
                "this closes nothing",
                span,
                "no block is open here",
                "remove it, or look for a block that was closed too early",
            ));
            return;
        }
        self.close();
        self.close_single();
    }

    fn misplaced(&mut self, span: SourceSpan) {
        self.errors.push(refusal(
            "a case outside a switch",
            span,
            "no `switch` is open here",
            "put it inside `switch(isens)`",
        ));
    }

    fn case(&mut self, number: u32, span: SourceSpan) {
        self.end_run();
        let fresh = self.language == Language::Matlab;
        match self.stack.last_mut() {
            Some(OpenBlock {
                block:
                    BlockKind::Switch {
                        cases,
                        dead,
                        filled,
                    },
                ..
            }) => {
                if fresh || *dead {
                    cases.clear();
                } else if *filled {
                    self.errors.push(refusal(
                        "a case that runs into the next one",
                        span,
                        "the case before has no `break`",
                        "end every case with `break;`",
                    ));
                    return;
                }
                cases.push(number);
                *dead = false;
                *filled = false;
            }
            _ => self.misplaced(span),
        }
    }

    fn default_case(&mut self, span: SourceSpan) {
        self.end_run();
        let runs_on = self.language != Language::Matlab;
        match self.stack.last_mut() {
            // A case without `break` runs into the statements of `default`.
            Some(OpenBlock {
                block: BlockKind::Switch { cases, dead, .. },
                ..
            }) if runs_on && !*dead && !cases.is_empty() => {}
            Some(OpenBlock {
                block: BlockKind::Switch { cases, dead, .. },
                ..
            }) => {
                cases.clear();
                *dead = true;
            }
            _ => self.misplaced(span),
        }
    }

    fn leave(&mut self) {
        self.end_run();
        let innermost = self.stack.last().map(|open| open.meaning);
        if let Some(OpenBlock {
            block: BlockKind::Switch { cases, dead, .. },
            ..
        }) = innermost.and_then(|place| self.stack.get_mut(place))
        {
            cases.clear();
            *dead = true;
        }
        self.close_single();
    }

    fn region(&self) -> Region {
        if self.returned {
            return Region::Dead;
        }
        let innermost = self.stack.last().map(|open| open.meaning);
        match innermost.map(|place| &self.stack[place].block) {
            None | Some(BlockKind::Function | BlockKind::Plain) => Region::Common,
            Some(BlockKind::Switch { cases, dead, .. }) if *dead || cases.is_empty() => {
                Region::Dead
            }
            Some(BlockKind::Switch { cases, .. }) => Region::Cases(cases.clone()),
            Some(BlockKind::SensorCase(number)) if self.excluded(innermost, *number) => {
                Region::Dead
            }
            Some(BlockKind::SensorCase(number)) => Region::Cases(vec![*number]),
            Some(BlockKind::Others(chain)) => Region::Others(chain.clone()),
            Some(BlockKind::Control(span)) => Region::Control(*span),
            Some(BlockKind::Dead) => Region::Dead,
        }
    }

    /// True where the block around a condition is an `else` that this case
    /// does not reach.
    fn excluded(&self, place: Option<usize>, number: u32) -> bool {
        let around = place
            .and_then(|place| place.checked_sub(1))
            .map(|below| &self.stack[self.stack[below].meaning].block);
        matches!(around, Some(BlockKind::Others(chain)) if chain.contains(&number))
    }

    fn plain(&mut self, index: usize, span: SourceSpan) {
        if let Some(run) = &mut self.current {
            run.statements.end = index + 1;
            return;
        }
        if self.functions.is_empty() && self.syntax.heads.is_empty() {
            self.functions.push(FunctionBlock {
                head: None,
                span,
                runs: Vec::new(),
            });
        }
        let outside = self.stack.is_empty() && !self.syntax.heads.is_empty();
        if outside {
            // Declarations may stand outside functions in C, calls in a
            // Python script; neither computes anything.
            if matches!(
                self.syntax.statements[index].kind,
                StatementKind::Equation { .. }
            ) {
                self.errors.push(refusal(
                    "an equation outside any function",
                    span,
                    "belongs to no function",
                    "move it into the function, or look for a block that was closed too early",
                ));
            }
            return;
        }
        let innermost = self.stack.last().map(|open| open.meaning);
        if let Some(OpenBlock {
            block: BlockKind::Switch { filled, .. },
            ..
        }) = innermost.and_then(|place| self.stack.get_mut(place))
        {
            *filled = true;
        }
        self.current = Some(StatementRun {
            region: self.region(),
            statements: index..index + 1,
        });
    }

    fn end_run(&mut self) {
        if let (Some(run), Some(function)) = (self.current.take(), self.functions.last_mut()) {
            function.runs.push(run);
        }
    }

    fn finish(mut self) -> Result<Vec<FunctionBlock>, Vec<Diagnostic>> {
        self.end_run();
        let unclosed = match self.language {
            Language::C => self.pending.take().map(|(_, span)| span).or_else(|| {
                let last = self.stack.last();
                last.map(|open| open.span)
            }),
            Language::Matlab => {
                let mut inner = self.stack.iter().rev();
                inner
                    .find(|open| !matches!(open.block, BlockKind::Function))
                    .map(|open| open.span)
            }
            Language::Python => None,
        };
        if let Some(span) = unclosed {
            let end = self.text.len();
            self.errors.push(
                Diagnostic::error()
                    .with_message("the file ends inside a block")
                    .with_labels(vec![
                        Label::primary(0, span.range()).with_message("this is never closed"),
                        Label::secondary(0, end..end).with_message("the file ends here"),
                    ])
                    .with_note("the file is cut short; generate or copy it again"),
            );
        }
        if self.errors.is_empty() {
            Ok(self.functions)
        } else {
            Err(self.errors)
        }
    }
}
