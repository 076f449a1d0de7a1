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

/// Room that is made at once: for a number, and more than a line takes.
const LEAST_ROOM: usize = 512;

/// Every number below a thousand as three digits, and a byte of filling, so
/// that all are copied in one step.
const GROUPS: [[u8; 4]; 1000] = {
    let mut groups = [[0; 4]; 1000];
    let mut number = 0;
    while number < groups.len() {
        let [hundreds, tens, ones] = [number / 100, number / 10 % 10, number % 10];
        groups[number] = [
            b'0' + hundreds as u8,
            b'0' + tens as u8,
            b'0' + ones as u8,
            0,
        ];
        number += 1;
    }
    groups
};

pub(super) struct Text<'w> {
    /// Text up to `length`, then room.
    buffer: Vec<u8>,
    length: usize,
    writer: &'w mut dyn io::Write,
}

impl<'w> Text<'w> {
    pub(super) fn new(writer: &'w mut dyn io::Write) -> Text<'w> {
        Text {
            buffer: Vec::new(),
            length: 0,
            writer,
        }
    }

    /// Makes room for so many bytes.
    #[inline]
    fn reserve(&mut self, count: usize) {
        if self.buffer.len() - self.length < count {
            self.grow(count);
        }
    }

    #[cold]
    fn grow(&mut self, count: usize) {
        let wanted = (self.length + count).max(2 * self.buffer.len());
        self.buffer.resize(wanted.max(LEAST_ROOM), 0);
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

    #[inline]
    pub(super) fn push(&mut self, text: &str) {
        self.reserve(text.len());
        let end = self.length + text.len();
        self.buffer[self.length..end].copy_from_slice(text.as_bytes());
        self.length = end;
    }

    fn character(&mut self, character: char) {
        self.push(character.encode_utf8(&mut [0; 4]));
    }

    pub(super) fn integer(&mut self, number: u32) {
        // The digits of the largest number, and the filling of the last group.
        self.reserve(u32::MAX.ilog10() as usize + 2);
        match number {
            0..1000 => self.first_group(number),
            1000..1_000_000 => {
                self.first_group(number / 1000);
                self.group(number % 1000);
            }
            _ => {
                let upper = number / 1_000_000;
                if upper < 1000 {
                    self.first_group(upper);
                } else {
                    self.first_group(upper / 1000);
                    self.group(upper % 1000);
                }
                self.group(number / 1000 % 1000);
                self.group(number % 1000);
            }
        }
    }

    /// Three digits.
    #[inline]
    fn group(&mut self, number: u32) {
        self.put(GROUPS[number as usize], 3);
    }

    /// One to three digits, the first of which is no zero unless it is alone.
    #[inline]
    fn first_group(&mut self, number: u32) {
        let zeros = usize::from(number < 10) + usize::from(number < 100);
        let digits = u32::from_le_bytes(GROUPS[number as usize]) >> (8 * zeros);
        self.put(digits.to_le_bytes(), 3 - zeros);
    }

    /// The first of four bytes; there is room for all.
    #[inline]
    fn put(&mut self, bytes: [u8; 4], count: usize) {
        self.buffer[self.length..self.length + 4].copy_from_slice(&bytes);
        self.length += count;
    }

    pub(super) fn quoted(&mut self, text: &str) {
        self.push("\"");
        for character in text.chars() {
            match character {
                '"' => self.push("\\\""),
                '\\' => self.push("\\\\"),
                '\n' => self.push("\\n"),
                '\r' => self.push("\\r"),
                '\t' => self.push("\\t"),
                other => self.character(other),
            }
        }
        self.push("\"");
    }

    pub(super) fn number(&mut self, number: f64) {
        self.push(&format!("{number:?}"));
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

    #[inline]
    pub(super) fn end_line(&mut self) -> io::Result<()> {
        self.push("\n");
        match self.length < FLUSH_AT {
            true => Ok(()),
            false => self.flush(),
        }
    }

    #[cold]
    fn flush(&mut self) -> io::Result<()> {
        let text = &self.buffer[..self.length];
        self.length = 0;
        self.writer.write_all(text)
    }

    pub(super) fn finish(mut self) -> io::Result<()> {
        self.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_have_their_digits() {
        let mut numbers = vec![0, 7, 40, 999, 1000, 1001, 999_999, u32::MAX];
        numbers.extend((0..10).flat_map(|power| {
            let power = 10_u32.pow(power);
            [power - 1, power, power + 1, power.saturating_mul(3)]
        }));
        for number in numbers {
            let mut bytes = Vec::new();
            let mut text = Text::new(&mut bytes);
            text.integer(number);
            text.finish().expect("a vector takes every byte");
            assert_eq!(bytes, number.to_string().as_bytes());
        }
    }
}
