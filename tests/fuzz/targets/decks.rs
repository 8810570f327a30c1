//! Fuzz target `decks`: see `readers/decks.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::decks::read(data));
