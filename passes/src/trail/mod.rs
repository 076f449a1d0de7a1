//! The trail: how every value came to be what it is.
//!
//! A value of the last state of a compilation has little to do with the text
//! of its equation. The trail keeps, for every value, the passes that made
//! or changed it and the rules these applied. Most of it is found by the
//! manager, which compares the definitions before and after a pass; what only
//! the pass itself knows (which rule, from which value), it notes while it
//! runs: [`Context::note`](crate::pass::Context::note).

mod notes;

pub use notes::Notes;
