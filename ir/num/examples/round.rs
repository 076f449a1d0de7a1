//! Rounding of numbers to a format, with the rounding error.
//!
//!     cargo run -p robovec-num --example round -- f16 0.1 3.14159 70000

use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::soft_float::FormatArithmetic;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let format = arguments.next().ok_or("a format and numbers")?;
    let arithmetic = FormatArithmetic::new(format.parse()?);
    for text in arguments {
        let number: f64 = text.parse()?;
        let rounded = arithmetic.convert(number);
        let square = arithmetic.mul(rounded, rounded);
        let exact = DoubleDouble.mul(Double::from(number), Double::from(number));
        println!(
            "{number} is {rounded} ({:+e}), its square {square} ({:+e})",
            rounded - number,
            square - exact.high
        );
    }
    Ok(())
}
