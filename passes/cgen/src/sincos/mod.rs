//! Sines and cosines of many angles at once, as C text.
//!
//! A library's `sin` costs 5 to 10 ns, as much as a hundred other operations
//! of generated code, and none computes the eight lanes of a vector in
//! portable C. So generated code brings its own: reduction to an eighth of a
//! turn, two polynomials, and a choice by bits, in the vector extensions that
//! gcc and clang share.
//!
//! The reduction subtracts multiples of a quarter turn in parts so short that
//! their products are exact (Cody and Waite 1980), and keeps the rounding error
//! in a second word. So no result depends on contraction by the compiler, and
//! the results are within 1 ulp (measured: 0.79 in both types) for angles up to
//! [`KernelConstants::limit`]. Larger ones, infinities and NaN are detected by
//! their bits and left to the library.
//!
//! The text needs no other: [`SineKernel::types`] once, then whichever
//! functions are called. Where the compiler has no vector extensions, or
//! `ROBOVEC_SCALAR` is defined, a vector is one number and the library
//! computes.

mod coefficients;
mod text;

use super::emit::Real;
pub(crate) use coefficients::KernelConstants;

/// The kernel for one type and number of lanes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct SineKernel {
    /// The type of a lane.
    pub(crate) real: Real,
    /// The maximum number of lanes of a vector, a power of two: where registers
    /// hold fewer, a vector has fewer. With one lane a vector is a number.
    pub(crate) lanes: u32,
}

impl SineKernel {
    /// The kernel whose vectors fill 64 bytes: for scalar code that has many
    /// angles at once. For narrower machines its vectors have fewer lanes.
    pub(crate) fn widest(real: Real) -> SineKernel {
        let lanes = match real {
            Real::Double => 8,
            Real::Float => 16,
        };
        SineKernel { real, lanes }
    }

    /// The short name of the type and lanes, `d8` or `f16`.
    pub(crate) fn suffix(self) -> String {
        let letter = match self.real {
            Real::Double => 'd',
            Real::Float => 'f',
        };
        format!("{letter}{}", self.lanes)
    }

    /// The C type of a vector in registers and in its own arrays.
    pub(crate) fn vector(self) -> String {
        format!("robovec_{}", self.suffix())
    }

    /// The C type of a vector in a caller's memory: aligned as a number only,
    /// and allowed to alias numbers.
    pub(crate) fn unaligned(self) -> String {
        format!("robovec_{}u", self.suffix())
    }

    /// The function of [`SineKernel::arrays`].
    pub(crate) fn arrays_name(self) -> String {
        format!("robovec_sincos_{}", self.suffix())
    }

    /// The function of [`SineKernel::runs`].
    pub(crate) fn runs_name(self) -> String {
        format!("robovec_sincos_runs_{}", self.suffix())
    }

    /// The types: to be written before the functions, once in a file. Needs
    /// nothing; includes `math.h`.
    pub(crate) fn types(self) -> String {
        text::types(self)
    }

    /// `static void robovec_sincos_d8(long count, const double *angles, double
    /// *sines, double *cosines)`: any number of contiguous angles, for scalar
    /// code. The arrays need no alignment and may not overlap.
    pub(crate) fn arrays(self) -> String {
        text::arrays(self)
    }

    /// `static void robovec_sincos_runs_d8(long count, const double *angles,
    /// const int *places, long stride, robovec_d8 *sines, robovec_d8
    /// *cosines)`: `count` vectors, the angles of the i-th at
    /// `angles + places[i] * stride`, for batch code.
    pub(crate) fn runs(self) -> String {
        text::runs(self)
    }
}

#[cfg(test)]
mod tests;
