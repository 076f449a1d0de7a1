//! Lines and columns of a text.

use super::token::SourceSpan;
use robovec_ir::SourcePlace;

/// Finds lines and columns; fast for requests in ascending order.
#[derive(Debug)]
pub struct LineIndex<'t> {
    text: &'t str,
    starts: Vec<u32>,
    /// The line found last, from 0.
    line: usize,
    /// The byte counted last, and its column, from 0: a line is counted once.
    counted: (u32, u32),
    ascii: bool,
    file: u32,
}

impl<'t> LineIndex<'t> {
    /// The lines of a text, whose file has this number.
    pub fn new(text: &'t str, file: u32) -> LineIndex<'t> {
        let breaks = memchr::memchr_iter(b'\n', text.as_bytes());
        let after_breaks = breaks.map(|at| at as u32 + 1);
        LineIndex {
            text,
            starts: std::iter::once(0).chain(after_breaks).collect(),
            line: 0,
            counted: (0, 0),
            ascii: text.is_ascii(),
            file,
        }
    }

    fn seek(&mut self, byte: u32) {
        if byte < self.starts[self.line] {
            self.line = self.starts.partition_point(|&start| start <= byte) - 1;
        }
        while self
            .starts
            .get(self.line + 1)
            .is_some_and(|&start| start <= byte)
        {
            self.line += 1;
        }
    }

    /// Line and column of a byte, both from 1.
    pub(crate) fn location(&mut self, byte: u32) -> (u32, u32) {
        self.seek(byte);
        let start = self.starts[self.line];
        let column = if self.ascii {
            byte - start
        } else {
            let (from, known) = match self.counted {
                (from, known) if from >= start && from <= byte => (from, known),
                _ => (start, 0),
            };
            let between = self.text.get(from as usize..byte as usize);
            let column = known + between.map_or(0, |text| text.chars().count() as u32);
            self.counted = (byte, column);
            column
        };
        (self.line as u32 + 1, column + 1)
    }

    /// The place of a span that is not empty.
    pub fn place(&mut self, span: SourceSpan) -> SourcePlace {
        let (line, column) = self.location(span.start);
        let (end_line, after) = self.location(span.end.max(span.start + 1));
        SourcePlace {
            file: self.file,
            line,
            column,
            end_line,
            end_column: after.saturating_sub(1).max(1),
        }
    }
}
