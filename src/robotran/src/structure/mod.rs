//! Blocks: which statements belong to which function, sensor case or part.
//!
//! The grammar gives a flat list of statements. Here it is cut into runs of
//! straight-line statements, with an explicit stack of the open blocks.

mod blocks;
mod cases;
mod statements;

use super::Language;
use super::places::LineIndex;
use super::syntax::SyntaxTree;
use super::token::SourceSpan;
use robovec_ir::Symbols;
use robovec_ir::diagnostic::{Diagnostic, Label};
use std::ops::Range;

/// Place of a run of statements.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Region {
    /// Outside any control structure.
    Common,
    /// In these cases of `switch(isens)`.
    Cases(Vec<u32>),
    /// In the `else` after conditions on these cases: in all others.
    Others(Vec<u32>),
    /// In a loop or a condition, with the place of its head.
    Control(SourceSpan),
    /// Unreachable place: `default`, or after a `return`.
    Dead,
}

/// Consecutive statements of one region.
#[derive(Clone, Debug)]
pub(super) struct StatementRun {
    pub(super) region: Region,
    pub(super) statements: Range<usize>,
}

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

    /// Statements from the first run to the last.
    pub(super) fn statements(&self) -> Range<usize> {
        debug_assert!(
            self.runs
                .is_sorted_by(|one, next| one.statements.end <= next.statements.start),
            "runs are in the order of the file"
        );
        match &self.runs[..] {
            [] => 0..0,
            [first, ..] => {
                let last = self.runs.last().expect("there is a first run");
                first.statements.start..last.statements.end
            }
        }
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
    /// The `else` after the conditions on these cases.
    Others(Vec<u32>),
    Control(SourceSpan),
    Dead,
}

struct OpenBlock {
    block: BlockKind,
    /// Beginning: its column in Python, its statement's span for errors.
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
    /// Cases of the conditions just closed, to which an `else` may belong.
    chain: Option<Vec<u32>>,
    /// The cases of the conditions before the one whose block is open.
    earlier: Vec<u32>,
    current: Option<StatementRun>,
    errors: Vec<Diagnostic>,
}

impl Cutter<'_> {
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
