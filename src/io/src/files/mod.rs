//! Files and folders that robovec reads and writes.
//!
//! A file that a user names is read up to the limit of its kind ([`limited`]).
//! All writes to the disk use this module, with these rules:
//!
//! - **Invariant.** A file appears whole or not at all: it is written under a
//!   temporary name beside its place, which it takes when all is there.
//! - A new file has the permissions that the user's mask leaves, an existing
//!   one keeps its own, its owner and its other names. A symbolic link stays,
//!   and its target is written.
//! - Temporary files of a killed run are removed when the next run writes into
//!   the same folder (`temporary`).
//! - Files of others are not replaced unless that is requested (`own`).
//! - A folder of files that belong together has a file that seals it
//!   ([`sealed`]).

pub mod limited;
mod look;
pub mod sealed;
mod temporary;
mod write;

pub use temporary::TemporaryFolder;
pub use write::{
    FileWriteError, Replace, make_folder, refuse_foreign, remove, set_force, write_whole,
};
