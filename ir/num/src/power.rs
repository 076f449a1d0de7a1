//! Products with powers of two, which only move the exponent of a number.

/// `number * 2^exponent`, in two factors: `2^exponent` alone may be out of
/// the range of binary64 where the product is not. Exact for exponents
/// from -2044 to 2046, unless the product leaves the normal range; beyond
/// them the factors are 0 or infinite.
pub fn times_power_of_two(number: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    number * 2f64.powi(half) * 2f64.powi(exponent - half)
}
