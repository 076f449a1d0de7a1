//! Files and folders that robovec reads and writes.
//!
//! A file that a user names is read up to the limit of its kind ([`limited`]).
//! Everything that leaves robovec for the disk goes through here, so that
//! these hold everywhere:
//!
//! - **Invariant.** A file appears whole or not at all: it is written under a
//!   temporary name beside its place, which it takes when all is there.
//! - A new file has the permissions that the user's mask leaves, an existing
//!   one keeps its own, its owner and its other names. A symbolic link stays,
//!   and what it points to is written.
//! - Temporary files of a run that was killed go when the next run writes
//!   into the same folder (`temporary`).
//! - What somebody else wrote is not replaced unless that is requested (`own`).
//! - A folder of files that belong together has a file that seals it
//!   ([`sealed`]).

pub mod limited;
mod look;
mod own;
pub mod sealed;
mod temporary;
mod write;

pub use own::{Replace, set_force};
pub use temporary::TemporaryFolder;
pub use write::{FileWriteError, make_folder, refuse_foreign, write_whole};
