#![no_main]

#[path = "../panics.rs"]
mod panics;
#[path = "../parsers.rs"]
mod parsers;

libfuzzer_sys::fuzz_target!(init: panics::expect_panics(), |bytes: &[u8]| {
    parsers::mesh(bytes);
});
