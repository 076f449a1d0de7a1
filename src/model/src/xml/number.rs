//! Numbers in files.

use robovec_ir::diagnostic::clip;
use robovec_num::decimal::is_lost;
use robovec_num::limits::{Amount, NumberLimit};

/// The numbers of a model, in SI units.
pub(crate) const NUMBER: NumberLimit = NumberLimit::real(
    -1e30,
    1e30,
    "products of such numbers must be numbers of binary64",
);

/// Reason why a text is no number of a model.
pub(crate) struct NumberRefusal {
    /// Fault, to follow the name of its subject.
    pub(crate) message: String,
    /// Label of the place.
    pub(crate) label: &'static str,
    /// Advice.
    pub(crate) help: &'static str,
}

/// The number that a text without surrounding blanks represents.
pub(crate) fn parse_number(text: &str) -> Result<f64, NumberRefusal> {
    let refused = |message: String, label, help| {
        Err(NumberRefusal {
            message,
            label,
            help,
        })
    };
    match text.parse::<f64>() {
        Ok(value) if is_lost(text, value) => refused(
            format!(" is too small: {}", clip(text)),
            "this value",
            "it would be read as 0",
        ),
        Ok(value) if NUMBER.admits(Amount::Real(value)) => Ok(value),
        Ok(value) if value.is_finite() => refused(
            format!(": {}", NUMBER.refusal(text)),
            "this value",
            "models are in SI units",
        ),
        Ok(value) => {
            let kind = if value.is_nan() {
                "not a number"
            } else {
                "not finite"
            };
            refused(
                format!(" is {kind}"),
                "this value",
                "write a finite number below 1.8e308",
            )
        }
        Err(_) if text.is_empty() => refused(
            " is empty".to_owned(),
            "no number",
            "write a number between the tags, or remove the element where it is zero",
        ),
        Err(_) => {
            let help = if text.replace(',', ".").parse::<f64>().is_ok() {
                "write a point instead of the comma"
            } else {
                "write a number such as 0.5 or -1.2e-3"
            };
            refused(
                format!(" is not a number: '{}'", clip(text)),
                "this value",
                help,
            )
        }
    }
}
