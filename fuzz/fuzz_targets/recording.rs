#![no_main]

#[path = "../parsers.rs"]
mod parsers;

libfuzzer_sys::fuzz_target!(init: parsers::expect_panics(), |bytes: &[u8]| {
    parsers::recording(bytes);
});
