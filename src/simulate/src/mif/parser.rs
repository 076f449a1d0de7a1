//! The grammar of memory initialisation files.

use super::{Image, MAX_BITS, MAX_LIMBS, MifError, MifProblem, Radix};

#[derive(Default)]
struct MifSettings {
    width: Option<u32>,
    depth: Option<u32>,
    address_radix: Option<Radix>,
    data_radix: Option<Radix>,
}

pub(super) struct Parser<'t> {
    text: &'t [u8],
    at: usize,
}

type Parsed<T> = Result<T, MifError>;

impl<'t> Parser<'t> {
    /// Starts at the beginning of a text.
    pub(super) fn new(text: &str) -> Parser<'_> {
        Parser {
            text: text.as_bytes(),
            at: 0,
        }
    }

    pub(super) fn file(mut self) -> Parsed<Image> {
        let mut settings = MifSettings::default();
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

    fn setting(&mut self, settings: &mut MifSettings, name: &[u8], start: usize) -> Parsed<()> {
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

    fn empty(&self, settings: &MifSettings, start: usize) -> Parsed<Image> {
        let (Some(width), Some(depth)) = (settings.width, settings.depth) else {
            return self.fail(start, MifProblem::NoSize);
        };
        let limbs = u64::from(width.div_ceil(64));
        let total = u64::from(depth) * limbs;
        if width == 0 || depth == 0 || width > MAX_BITS || total > MAX_LIMBS {
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

    /// `END` as its own word; hexadecimal digits follow it otherwise.
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
        let lines = before.split(|&byte| byte == b'\n');
        let (line, text) = (1u32..).zip(lines).last().expect("a text has a line");
        Err(MifError {
            line,
            column: text.len() as u32 + 1,
            problem,
        })
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// A decimal number of 32 bits.
pub(super) fn decimal(digits: &[u8]) -> Option<u32> {
    let mut limb = [0];
    number(digits, Radix::Decimal, 32, &mut limb).then_some(limb[0] as u32)
}

pub(super) fn radix(name: &[u8]) -> Option<Radix> {
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

/// Reads digits into limbs that are zero; false for none or too many.
pub(super) fn number(digits: &[u8], radix: Radix, width: u32, limbs: &mut [u64]) -> bool {
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
