//! Writing memory content for `$readmemh`.
//!
//! Simulators and open synthesis read this; Quartus reads `.mif`. Both files
//! hold the same words.

use std::io::{self, Write};

/// A writer of one `.hex` file.
pub(super) struct HexWriter<'w> {
    target: io::BufWriter<&'w mut dyn Write>,
    digits: usize,
}

impl<'w> HexWriter<'w> {
    /// Starts a file of words of `width` bits; `title` becomes its first
    /// line.
    pub(super) fn new(
        target: &'w mut dyn Write,
        title: &str,
        width: u32,
    ) -> io::Result<HexWriter<'w>> {
        let mut target = io::BufWriter::new(target);
        writeln!(target, "// {title}")?;
        Ok(HexWriter {
            target,
            digits: width.div_ceil(4) as usize,
        })
    }

    /// The next word, in limbs of 64 bits, the lowest first.
    pub(super) fn word(&mut self, limbs: &[u64]) -> io::Result<()> {
        assert!(
            (self.digits..16 * limbs.len()).all(|place| hexadecimal_digit(limbs, place) == 0),
            "a number fits its digits"
        );
        let mut line = String::with_capacity(self.digits + 1);
        for place in (0..self.digits).rev() {
            let digit = hexadecimal_digit(limbs, place) as u32;
            line.push(char::from_digit(digit, 16).expect("four bits are a digit"));
        }
        line.push('\n');
        self.target.write_all(line.as_bytes())
    }

    /// A word at an address, counted in words.
    pub(super) fn word_at(&mut self, address: u32, limbs: &[u64]) -> io::Result<()> {
        write!(self.target, "@{address:x} ")?;
        self.word(limbs)
    }

    /// A word at an address whose content is not known.
    pub(super) fn unknown_at(&mut self, address: u32) -> io::Result<()> {
        writeln!(self.target, "@{address:x} {}", "x".repeat(self.digits))
    }

    /// The next words are zero.
    pub(super) fn zeros(&mut self, count: u32) -> io::Result<()> {
        (0..count).try_for_each(|_| self.word(&[]))
    }

    /// Ends the file.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.target.flush()
    }
}

/// A hexadecimal digit of a word in limbs of 64 bits, both counted from the
/// lowest; 0 beyond the limbs.
pub(super) fn hexadecimal_digit(limbs: &[u64], place: usize) -> usize {
    let limb = limbs.get(place / 16).copied().unwrap_or(0);
    (limb >> (4 * (place % 16))) as usize & 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_follow_one_another_or_stand_at_addresses() {
        let mut bytes: Vec<u8> = Vec::new();
        let mut writer = HexWriter::new(&mut bytes, "title", 70).expect("a vector");
        writer
            .word(&[0xfedc_ba98_7654_3210, 0x2a])
            .expect("a vector");
        writer.zeros(1).expect("a vector");
        writer.word_at(31, &[7]).expect("a vector");
        writer.unknown_at(32).expect("a vector");
        writer.finish().expect("a vector");
        let text = String::from_utf8(bytes).expect("ASCII");
        assert_eq!(
            text,
            "// title\n2afedcba9876543210\n000000000000000000\n@1f 000000000000000007\n\
             @20 xxxxxxxxxxxxxxxxxx\n"
        );
    }
}
