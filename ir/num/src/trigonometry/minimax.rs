//! Polynomials fitted to a range: the exchange algorithm of Remez (1934).
//!
//! Of all polynomials with a number of terms the one sought has the smallest
//! largest error. Its error takes that size, with alternating signs, once more
//! often than it has coefficients (Chebyshev); so in turn the coefficients are
//! found that level the error at given angles, and the angles are moved to
//! where the error is largest. Everything is computed in double-double, so the
//! result does not depend on the platform. Nothing here is trusted:
//! [`Polynomial::proved_error`] bounds the error of the result.
//!
//! Coefficients that must be numbers of a narrow format are rounded in
//! sequence, the lowest power first, and the others fitted again each time:
//! they compensate for most of the rounding error.

use super::polynomial::{Circular, LARGEST_RANGE, Polynomial};
use crate::arithmetic::Arithmetic;
use crate::double_double::{Double, DoubleDouble};
use crate::format::Format;
use crate::soft_float::FormatArithmetic;

/// Number of grid points between two extrema, such that the largest error found
/// is within a thousandth of the true one.
const GRID: usize = 24;

/// Exchanges; the algorithm converges quadratically, five are the rule.
const MAX_EXCHANGES: usize = 20;

impl Polynomial {
    /// The polynomial with powers up to an order whose largest absolute error
    /// for angles of at most `range` radians is smallest, and of which each
    /// coefficient is a number of `format`, if given.
    ///
    /// The series of Taylor where nothing can be fitted: to a range of zero,
    /// or beyond [`LARGEST_RANGE`].
    pub fn minimax(of: Circular, order: u32, range: f64, format: Option<Format>) -> Polynomial {
        let format = format.unwrap_or(Format::BINARY64);
        let terms = of.terms(order);
        let taylor = || Polynomial::taylor(of, order).rounded(format);
        if !(f64::MIN_POSITIVE..=LARGEST_RANGE).contains(&range) {
            return taylor();
        }
        let arithmetic = FormatArithmetic::new(format);
        let mut fixed: Vec<f64> = Vec::with_capacity(terms);
        while fixed.len() < terms {
            let Some(rest) = fit(of, &fixed, terms - fixed.len(), range) else {
                return taylor();
            };
            // Nothing is gained from fitting again behind binary64.
            let rounded = rest
                .iter()
                .map(|coefficient| arithmetic.convert(coefficient.high));
            match format {
                Format::BINARY64 => fixed.extend(rounded),
                _ => fixed.extend(rounded.take(1)),
            }
        }
        let fitted = Polynomial {
            of,
            coefficients: fixed,
        };
        // Over a tiny range rounding decides alone, and the series is as good.
        let series = taylor();
        if fitted.proved_error(range) <= series.proved_error(range) {
            fitted
        } else {
            series
        }
    }

    /// The polynomial that begins with given coefficients and whose further
    /// ones, up to an order, make the largest absolute error smallest; each
    /// is a number of `format`. Kernels begin with the series' own `1` and
    /// `-1/2`, whose products are exact, to lose nothing for small angles.
    ///
    /// `None` where no fit is possible: no room after the leading coefficients,
    /// a range of zero or beyond [`LARGEST_RANGE`].
    pub fn minimax_behind(
        of: Circular,
        leading: &[f64],
        order: u32,
        range: f64,
        format: Format,
    ) -> Option<Polynomial> {
        let terms = of.terms(order);
        if terms <= leading.len() || !(f64::MIN_POSITIVE..=LARGEST_RANGE).contains(&range) {
            return None;
        }
        let arithmetic = FormatArithmetic::new(format);
        let mut fixed = leading.to_vec();
        while fixed.len() < terms {
            let rest = fit(of, &fixed, terms - fixed.len(), range)?;
            fixed.push(arithmetic.convert(rest[0].high));
        }
        Some(Polynomial {
            of,
            coefficients: fixed,
        })
    }
}

/// A grid on the range with the values of the approximated function.
struct Grid {
    /// Angles over the range, increasing from 0 or just above it to 1.
    places: Vec<Double>,
    /// The function less the fixed terms.
    wanted: Vec<Double>,
}

/// The best coefficients after some fixed ones; `None` when the algorithm
/// breaks down.
fn fit(of: Circular, fixed: &[f64], terms: usize, range: f64) -> Option<Vec<Double>> {
    let range = Double::from(range);
    let first = of.first_power() + 2 * fixed.len() as u32;
    let grid = grid(of, fixed, terms, range);
    let mut chosen: Vec<usize> = (0..=terms).map(|k| k * GRID).collect();
    let mut coefficients = level(&grid, &chosen, first)?;
    for _ in 0..MAX_EXCHANGES {
        let errors: Vec<f64> = (0..grid.places.len())
            .map(|index| {
                let value = powers(&coefficients, grid.places[index], first);
                (value - grid.wanted[index]).high
            })
            .collect();
        let moved = extrema(&errors, terms + 1)?;
        if moved == chosen {
            break;
        }
        chosen = moved;
        coefficients = level(&grid, &chosen, first)?;
    }
    // The powers were those of the angle over the range.
    let mut scale = Double::from(1.0);
    for _ in 0..first {
        scale = scale / range;
    }
    for coefficient in &mut coefficients {
        *coefficient = *coefficient * scale;
        scale = scale / range / range;
    }
    let finite = coefficients.iter().all(|number| number.high.is_finite());
    finite.then_some(coefficients)
}

/// Angles at which the error of a Chebyshev polynomial of the right symmetry
/// is extreme, every [`GRID`]th, and those between them.
fn grid(of: Circular, fixed: &[f64], terms: usize, range: Double) -> Grid {
    // T_{2n+1} for odd, T_{2n} for even polynomials of n terms; powers from
    // the second on leave the angle 0 out.
    let even = of == Circular::Cosine && fixed.is_empty();
    let waves = 2 * terms + usize::from(!even);
    let count = terms * GRID;
    let mut grid = Grid {
        places: Vec::with_capacity(count + 1),
        wanted: Vec::with_capacity(count + 1),
    };
    let half_turn = DoubleDouble.literal(std::f64::consts::PI);
    for index in 0..=count {
        let step = Double::from((count - index) as f64) / Double::from((GRID * waves) as f64);
        let place = DoubleDouble.cos(half_turn * step);
        let angle = place * range;
        let exact = match of {
            Circular::Sine => DoubleDouble.sin(angle),
            Circular::Cosine => DoubleDouble.cos(angle),
        };
        let known: Vec<Double> = fixed.iter().map(|&number| Double::from(number)).collect();
        grid.wanted
            .push(exact - powers(&known, angle, of.first_power()));
        grid.places.push(place);
    }
    grid
}

/// `x^first (c_0 + c_1 x² + …)`.
fn powers(coefficients: &[Double], x: Double, first: u32) -> Double {
    let square = x * x;
    let mut sum = Double::from(0.0);
    for &coefficient in coefficients.iter().rev() {
        sum = sum * square + coefficient;
    }
    for _ in 0..first {
        sum = sum * x;
    }
    sum
}

/// The coefficients whose errors at the chosen places are equal and
/// alternate in sign: a linear system, solved by elimination with pivots.
fn level(grid: &Grid, chosen: &[usize], first: u32) -> Option<Vec<Double>> {
    let size = chosen.len();
    let mut rows: Vec<Vec<Double>> = Vec::with_capacity(size);
    for (number, &index) in chosen.iter().enumerate() {
        let x = grid.places[index];
        let mut row = Vec::with_capacity(size + 1);
        let mut power = Double::from(1.0);
        for _ in 0..first {
            power = power * x;
        }
        for _ in 0..size - 1 {
            row.push(power);
            power = power * x * x;
        }
        row.push(Double::from(if number % 2 == 0 { 1.0 } else { -1.0 }));
        row.push(grid.wanted[index]);
        rows.push(row);
    }
    for column in 0..size {
        let largest = (column..size)
            .max_by(|&a, &b| {
                let sizes = [a, b].map(|row| rows[row][column].high.abs());
                // The first of equals.
                sizes[0].total_cmp(&sizes[1]).then(b.cmp(&a))
            })
            .filter(|&row| rows[row][column].high != 0.0)?;
        rows.swap(column, largest);
        let pivot = rows[column].clone();
        for row in rows.iter_mut().skip(column + 1) {
            let factor = row[column] / pivot[column];
            for (entry, &above) in row.iter_mut().zip(&pivot).skip(column) {
                *entry = *entry - factor * above;
            }
        }
    }
    let mut solution = vec![Double::from(0.0); size];
    for row in (0..size).rev() {
        let mut sum = rows[row][size];
        for column in row + 1..size {
            sum = sum - rows[row][column] * solution[column];
        }
        solution[row] = sum / rows[row][row];
    }
    // The last unknown is the size of the error.
    solution.pop();
    Some(solution)
}

/// The places of the largest errors of alternating signs, at most the wanted
/// number: the largest of every run of one sign; if there are too many, the run
/// at either end with the smaller error is dropped.
fn extrema(errors: &[f64], wanted: usize) -> Option<Vec<usize>> {
    let mut found: Vec<usize> = Vec::new();
    for (index, error) in errors.iter().enumerate() {
        match found.last_mut() {
            Some(last) if (errors[*last] >= 0.0) == (*error >= 0.0) => {
                if error.abs() > errors[*last].abs() {
                    *last = index;
                }
            }
            _ => found.push(index),
        }
    }
    while found.len() > wanted {
        let (first, last) = (found[0], found[found.len() - 1]);
        if errors[first].abs() < errors[last].abs() {
            found.remove(0);
        } else {
            found.pop();
        }
    }
    (found.len() == wanted).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    #[test]
    fn fitted_polynomials_beat_the_series_by_two_to_their_degree() {
        for of in Circular::BOTH {
            for (order, range) in [(3, 0.5), (5, FRAC_PI_4), (7, FRAC_PI_2), (11, PI)] {
                let taylor = Polynomial::taylor(of, order);
                let fitted = Polynomial::minimax(of, order, range, None);
                assert_eq!(taylor.degree(), fitted.degree());
                let gain = taylor.proved_error(range) / fitted.proved_error(range);
                let expected = 2f64.powi(taylor.degree() as i32 + 1);
                let name = of.name();
                assert!(gain > 0.5 * expected, "{name} {order} on {range}: {gain}");
                assert!(gain < 8.0 * expected, "{name} {order} on {range}: {gain}");
            }
        }
    }

    #[test]
    fn the_error_is_level() {
        // The best cosine with two terms on [-1, 1] touches its largest error
        // at 0, inside and at the end.
        let fitted = Polynomial::minimax(Circular::Cosine, 2, 1.0, None);
        let error = |angle: f64| {
            let angle = Double::from(angle);
            (fitted.at(angle) - DoubleDouble.cos(angle)).high.abs()
        };
        let inside = (1..1000).map(|k| error(f64::from(k) / 1000.0));
        let inside = inside.fold(0.0, f64::max);
        for end in [error(0.0), error(1.0)] {
            assert!((end / inside - 1.0).abs() < 1e-3, "{end} and {inside}");
        }
        assert!((fitted.proved_error(1.0) / inside - 1.0).abs() < 0.03);
    }

    #[test]
    fn rounded_coefficients_are_made_up_for() {
        let format: Format = "float(8,11)".parse().expect("a format");
        for of in Circular::BOTH {
            let plain = Polynomial::minimax(of, 5, 1.0, None);
            let rounded = plain.rounded(format).proved_error(1.0);
            let fitted = Polynomial::minimax(of, 5, 1.0, Some(format));
            assert_eq!(fitted, fitted.rounded(format));
            let found = fitted.proved_error(1.0);
            assert!(found <= rounded, "{}: {found} over {rounded}", of.name());
        }
    }

    #[test]
    fn leading_coefficients_are_kept_and_made_up_for() {
        let leading = [1.0, -0.5];
        let kept = |order| {
            Polynomial::minimax_behind(Circular::Cosine, &leading, order, 0.8, Format::BINARY64)
        };
        let fitted = kept(14).expect("room for more coefficients");
        assert_eq!(fitted.coefficients[..2], leading);
        assert_eq!(fitted.degree(), 14);
        let taylor = Polynomial::taylor(Circular::Cosine, 14).proved_error(0.8);
        assert!(fitted.proved_error(0.8) < taylor / 20.0);
        assert_eq!(kept(2), None);
    }

    #[test]
    fn ranges_that_fit_nothing_give_the_series() {
        for range in [0.0, -1.0, f64::NAN, 1e3, 1e-300] {
            let fitted = Polynomial::minimax(Circular::Sine, 5, range, None);
            assert_eq!(fitted, Polynomial::taylor(Circular::Sine, 5), "{range}");
        }
    }
}
