//! Numbers formatted for users.

/// A number rounded to some decimals, which hides the last bits of sums.
pub fn round(number: f64, decimals: u8) -> f64 {
    let scale = 10f64.powi(i32::from(decimals));
    (number * scale).round() / scale
}

/// At most four decimals, without zeros at the end.
pub(crate) fn trimmed(number: f64) -> String {
    let text = format!("{number:.4}");
    let trimmed = text.trim_end_matches('0').trim_end_matches('.');
    match trimmed {
        "-0" => "0".to_owned(),
        _ => trimmed.to_owned(),
    }
}

/// Two digits and an exponent; a plain 0, and a dash for a missing number.
pub fn exponential(number: f64) -> String {
    if number.is_nan() {
        "-".to_owned()
    } else if number == 0.0 {
        "0".to_owned()
    } else {
        format!("{number:.1e}")
    }
}

/// Two digits and an exponent where two decimals are not enough.
pub fn scientific(number: f64) -> String {
    match number {
        number if (0.1..1000.0).contains(&number) => format!("{number:.2}"),
        number => exponential(number),
    }
}

/// A number of units of rounding, with two decimals where it is small.
pub fn units(number: f64) -> String {
    match number {
        number if number < 10.0 => format!("{number:.2}"),
        number if number < 1000.0 => format!("{number:.0}"),
        number => scientific(number),
    }
}

/// A share of 1 in percent.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A share of 1 in percent with two decimals, for small shares of a device.
pub fn share_percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// Text of a value, a dash for none.
pub fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), text)
}

/// Text of a value, empty for none.
pub fn or_nothing<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(String::new, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.00001, "0"),
            (1.5, "1.5"),
            (743.0, "743"),
            (0.12345, "0.1235"),
        ] {
            assert_eq!(trimmed(value), text);
        }
        for text in [exponential, scientific, units] {
            assert_eq!(text(f64::NAN), "-");
        }
    }
}
