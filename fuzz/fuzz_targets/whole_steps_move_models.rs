//! Target for cargo-fuzz; the body is in the library.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    robovec_fuzz::loops::whole_steps_move_models(data);
});
