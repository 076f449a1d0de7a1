//! Interned strings, and the names of values built from them.
//!
//! A Robotran name (`OM16`) is a symbol; a name made by a pass is the symbol
//! of the equation it came from with a number behind it (`OM16.1`). Keeping
//! the two parts apart makes a derived name cost eight bytes and no
//! allocation.

use hashbrown::HashTable;
use rustc_hash::FxBuildHasher;
use std::hash::BuildHasher;

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
    text: String,
    ends: Vec<u32>,
    /// For each string whether names can be derived from it
    /// ([`Symbols::is_base`]).
    bases: Vec<bool>,
    table: HashTable<SymbolEntry>,
}

/// A string in the hash table, with what finds it: growing the table reads no
/// string, and one of up to eight bytes, as most names are, is compared
/// without a look at the text of all.
#[derive(Clone, Copy, Debug)]
struct SymbolEntry {
    key: TextKey,
    symbol: u32,
}

/// A number that tells texts apart: the text itself where it fits, else a
/// hash. The two cannot be equal, since no UTF-8 has a byte of 255.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct TextKey {
    /// The halves of the 64 bits; as one number they would take the entry
    /// from twelve bytes to sixteen.
    halves: [u32; 2],
}

/// The byte that marks the key of a text that does not fit.
const HASHED: u64 = 0xff << 56;

impl TextKey {
    fn of(string: &str) -> TextKey {
        let bytes = string.as_bytes();
        // Zeros fill up what is shorter, so a text must have none of its own.
        let bits = match bytes.len() <= 8 && !bytes.contains(&0) {
            true => (bytes.iter().rev()).fold(0, |bits, &byte| bits << 8 | u64::from(byte)),
            false => FxBuildHasher.hash_one(string) | HASHED,
        };
        TextKey {
            halves: [bits as u32, (bits >> 32) as u32],
        }
    }

    fn bits(self) -> u64 {
        u64::from(self.halves[0]) | u64::from(self.halves[1]) << 32
    }

    /// True when texts with this key are equal.
    fn is_text(self) -> bool {
        self.bits() & HASHED != HASHED
    }

    fn hash(self) -> u64 {
        FxBuildHasher.hash_one(self.bits())
    }
}

impl Symbols {
    /// An empty interner.
    pub fn new() -> Symbols {
        Symbols::default()
    }

    /// The symbol of a string, made at its first appearance.
    pub fn intern(&mut self, string: &str) -> Symbol {
        let key = TextKey::of(string);
        if let Some(found) = self.lookup(key, string) {
            return found;
        }
        let symbol = self.ends.len() as u32;
        self.text.push_str(string);
        let end = u32::try_from(self.text.len());
        self.ends
            .push(end.expect("all names together have less than 4 GiB"));
        self.bases
            .push(is_word(string) && Name::split(string).1 == 0);
        let entry = SymbolEntry { key, symbol };
        self.table
            .insert_unique(key.hash(), entry, |entry| entry.key.hash());
        Symbol(symbol)
    }

    /// The symbol of a string, if it was interned before.
    pub fn find(&self, string: &str) -> Option<Symbol> {
        self.lookup(TextKey::of(string), string)
    }

    fn lookup(&self, key: TextKey, string: &str) -> Option<Symbol> {
        let same = |entry: &SymbolEntry| {
            entry.key == key
                && (key.is_text() || slice(&self.text, &self.ends, entry.symbol) == string)
        };
        let found = self.table.find(key.hash(), same);
        found.map(|entry| Symbol(entry.symbol))
    }

    /// The string of a symbol.
    #[inline]
    pub fn text(&self, symbol: Symbol) -> &str {
        slice(&self.text, &self.ends, symbol.0)
    }

    /// True for a symbol that is a [word](is_word) and does not itself end as
    /// a derived name does: names of values start with such a symbol.
    ///
    /// # Panics
    ///
    /// When the symbol is not of this interner.
    #[inline]
    pub fn is_base(&self, symbol: Symbol) -> bool {
        self.bases[symbol.index()]
    }

    /// The number of distinct strings.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// True when nothing was interned.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
}

#[inline]
fn slice<'a>(text: &'a str, ends: &[u32], symbol: u32) -> &'a str {
    let symbol = symbol as usize;
    let start = if symbol == 0 { 0 } else { ends[symbol - 1] };
    &text[start as usize..ends[symbol] as usize]
}

/// True for a word: letters, digits and underscores in parts joined by dots,
/// the first of which does not begin with a digit.
pub(crate) fn is_word(text: &str) -> bool {
    // A part has begun when the byte before belongs to it.
    let mut begun = false;
    for &byte in text.as_bytes() {
        match byte {
            b'.' if begun => begun = false,
            b'_' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => begun = true,
            _ => return false,
        }
    }
    begun && !text.as_bytes()[0].is_ascii_digit()
}

/// The name of a value: a symbol, and a number that is 0 for the symbol
/// itself and counts from 1 for the names derived from it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Name {
    /// The symbol the name starts with.
    pub base: Symbol,
    /// 0, or the number behind the dot.
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

    /// A number behind the dot has at most this many digits.
    pub const MAX_DIGITS: usize = 9;

    /// The largest number behind the dot.
    pub const MAX_NUMBER: u32 = 999_999_999;

    /// The name as text, without the leading `%`.
    pub fn display(self, symbols: &Symbols) -> String {
        match self.suffix {
            0 => symbols.text(self.base).to_owned(),
            suffix => format!("{}.{suffix}", symbols.text(self.base)),
        }
    }
}

/// Hands out names that no value of a function bears yet.
///
/// The state is computed from the function alone, so a pass names its values
/// alike whether the function came from another pass or from text.
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

    /// A new name derived from a symbol: the symbol itself when no value
    /// bears it, else the symbol with the next free number.
    ///
    /// # Panics
    ///
    /// When the symbol is that of [`Name::NONE`].
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
        let mut symbols = Symbols::new();
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
        let mut symbols = Symbols::new();
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
