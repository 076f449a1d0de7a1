//! Sines and cosines as machines compute them, with proofs of their error.
//!
//! A machine of adders and multipliers has no sine. The alternative is a
//! [`Polynomial`]: the thesis truncates the series of Taylor (1.2.2), and a
//! polynomial of the same degree fitted to a range is some 2^degree times
//! better. Errors of sines and cosines reach every result of a multibody
//! program and are often far larger than its rounding errors, so each form here
//! comes with a bound that is *proved*, not sampled:
//! [`Polynomial::proved_error`] encloses the distance from the true function on
//! every part of the range ([`enclosure`], [`bound`]).

pub mod bound;
pub mod enclosure;
pub mod halving;
pub mod host;
pub mod minimax;
pub mod polynomial;

pub use bound::worst;
pub use halving::Halved;
pub use polynomial::{Circular, LARGEST_RANGE, MAX_ORDER, Polynomial};
