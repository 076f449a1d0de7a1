//! All tests of the passes from outside, in one program: `cargo test
//! --workspace --test all MODULE::` runs those of a module.

mod manager;
mod pipelines;
mod reduce;
mod rtl;
mod trail;
