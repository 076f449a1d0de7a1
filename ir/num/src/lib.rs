//! Numbers and their operations. This crate does not depend on functions or
//! programs.
//!
//! - The [`operation`]s, and the [`arithmetic`] trait that evaluation is
//!   generic over, for one state or several ([`batch`]).
//! - Kinds of number: formats of any width ([`mod@format`], [`soft_float`]),
//!   double-double ([`double_double`]), also with error bounds ([`ball`]),
//!   [`interval`]s, dual numbers ([`dual`]) and prime fields ([`field`]).
//! - Sine and cosine by series and by units ([`trigonometry`]).
//! - Numbers as text ([`decimal`], [`hexadecimal`]) and their [`limits`].
//! - Tools: powers of two ([`power`]), [`random`] numbers, hashes ([`fnv`])
//!   and sorting ([`radix`]).

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
pub mod named;
pub mod operation;
pub mod power;
pub mod radix;
pub mod random;
pub mod soft_float;
pub mod trigonometry;

pub use format::{FixedFormat, Format, NumberFormat};
pub use limits::{Amount, NumberLimit};
pub use operation::Operation;
