//! Fuzz target: results_stay_in_class.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| robovec_fuzz::results_stay_in_class(data));
