//! The types of the pass's options.

use robovec_framework::option_words;
use robovec_framework::options::OptionValue;
use robovec_num::limits::Amount;
use std::f64::consts::PI;

option_words! {
    /// The method by which sines and cosines are computed.
    pub enum CircularMethod {
        /// Left as they are: true sines and cosines.
        True = "true",
        /// Taylor series.
        Taylor = "taylor",
        /// Polynomials of the smallest error on the range.
        Minimax = "minimax",
        /// On the host: range reduction and a polynomial.
        Polynomial = "polynomial",
        /// On the host: range reduction, a table and a polynomial.
        Table = "table",
        /// On the host: range reduction and rotations.
        Cordic = "cordic",
    }
}

option_words! {
    /// Place where sines and cosines are computed.
    pub enum CircularPlace {
        /// By the processing elements, as part of the program.
        Elements = "elements",
        /// Before the run, by the host or an input unit.
        Host = "host",
    }
}

option_words! {
    /// The order in which a polynomial is evaluated.
    pub enum Scheme {
        /// The shortest path in cycles, then the fewest operations.
        Shortest = "shortest",
        /// Horner's scheme: the fewest operations.
        Horner = "horner",
    }
}

/// An angle in radians, of either sign: `0.1`, `pi`, `0.25pi`; or in degrees:
/// `45deg`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AngleOption(pub f64);

impl OptionValue for AngleOption {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "number | pi | 0.25pi | 45deg".to_owned()
    }
    fn parse(text: &str) -> Result<AngleOption, String> {
        let number = |text: &str| text.parse::<f64>().ok();
        let angle = if text == "pi" {
            Some(PI)
        } else if let Some(factor) = text.strip_suffix("pi") {
            number(factor).map(|factor| factor * PI)
        } else if let Some(degrees) = text.strip_suffix("deg") {
            number(degrees).map(|degrees| degrees * (PI / 180.0))
        } else {
            number(text)
        };
        let positive = angle.filter(|angle| angle.is_finite() && *angle > 0.0);
        positive
            .map(AngleOption)
            .ok_or_else(|| format!("'{text}' is not a positive angle, as 0.1, pi, 0.25pi or 45deg"))
    }
    fn print(&self) -> String {
        match self.0 / PI {
            1.0 => "pi".to_owned(),
            turns if (turns * 8.0).fract() == 0.0 && turns * PI == self.0 => format!("{turns}pi"),
            _ => self.0.to_string(),
        }
    }
    fn amount(&self) -> Option<Amount> {
        Some(Amount::Real(self.0))
    }
}

/// An error that may be left to the machine's number format.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FormatTolerance(pub Option<f64>);

impl OptionValue for FormatTolerance {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "number | machine".to_owned()
    }
    fn parse(text: &str) -> Result<FormatTolerance, String> {
        if text == "machine" {
            return Ok(FormatTolerance(None));
        }
        let number = text.parse::<f64>().ok();
        let positive = number.filter(|number| number.is_finite() && *number > 0.0);
        positive
            .map(|number| FormatTolerance(Some(number)))
            .ok_or_else(|| format!("'{text}' is neither a positive number nor 'machine'"))
    }
    fn print(&self) -> String {
        match self.0 {
            None => "machine".to_owned(),
            Some(number) => format!("{number:e}"),
        }
    }
    fn amount(&self) -> Option<Amount> {
        self.0.map(Amount::Real)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_tolerances_read_back() {
        for text in ["0.1", "pi", "0.25pi", "2pi", "2.5"] {
            let angle = AngleOption::parse(text).expect(text);
            assert_eq!(angle.print(), text);
        }
        assert_eq!(AngleOption::parse("180deg"), Ok(AngleOption(PI)));
        let degree = AngleOption::parse("1deg").expect("an angle");
        assert_eq!(AngleOption::parse(&degree.print()), Ok(degree));
        for text in ["", "0", "-1", "inf", "nan", "xpi", "pie", "deg", "-0.5pi"] {
            assert!(AngleOption::parse(text).is_err(), "{text}");
        }
        for text in ["machine", "1e-6", "2.5e-1"] {
            assert_eq!(FormatTolerance::parse(text).expect(text).print(), text);
        }
        for text in ["", "0", "-1", "nan", "small"] {
            assert!(FormatTolerance::parse(text).is_err(), "{text}");
        }
    }
}
