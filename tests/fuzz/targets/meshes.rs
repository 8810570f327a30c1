//! Fuzz target `meshes`: see `readers/meshes.rs`.
#![no_main]

#[path = "../readers/mod.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| readers::meshes::read(data));
