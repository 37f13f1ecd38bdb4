//! The JSON files and the `.rad` file beside a map.
#![no_main]

#[path = "../../tests/support/attacks.rs"]
#[allow(dead_code)]
mod attacks;
#[path = "../../tests/support/map_builder.rs"]
#[allow(dead_code)]
mod map_builder;
#[path = "../../tests/support/tiny.rs"]
#[allow(dead_code)]
mod tiny;

use qrad::bsp::Format;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    attacks::sidecar(bytes, &tiny::map(Format::Bsp29));
});
