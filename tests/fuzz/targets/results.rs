//! Fuzz target `results`: see `readers/results.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::results::read(data));
