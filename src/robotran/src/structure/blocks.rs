//! Functions and blocks: where they open and close.

use super::{BlockKind, Cutter, FunctionBlock, OpenBlock};
use crate::Language;
use crate::explain::refusal;
use crate::syntax::StatementKind;
use crate::token::{RobotranName, SourceSpan};
use robovec_cgen::kind::bare_name;

/// The open flow around a block; none at the outermost level.
fn inside(outer: Option<&OpenBlock>) -> (bool, bool) {
    match outer {
        Some(open) => open.inside,
        None => (false, false),
    }
}

impl Cutter<'_> {
    /// Matlab closes `if`, `elseif`, `else` by one `end`.
    pub(super) fn close_for_else(&mut self) {
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

    pub(super) fn head(&mut self, index: usize, head: u32, span: SourceSpan, column: u32) {
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

    pub(super) fn block(
        &mut self,
        block: BlockKind,
        span: SourceSpan,
        column: u32,
        selector: Option<RobotranName>,
    ) {
        let outer = self.stack.last();
        let (nested, inside_control) = inside(outer);
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
                "remove it from the function; only the reduced functions (accelred, invdynared) are split at their loops",
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

    /// True outside functions, and in those that are cut at loops.
    fn may_decide(&self) -> bool {
        if self.stack.is_empty() {
            return !self.syntax.heads.is_empty();
        }
        let head = self.functions.last().and_then(|function| function.head);
        head.is_some_and(|head| {
            let name = self.symbols.text(self.syntax.heads[head as usize].name);
            matches!(bare_name(name), "accelred" | "invdynared")
        })
    }

    pub(super) fn open(&mut self, block: BlockKind, column: u32, span: SourceSpan, single: bool) {
        self.end_run();
        let outer = self.stack.last();
        let (sensor, control) = inside(outer);
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
        let closed = self.stack.pop().expect("a block is open");
        match closed.block {
            BlockKind::Function => self.returned = false,
            BlockKind::SensorCase(number) => {
                let mut chain = std::mem::take(&mut self.earlier);
                chain.push(number);
                self.chain = Some(chain);
            }
            // `else if` of C: a condition within an `else`.
            BlockKind::Others(mut chain) => {
                chain.extend(self.chain.take().into_iter().flatten());
                self.chain = Some(chain);
            }
            BlockKind::Plain
            | BlockKind::Switch { .. }
            | BlockKind::Control(_)
            | BlockKind::Dead => {}
        }
    }

    pub(super) fn open_pending_without_brace(&mut self) {
        if let Some((block, span)) = self.pending.take() {
            self.open(block, 0, span, true);
        }
    }

    pub(super) fn close_single(&mut self) {
        while matches!(self.stack.last(), Some(open) if open.single) {
            self.close();
        }
    }

    pub(super) fn close_to_column(&mut self, column: u32) {
        while matches!(self.stack.last(), Some(open) if open.column >= column) {
            self.close();
        }
    }

    pub(super) fn block_close(&mut self, span: SourceSpan) {
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
}
