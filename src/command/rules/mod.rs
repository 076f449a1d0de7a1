//! `robovec rules`: a bench for rules of rewriting.

mod read;

pub(super) use read::sound;
