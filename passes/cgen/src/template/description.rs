//! The description of a target, `target.toml`.

use super::pattern::{OperationText, TextPattern};
use super::{TargetError, line_of};
use robovec_framework::pass::TargetFolder;
use robovec_ir::Operation;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// The text of a key, with its place.
type PlacedText = Spanned<String>;

/// `target.toml` as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenTarget {
    file: PlacedText,
    #[serde(default)]
    nested: bool,
    #[serde(default)]
    from_one: bool,
    #[serde(default)]
    reserved: String,
    text: WrittenTexts,
    operations: WrittenOperations,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenTexts {
    scalar: PlacedText,
    vector: PlacedText,
    matrix: PlacedText,
    number: PlacedText,
    infinity: Option<String>,
    nan: Option<String>,
    constant: Option<PlacedText>,
    value: Option<PlacedText>,
}

macro_rules! operations {
    ($($name:ident $operation:ident),+) => {
        /// The text of every operation; a target need not have all.
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct WrittenOperations { $($name: Option<PlacedText>),+ }

        impl WrittenOperations {
            fn all(&self) -> [(Operation, &Option<PlacedText>); Operation::ALL.len()] {
                [$((Operation::$operation, &self.$name)),+]
            }
        }
    };
}

operations!(
    copy Copy, neg Neg, add Add, sub Sub, mul Mul, div Div, sin Sin, cos Cos, sqrt Sqrt, fma Fma,
    fms Fms, fnma Fnma
);

/// Fields of the texts of elements, numbers, constants and values.
const ELEMENT: [&str; 5] = ["array", "index", "row", "column", "name"];
const NUMBER: [&str; 4] = ["decimal", "mantissa", "exponent", "bits"];
const CONSTANT: [&str; 2] = ["number", "name"];
const NAME: [&str; 1] = ["name"];

/// The texts of a target.
#[derive(Clone, Debug)]
pub(super) struct TargetTexts {
    /// The name of the file.
    pub(super) file: TextPattern,
    /// True if operations are inside the expressions of others.
    pub(super) is_nested: bool,
    /// Index of the first element of an array.
    pub(super) base: u32,
    pub(super) reserved: Vec<String>,
    /// An element of a scalar, a vector, a matrix.
    pub(super) elements: [TextPattern; 3],
    /// A number without its sign, unless it has the field `bits`.
    pub(super) number: TextPattern,
    pub(super) infinity: Option<String>,
    pub(super) nan: Option<String>,
    pub(super) constant: TextPattern,
    pub(super) value: TextPattern,
    /// In the order of [`Operation::ALL`].
    pub(super) operations: Vec<Option<OperationText>>,
}

impl TargetTexts {
    /// Reads the description of a folder.
    ///
    /// # Errors
    ///
    /// Reports the first fault and its place.
    pub(super) fn parse(folder: &TargetFolder) -> Result<TargetTexts, TargetError> {
        let fault = |span: Range<usize>, message: String| TargetError::Description {
            folder: folder.name.clone(),
            line: line_of(&folder.description, span.start),
            span,
            message,
        };
        let written: WrittenTarget = toml::from_str(&folder.description)
            .map_err(|error| fault(error.span().unwrap_or(0..0), error.message().to_owned()))?;
        let pattern = |text: &PlacedText, known: &[&str]| {
            TextPattern::parse(text.as_ref(), known).map_err(|reason| fault(text.span(), reason))
        };
        let or = |text: Option<PlacedText>, default: &str, known: &[&str]| match text {
            Some(text) => pattern(&text, known),
            None => Ok(TextPattern::parse(default, known).expect("a valid default")),
        };
        let operations = written.operations.all();
        let operations = operations.into_iter().map(|(operation, text)| {
            let Some(text) = text else { return Ok(None) };
            match OperationText::parse(text.as_ref(), operation) {
                Ok(read) if written.nested && read.pattern.has(3) => {
                    let reason = "operations inside expressions have no '{name}': nested = false";
                    Err(fault(text.span(), reason.to_owned()))
                }
                read => read.map(Some).map_err(|reason| fault(text.span(), reason)),
            }
        });
        if written.file.as_ref().contains(['/', '\\']) {
            let reason = "the name of a file has no folder".to_owned();
            return Err(fault(written.file.span(), reason));
        }
        let texts = written.text;
        Ok(TargetTexts {
            file: pattern(&written.file, &NAME)?,
            is_nested: written.nested,
            base: u32::from(written.from_one),
            reserved: (written.reserved.split_whitespace())
                .map(str::to_owned)
                .collect(),
            elements: [
                pattern(&texts.scalar, &ELEMENT)?,
                pattern(&texts.vector, &ELEMENT)?,
                pattern(&texts.matrix, &ELEMENT)?,
            ],
            number: pattern(&texts.number, &NUMBER)?,
            infinity: texts.infinity,
            nan: texts.nan,
            constant: or(texts.constant, "{number}", &CONSTANT)?,
            value: or(texts.value, "{name}", &NAME)?,
            operations: operations.collect::<Result<_, _>>()?,
        })
    }

    /// The text of an operation, if the target has it.
    pub(super) fn operation(&self, operation: Operation) -> Option<&OperationText> {
        self.operations[operation as usize].as_ref()
    }

    /// A number, exactly; `None` for one that is not finite and has no text.
    pub(super) fn number(&self, number: f64) -> Option<String> {
        if self.number.has(3) {
            let bits = format!("{:016X}", number.to_bits());
            return Some(self.number.fill(|_| bits.clone()));
        }
        if number.is_nan() {
            return self.nan.clone();
        }
        let sign = if number.is_sign_negative() { "-" } else { "" };
        if number.is_infinite() {
            return Some(format!("{sign}{}", self.infinity.as_ref()?));
        }
        let size = number.abs();
        let scientific = format!("{size:e}");
        let (mantissa, exponent) = scientific.split_once('e').expect("an exponent");
        let digits = self.number.fill(|field| match field {
            0 => with_point(&format!("{size:?}")),
            1 => with_point(mantissa),
            _ => exponent.to_owned(),
        });
        Some(format!("{sign}{digits}"))
    }
}

/// The digits of a number with a point: `1.0e300`.
fn with_point(digits: &str) -> String {
    let (mantissa, exponent) = digits.split_at(digits.find('e').unwrap_or(digits.len()));
    let point = if mantissa.contains('.') { "" } else { ".0" };
    format!("{mantissa}{point}{exponent}")
}
