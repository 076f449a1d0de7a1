//! Names of implementations: `cordic(iterations=24 bits=32)`.

use super::Implementation;
use crate::trigonometry::MAX_ORDER;
use std::fmt;
use std::str::FromStr;

/// The reason why a text names no implementation.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ImplementationError {
    /// It has another form.
    #[error(
        "expected polynomial(order=N bits=B), table(entries=N degree=D bits=B) or \
         cordic(iterations=N bits=B)"
    )]
    Unreadable,
    /// A number that cannot be.
    #[error(
        "there are 8 to 50 bits, 1 to 65536 entries, a power of two, degrees and orders from 1 \
         to {MAX_ORDER}, and 1 to 60 iterations"
    )]
    Number,
}

impl fmt::Display for Implementation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Implementation::Polynomial { order, bits } => {
                write!(formatter, "polynomial(order={order} bits={bits})")
            }
            Implementation::Table {
                entries,
                degree,
                bits,
            } => write!(
                formatter,
                "table(entries={entries} degree={degree} bits={bits})"
            ),
            Implementation::Cordic { iterations, bits } => {
                write!(formatter, "cordic(iterations={iterations} bits={bits})")
            }
        }
    }
}

impl FromStr for Implementation {
    type Err = ImplementationError;

    fn from_str(text: &str) -> Result<Implementation, ImplementationError> {
        let unreadable = || ImplementationError::Unreadable;
        let (kind, rest) = text.trim().split_once('(').ok_or_else(unreadable)?;
        let inside = rest.strip_suffix(')').ok_or_else(unreadable)?;
        let mut words = Vec::new();
        for word in inside.split_whitespace() {
            let (name, number) = word.split_once('=').ok_or_else(unreadable)?;
            words.push((name, number.parse::<u32>().map_err(|_| unreadable())?));
        }
        let found = match (kind, words.as_slice()) {
            ("polynomial", &[("order", order), ("bits", bits)]) => {
                Implementation::Polynomial { order, bits }
            }
            ("table", &[("entries", entries), ("degree", degree), ("bits", bits)]) => {
                Implementation::Table {
                    entries,
                    degree,
                    bits,
                }
            }
            ("cordic", &[("iterations", iterations), ("bits", bits)]) => {
                Implementation::Cordic { iterations, bits }
            }
            _ => return Err(unreadable()),
        };
        found.checked()
    }
}

impl Implementation {
    /// The implementation, when it is one that can be built.
    ///
    /// # Errors
    ///
    /// [`ImplementationError::Number`] when a number is out of its range.
    pub fn checked(self) -> Result<Implementation, ImplementationError> {
        let possible = match self {
            Implementation::Polynomial { order, .. } => (1..=MAX_ORDER).contains(&order),
            Implementation::Table {
                entries, degree, ..
            } => {
                let fits = (1..=Implementation::MAX_ENTRIES).contains(&entries);
                fits && entries.is_power_of_two() && (1..=MAX_ORDER).contains(&degree)
            }
            Implementation::Cordic { iterations, .. } => (1..=60).contains(&iterations),
        };
        if possible && Implementation::BITS.contains(&self.bits()) {
            Ok(self)
        } else {
            Err(ImplementationError::Number)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for text in [
            "polynomial(order=7 bits=30)",
            "table(entries=64 degree=2 bits=32)",
            "cordic(iterations=24 bits=28)",
        ] {
            let found: Implementation = text.parse().expect(text);
            assert_eq!(found.to_string(), text);
        }
        for text in [
            "",
            "cordic",
            "cordic(24)",
            "sine(order=1 bits=8)",
            "table(degree=1)",
        ] {
            let found = text.parse::<Implementation>();
            assert_eq!(found, Err(ImplementationError::Unreadable), "{text}");
        }
        for text in [
            "cordic(iterations=0 bits=30)",
            "cordic(iterations=9 bits=60)",
            "table(entries=3 degree=1 bits=20)",
            "polynomial(order=99 bits=20)",
        ] {
            let found = text.parse::<Implementation>();
            assert_eq!(found, Err(ImplementationError::Number), "{text}");
        }
    }
}
