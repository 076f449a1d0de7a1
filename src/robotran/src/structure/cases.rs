//! The cases of sensors, and the exits from them.

use super::{BlockKind, Cutter, OpenBlock};
use crate::Language;
use crate::explain::refusal;
use crate::token::SourceSpan;

impl Cutter<'_> {
    /// The number of a condition `isens == 3`.
    pub(super) fn sensor_case(&self, span: SourceSpan) -> Option<u32> {
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

    /// A `return`: nothing after it in the function is reached. Within a case
    /// it would also skip the statements after all cases.
    pub(super) fn give_back(&mut self, span: SourceSpan) {
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
                    "skips the equations after the cases",
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

    fn misplaced(&mut self, span: SourceSpan) {
        self.errors.push(refusal(
            "a case outside a switch",
            span,
            "no `switch` is open here",
            "put it inside `switch(isens)`",
        ));
    }

    pub(super) fn case(&mut self, number: u32, span: SourceSpan) {
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

    pub(super) fn default_case(&mut self, span: SourceSpan) {
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

    pub(super) fn leave(&mut self) {
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
}
