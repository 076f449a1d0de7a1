//! Sines and cosines computed before the run.
//!
//! A host, or an input unit in front of the processing elements, has
//! comparisons, shifts and tables, which straight-line code has not. It reduces
//! any angle to an eighth of a turn ([`reduction`]) and continues with a
//! polynomial, with a table and a polynomial, or with CORDIC. All of it is
//! integer arithmetic, so that the same angle gives the same bits on every
//! platform, and hardware can do the same; results are multiples of `2^-bits`
//! with a *proved* absolute error ([`TrigonometricUnit::proved_error`]).
//!
//! The implementation of a function's sines and cosines is recorded under the
//! key [`KEY`] of its metadata; a function without the entry has those of the
//! arithmetic in which it is evaluated.

mod arithmetic;
mod cordic;
mod kernel;
mod name;
pub mod reduction;
mod unit;

pub use arithmetic::WithTrigonometry;
pub use name::ImplementationError;
pub use unit::{TrigonometricCost, TrigonometricUnit};

/// The key of the metadata entry that names an implementation.
pub const KEY: &str = "trigonometry";

/// The method by which sines and cosines are computed before the run.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Implementation {
    /// Polynomials on an eighth of a turn.
    Polynomial {
        /// The largest power of the angle.
        order: u32,
        /// Bits after the point.
        bits: u32,
    },
    /// A table of sines and cosines, and polynomials for the rest of the
    /// angle.
    Table {
        /// Entries for an eighth of a turn, a power of two.
        entries: u32,
        /// The largest power of the rest of the angle.
        degree: u32,
        /// Bits after the point.
        bits: u32,
    },
    /// Rotations by angles whose tangents are powers of two (Volder 1959):
    /// shifts and additions only.
    Cordic {
        /// Rotations.
        iterations: u32,
        /// Bits after the point.
        bits: u32,
    },
}

impl Implementation {
    /// Bits after the point, at least and at most: every result is then a
    /// binary64 number.
    pub const BITS: std::ops::RangeInclusive<u32> = 8..=50;
    /// The largest table.
    pub const MAX_ENTRIES: u32 = 1 << 16;

    /// Bits after the point.
    pub fn bits(self) -> u32 {
        match self {
            Implementation::Polynomial { bits, .. }
            | Implementation::Table { bits, .. }
            | Implementation::Cordic { bits, .. } => bits,
        }
    }
}
