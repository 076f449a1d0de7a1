//! Writing memory initialisation files.

use crate::hex::hexadecimal_digit;
use robovec_num::fnv::Fnv;
use std::io::{self, Write};

const FLUSH_AT: usize = 1 << 16;

/// A writer of one `.mif` file: lines go through a buffer of bounded size,
/// and the bytes into a hash on their way.
pub(super) struct MifWriter<'w> {
    buffer: Vec<u8>,
    target: &'w mut dyn Write,
    hash: Fnv,
    address_digits: usize,
    data_digits: usize,
}

impl<'w> MifWriter<'w> {
    /// Starts a file of `depth` words of `width` bits; `title` becomes its
    /// first line.
    pub(super) fn new(
        target: &'w mut dyn Write,
        hash: Fnv,
        title: &str,
        width: u32,
        depth: u32,
    ) -> io::Result<MifWriter<'w>> {
        let mut writer = MifWriter {
            buffer: Vec::with_capacity(FLUSH_AT + 4096),
            target,
            hash,
            address_digits: hexadecimal_digits(depth.saturating_sub(1)),
            data_digits: width.div_ceil(4) as usize,
        };
        writeln!(writer.buffer, "-- {title}")?;
        writeln!(writer.buffer, "WIDTH = {width};")?;
        writeln!(writer.buffer, "DEPTH = {depth};")?;
        writeln!(writer.buffer, "ADDRESS_RADIX = HEX;")?;
        writeln!(writer.buffer, "DATA_RADIX = HEX;")?;
        writeln!(writer.buffer, "CONTENT BEGIN")?;
        Ok(writer)
    }

    /// One word, in limbs of 64 bits, the lowest first.
    pub(super) fn word(&mut self, address: u32, limbs: &[u64]) -> io::Result<()> {
        self.word_with(address, limbs, "")
    }

    /// One word with a comment after it.
    pub(super) fn word_with(
        &mut self,
        address: u32,
        limbs: &[u64],
        comment: &str,
    ) -> io::Result<()> {
        self.buffer.extend_from_slice(b"  ");
        self.hexadecimal(&[u64::from(address)], self.address_digits);
        self.buffer.extend_from_slice(b" : ");
        self.hexadecimal(limbs, self.data_digits);
        self.buffer.push(b';');
        if !comment.is_empty() {
            self.buffer.extend_from_slice(b" -- ");
            self.buffer.extend_from_slice(comment.as_bytes());
        }
        self.end_line()
    }

    /// Zero from the first to the last address, both included.
    pub(super) fn zeros(&mut self, first: u32, last: u32) -> io::Result<()> {
        assert!(first <= last, "a range of addresses ascends");
        if first == last {
            return self.word(first, &[]);
        }
        self.buffer.extend_from_slice(b"  [");
        self.hexadecimal(&[u64::from(first)], self.address_digits);
        self.buffer.extend_from_slice(b"..");
        self.hexadecimal(&[u64::from(last)], self.address_digits);
        self.buffer.extend_from_slice(b"] : ");
        self.hexadecimal(&[], self.data_digits);
        self.buffer.push(b';');
        self.end_line()
    }

    /// A word whose value is not known yet, as a comment.
    pub(super) fn unknown(&mut self, address: u32, comment: &str) -> io::Result<()> {
        self.buffer.extend_from_slice(b"  -- ");
        self.hexadecimal(&[u64::from(address)], self.address_digits);
        self.buffer.extend_from_slice(b" : ");
        self.buffer.extend_from_slice(comment.as_bytes());
        self.end_line()
    }

    /// Ends the file; the hash of all bytes so far.
    pub(super) fn finish(mut self) -> io::Result<Fnv> {
        self.buffer.extend_from_slice(b"END;\n");
        self.flush()?;
        Ok(self.hash)
    }

    fn hexadecimal(&mut self, limbs: &[u64], digits: usize) {
        assert!(
            (digits..16 * limbs.len()).all(|place| hexadecimal_digit(limbs, place) == 0),
            "a number fits its digits"
        );
        for place in (0..digits).rev() {
            self.buffer
                .push(b"0123456789ABCDEF"[hexadecimal_digit(limbs, place)]);
        }
    }

    fn end_line(&mut self) -> io::Result<()> {
        self.buffer.push(b'\n');
        if self.buffer.len() >= FLUSH_AT {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.hash.update(&self.buffer);
        self.target.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }
}

fn hexadecimal_digits(number: u32) -> usize {
    ((u32::BITS - number.leading_zeros()).div_ceil(4) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_words_ranges_and_comments() {
        let mut bytes = Vec::new();
        let mut writer = MifWriter::new(&mut bytes, Fnv::new(), "title", 70, 20).expect("a vector");
        writer
            .word(0, &[0xfedc_ba98_7654_3210, 0x2a])
            .expect("a vector");
        writer.zeros(1, 18).expect("a vector");
        writer.word_with(19, &[7], "seven").expect("a vector");
        writer.finish().expect("a vector");
        let text = String::from_utf8(bytes).expect("ASCII");
        assert_eq!(
            text,
            "-- title\nWIDTH = 70;\nDEPTH = 20;\nADDRESS_RADIX = HEX;\nDATA_RADIX = HEX;\n\
             CONTENT BEGIN\n  00 : 2AFEDCBA9876543210;\n  [01..12] : 000000000000000000;\n  \
             13 : 000000000000000007; -- seven\nEND;\n"
        );
    }
}
