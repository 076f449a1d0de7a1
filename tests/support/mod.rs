//! What tests of several modules share.

pub(crate) mod browser;
pub(crate) mod files;
pub(crate) mod programs;
