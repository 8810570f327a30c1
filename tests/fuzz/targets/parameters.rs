//! Fuzz target `parameters`: see `readers/parameters.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::parameters::read(data));
