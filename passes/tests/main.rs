//! All tests of the passes from outside, in one program: `cargo test
//! --workspace --test all MODULE::` runs those of a module.

mod pipelines;
mod rtl_cores;
