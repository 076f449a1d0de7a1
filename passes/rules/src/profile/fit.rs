//! Formulas through small sequences of whole numbers.
//!
//! The number of nodes of a saturated graph follows a formula when its size
//! grows, such as `3^n - 2*2^n + n + 1` for a sum under associativity and
//! commutativity. A formula is believed when it goes through every point
//! exactly and has at least one coefficient less than there are points.

use std::fmt::Write;

/// The growth of a sequence.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub enum Growth {
    /// No growth: the rule adds no forms.
    Constant,
    /// Like a power of n.
    Polynomial(u32),
    /// Like this number to the power n.
    Exponential(f64),
    /// Without end: the graph did not saturate within its budget although
    /// its terms are small.
    Endless,
}

/// The simplest formula through points `(n, count)` of consecutive n, if one
/// passes through all of them.
pub(super) fn formula(points: &[(u32, u64)]) -> Option<(Growth, String)> {
    let last = points.len().checked_sub(1)?;
    for degree in 0..last.min(5) as u32 {
        let basis: Vec<GrowthTerm> = (0..=degree).rev().map(GrowthTerm::Power).collect();
        if let Some(text) = through(points, &basis) {
            let growth = match degree {
                0 => Growth::Constant,
                _ => Growth::Polynomial(degree),
            };
            return Some((growth, text));
        }
    }
    for base in 2..=8i64 {
        for lower in 1..base {
            let mut basis = vec![GrowthTerm::Exponential(base)];
            if lower > 1 {
                basis.push(GrowthTerm::Exponential(lower));
            }
            basis.extend([GrowthTerm::Power(1), GrowthTerm::Power(0)]);
            if basis.len() < points.len()
                && let Some(text) = through(points, &basis)
            {
                return Some((Growth::Exponential(base as f64), text));
            }
        }
    }
    None
}

/// The growth of points that follow no simple formula: by the last ratios of
/// differences.
pub(super) fn estimate(points: &[(u32, u64)]) -> Growth {
    let [.., (_, a), (_, b), (n, c)] = points[..] else {
        return Growth::Constant;
    };
    if b == c {
        return Growth::Constant;
    }
    let ratio = |above: u64, below: u64| above as f64 / below.max(1) as f64;
    // A power of n grows by ((n+1)/n)^d, an exponential by the same ratio
    // again and again.
    let (late, early) = (ratio(c, b), ratio(b, a));
    let step = (f64::from(n) / f64::from(n - 1)).ln();
    let degree = late.ln() / step;
    if late >= 1.5 && (late >= early * 0.93 || degree > 5.0) {
        Growth::Exponential((late * 10.0).round() / 10.0)
    } else {
        Growth::Polynomial(degree.round().max(1.0) as u32)
    }
}

/// A term of a formula.
#[derive(Clone, Copy)]
enum GrowthTerm {
    Exponential(i64),
    Power(u32),
}

impl GrowthTerm {
    fn at(self, n: u32) -> Option<i128> {
        match self {
            GrowthTerm::Exponential(base) => i128::from(base).checked_pow(n),
            GrowthTerm::Power(power) => i128::from(n).checked_pow(power),
        }
    }

    fn text(self) -> String {
        match self {
            GrowthTerm::Exponential(base) => format!("{base}^n"),
            GrowthTerm::Power(0) => String::new(),
            GrowthTerm::Power(1) => "n".to_owned(),
            GrowthTerm::Power(power) => format!("n^{power}"),
        }
    }
}

/// The combination of terms through all points, if there is one.
fn through(points: &[(u32, u64)], basis: &[GrowthTerm]) -> Option<String> {
    let size = basis.len();
    let row = |&(n, count): &(u32, u64)| -> Option<Vec<i128>> {
        let mut row = Vec::with_capacity(size + 1);
        for term in basis {
            row.push(term.at(n)?);
        }
        row.push(i128::from(count));
        Some(row)
    };
    let rows: Vec<Vec<i128>> = points.iter().map(row).collect::<Option<_>>()?;
    let (values, scale) = solve(rows.get(..size)?.to_vec())?;
    for row in &rows {
        let mut sum = 0i128;
        for (value, factor) in values.iter().zip(row) {
            sum = sum.checked_add(value.checked_mul(*factor)?)?;
        }
        if sum != scale.checked_mul(row[size])? {
            return None;
        }
    }
    Some(text(&values, scale, basis))
}

/// Solves a square system without fractions (Bareiss): numerators and their
/// common denominator.
fn solve(mut rows: Vec<Vec<i128>>) -> Option<(Vec<i128>, i128)> {
    let size = rows.len();
    let mut previous = 1i128;
    assert!(
        rows.iter().all(|row| row.len() == size + 1),
        "as many equations as unknowns, and their right sides"
    );
    for column in 0..size {
        let pivot = (column..size).find(|&row| rows[row][column] != 0)?;
        rows.swap(column, pivot);
        let pivot_row = rows[column].clone();
        for (index, row) in rows.iter_mut().enumerate() {
            if index == column {
                continue;
            }
            let factor = row[column];
            for (entry, above) in row.iter_mut().zip(&pivot_row) {
                let product = entry.checked_mul(pivot_row[column])?;
                let difference = product.checked_sub(factor.checked_mul(*above)?)?;
                *entry = difference / previous;
            }
        }
        previous = pivot_row[column];
    }
    // Every row now has the determinant on the diagonal.
    let values = rows.iter().map(|row| row[size]).collect();
    Some((values, previous))
}

fn text(values: &[i128], scale: i128, basis: &[GrowthTerm]) -> String {
    assert_eq!(values.len(), basis.len(), "every term has a coefficient");
    let mut text = String::new();
    let mut divisor = scale.abs();
    for value in values {
        divisor = common(divisor, value.abs());
    }
    let divisor = if scale < 0 { -divisor } else { divisor };
    let below = scale / divisor;
    for (value, term) in values.iter().zip(basis) {
        let value = value / divisor;
        if value == 0 {
            continue;
        }
        let sign = match (value < 0, text.is_empty()) {
            (true, true) => "-",
            (true, false) => " - ",
            (false, true) => "",
            (false, false) => " + ",
        };
        let (size, name) = (value.abs(), term.text());
        // Writing to a string cannot fail.
        let _ = match (size, name.as_str()) {
            (_, "") => write!(text, "{sign}{size}"),
            (1, name) => write!(text, "{sign}{name}"),
            (_, name) => write!(text, "{sign}{size}*{name}"),
        };
    }
    match (text.is_empty(), below) {
        (true, _) => "0".to_owned(),
        (false, 1) => text,
        (false, below) => format!("({text})/{below}"),
    }
}

fn common(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(function: impl Fn(u64) -> u64) -> Vec<(u32, u64)> {
        (2..8).map(|n| (n, function(u64::from(n)))).collect()
    }

    #[test]
    fn formulas_are_found_exactly() {
        for (points, growth, expected) in [
            (points(|_| 7), Growth::Constant, "7"),
            (points(|n| 3 * n - 1), Growth::Polynomial(1), "3*n - 1"),
            (
                points(|n| n * (n - 1) / 2),
                Growth::Polynomial(2),
                "(n^2 - n)/2",
            ),
            (
                points(|n| 3u64.pow(n as u32) - 2u64.pow(n as u32 + 1) + 1 + n),
                Growth::Exponential(3.0),
                "3^n - 2*2^n + n + 1",
            ),
            (points(|n| 5 << n), Growth::Exponential(2.0), "5*2^n"),
        ] {
            assert_eq!(formula(&points), Some((growth, expected.to_owned())));
        }
    }

    #[test]
    fn what_has_no_formula_is_estimated() {
        let factorial = points(|n| (1..=n).product());
        assert_eq!(formula(&factorial), None);
        assert!(matches!(estimate(&factorial), Growth::Exponential(base) if base > 5.0));
        assert!(matches!(
            estimate(&points(|n| n.pow(3) + n % 2)),
            Growth::Polynomial(2..=4)
        ));
    }
}
