//! Limits: the numbers that a user may write, and the cost of larger ones.
//!
//! Every number that comes from outside (an option of a pass, a flag of a
//! program, a field of a file) is declared with an [`NumberLimit`] beside it.
//! The reader of the number uses it, the message beyond the limit is made from
//! it, and so is the table of all limits (`docs/limits.md`), which tests walk
//! through. No limit is in another place.
//!
//! **Invariant.** Within the limits nothing overflows, and a small input is
//! treated in seconds; the reason gives the cost of a larger number, or the
//! quantity that could not be represented.

mod field;

pub use field::{LimitedField, deserialize};

use crate::decimal;
use std::borrow::Cow;
use std::fmt;

/// A number as a user writes it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Amount {
    /// An integer.
    Whole(u64),
    /// Any number.
    Real(f64),
}

/// The numbers that may be at some place, both ends included.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NumberLimit {
    least: Amount,
    most: Amount,
    reason: &'static str,
}

impl NumberLimit {
    /// Integers from `least` to `most`. The reason is a clause that shows why
    /// not more: "every round reads the function again".
    pub const fn whole(least: u64, most: u64, reason: &'static str) -> NumberLimit {
        assert!(least <= most, "a limit allows a number");
        NumberLimit {
            least: Amount::Whole(least),
            most: Amount::Whole(most),
            reason,
        }
    }

    /// Numbers from `least` to `most`, both finite.
    pub const fn real(least: f64, most: f64, reason: &'static str) -> NumberLimit {
        assert!(
            least <= most && least.is_finite() && most.is_finite(),
            "a limit allows a number, and its ends are finite"
        );
        NumberLimit {
            least: Amount::Real(least),
            most: Amount::Real(most),
            reason,
        }
    }

    /// Every integer of 64 bits: for seeds, of which none costs more.
    pub const SEED: NumberLimit = NumberLimit::whole(0, u64::MAX, "a seed costs nothing");

    /// The smallest number.
    pub const fn least(&self) -> Amount {
        self.least
    }

    /// The largest number.
    pub const fn most(&self) -> Amount {
        self.most
    }

    /// The largest integer; 0 where numbers need not be integers.
    pub const fn most_whole(&self) -> u64 {
        match self.most {
            Amount::Whole(most) => most,
            Amount::Real(_) => 0,
        }
    }

    /// The reason why no more is allowed.
    pub const fn reason(&self) -> &'static str {
        self.reason
    }

    /// True when only integers are allowed.
    pub const fn is_whole(&self) -> bool {
        matches!(self.least, Amount::Whole(_))
    }

    /// Tests whether the number is allowed.
    pub fn admits(&self, amount: Amount) -> bool {
        match (self.least, amount, self.most) {
            (Amount::Whole(least), Amount::Whole(number), Amount::Whole(most)) => {
                (least..=most).contains(&number)
            }
            (Amount::Real(least), Amount::Real(number), Amount::Real(most)) => {
                (least..=most).contains(&number)
            }
            (Amount::Real(_), Amount::Whole(number), _) => self.admits(Amount::Real(number as f64)),
            _ => false,
        }
    }

    /// The message about a number that is not allowed, as written.
    pub fn refusal(&self, written: &str) -> String {
        let written = clip(written);
        format!(
            "{written} is not allowed: {self}, since {reason}",
            reason = self.reason
        )
    }

    /// Checks a number; the error is the reason why it is refused.
    ///
    /// # Errors
    ///
    /// The message for the user, when the number is not allowed.
    pub fn check(&self, amount: Amount) -> Result<(), String> {
        if self.admits(amount) {
            return Ok(());
        }
        Err(self.refusal(&amount.to_string()))
    }

    /// Reads an integer of a text.
    ///
    /// # Errors
    ///
    /// The message for the user, when the text is no such number or is not
    /// allowed.
    pub fn read_whole(&self, text: &str) -> Result<u64, String> {
        match text.parse::<u64>() {
            Ok(number) if self.admits(Amount::Whole(number)) => Ok(number),
            Ok(_) | Err(_) => Err(self.refusal(&quoted(text))),
        }
    }

    /// Reads a number of a text.
    ///
    /// # Errors
    ///
    /// As [`NumberLimit::read_whole`].
    pub fn read_real(&self, text: &str) -> Result<f64, String> {
        match text.parse::<f64>() {
            Ok(number) if decimal::is_lost(text, number) => {
                Err(format!("{} is too small: {}", clip(text), decimal::LOST))
            }
            Ok(number) if self.admits(Amount::Real(number)) => Ok(number),
            Ok(_) | Err(_) => Err(self.refusal(&quoted(text))),
        }
    }
}

/// A number with the noun that is counted, given in the singular: `1 design`,
/// `2 designs`, `0 entries`. The plural is the regular one.
pub fn counted(count: impl TryInto<u64>, noun: &str) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    let ends = |ends: &[&str]| ends.iter().any(|end| noun.ends_with(end));
    match noun.strip_suffix('y') {
        _ if count == 1 => format!("1 {noun}"),
        Some(stem) if !ends(&["ay", "ey", "oy"]) => format!("{count} {stem}ies"),
        _ if ends(&["s", "x", "ch", "sh"]) => format!("{count} {noun}es"),
        _ => format!("{count} {noun}s"),
    }
}

/// A piece of the user's text for use in a message: at most 60 characters,
/// with an ellipsis where it was cut.
pub fn clip(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(60) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}

/// A word that is no number is in quotation marks.
fn quoted(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(_) => text.to_owned(),
        Err(_) => format!("'{}'", clip(text)),
    }
}

impl fmt::Display for Amount {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Amount::Whole(number) => write!(formatter, "{number}"),
            Amount::Real(number) if number == 0.0 || (1e-3..1e6).contains(&number.abs()) => {
                write!(formatter, "{number}")
            }
            Amount::Real(number) => write!(formatter, "{number:e}"),
        }
    }
}

/// As "an integer from 1 to 64".
impl fmt::Display for NumberLimit {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.is_whole() {
            "an integer"
        } else {
            "a number"
        };
        if self.least == self.most {
            return write!(formatter, "only {} is", self.least);
        }
        write!(formatter, "{kind} from {} to {} is", self.least, self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROUNDS: NumberLimit = NumberLimit::whole(1, 64, "every round reads the function again");
    const CLOCK: NumberLimit = NumberLimit::real(1e-3, 1e6, "no element runs at it");

    #[test]
    fn both_ends_are_allowed_and_nothing_beside_them() {
        for (text, number) in [("1", 1), ("64", 64), ("+7", 7)] {
            assert_eq!(ROUNDS.read_whole(text), Ok(number));
        }
        for text in [
            "0",
            "65",
            "-1",
            "1.5",
            "1e1",
            "",
            "nan",
            "x",
            "4294967296",
            "18446744073709551616",
        ] {
            assert!(ROUNDS.read_whole(text).is_err(), "{text}");
        }
        for (text, number) in [("1e-3", 1e-3), ("1000000", 1e6), ("5", 5.0)] {
            assert_eq!(CLOCK.read_real(text), Ok(number));
        }
        for text in [
            "0", "nan", "inf", "-inf", "-1", "1e-300", "1e308", "1e999", "", "x",
        ] {
            assert!(CLOCK.read_real(text).is_err(), "{text}");
        }
        assert!(!ROUNDS.admits(Amount::Real(1.0)));
        assert!(CLOCK.admits(Amount::Whole(3)));
    }

    #[test]
    fn refusals_name_the_number_the_limit_and_the_reason() {
        assert_eq!(
            ROUNDS.read_whole("4294967295").expect_err("too many"),
            "4294967295 is not allowed: an integer from 1 to 64 is, since every round reads the \
             function again"
        );
        assert_eq!(
            CLOCK.check(Amount::Real(1e-300)).expect_err("too slow"),
            "1e-300 is not allowed: a number from 0.001 to 1e6 is, since no element runs at it"
        );
        let two = NumberLimit::whole(2, 2, "there is no other");
        assert_eq!(
            two.read_whole("three").expect_err("no number"),
            "'three' is not allowed: only 2 is, since there is no other"
        );
    }

    #[test]
    fn counts_have_the_right_noun() {
        for (count, noun, text) in [
            (1, "model", "1 model"),
            (0, "state", "0 states"),
            (2, "entry", "2 entries"),
            (3, "box", "3 boxes"),
            (4, "array", "4 arrays"),
        ] {
            assert_eq!(counted(count, noun), text);
        }
    }
}
