//! Numbers and what is computed with them, below everything that knows what a
//! function is.
//!
//! The [`operation`]s, the [`arithmetic`] trait that evaluation is generic
//! over, and its kinds of number: IEEE formats of any width ([`mod@format`],
//! [`soft_float`]), numbers of twice the length ([`double_double`]), numbers with derivatives
//! ([`dual`]), prime
//! fields ([`field`]), and sine and cosine by series ([`trigonometry`]); and sorting by
//! numbers ([`radix`]).

pub mod arithmetic;
pub mod ball;
pub mod batch;
pub mod decimal;
pub mod double_double;
pub mod dual;
pub mod field;
pub mod fnv;
pub mod format;
pub mod hexadecimal;
pub mod interval;
pub mod limits;
pub mod operation;
pub mod power;
pub mod radix;
pub mod random;
pub mod soft_float;
pub mod trigonometry;

pub use format::{FixedFormat, Format, NumberFormat};
pub use limits::{Amount, LimitRow, NumberLimit};
pub use operation::Operation;
