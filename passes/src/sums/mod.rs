//! Signed sums and products of any number of operands: what the passes that
//! rewrite them share.
//!
//! [`groups`] reads the sums and products of a function, [`terms`] takes out
//! what cancels, [`values`] knows values by their fingerprints and [`places`]
//! finds them, [`earliest`] has the trees that combine the two earliest operands
//! first, [`fused`] takes fused operations apart and makes them, and [`writer`]
//! writes sums and products as operations, with signs, names and sources.

pub(crate) mod earliest;
pub(crate) mod fused;
pub(crate) mod groups;
pub(crate) mod places;
pub(crate) mod terms;
pub(crate) mod values;
pub(crate) mod writer;
