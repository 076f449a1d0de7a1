//! Number formats of machines, values and measurements.
//!
//! A format is data, so that a search can walk through formats and a machine
//! file can name one. Names are those of [`Format::from_str`]: `f16`, `bf16`,
//! `f32`, `f64`, `float(8,17)` for 8 bits of exponent and 17 stored bits of
//! mantissa, `float(8,17,flush)` for the same without subnormal numbers, and
//! `fixed(12,19)` for a sign, 12 bits before the point and 19 after it. The
//! thesis calls formats between and below the IEEE ones *customised* (1.1).

pub mod fields;

use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// A binary floating-point format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberFormat {
    /// Width of the exponent, in bits.
    #[serde(deserialize_with = "fields::exponent::deserialize")]
    pub exponent: u32,
    /// Width of the stored mantissa, in bits.
    #[serde(deserialize_with = "fields::mantissa::deserialize")]
    pub mantissa: u32,
    /// True if subnormal numbers are kept, false if they are flushed to zero.
    pub subnormals: bool,
}

/// A number format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Format {
    /// Binary floating point, rounded to nearest with ties to even.
    Float(NumberFormat),
    /// Two's complement fixed point, rounded to nearest with ties to even,
    /// saturating.
    Fixed(FixedFormat),
}

/// A fixed-point format: multiples of `2^-fraction` from `-2^integer` up to,
/// but not including, `2^integer`. At most 53 bits, so that its numbers are
/// binary64 numbers as those of every other format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct FixedFormat {
    /// Bits before the point, without the sign.
    pub integer: u32,
    /// Bits after the point.
    pub fraction: u32,
}

impl Format {
    /// IEEE binary32.
    pub const BINARY32: Format = Format::Float(NumberFormat::BINARY32);
    /// IEEE binary64.
    pub const BINARY64: Format = Format::Float(NumberFormat::BINARY64);

    /// The widest exponent and mantissa: those of binary64, which carries
    /// the numbers of every other format exactly.
    pub const WIDEST: NumberFormat = NumberFormat::BINARY64;

    /// True for widths that can be computed with: those that
    /// [`Format::from_str`] accepts.
    pub fn is_possible(self) -> bool {
        match self {
            Format::Float(float) => {
                (2..=11).contains(&float.exponent) && (1..=52).contains(&float.mantissa)
            }
            Format::Fixed(fixed) => {
                let bits = fixed.integer.saturating_add(fixed.fraction);
                (1..=53).contains(&bits)
            }
        }
    }

    /// Bits of a word.
    pub fn width(self) -> u32 {
        match self {
            Format::Float(float) => 1 + float.exponent + float.mantissa,
            Format::Fixed(fixed) => 1 + fixed.integer + fixed.fraction,
        }
    }

    /// Bits of the significand that an operation's multiplier has to handle:
    /// with the hidden one of a float, without the sign.
    pub fn significand(self) -> u32 {
        match self {
            Format::Float(float) => float.mantissa + 1,
            Format::Fixed(fixed) => fixed.integer + fixed.fraction,
        }
    }

    /// The largest distance of a number of size 1 from the nearest number of
    /// the format.
    pub fn unit_roundoff(self) -> f64 {
        let bits = match self {
            Format::Float(float) => float.mantissa,
            Format::Fixed(fixed) => fixed.fraction,
        };
        2f64.powi(-(bits as i32) - 1)
    }
}

impl NumberFormat {
    /// IEEE binary32.
    pub const BINARY32: NumberFormat = NumberFormat {
        exponent: 8,
        mantissa: 23,
        subnormals: true,
    };
    /// IEEE binary64.
    pub const BINARY64: NumberFormat = NumberFormat {
        exponent: 11,
        mantissa: 52,
        subnormals: true,
    };

    /// The largest exponent of a finite number.
    pub fn largest_exponent(self) -> i32 {
        (1 << (self.exponent - 1)) - 1
    }

    /// The exponent of the smallest normal number.
    pub fn smallest_exponent(self) -> i32 {
        1 - self.largest_exponent()
    }
}

impl Default for Format {
    fn default() -> Format {
        Format::BINARY32
    }
}

/// A float is written as a table of its fields, anything else by its name.
impl Serialize for Format {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Format::Float(float) => float.serialize(serializer),
            Format::Fixed(_) => serializer.collect_str(self),
        }
    }
}

/// Every format can be read from its name, a float also from a table.
impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Format, D::Error> {
        deserializer.deserialize_any(FormatVisitor)
    }
}

struct FormatVisitor;

impl<'de> Visitor<'de> for FormatVisitor {
    type Value = Format;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the name of a number format, as \"float(8,17)\", or a table with exponent, mantissa and subnormals")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<Format, E> {
        name.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, fields: A) -> Result<Format, A::Error> {
        NumberFormat::deserialize(MapAccessDeserializer::new(fields)).map(Format::Float)
    }
}

/// The names of formats with their own name.
const NAMED: [(&str, u32, u32); 4] = [
    ("f16", 5, 10),
    ("bf16", 8, 7),
    ("f32", 8, 23),
    ("f64", 11, 52),
];

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Format::Float(float) => {
                let (exponent, mantissa) = (float.exponent, float.mantissa);
                let named = NAMED
                    .iter()
                    .find(|(_, e, m)| (*e, *m) == (exponent, mantissa));
                match (named, float.subnormals) {
                    (Some((name, ..)), true) => formatter.write_str(name),
                    (None, true) => write!(formatter, "float({exponent},{mantissa})"),
                    (_, false) => write!(formatter, "float({exponent},{mantissa},flush)"),
                }
            }
            Format::Fixed(fixed) => {
                write!(formatter, "fixed({},{})", fixed.integer, fixed.fraction)
            }
        }
    }
}

/// The reason why a text is no format.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum FormatError {
    /// It does not read as one.
    #[error(
        "expected a number format: f16, bf16, f32, f64, float(EXPONENT,MANTISSA), \
         float(EXPONENT,MANTISSA,flush) or fixed(INTEGER,FRACTION)"
    )]
    Unreadable,
    /// A width that cannot be computed with.
    #[error(
        "a float has 2 to 11 bits of exponent and 1 to 52 of mantissa, \
         a fixed-point number at most 53 bits without its sign, at least one of them"
    )]
    Width,
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Format, FormatError> {
        let text = text.trim();
        if let Some(&(_, exponent, mantissa)) = NAMED.iter().find(|(name, ..)| *name == text) {
            return Ok(Format::Float(NumberFormat {
                exponent,
                mantissa,
                subnormals: true,
            }));
        }
        let (kind, rest) = text.split_once('(').ok_or(FormatError::Unreadable)?;
        let inside = rest.strip_suffix(')').ok_or(FormatError::Unreadable)?;
        let parts: Vec<&str> = inside.split(',').map(str::trim).collect();
        let number = |text: &str| text.parse::<u32>().map_err(|_| FormatError::Unreadable);
        let format = match (kind.trim(), parts.as_slice()) {
            ("float", [exponent, mantissa, rest @ ..]) => Format::Float(NumberFormat {
                exponent: number(exponent)?,
                mantissa: number(mantissa)?,
                subnormals: match rest {
                    [] => true,
                    ["flush"] => false,
                    _ => return Err(FormatError::Unreadable),
                },
            }),
            ("fixed", [integer, fraction]) => Format::Fixed(FixedFormat {
                integer: number(integer)?,
                fraction: number(fraction)?,
            }),
            _ => return Err(FormatError::Unreadable),
        };
        if format.is_possible() {
            Ok(format)
        } else {
            Err(FormatError::Width)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for text in [
            "f16",
            "bf16",
            "f32",
            "f64",
            "float(8,17)",
            "float(8,23,flush)",
            "fixed(12,19)",
        ] {
            let format: Format = text.parse().expect(text);
            assert_eq!(format.to_string(), text);
        }
        assert_eq!("float( 8 , 23 )".parse(), Ok(Format::BINARY32));
        for text in [
            "",
            "f31",
            "float(8)",
            "float(8,23,flash)",
            "fixed(8,-1)",
            "float(8,23",
        ] {
            assert_eq!(
                text.parse::<Format>(),
                Err(FormatError::Unreadable),
                "{text}"
            );
        }
        for text in [
            "float(1,3)",
            "float(12,3)",
            "float(8,53)",
            "fixed(40,40)",
            "fixed(0,0)",
        ] {
            assert_eq!(text.parse::<Format>(), Err(FormatError::Width), "{text}");
        }
    }

    #[test]
    fn widths_and_roundoffs_are_those_of_the_formats() {
        assert_eq!(Format::BINARY32.width(), 32);
        assert_eq!(
            Format::BINARY32.unit_roundoff(),
            f64::from(f32::EPSILON) / 2.0
        );
        assert_eq!(Format::BINARY64.unit_roundoff(), f64::EPSILON / 2.0);
        assert_eq!(NumberFormat::BINARY32.smallest_exponent(), -126);
        assert_eq!(NumberFormat::BINARY64.largest_exponent(), 1023);
        let fixed: Format = "fixed(15,16)".parse().expect("it is one");
        assert_eq!((fixed.width(), fixed.unit_roundoff()), (32, 2f64.powi(-17)));
    }
}
