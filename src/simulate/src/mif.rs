//! Reading memory initialisation files.
//!
//! All constructs of the format are read: both kinds of comment, all radices,
//! ranges and lists. The file may come from any program, so sizes are bounded
//! before any allocation and every word may be set only once.

mod parser;

use parser::Parser;
use std::fmt;

/// Most 64-bit limbs of one image: 128 MiB.
const MAX_LIMBS: u64 = 1 << 24;

/// Most bits of a word; the largest machines have some thousand.
const MAX_BITS: u32 = 1 << 14;

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
        Parser::new(text).file()
    }
}

/// A place in a file and its mistake.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}, column {column}: {problem}")]
pub struct MifError {
    /// Counted from 1.
    pub line: u32,
    /// In bytes, counted from 1.
    pub column: u32,
    /// Fault of the file.
    pub problem: MifProblem,
}

/// Faults of memory initialisation files.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum MifProblem {
    /// Another token was found.
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
    #[error("this is not a number of base {radix}, or it does not fit")]
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
    /// Text after `END;`.
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
