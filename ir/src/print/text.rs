//! The buffer text is written through.
//!
//! The formatting machinery of the standard library would cost more than all
//! passes together on a function of 600,000 operations, so integers and names
//! are appended by hand and the buffer goes out in large pieces.

use super::HEADER;
use crate::function::Array;
use crate::module::Tables;
use crate::symbol::{Symbol, Symbols};
use std::io;

const FLUSH_AT: usize = 1 << 16;

/// Number of bytes reserved at a time, more than the length of a line.
const LEAST_ROOM: usize = 512;

/// Every number below a thousand as three digits, and a byte of zeros.
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

/// Six digits of 0, the first in the lowest byte.
const ZEROS: u64 = u64::from_le_bytes(*b"000000\0\0");

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

    /// Copies these bytes to the end of the text, without adding them to its
    /// length.
    #[inline]
    fn put(&mut self, bytes: &[u8]) {
        // Whether there is room is asked once, by the place itself.
        let place = self.length..self.length + bytes.len();
        match self.buffer.get_mut(place) {
            Some(room) => room.copy_from_slice(bytes),
            None => self.put_grown(bytes),
        }
    }

    #[cold]
    fn put_grown(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        let wanted = end.max(2 * self.buffer.len()).max(LEAST_ROOM);
        self.buffer.resize(wanted, 0);
        self.buffer[self.length..end].copy_from_slice(bytes);
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
        self.put(text.as_bytes());
        self.length += text.len();
    }

    /// Appends the string of a symbol.
    #[inline]
    pub(super) fn symbol(&mut self, symbols: &Symbols, symbol: Symbol) {
        let Some((bytes, length)) = symbols.short_text(symbol) else {
            return self.push(symbols.text(symbol));
        };
        self.put(&bytes);
        self.length += length;
    }

    /// Appends this number of these bytes; copying all of them costs less.
    #[inline]
    pub(super) fn short(&mut self, bytes: &[u8; 16], length: usize) {
        self.put(bytes);
        self.length += length;
    }

    fn character(&mut self, character: char) {
        self.push(character.encode_utf8(&mut [0; 4]));
    }

    #[inline]
    pub(super) fn integer(&mut self, number: u32) {
        match number.checked_sub(1_000_000) {
            None => self.six_digits(number, true),
            Some(_) => self.long_integer(number),
        }
    }

    #[cold]
    fn long_integer(&mut self, number: u32) {
        self.six_digits(number / 1_000_000, true);
        self.six_digits(number % 1_000_000, false);
    }

    /// The last six digits, without leading zeros on request, but with a digit
    /// at least.
    #[inline]
    fn six_digits(&mut self, number: u32, leading: bool) {
        let group = |number: u32| u64::from(u32::from_le_bytes(GROUPS[number as usize]));
        let digits = group(number / 1000) | group(number % 1000) << 24;
        let zeros = match leading {
            // A byte of its own ends the search for the first that is no zero.
            true => ((digits ^ ZEROS) | 1 << 40).trailing_zeros() / 8,
            false => 0,
        };
        // Copying all eight bytes costs less than six of them.
        self.put(&(digits >> (8 * zeros)).to_le_bytes());
        self.length += 6 - zeros as usize;
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
        self.symbol(&tables.symbols, array.name);
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
        if self.length < FLUSH_AT {
            Ok(())
        } else {
            self.flush()
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
