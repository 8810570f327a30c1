//! Fuzz target `references`: see `readers/references.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::references::read(data));
