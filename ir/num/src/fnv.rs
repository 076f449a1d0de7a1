//! A hash of bytes that is the same on every system and in every version:
//! 64-bit FNV-1a.
//!
//! It distinguishes files and machines that differ by mistake. It gives no
//! protection against deliberate collisions.

use std::fmt;
use std::str::FromStr;

/// 64-bit FNV-1a, continued over several pieces; written as sixteen
/// hexadecimal digits of lower case.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Fnv(u64);

impl Fnv {
    /// The hash of no bytes.
    pub const fn new() -> Fnv {
        Fnv(0xcbf2_9ce4_8422_2325)
    }

    /// The hash of one piece.
    pub fn of(bytes: &[u8]) -> Fnv {
        let mut hash = Fnv::new();
        hash.update(bytes);
        hash
    }

    /// Adds bytes to the hash.
    pub fn update(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Sixteen hexadecimal digits.
    pub fn text(self) -> String {
        self.to_string()
    }
}

impl Default for Fnv {
    fn default() -> Fnv {
        Fnv::new()
    }
}

impl fmt::Display for Fnv {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:016x}", self.0)
    }
}

/// A text that is no hash.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("a hash has sixteen hexadecimal digits of lower case")]
pub struct FnvError;

impl FromStr for Fnv {
    type Err = FnvError;

    /// Reads exactly the texts that [`Fnv`] prints.
    fn from_str(text: &str) -> Result<Fnv, FnvError> {
        let digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        if text.len() != 16 || !text.bytes().all(digit) {
            return Err(FnvError);
        }
        u64::from_str_radix(text, 16).map(Fnv).map_err(|_| FnvError)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_fnv_1a_of_64_bits() {
        assert_eq!(Fnv::of(b"").text(), "cbf29ce484222325");
        assert_eq!(Fnv::of(b"a").text(), "af63dc4c8601ec8c");
        assert_eq!(Fnv::of(b"foobar").text(), "85944171f73967e8");
        let mut pieces = Fnv::of(b"foo");
        pieces.update(b"bar");
        assert_eq!(pieces, Fnv::of(b"foobar"));
    }

    #[test]
    fn only_what_is_printed_is_read() {
        let hash = Fnv::of(b"a");
        assert_eq!(hash.text().parse(), Ok(hash));
        for wrong in [
            "",
            "af63dc4c8601ec8",
            "AF63DC4C8601EC8C",
            "+f63dc4c8601ec8c",
            "af63dc4c8601ec8cc",
        ] {
            assert_eq!(wrong.parse::<Fnv>(), Err(FnvError), "{wrong}");
        }
    }
}
