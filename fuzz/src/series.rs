//! The errors of polynomials for sine and cosine are within their proved
//! bounds.

use arbitrary::{Result, Unstructured};
use robovec_ir::{FixedFormat, Format};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::trigonometry::host::{Implementation, TrigonometricUnit};
use robovec_num::trigonometry::{Circular, Halved, Polynomial};

/// Angles tried on every range.
const SAMPLES: u32 = 24;

/// Makes polynomials of a random order, range, method, format and number of
/// halvings, or a unit of the host, and compares their values at random
/// angles with true ones.
///
/// # Panics
///
/// Panics when an error is larger than the proved bound.
pub fn series_keep_their_errors(data: &[u8]) {
    // Bytes that run out test nothing, and are no failure.
    let _ = run(&mut Unstructured::new(data));
}

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    if bytes.ratio(1, 3)? {
        return host(bytes);
    }
    let range = f64::from(bytes.int_in_range(1..=8000u32)?) / 1000.0;
    let halvings = bytes.int_in_range(0..=4)?;
    let small = range * 2f64.powi(-(halvings as i32));
    let format = match bytes.int_in_range(0..=3)? {
        0 => Format::BINARY64,
        1 => Format::BINARY32,
        2 => "float(8,12)".parse().expect("it is one"),
        _ => Format::Fixed(FixedFormat {
            integer: 2,
            fraction: 20,
        }),
    };
    let fitted: bool = bytes.arbitrary()?;
    let mut polynomial = |of: Circular| -> Result<Polynomial> {
        let order = bytes.int_in_range(1..=13)?;
        Ok(if fitted {
            Polynomial::minimax(of, order, small, Some(format))
        } else {
            Polynomial::taylor(of, order).rounded(format)
        })
    };
    let halved = Halved {
        sine: polynomial(Circular::Sine)?,
        cosine: polynomial(Circular::Cosine)?,
        halvings,
    };
    let proved = halved.proved_errors(range);
    for _ in 0..SAMPLES {
        let angle = range * place(bytes)?;
        let found = halved.at(Double::from(angle));
        for ((found, exact), proved) in found.into_iter().zip(exact(angle)).zip(proved) {
            let error = (found - exact).high.abs();
            assert!(
                error <= proved,
                "{halved:?} at {angle:?}: {error:e} above {proved:e}"
            );
        }
    }
    Ok(())
}

fn host(bytes: &mut Unstructured<'_>) -> Result<()> {
    let bits = bytes.int_in_range(Implementation::BITS)?;
    let implementation = match bytes.int_in_range(0..=2)? {
        0 => Implementation::Polynomial {
            order: bytes.int_in_range(1..=11)?,
            bits,
        },
        1 => Implementation::Table {
            entries: 1 << bytes.int_in_range(0..=8)?,
            degree: bytes.int_in_range(1..=5)?,
            bits,
        },
        _ => Implementation::Cordic {
            iterations: bytes.int_in_range(1..=60)?,
            bits,
        },
    };
    let unit = TrigonometricUnit::new(implementation).expect("its numbers are in their ranges");
    let proved = unit.proved_error();
    let size = 2f64.powi(bytes.int_in_range(-4..=30)?);
    for _ in 0..SAMPLES {
        let angle = size * place(bytes)?;
        for (found, exact) in unit.sine_and_cosine(angle).into_iter().zip(exact(angle)) {
            let error = exact.distance(found);
            assert!(
                error <= proved,
                "{implementation} at {angle:?}: {error:e} above {proved:e}"
            );
        }
    }
    Ok(())
}

/// From -1 to 1, both ends included.
fn place(bytes: &mut Unstructured<'_>) -> Result<f64> {
    Ok(f64::from(bytes.arbitrary::<i32>()?.max(-i32::MAX)) / f64::from(i32::MAX))
}

fn exact(angle: f64) -> [Double; 2] {
    let angle = Double::from(angle);
    [DoubleDouble.sin(angle), DoubleDouble.cos(angle)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn random_series_and_units_keep_their_errors() {
        cases::of_one_size(120, 400, run);
    }
}
