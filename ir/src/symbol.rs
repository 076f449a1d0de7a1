//! Interned strings, and the names of values built from them.
//!
//! A Robotran name (`OM16`) is a symbol; a name made by a pass is the symbol
//! of the equation it came from with a number after it (`OM16.1`). Keeping
//! the two parts apart makes a derived name cost eight bytes and no
//! allocation.

use hashbrown::HashTable;
use rustc_hash::FxBuildHasher;
use std::hash::{BuildHasher, Hash};

/// An interned string; see [`Symbols`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Symbol(pub u32);

impl Symbol {
    /// The place in the interner, counted from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The interner: every distinct string once, in order of first appearance.
#[derive(Clone, Default, Debug)]
pub struct Symbols {
    strings: Vec<StoredText>,
    /// The strings that do not fit into eight bytes, one after the other.
    long: String,
    long_ends: Vec<u32>,
    /// For each string whether names can be derived from it
    /// ([`Symbols::is_base`]).
    bases: Vec<bool>,
    /// The hash beside the symbol: growing the table reads no string, and
    /// almost every string that is compared is the right one.
    table: HashTable<(u32, u32)>,
    /// The short strings met last, by hash: most names are read again within
    /// a few lines, and finding them here costs no walk through a table that
    /// has outgrown the caches. Empty while the table has not.
    recent: Vec<(StoredText, Symbol)>,
}

/// Places of [`Symbols::recent`], a power of two; they take half of a cache of
/// first level.
const RECENT: usize = 2048;

/// A string of up to eight bytes, as most names are, without a zero among
/// them: the bytes and then zeros. Or the number of a longer one, after a
/// byte that no UTF-8 has.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct StoredText([u8; 8]);

impl StoredText {
    const LONG: u8 = 0xff;

    /// No string.
    const NONE: StoredText = StoredText([StoredText::LONG; 8]);

    /// The string, if it fits.
    #[inline]
    fn short(string: &str) -> Option<StoredText> {
        let bytes = string.as_bytes();
        let half = |at: usize| {
            let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
            Some(u64::from(u32::from_le_bytes(bytes)))
        };
        // Of four bytes and more two halves that may overlap.
        let packed = match bytes.len() {
            0..4 => (0..)
                .step_by(8)
                .zip(bytes)
                .fold(0, |packed, (shift, &byte)| {
                    packed | u64::from(byte) << shift
                }),
            length @ 4..=8 => half(0)? | half(length - 4)? << (8 * (length - 4)),
            _ => return None,
        };
        // A zero byte borrows from a bit of its own; those behind the string
        // are filled up first.
        let unused = u64::MAX.unbounded_shl(8 * bytes.len() as u32);
        let filled = packed | unused;
        let zeros = filled.wrapping_sub(0x0101_0101_0101_0101) & !filled & 0x8080_8080_8080_8080;
        (zeros == 0).then_some(StoredText(packed.to_le_bytes()))
    }

    fn long(number: usize) -> StoredText {
        let number = u32::try_from(number).expect("there are fewer strings than bytes");
        let [a, b, c, d] = number.to_le_bytes();
        StoredText([a, b, c, d, 0, 0, 0, StoredText::LONG])
    }

    /// The number of the long string.
    #[inline]
    fn number(&self) -> Option<usize> {
        let [a, b, c, d, .., mark] = self.0;
        (mark == StoredText::LONG).then_some(u32::from_le_bytes([a, b, c, d]) as usize)
    }

    fn hash(self) -> u32 {
        hash(u64::from_le_bytes(self.0))
    }
}

impl Symbols {
    /// The symbol of a string, made at its first appearance.
    pub fn intern(&mut self, string: &str) -> Symbol {
        let short = StoredText::short(string);
        let hash = short.map_or_else(|| hash(string), StoredText::hash);
        if let Some(short) = short
            && let Some(&(known, symbol)) = self.recent.get(recent(hash))
            && known == short
        {
            return symbol;
        }
        let symbol = self.lookup(hash, short, string);
        let symbol = symbol.unwrap_or_else(|| self.enter(hash, short, string));
        if let Some(short) = short
            && let Some(place) = self.recent.get_mut(recent(hash))
        {
            *place = (short, symbol);
        }
        symbol
    }

    /// Makes the symbol of a string that has none.
    fn enter(&mut self, hash: u32, short: Option<StoredText>, string: &str) -> Symbol {
        debug_assert!(self.find(string).is_none(), "a string is entered once");
        if self.strings.len() == RECENT {
            self.recent = vec![(StoredText::NONE, Symbol(0)); RECENT];
        }
        let symbol = self.strings.len() as u32;
        let stored = short.unwrap_or_else(|| self.store(string));
        self.strings.push(stored);
        let is_base = match word_parts(string) {
            None => false,
            Some(1) => true,
            Some(_) => Name::split(string).1 == 0,
        };
        self.bases.push(is_base);
        self.table
            .insert_unique(spread(hash), (hash, symbol), |&(hash, _)| spread(hash));
        Symbol(symbol)
    }

    fn store(&mut self, string: &str) -> StoredText {
        self.long.push_str(string);
        let end = u32::try_from(self.long.len());
        self.long_ends
            .push(end.expect("all names together have less than 4 GiB"));
        StoredText::long(self.long_ends.len() - 1)
    }

    /// The symbol of a string, if it was interned before.
    pub fn find(&self, string: &str) -> Option<Symbol> {
        let short = StoredText::short(string);
        let hash = short.map_or_else(|| hash(string), StoredText::hash);
        self.lookup(hash, short, string)
    }

    fn lookup(&self, hash: u32, short: Option<StoredText>, string: &str) -> Option<Symbol> {
        let same = |&(other, candidate): &(u32, u32)| {
            other == hash
                && match short {
                    Some(short) => self.strings[candidate as usize] == short,
                    None => self.text(Symbol(candidate)) == string,
                }
        };
        let found = self.table.find(spread(hash), same);
        found.map(|&(_, symbol)| Symbol(symbol))
    }

    /// The string of a symbol.
    #[inline]
    pub fn text(&self, symbol: Symbol) -> &str {
        let stored = &self.strings[symbol.index()];
        if let Some(number) = stored.number() {
            return self.long_text(number);
        }
        let bits = u64::from_le_bytes(stored.0);
        let length = 8 - bits.leading_zeros() as usize / 8;
        str::from_utf8(&stored.0[..length]).expect("what is stored is a string")
    }

    /// The bytes of a string that fits into eight of them, zeros after it, and
    /// its length; copying all eight costs less than a test of the length.
    #[inline]
    pub(crate) fn short_text(&self, symbol: Symbol) -> Option<([u8; 8], usize)> {
        let stored = self.strings[symbol.index()];
        let length = 8 - u64::from_le_bytes(stored.0).leading_zeros() as usize / 8;
        stored.number().is_none().then_some((stored.0, length))
    }

    fn long_text(&self, number: usize) -> &str {
        let start = match number {
            0 => 0,
            _ => self.long_ends[number - 1],
        };
        &self.long[start as usize..self.long_ends[number] as usize]
    }

    /// True for a symbol that is a [word](is_word) and does not itself end as
    /// a derived name does: names of values start with such a symbol.
    ///
    /// # Panics
    ///
    /// Panics when the symbol is not of this interner.
    #[inline]
    pub fn is_base(&self, symbol: Symbol) -> bool {
        self.bases[symbol.index()]
    }

    /// The number of distinct strings.
    pub fn len(&self) -> usize {
        self.strings.len()
    }

    /// True when nothing was interned.
    pub fn is_empty(&self) -> bool {
        self.strings.is_empty()
    }
}

/// The place of a hash among the strings met last.
fn recent(hash: u32) -> usize {
    hash as usize & (RECENT - 1)
}

fn hash(key: impl Hash) -> u32 {
    let hash = FxBuildHasher.hash_one(key);
    (hash ^ hash >> 32) as u32
}

/// The table looks at both ends of its 64 bits.
fn spread(hash: u32) -> u64 {
    u64::from(hash) | u64::from(hash) << 32
}

/// True for a word: letters, digits and underscores in parts joined by dots,
/// the first of which does not begin with a digit.
pub(crate) fn is_word(text: &str) -> bool {
    word_parts(text).is_some()
}

/// The number of parts of a [word](is_word); `None` for a text that is none.
fn word_parts(text: &str) -> Option<usize> {
    let mut parts = 0;
    // A part has begun when the byte before belongs to it.
    let mut begun = false;
    for &byte in text.as_bytes() {
        match byte {
            b'.' if begun => {
                begun = false;
                parts += 1;
            }
            b'_' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => begun = true,
            _ => return None,
        }
    }
    (begun && !text.as_bytes()[0].is_ascii_digit()).then_some(parts + 1)
}

/// The name of a value: a symbol, and a number that is 0 for the symbol
/// itself and counts from 1 for the names derived from it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Name {
    /// The symbol the name starts with.
    pub base: Symbol,
    /// 0, or the number after the dot.
    pub suffix: u32,
}

impl Name {
    /// No name: an inner node of an expression tree.
    pub const NONE: Name = Name {
        base: Symbol(u32::MAX),
        suffix: 0,
    };

    /// The name that is a symbol and nothing more.
    #[inline]
    pub fn plain(base: Symbol) -> Name {
        Name { base, suffix: 0 }
    }

    /// True for [`Name::NONE`].
    #[inline]
    pub fn is_none(self) -> bool {
        self.base == Name::NONE.base
    }

    /// Takes the text of a name apart: digits after the last dot, without a
    /// leading zero and at most nine of them, are the number; all else
    /// belongs to the symbol.
    pub fn split(text: &str) -> (&str, u32) {
        let bytes = text.as_bytes();
        let is_digit = |byte: &&u8| byte.is_ascii_digit();
        let digits = bytes.iter().rev().take_while(is_digit).count();
        let start = bytes.len() - digits;
        let canonical = (1..=Name::MAX_DIGITS).contains(&digits) && bytes[start] != b'0';
        if !canonical || start == 0 || bytes[start - 1] != b'.' {
            return (text, 0);
        }
        let digit = |number, byte: &u8| 10 * number + u32::from(byte - b'0');
        let suffix = bytes[start..].iter().fold(0, digit);
        (&text[..start - 1], suffix)
    }

    /// A number after the dot has at most this many digits.
    pub const MAX_DIGITS: usize = 9;

    /// The largest number after the dot.
    pub const MAX_NUMBER: u32 = 999_999_999;

    /// The name as text, without the leading `%`.
    pub fn display(self, symbols: &Symbols) -> String {
        match self.suffix {
            0 => symbols.text(self.base).to_owned(),
            suffix => format!("{}.{suffix}", symbols.text(self.base)),
        }
    }
}

/// Hands out names that no value of a function has yet.
///
/// The state is computed from the function alone, so a pass gives its values
/// the same names for a function from another pass as for one from text.
#[derive(Clone, Debug)]
pub struct FreshNames {
    next: Vec<u32>,
}

impl FreshNames {
    /// Starts from the names already taken.
    pub fn new(taken: impl Iterator<Item = Name>) -> FreshNames {
        let mut next: Vec<u32> = Vec::new();
        for name in taken.filter(|name| !name.is_none()) {
            let index = name.base.index();
            if index >= next.len() {
                next.resize(index + 1, 0);
            }
            next[index] = next[index].max(name.suffix + 1);
        }
        FreshNames { next }
    }

    /// A new name derived from a symbol: the symbol itself when no value has
    /// it, else the symbol with the next unused number.
    ///
    /// # Panics
    ///
    /// Panics when the symbol is that of [`Name::NONE`].
    #[inline]
    pub fn fresh(&mut self, base: Symbol) -> Name {
        assert!(base != Name::NONE.base, "a fresh name has a symbol");
        let index = base.index();
        if index >= self.next.len() {
            self.next.resize(index + 1, 0);
        }
        let suffix = self.next[index];
        self.next[index] += 1;
        Name { base, suffix }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_words_that_are_not_derived() {
        let mut symbols = Symbols::default();
        for (text, is_base) in [
            ("OM16", true),
            ("_x.y_2", true),
            ("sens.P.1", false),
            ("", false),
            ("1x", false),
            (".x", false),
            ("x.", false),
            ("x..y", false),
            ("x-y", false),
            ("x.01", true),
        ] {
            let symbol = symbols.intern(text);
            assert_eq!(symbols.is_base(symbol), is_base, "{text}");
        }
    }

    #[test]
    fn interning_is_idempotent_and_names_are_fresh() {
        let mut symbols = Symbols::default();
        for (text, split) in [
            ("OM16", ("OM16", 0)),
            ("OM16.12", ("OM16", 12)),
            ("sens.P.1", ("sens.P", 1)),
            ("sens.P", ("sens.P", 0)),
            ("x.01", ("x.01", 0)),
            ("x.0", ("x.0", 0)),
            ("x.9999999999", ("x.9999999999", 0)),
        ] {
            assert_eq!(Name::split(text), split);
        }
        let first = symbols.intern("OM16");
        let second = symbols.intern("CF323");
        assert_eq!(symbols.intern("OM16"), first);
        assert_eq!(symbols.text(second), "CF323");
        assert_eq!(symbols.find("absent"), None);
        for text in ["OB3130_129", "OB3130_12", "eight_by", "", "\0", "a\0", "a"] {
            assert_eq!(symbols.find(text), None);
            let symbol = symbols.intern(text);
            assert_eq!(symbols.find(text), Some(symbol));
            assert_eq!(symbols.text(symbol), text);
        }
        let taken = [
            Name::plain(first),
            Name {
                base: first,
                suffix: 4,
            },
        ];
        let mut fresh = FreshNames::new(taken.into_iter());
        assert_eq!(fresh.fresh(first).display(&symbols), "OM16.5");
        assert_eq!(fresh.fresh(second).display(&symbols), "CF323");
        assert_eq!(fresh.fresh(second).display(&symbols), "CF323.1");
    }
}
