//! Shared parts of the tests of several modules.

pub(crate) mod browser;
pub(crate) mod files;
pub(crate) mod programs;
