//! Signed sums and products of any number of operands: what the passes that
//! rewrite them share.
//!
//! [`groups`] reads the sums and products of a function, [`earliest`] has the
//! trees that combine the two earliest operands first.

pub(crate) mod earliest;
pub(crate) mod groups;
