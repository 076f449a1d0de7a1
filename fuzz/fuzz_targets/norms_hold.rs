//! Target for cargo-fuzz; the body is in the library.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| robovec_fuzz::norms_hold(data));
