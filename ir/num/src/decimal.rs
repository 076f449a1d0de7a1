//! Decimals that binary64 does not hold.

/// True for a decimal other than 0 whose nearest number of binary64 is 0:
/// `1e-400`. Readers refuse it, as they refuse `1e400`.
pub fn is_lost(text: &str, number: f64) -> bool {
    let mut parts = text.split(['e', 'E']);
    let significand = parts.next().expect("a text has a first part");
    number == 0.0 && significand.contains(|digit| matches!(digit, '1'..='9'))
}

/// The remark on a decimal that [`is_lost`].
pub const LOST: &str = "it would be read as 0: numbers below 2.5e-324 do not exist in 64 bits";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_digits_that_vanish_are_lost() {
        for (text, lost) in [
            ("1e-400", true),
            ("-0.1e-399", true),
            ("2e-324", true),
            ("3e-324", false),
            ("0", false),
            ("-0.000e-999", false),
            ("0e400", false),
            ("1e-300", false),
        ] {
            let number = text.parse().expect("a decimal");
            assert_eq!(is_lost(text, number), lost, "{text}");
        }
    }
}
