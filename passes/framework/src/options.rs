//! Typed options of passes.
//!
//! The fields of a pass's structure are its options: name, type, default and
//! documentation stand in one place and nowhere else, so that the help, the
//! parser and the printer cannot drift apart. A number cannot be declared
//! without its limit: the compiler refuses it.

use crate::registry::Registry;
use robovec_ir::Format;
use robovec_num::format::FormatError;
use robovec_num::limits::{Amount, LimitRow, NumberLimit};

/// A type an option can have.
pub trait OptionValue: Sized + PartialEq {
    /// Whether values are numbers, so that an option of this type needs a
    /// limit.
    const IS_NUMBER: bool = false;
    /// What the help calls the type (`integer`, `first | preferential`).
    fn type_name() -> String;
    /// Reads a value from a pipeline's text; the error says what is wanted.
    ///
    /// # Errors
    ///
    /// When the text is no such value.
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

/// A number format by its name; one with parentheses stands in quotes.
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

/// What the registry knows of an option.
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
    /// The numbers it can be, when it is one.
    pub limit: Option<NumberLimit>,
}

impl OptionInfo {
    /// Its type for people: `integer, 1 to 64`.
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
/// What is wrong with the text: no value of the type, or beyond the limit.
pub fn read<T: OptionValue>(text: &str, limit: Option<NumberLimit>) -> Result<T, String> {
    let read = T::parse(text);
    let Some(limit) = limit else { return read };
    match read {
        Ok(value) => match value.amount() {
            Some(amount) if !limit.admits(amount) => Err(limit.refusal(text)),
            Some(_) | None => Ok(value),
        },
        // One too many for the type is a number as well.
        Err(_) if text.parse::<f64>().is_ok() => Err(limit.refusal(text)),
        Err(reason) => Err(reason),
    }
}

/// The limits of all options of all passes, and of groups.
pub fn rows(registry: &Registry) -> Vec<LimitRow> {
    let mut rows = Vec::new();
    for pass in registry.passes {
        for option in pass.options {
            rows.extend(option.limit.map(|limit| LimitRow {
                place: pass.name.to_owned(),
                name: option.name.to_owned(),
                limit,
                usual: (option.default)(),
            }));
        }
    }
    rows.push(LimitRow {
        place: "fixpoint".to_owned(),
        name: "max".to_owned(),
        limit: crate::pipeline::ROUNDS,
        usual: crate::pipeline::DEFAULT_ROUNDS.to_string(),
    });
    rows
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
        /// What is wrong.
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

/// Declares a pass: a structure whose fields are its options, and its entry
/// for the registry. The doc comment is the pass's page in the manual; its
/// first line is the one-line description. A field that is a number says
/// behind `=>` what it can be: `pub rounds: u32 = 6 => NumberLimit::whole(0, 64,
/// "every round takes as long as the first")`.
#[macro_export]
macro_rules! declare_pass {
    (
        $(#[doc = $documentation:expr])*
        pub struct $pass:ident($name:literal) {
            $($(#[doc = $field_documentation:expr])* pub $field:ident: $type:ty = $default:expr $(=> $limit:expr)?),* $(,)?
        }
        takes: [$($takes:ident),+],
        gives: $gives:expr,
        class: $class:ident,
        requires: [$($requires:ident),*],
        sets: [$($sets:ident),*],
        destroys: [$($destroys:ident),*] $(,)?
    ) => {
        $(#[doc = $documentation])*
        #[derive(Clone, PartialEq, Debug)]
        pub struct $pass {
            $($(#[doc = $field_documentation])* pub $field: $type),*
        }

        impl Default for $pass {
            fn default() -> $pass {
                $pass { $($field: $default),* }
            }
        }

        impl $pass {
            /// The pass's entry in the registry.
            pub const INFO: $crate::pass::PassInfo = $crate::pass::PassInfo {
                name: $name,
                documentation: concat!($($documentation, "\n"),*),
                options: &[$($crate::options::OptionInfo {
                    name: $crate::options::plain_name(stringify!($field)),
                    documentation: concat!($($field_documentation, "\n"),*),
                    type_name: <$type as $crate::options::OptionValue>::type_name,
                    default: || $crate::options::OptionValue::print(&$pass::default().$field),
                    limit: {
                        #[allow(unused_mut, unused_assignments)]
                        let mut limit: Option<robovec_num::limits::NumberLimit> = None;
                        $(limit = Some($limit);)?
                        assert!(
                            limit.is_some() || !<$type as $crate::options::OptionValue>::IS_NUMBER,
                            "an option that is a number needs a limit"
                        );
                        limit
                    },
                }),*],
                takes: &[$(robovec_ir::Level::$takes),+],
                gives: $gives,
                class: $crate::NumericClass::$class,
                requires: &[$($crate::pass::Property::$requires),*],
                sets: &[$($crate::pass::Property::$sets),*],
                destroys: &[$($crate::pass::Property::$destroys),*],
                build: $pass::build,
            };

            #[allow(unused_mut, unused_variables, clippy::never_loop)]
            fn build(
                options: &[(String, String)],
            ) -> Result<Box<dyn $crate::pass::Pass>, $crate::options::OptionError> {
                let mut pass = $pass::default();
                for (name, text) in options {
                    let limit = || {
                        let known = $pass::INFO.options.iter();
                        known.filter(|option| option.name == name).find_map(|option| option.limit)
                    };
                    match name.as_str() {
                        $(known if known == $crate::options::plain_name(stringify!($field)) => {
                            pass.$field = $crate::options::read(text, limit()).map_err(
                                |reason| $crate::options::OptionError::Value {
                                    name: name.clone(),
                                    reason,
                                },
                            )?;
                        })*
                        _ => return Err($crate::options::OptionError::Unknown(name.clone())),
                    }
                }
                Ok(Box::new(pass))
            }
        }
    };
}
