//! All tests of code generation from outside, in one program: `cargo test
//! --workspace --test all MODULE::` runs those of a module.

mod rtl_cores;
