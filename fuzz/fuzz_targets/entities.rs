//! Entity text.
#![no_main]

#[path = "../../tests/support/attacks.rs"]
#[allow(dead_code)]
mod attacks;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attacks::entities(bytes));
