//! Files read up to a limit or written whole, tools that are run, and equations, models and machines from path to value.

pub mod files;
pub mod process;
pub mod sources;
