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
    /// The hash beside the symbol: growing the table reads no string, and
    /// almost every string that is compared is the right one.
    table: HashTable<(u32, u32)>,
}

impl Symbols {
    /// An empty interner.
    pub fn new() -> Symbols {
        Symbols::default()
    }

    /// The symbol of a string, made at its first appearance.
    pub fn intern(&mut self, string: &str) -> Symbol {
        let hash = hash(string);
        if let Some(found) = self.lookup(hash, string) {
            return found;
        }
        let symbol = self.ends.len() as u32;
        self.text.push_str(string);
        let end = u32::try_from(self.text.len());
        self.ends
            .push(end.expect("all names together have less than 4 GiB"));
        self.table
            .insert_unique(spread(hash), (hash, symbol), |&(hash, _)| spread(hash));
        Symbol(symbol)
    }

    /// The symbol of a string, if it was interned before.
    pub fn find(&self, string: &str) -> Option<Symbol> {
        self.lookup(hash(string), string)
    }

    fn lookup(&self, hash: u32, string: &str) -> Option<Symbol> {
        self.table
            .find(spread(hash), |&(other, candidate)| {
                other == hash && slice(&self.text, &self.ends, candidate) == string
            })
            .map(|&(_, found)| Symbol(found))
    }

    /// The string of a symbol.
    #[inline]
    pub fn text(&self, symbol: Symbol) -> &str {
        slice(&self.text, &self.ends, symbol.0)
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

fn hash(string: &str) -> u32 {
    let hash = FxBuildHasher.hash_one(string);
    (hash ^ hash >> 32) as u32
}

/// The table looks at both ends of its 64 bits.
fn spread(hash: u32) -> u64 {
    u64::from(hash) | u64::from(hash) << 32
}

fn slice<'a>(text: &'a str, ends: &[u32], symbol: u32) -> &'a str {
    let symbol = symbol as usize;
    let start = if symbol == 0 { 0 } else { ends[symbol - 1] };
    &text[start as usize..ends[symbol] as usize]
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
        let Some(dot) = text.rfind('.') else {
            return (text, 0);
        };
        let digits = &text[dot + 1..];
        let canonical = (1..=Name::MAX_DIGITS).contains(&digits.len())
            && digits.bytes().all(|byte| byte.is_ascii_digit())
            && !digits.starts_with('0');
        match digits.parse() {
            Ok(suffix) if canonical => (&text[..dot], suffix),
            Ok(_) | Err(_) => (text, 0),
        }
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
