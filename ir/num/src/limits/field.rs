//! Limited fields of files that are read by `serde`.
//!
//! A field is read as any number, then compared: so the message is the same for
//! one too many, for a minus sign and for 10^30, and a reader with places puts
//! the caret under the value.

use super::{Amount, NumberLimit};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;

/// A type that a limited field can have.
pub trait LimitedField: Sized {
    /// The type with a number that was compared with its limit, and so fits.
    fn from_amount(amount: Amount) -> Self;
    /// The number a value represents, if it represents one.
    fn amount(&self) -> Option<Amount>;
    /// The value of a field that is present but empty (`null`), where that is
    /// allowed.
    fn nothing() -> Option<Self> {
        None
    }
}

impl LimitedField for u32 {
    fn from_amount(amount: Amount) -> u32 {
        match amount {
            Amount::Whole(number) => u32::try_from(number).unwrap_or(u32::MAX),
            Amount::Real(number) => number as u32,
        }
    }
    fn amount(&self) -> Option<Amount> {
        Some(Amount::Whole(u64::from(*self)))
    }
}

impl LimitedField for f64 {
    fn from_amount(amount: Amount) -> f64 {
        match amount {
            Amount::Whole(number) => number as f64,
            Amount::Real(number) => number,
        }
    }
    fn amount(&self) -> Option<Amount> {
        Some(Amount::Real(*self))
    }
}

impl<T: LimitedField> LimitedField for Option<T> {
    fn from_amount(amount: Amount) -> Option<T> {
        Some(T::from_amount(amount))
    }
    fn amount(&self) -> Option<Amount> {
        self.as_ref().and_then(T::amount)
    }
    fn nothing() -> Option<Option<T>> {
        Some(None)
    }
}

/// Reads a field and compares it with its limit.
///
/// # Errors
///
/// Fails when the field holds no number, or one that is not allowed; the
/// message names the field.
pub fn deserialize<'de, T, D>(
    name: &str,
    limit: NumberLimit,
    deserializer: D,
) -> Result<T, D::Error>
where
    T: LimitedField,
    D: Deserializer<'de>,
{
    let refuse = |reason: String| de::Error::custom(format!("'{name}': {reason}"));
    let amount = match Number::deserialize(deserializer)? {
        Number::Nothing => {
            return T::nothing().ok_or_else(|| refuse("expected a number".to_owned()));
        }
        Number::Negative(number) if limit.is_whole() => {
            return Err(refuse(limit.refusal(&number.to_string())));
        }
        Number::Negative(number) => Amount::Real(number as f64),
        Number::Amount(amount) => amount,
    };
    limit.check(amount).map_err(refuse)?;
    Ok(T::from_amount(amount))
}

/// Declares the limited fields of a kind of file: for each a module of its
/// name, with its limit and the function that `serde` reads it by
/// (`#[serde(deserialize_with = "fields::count::deserialize")]`), and the list
/// of all of them.
#[macro_export]
macro_rules! limited_fields {
    ($(
        $(#[doc = $documentation:expr])*
        $field:ident ($name:literal, $usual:literal) = $limit:expr;
    )+) => {
        $(
            $(#[doc = $documentation])*
            pub mod $field {
                use $crate::limits::{LimitedField, NumberLimit};

                /// Allowed numbers.
                pub const LIMIT: NumberLimit = $limit;

                /// Reads the field.
                ///
                /// # Errors
                ///
                /// Fails when it holds no number, or one that is not allowed.
                pub fn deserialize<'de, T, D>(deserializer: D) -> Result<T, D::Error>
                where
                    T: LimitedField,
                    D: serde::Deserializer<'de>,
                {
                    $crate::limits::deserialize($name, LIMIT, deserializer)
                }

                /// Compares a value that came another way.
                ///
                /// # Errors
                ///
                /// Fails when it is not allowed.
                pub fn check<T: LimitedField>(value: &T) -> Result<(), String> {
                    match value.amount() {
                        None => Ok(()),
                        Some(amount) => LIMIT
                            .check(amount)
                            .map_err(|reason| format!("'{}': {reason}", $name)),
                    }
                }
            }
        )+

        /// All limited fields: name, limit, and the value when none is given.
        pub const FIELDS: &[(&str, $crate::limits::NumberLimit, &str)] =
            &[$(($name, $field::LIMIT, $usual)),+];
    };
}

/// A number of a file.
enum Number {
    Amount(Amount),
    Negative(i64),
    Nothing,
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Number, D::Error> {
        deserializer.deserialize_any(NumberVisitor)
    }
}

struct NumberVisitor;

impl Visitor<'_> for NumberVisitor {
    type Value = Number;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a number")
    }
    fn visit_u64<E>(self, number: u64) -> Result<Number, E> {
        Ok(Number::Amount(Amount::Whole(number)))
    }
    fn visit_i64<E>(self, number: i64) -> Result<Number, E> {
        Ok(match u64::try_from(number) {
            Ok(number) => Number::Amount(Amount::Whole(number)),
            Err(_) => Number::Negative(number),
        })
    }
    fn visit_f64<E>(self, number: f64) -> Result<Number, E> {
        Ok(Number::Amount(Amount::Real(number)))
    }
    fn visit_unit<E>(self) -> Result<Number, E> {
        Ok(Number::Nothing)
    }
}
