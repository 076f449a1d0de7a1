//! Promise of a pass about numbers.

use std::fmt;

robovec_num::named! {
    /// Numeric class of a pass: the strongest relation between its input and its
    /// output, and so the claim that the semantic check tests.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum NumericClass {
        /// Every output is bit-identical under IEEE arithmetic, except the sign of
        /// a zero (a minus becomes `0 - x`) and outputs with an infinite or NaN
        /// intermediate value (`0*x` becomes 0).
        Exact = "exact",
        /// Equal over the real numbers (reassociation, distribution), with `sin`
        /// and `cos` as unknown functions.
        Real = "real",
        /// Equal over the real numbers when `sin` and `cos` lie on the circle.
        RealTrig = "real-trig",
        /// Changes the function (a series for a sine, a narrower format); the
        /// pass must state its error.
        Approximating = "approximating",
    }
}

impl fmt::Display for NumericClass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}
