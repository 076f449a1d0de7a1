//! Signed sums and products of any number of operands: the common parts of the
//! passes that rewrite them.
//!
//! [`groups`] reads the sums and products of a function, [`terms`] removes
//! cancelling terms, [`values`] identifies values by their fingerprints and
//! [`places`] finds them, [`earliest`] has the trees that combine the two
//! earliest operands first, [`fused`] splits and makes fused operations, and
//! [`writer`] writes sums and products as operations, with signs, names and
//! sources.

pub(crate) mod earliest;
pub(crate) mod fused;
pub(crate) mod groups;
pub(crate) mod places;
pub(crate) mod terms;
pub(crate) mod values;
pub(crate) mod writer;
