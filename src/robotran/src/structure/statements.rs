//! Effect of each statement on the open blocks.

use super::{BlockKind, Cutter, FunctionBlock, OpenBlock, Region, StatementRun};
use crate::Language;
use crate::explain::refusal;
use crate::syntax::{StatementKind, SyntaxStatement};
use crate::token::SourceSpan;

impl Cutter<'_> {
    pub(super) fn statement(&mut self, index: usize, column: u32) {
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
            StatementKind::If | StatementKind::ElseIf | StatementKind::Else => {
                let block = self.condition(kind, span);
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

    /// The block that a condition, or the statement after one, opens.
    fn condition(&mut self, kind: StatementKind, span: SourceSpan) -> BlockKind {
        if matches!(kind, StatementKind::If) {
            return match self.sensor_case(span) {
                Some(number) => BlockKind::SensorCase(number),
                None => BlockKind::Control(span),
            };
        }
        self.close_for_else();
        let chain = self.chain.take();
        if matches!(kind, StatementKind::Else) {
            return match chain {
                Some(chain) => BlockKind::Others(chain),
                None => BlockKind::Control(span),
            };
        }
        match (self.sensor_case(span), chain) {
            (Some(number), Some(chain)) if !chain.contains(&number) => {
                self.earlier = chain;
                BlockKind::SensorCase(number)
            }
            (Some(_), Some(_)) => BlockKind::Dead,
            _ => BlockKind::Control(span),
        }
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

    /// True where a condition is in an `else` that this case does not reach.
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
}
