//! Reading memory initialisation files.
//!
//! Everything the format allows is read: both kinds of comment, all radices,
//! ranges and lists. Nothing is assumed about who wrote the file, so sizes
//! are bounded before anything is allocated and every word may be set only
//! once.

use std::fmt;

/// Most 64-bit limbs of one image: 128 MiB.
const MOST_LIMBS: u64 = 1 << 24;

/// Most bits of a word; an instruction word of the largest machines has some
/// thousand.
const MOST_BITS: u32 = 1 << 14;

/// The content of a memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Image {
    width: u32,
    depth: u32,
    limbs: usize,
    words: Vec<u64>,
    defined: Vec<u64>,
}

impl Image {
    /// Bits of a word.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Words.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// True when the file gives the word a content.
    pub fn is_defined(&self, address: u32) -> bool {
        let address = address as usize;
        self.defined[address / 64] >> (address % 64) & 1 == 1
    }

    /// A word, in limbs of 64 bits, the lowest first.
    pub fn word(&self, address: u32) -> &[u64] {
        let start = address as usize * self.limbs;
        &self.words[start..start + self.limbs]
    }

    /// Some bits of a word, at most 32.
    pub fn bits(&self, address: u32, low: u32, width: u32) -> u32 {
        let word = self.word(address);
        let (limb, shift) = ((low / 64) as usize, low % 64);
        let mut bits = word[limb] >> shift;
        if shift + width > 64 {
            bits |= word[limb + 1] << (64 - shift);
        }
        (bits & ((1u64 << width) - 1)) as u32
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// At the first place where the text is not a memory initialisation file,
    /// a word is set twice, lies outside the depth or does not fit the width.
    pub fn parse(text: &str) -> Result<Image, MifError> {
        Parser {
            text: text.as_bytes(),
            at: 0,
        }
        .file()
    }
}

/// A place in a file and what is wrong there.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}, column {column}: {problem}")]
pub struct MifError {
    /// Counted from 1.
    pub line: u32,
    /// In bytes, counted from 1.
    pub column: u32,
    /// What is wrong.
    pub problem: MifProblem,
}

/// What can be wrong with a memory initialisation file.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum MifProblem {
    /// Something else stands there.
    #[error("expected {0}")]
    Expected(&'static str),
    /// A setting with an unknown name.
    #[error("expected WIDTH, DEPTH, ADDRESS_RADIX, DATA_RADIX or CONTENT")]
    UnknownSetting,
    /// A setting given twice.
    #[error("this setting is given twice")]
    SettingTwice,
    /// No width or depth before the content.
    #[error("the content begins before WIDTH and DEPTH are given")]
    NoSize,
    /// A number with foreign digits, or too large for its place.
    #[error("this is no number of base {radix} that fits")]
    BadNumber {
        /// The base.
        radix: Radix,
    },
    /// A depth or width of 0, or too much of both.
    #[error("a memory of {depth} words of {width} bits is empty or too large")]
    BadSize {
        /// Words.
        depth: u32,
        /// Bits.
        width: u32,
    },
    /// An address beyond the depth, or a range that ends before it starts.
    #[error("the addresses go beyond the depth of {depth} words, or backwards")]
    BadAddress {
        /// Words.
        depth: u32,
    },
    /// A word set before.
    #[error("word {address} is set twice")]
    WordTwice {
        /// The address.
        address: u32,
    },
    /// Text behind `END;`.
    #[error("nothing may follow END")]
    AfterEnd,
}

/// A base that numbers are written in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Radix {
    /// Base 2.
    Binary,
    /// Base 8.
    Octal,
    /// Base 10.
    Decimal,
    /// Base 16.
    Hexadecimal,
}

impl Radix {
    fn base(self) -> u64 {
        match self {
            Radix::Binary => 2,
            Radix::Octal => 8,
            Radix::Decimal => 10,
            Radix::Hexadecimal => 16,
        }
    }
}

impl fmt::Display for Radix {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.base())
    }
}

#[derive(Default)]
struct Settings {
    width: Option<u32>,
    depth: Option<u32>,
    address_radix: Option<Radix>,
    data_radix: Option<Radix>,
}

struct Parser<'t> {
    text: &'t [u8],
    at: usize,
}

type Parsed<T> = Result<T, MifError>;

impl<'t> Parser<'t> {
    fn file(mut self) -> Parsed<Image> {
        let mut settings = Settings::default();
        loop {
            let start = self.skip();
            let word = self.word();
            if word.eq_ignore_ascii_case(b"content") {
                break;
            }
            self.setting(&mut settings, word, start)?;
        }
        let start = self.skip();
        if !self.word().eq_ignore_ascii_case(b"begin") {
            return self.fail(start, MifProblem::Expected("BEGIN"));
        }
        let mut image = self.empty(&settings, start)?;
        let address_radix = settings.address_radix.unwrap_or(Radix::Hexadecimal);
        let data_radix = settings.data_radix.unwrap_or(Radix::Hexadecimal);
        let mut scratch = Vec::new();
        loop {
            let start = self.skip();
            if self.at_end_keyword() {
                break;
            }
            self.entry(&mut image, address_radix, data_radix, &mut scratch, start)?;
        }
        self.at += 3;
        self.expect(b';', "';' after END")?;
        let rest = self.skip();
        if rest < self.text.len() {
            return self.fail(rest, MifProblem::AfterEnd);
        }
        Ok(image)
    }

    fn setting(&mut self, settings: &mut Settings, name: &[u8], start: usize) -> Parsed<()> {
        let is = |known: &str| name.eq_ignore_ascii_case(known.as_bytes());
        let (width, depth) = (is("width"), is("depth"));
        let (address, data) = (is("address_radix"), is("data_radix"));
        if !(width || depth || address || data) {
            return self.fail(start, MifProblem::UnknownSetting);
        }
        self.expect(b'=', "'='")?;
        let value_at = self.skip();
        let value = self.word();
        let given = if width || depth {
            let number = decimal(value);
            let Some(number) = number else {
                let radix = Radix::Decimal;
                return self.fail(value_at, MifProblem::BadNumber { radix });
            };
            let place = if width {
                &mut settings.width
            } else {
                &mut settings.depth
            };
            place.replace(number).is_some()
        } else {
            let Some(radix) = radix(value) else {
                return self.fail(value_at, MifProblem::Expected("BIN, OCT, DEC, UNS or HEX"));
            };
            let place = if address {
                &mut settings.address_radix
            } else {
                &mut settings.data_radix
            };
            place.replace(radix).is_some()
        };
        if given {
            return self.fail(start, MifProblem::SettingTwice);
        }
        self.expect(b';', "';'")
    }

    fn empty(&self, settings: &Settings, start: usize) -> Parsed<Image> {
        let (Some(width), Some(depth)) = (settings.width, settings.depth) else {
            return self.fail(start, MifProblem::NoSize);
        };
        let limbs = u64::from(width.div_ceil(64));
        let total = u64::from(depth) * limbs;
        if width == 0 || depth == 0 || width > MOST_BITS || total > MOST_LIMBS {
            return self.fail(start, MifProblem::BadSize { depth, width });
        }
        Ok(Image {
            width,
            depth,
            limbs: limbs as usize,
            words: vec![0; total as usize],
            defined: vec![0; depth.div_ceil(64) as usize],
        })
    }

    /// `address : word …;` or `[first..last] : word …;`.
    fn entry(
        &mut self,
        image: &mut Image,
        address_radix: Radix,
        data_radix: Radix,
        scratch: &mut Vec<u64>,
        start: usize,
    ) -> Parsed<()> {
        let range = self.text.get(self.at) == Some(&b'[');
        if range {
            self.at += 1;
        }
        let first = self.address(address_radix)?;
        let mut last = first;
        if range {
            self.expect(b'.', "'..'")?;
            self.expect(b'.', "'..'")?;
            last = self.address(address_radix)?;
            self.expect(b']', "']'")?;
        }
        self.expect(b':', "':'")?;
        scratch.clear();
        let mut count = 0u32;
        loop {
            let at = self.skip();
            if count > 0 && self.text.get(at) == Some(&b';') {
                self.at += 1;
                break;
            }
            let digits = self.word();
            let place = scratch.len();
            scratch.resize(place + image.limbs, 0);
            if !number(digits, data_radix, image.width, &mut scratch[place..]) {
                return self.fail(at, MifProblem::BadNumber { radix: data_radix });
            }
            count += 1;
        }
        if !range {
            last = first.saturating_add(count - 1);
        }
        if last >= image.depth || last < first {
            let depth = image.depth;
            return self.fail(start, MifProblem::BadAddress { depth });
        }
        for (address, word) in (first..=last).zip(scratch.chunks(image.limbs).cycle()) {
            let bit = 1u64 << (address % 64);
            let defined = &mut image.defined[address as usize / 64];
            if *defined & bit != 0 {
                return self.fail(start, MifProblem::WordTwice { address });
            }
            *defined |= bit;
            let place = address as usize * image.limbs;
            image.words[place..place + image.limbs].copy_from_slice(word);
        }
        Ok(())
    }

    fn address(&mut self, radix: Radix) -> Parsed<u32> {
        let at = self.skip();
        let mut limb = [0];
        let digits = self.word();
        if !number(digits, radix, 32, &mut limb) {
            return self.fail(at, MifProblem::BadNumber { radix });
        }
        Ok(limb[0] as u32)
    }

    /// `END` as a word of its own; hexadecimal digits follow it otherwise.
    fn at_end_keyword(&self) -> bool {
        let rest = &self.text[self.at..];
        let letters = rest.len() >= 3 && rest[..3].eq_ignore_ascii_case(b"end");
        letters && !rest.get(3).is_some_and(|&byte| is_word(byte))
    }

    fn expect(&mut self, byte: u8, what: &'static str) -> Parsed<()> {
        let at = self.skip();
        if self.text.get(at) != Some(&byte) {
            return self.fail(at, MifProblem::Expected(what));
        }
        self.at += 1;
        Ok(())
    }

    /// Letters, digits and underscores from here on, perhaps none.
    fn word(&mut self) -> &'t [u8] {
        let rest = &self.text[self.at..];
        let length = rest.iter().take_while(|&&byte| is_word(byte)).count();
        self.at += length;
        &rest[..length]
    }

    /// Skips blanks and comments; the place reached.
    fn skip(&mut self) -> usize {
        loop {
            match self.text.get(self.at) {
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                Some(b'-') if self.text.get(self.at + 1) == Some(&b'-') => {
                    self.skip_past(b'\n', 2);
                }
                Some(b'%') => self.skip_past(b'%', 1),
                Some(_) | None => return self.at,
            }
        }
    }

    fn skip_past(&mut self, end: u8, opening: usize) {
        self.at += opening;
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|&byte| byte == end);
        self.at += length.map_or(rest.len(), |length| length + 1);
    }

    fn fail<T>(&self, at: usize, problem: MifProblem) -> Parsed<T> {
        let before = &self.text[..at.min(self.text.len())];
        let line_start = before
            .iter()
            .rposition(|&byte| byte == b'\n')
            .map_or(0, |newline| newline + 1);
        let lines = before.iter().filter(|&&byte| byte == b'\n').count();
        Err(MifError {
            line: lines as u32 + 1,
            column: (before.len() - line_start) as u32 + 1,
            problem,
        })
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

fn decimal(digits: &[u8]) -> Option<u32> {
    let mut limb = [0];
    number(digits, Radix::Decimal, 32, &mut limb).then_some(limb[0] as u32)
}

fn radix(name: &[u8]) -> Option<Radix> {
    let known = [
        ("bin", Radix::Binary),
        ("oct", Radix::Octal),
        ("dec", Radix::Decimal),
        ("uns", Radix::Decimal),
        ("hex", Radix::Hexadecimal),
    ];
    let found = known
        .iter()
        .find(|(known, _)| name.eq_ignore_ascii_case(known.as_bytes()));
    found.map(|&(_, radix)| radix)
}

/// Reads digits into limbs that are zero; false when there are none, one is
/// foreign, or the number has more than `width` bits.
fn number(digits: &[u8], radix: Radix, width: u32, limbs: &mut [u64]) -> bool {
    let zeros = digits.iter().take_while(|&&digit| digit == b'0').count();
    let significant = &digits[zeros..];
    // Every digit behind the leading zeros stands for a bit or more.
    if digits.is_empty() || significant.len() > width as usize {
        return false;
    }
    let fits = match radix {
        Radix::Hexadecimal => shifted(significant, 4, limbs),
        Radix::Octal => shifted(significant, 3, limbs),
        Radix::Binary => shifted(significant, 1, limbs),
        Radix::Decimal => multiplied(significant, limbs),
    };
    let used = width % 64;
    let top = (width / 64) as usize;
    fits && (used == 0 || limbs.get(top).is_none_or(|limb| limb >> used == 0))
}

/// Digits of a base that is a power of two, from the last to the first.
fn shifted(digits: &[u8], bits: u32, limbs: &mut [u64]) -> bool {
    let (mut limb, mut shift) = (0, 0);
    for &digit in digits.iter().rev() {
        let Some(digit) = (digit as char).to_digit(1 << bits) else {
            return false;
        };
        let wide = u128::from(digit) << shift;
        for (limb, part) in [(limb, wide as u64), (limb + 1, (wide >> 64) as u64)] {
            match limbs.get_mut(limb) {
                Some(limb) => *limb |= part,
                None if part != 0 => return false,
                None => {}
            }
        }
        shift += bits;
        if shift >= 64 {
            (limb, shift) = (limb + 1, shift - 64);
        }
    }
    true
}

/// Decimal digits, from the first to the last.
fn multiplied(digits: &[u8], limbs: &mut [u64]) -> bool {
    for &digit in digits {
        let Some(digit) = (digit as char).to_digit(10) else {
            return false;
        };
        let mut carry = u128::from(digit);
        for limb in limbs.iter_mut() {
            let product = u128::from(*limb) * 10 + carry;
            *limb = product as u64;
            carry = product >> 64;
        }
        if carry != 0 {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(content: &str) -> Result<Image, MifError> {
        Image::parse(&format!(
            "WIDTH=8; DEPTH=16; ADDRESS_RADIX=HEX; DATA_RADIX=HEX; CONTENT BEGIN {content} END;"
        ))
    }

    fn problem(content: &str) -> MifProblem {
        parse(content).expect_err("it must be refused").problem
    }

    #[test]
    fn words_ranges_lists_and_comments_are_read() {
        let image = parse("0:1F; % a: 3; % [2..7]: A b; -- 8: 4;\n e : 7 8;").expect("it is fine");
        let words: Vec<_> = (0..16)
            .map(|address| image.is_defined(address).then(|| image.word(address)[0]))
            .collect();
        let (a, b) = (Some(10), Some(11));
        let mut expected = vec![Some(31), None, a, b, a, b, a, b];
        expected.extend([None; 6]);
        expected.extend([Some(7), Some(8)]);
        assert_eq!(words, expected);
    }

    #[test]
    fn other_radices_and_wide_words_are_read() {
        let text = "-- header\nDEPTH = 3;\nwidth=100;address_radix=DEC;data_radix=bin;content\nbegin\n\
                    2 : 1000000000000000000000000000000000000000000000000000000000000000011;end;\n";
        let image = Image::parse(text).expect("it is fine");
        assert_eq!(image.word(2), [3, 4]);
        assert_eq!(image.bits(2, 60, 10), 1 << 6);
        assert_eq!(image.bits(2, 0, 32), 3);
        let text = "WIDTH=64;DEPTH=1;ADDRESS_RADIX=OCT;DATA_RADIX=UNS;CONTENT BEGIN \
                    0:18446744073709551615;END;";
        assert_eq!(Image::parse(text).expect("it fits").word(0), [u64::MAX]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let error = Image::parse("WIDTH = 8;\n  DEPHT = 3;").expect_err("misspelt");
        assert_eq!((error.line, error.column), (2, 3));
        assert_eq!(error.problem, MifProblem::UnknownSetting);
        let radix = Radix::Hexadecimal;
        assert_eq!(problem("0 : 1G;"), MifProblem::BadNumber { radix });
        assert_eq!(problem("0 : 100;"), MifProblem::BadNumber { radix });
        assert_eq!(problem("0 : ;"), MifProblem::BadNumber { radix });
        assert_eq!(problem("10 : 0;"), MifProblem::BadAddress { depth: 16 });
        assert_eq!(problem("[3..2] : 0;"), MifProblem::BadAddress { depth: 16 });
        assert_eq!(problem("f : 0 1;"), MifProblem::BadAddress { depth: 16 });
        assert_eq!(
            problem("1:0; [0..3]:1;"),
            MifProblem::WordTwice { address: 1 }
        );
        assert_eq!(problem("0 1;"), MifProblem::Expected("':'"));
        assert_eq!(problem("0 : 1; END; 3"), MifProblem::AfterEnd);
        assert_eq!(
            Image::parse("CONTENT BEGIN END;")
                .expect_err("no size")
                .problem,
            MifProblem::NoSize
        );
        assert_eq!(
            Image::parse("DEPTH=4294967295;WIDTH=4294967295;CONTENT BEGIN END;")
                .expect_err("too large")
                .problem,
            MifProblem::BadSize {
                depth: u32::MAX,
                width: u32::MAX
            }
        );
    }

    #[test]
    fn every_truncation_is_refused() {
        let text =
            "WIDTH=8;DEPTH=16;ADDRESS_RADIX=HEX;DATA_RADIX=HEX;CONTENT BEGIN\n0:1;[1..f]:2 3;END;";
        assert!(Image::parse(text).is_ok());
        for end in 0..text.len() {
            assert!(Image::parse(&text[..end]).is_err(), "{}", &text[..end]);
        }
    }
}
