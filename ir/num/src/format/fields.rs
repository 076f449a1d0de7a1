//! The limits of the numbers of a format that is written as a table.

use crate::limited_fields;

limited_fields! {
    /// Bits of a float's exponent.
    exponent ("number.exponent", "8") = NumberLimit::whole(
        2, 11, "every number of a format must be a number of binary64");
    /// Bits of a float's mantissa.
    mantissa ("number.mantissa", "23") = NumberLimit::whole(
        1, 52, "every number of a format must be a number of binary64");
}
