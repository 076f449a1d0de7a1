//! Typed options of passes.
//!
//! The fields of a pass's structure are its options: name, type, default and
//! documentation are in one place and nowhere else, so that the help, the
//! parser and the printer cannot drift apart. A number cannot be declared
//! without its limit: the compiler refuses it.

use robovec_ir::Format;
use robovec_num::decimal;
use robovec_num::format::FormatError;
use robovec_num::limits::{Amount, NumberLimit};

/// A type an option can have.
pub trait OptionValue: Sized + PartialEq {
    /// True if values are numbers, so that an option of this type needs a
    /// limit.
    const IS_NUMBER: bool = false;
    /// Name of the type in the help (`integer`, `first | preferential`).
    fn type_name() -> String;
    /// Reads a value from a pipeline's text; the error describes the expected
    /// form.
    ///
    /// # Errors
    ///
    /// Fails when the text is no such value.
    fn parse(text: &str) -> Result<Self, String>;
    /// Writes the value so that [`OptionValue::parse`] reads it back.
    fn print(&self) -> String;
    /// The number that is compared with the limit, if the value has one.
    fn amount(&self) -> Option<Amount> {
        None
    }
}

impl OptionValue for bool {
    fn type_name() -> String {
        "true | false".to_owned()
    }
    fn parse(text: &str) -> Result<bool, String> {
        match text {
            "true" | "" => Ok(true),
            "false" => Ok(false),
            other => Err(format!("'{other}' is neither true nor false")),
        }
    }
    fn print(&self) -> String {
        self.to_string()
    }
}

impl OptionValue for u32 {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "integer".to_owned()
    }
    fn parse(text: &str) -> Result<u32, String> {
        text.parse()
            .map_err(|_| format!("'{text}' is not an integer"))
    }
    fn print(&self) -> String {
        self.to_string()
    }
    fn amount(&self) -> Option<Amount> {
        Some(Amount::Whole(u64::from(*self)))
    }
}

/// An integer that may be left to the machine file.
impl OptionValue for Option<u32> {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "integer | machine".to_owned()
    }
    fn parse(text: &str) -> Result<Option<u32>, String> {
        match text {
            "machine" => Ok(None),
            other => u32::parse(other).map(Some),
        }
    }
    fn print(&self) -> String {
        match self {
            None => "machine".to_owned(),
            Some(number) => number.to_string(),
        }
    }
    fn amount(&self) -> Option<Amount> {
        self.and_then(|number| number.amount())
    }
}

/// A number format by its name; one with parentheses is in quotes.
impl OptionValue for Format {
    fn type_name() -> String {
        "f32 | f64 | \"float(EXPONENT,MANTISSA)\" | ...".to_owned()
    }
    fn parse(text: &str) -> Result<Format, String> {
        text.parse().map_err(|error: FormatError| error.to_string())
    }
    fn print(&self) -> String {
        self.to_string()
    }
}

/// Reads names joined by `+`, each once.
///
/// # Errors
///
/// Fails when one is empty or is there twice.
pub fn joined_names(text: &str) -> Result<Vec<String>, String> {
    let names: Vec<String> = text.split('+').map(str::to_owned).collect();
    if names.iter().any(String::is_empty) {
        return Err(format!("'{text}' is not a list of names joined by '+'"));
    }
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("'{}' is named twice", pair[0])),
        None => Ok(names),
    }
}

/// Entry of the registry about an option.
#[derive(Clone, Copy, Debug)]
pub struct OptionInfo {
    /// Its name in the pipeline.
    pub name: &'static str,
    /// Its documentation.
    pub documentation: &'static str,
    /// Name of its type.
    pub type_name: fn() -> String,
    /// Its default, as text.
    pub default: fn() -> String,
    /// The limit of its numbers, if it is one.
    pub limit: Option<NumberLimit>,
}

impl OptionInfo {
    /// Its type for users: `integer, 1 to 64`.
    pub fn type_text(&self) -> String {
        let name = (self.type_name)();
        match &self.limit {
            None => name,
            Some(limit) => format!("{name}, {} to {}", limit.least(), limit.most()),
        }
    }
}

/// Reads an option's value and compares it with the option's limit.
///
/// # Errors
///
/// The fault of the text: no value of the type, or beyond the limit.
pub fn read<T: OptionValue>(text: &str, limit: Option<NumberLimit>) -> Result<T, String> {
    let read = T::parse(text);
    let Some(limit) = limit else { return read };
    match read {
        Ok(value) => match value.amount() {
            Some(Amount::Real(number)) if decimal::is_lost(text, number) => {
                Err(format!("{text} is too small: {}", decimal::LOST))
            }
            Some(amount) if !limit.admits(amount) => Err(limit.refusal(text)),
            Some(_) | None => Ok(value),
        },
        // One too many for the type is a number as well.
        Err(_) if text.parse::<f64>().is_ok() => Err(limit.refusal(text)),
        Err(reason) => Err(reason),
    }
}

/// An option in a pipeline that its pass cannot take.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum OptionError {
    /// The pass has no such option.
    #[error("no option '{0}'")]
    Unknown(String),
    /// The option's value is of the wrong type.
    #[error("option '{name}': {reason}")]
    Value {
        /// The option.
        name: String,
        /// Fault in words.
        reason: String,
    },
}

/// The name of an option as users write it: a field named by a word that Rust
/// keeps for itself (`r#for`) loses its prefix.
pub const fn plain_name(field: &'static str) -> &'static str {
    match field.as_bytes() {
        [b'r', b'#', name @ ..] => match std::str::from_utf8(name) {
            Ok(name) => name,
            Err(_) => field,
        },
        _ => field,
    }
}

/// An enumeration of words as an option type.
#[macro_export]
macro_rules! option_words {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum $name { $($(#[$variant_meta])* $variant),+ }

        impl $crate::options::OptionValue for $name {
            fn type_name() -> String {
                [$($word),+].join(" | ")
            }
            fn parse(text: &str) -> Result<$name, String> {
                match text {
                    $($word => Ok($name::$variant),)+
                    other => Err(format!("'{other}' is not one of {}", Self::type_name())),
                }
            }
            fn print(&self) -> String {
                match self { $($name::$variant => $word.to_owned()),+ }
            }
        }
    };
}
