//! Fuzz target `checkpoints`: see `readers/checkpoints.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::checkpoints::read(data));
