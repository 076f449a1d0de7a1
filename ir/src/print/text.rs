//! The buffer text is written through.
//!
//! The formatting machinery of the standard library would cost more than all
//! passes together on a function of 600,000 operations, so integers and names
//! are appended by hand and the buffer goes out in large pieces.

use super::HEADER;
use crate::function::Array;
use crate::module::Tables;
use std::io;

const FLUSH_AT: usize = 1 << 16;

pub(super) struct Text<'w> {
    buffer: String,
    writer: &'w mut dyn io::Write,
}

impl<'w> Text<'w> {
    pub(super) fn new(writer: &'w mut dyn io::Write) -> Text<'w> {
        Text {
            buffer: String::with_capacity(FLUSH_AT + 4096),
            writer,
        }
    }

    pub(super) fn file_header(&mut self, tables: &Tables) {
        self.push(HEADER);
        self.push("\n");
        for (index, file) in tables.sources.files.iter().enumerate() {
            self.push("source ");
            self.integer(index as u32);
            self.push(" ");
            self.quoted(file);
            self.push("\n");
        }
    }

    pub(super) fn push(&mut self, text: &str) {
        self.buffer.push_str(text);
    }

    pub(super) fn integer(&mut self, mut number: u32) {
        let mut digits = [0u8; 10];
        let mut start = digits.len();
        loop {
            start -= 1;
            digits[start] = b'0' + (number % 10) as u8;
            number /= 10;
            if number == 0 {
                break;
            }
        }
        for &digit in &digits[start..] {
            self.buffer.push(digit as char);
        }
    }

    pub(super) fn quoted(&mut self, text: &str) {
        self.buffer.push('"');
        for character in text.chars() {
            match character {
                '"' => self.buffer.push_str("\\\""),
                '\\' => self.buffer.push_str("\\\\"),
                '\n' => self.buffer.push_str("\\n"),
                '\r' => self.buffer.push_str("\\r"),
                '\t' => self.buffer.push_str("\\t"),
                other => self.buffer.push(other),
            }
        }
        self.buffer.push('"');
    }

    pub(super) fn number(&mut self, number: f64) {
        self.buffer.push_str(&format!("{number:?}"));
    }

    pub(super) fn element(&mut self, tables: &Tables, array: &Array, indices: &[u32]) {
        self.push(tables.symbols.text(array.name));
        if let Some((first, rest)) = indices.split_first() {
            self.push("[");
            self.integer(*first);
            for index in rest {
                self.push(",");
                self.integer(*index);
            }
            self.push("]");
        }
    }

    pub(super) fn end_line(&mut self) -> io::Result<()> {
        self.buffer.push('\n');
        if self.buffer.len() >= FLUSH_AT {
            self.writer.write_all(self.buffer.as_bytes())?;
            self.buffer.clear();
        }
        Ok(())
    }

    pub(super) fn finish(self) -> io::Result<()> {
        self.writer.write_all(self.buffer.as_bytes())
    }
}
