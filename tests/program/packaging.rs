//! System libraries of the program: it needs no function that the GNU C library 2.28 lacks. A symbol has the version of
//! the library used for linking, so names are compared here; `.github/packaging/oldest-glibc` checks the versions in
//! programs linked with 2.28.

use std::process::Command;

/// Functions that 2.28 has under an earlier version.
const MOVED: &[&str] = &[
    "__libc_start_main",
    "exp",
    "exp2",
    "fstat64",
    "fstatat64",
    "hypot",
    "hypotf",
    "log",
    "log2",
    "lstat64",
    "pow",
    "stat64",
];
/// Functions of libpthread and libdl, which are part of libc since 2.34.
const MERGED: &[&str] = &["pthread_", "dladdr", "dlclose", "dlerror", "dlopen", "dlsym", "sem_"];

#[test]
fn the_program_needs_no_function_beyond_glibc_2_28() {
    let objdump = Command::new("objdump").args(["-T", env!("CARGO_BIN_EXE_revolve")]).output();
    let Ok(output) = objdump else {
        assert!(std::env::var_os("CI").is_none(), "in CI there must be objdump");
        println!("left out: symbols that the program needs (no objdump)");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut checked = 0;
    for line in text.lines().filter(|line| line.contains("*UND*")) {
        // Address, flags (`w` for a function that may be absent), section, size, version, name.
        let Some((head, rest)) = line.split_once("GLIBC_2.") else { continue };
        let Some((version, name)) = rest.split_once(|c: char| c != '.' && !c.is_ascii_digit()) else { continue };
        let minor: u32 = version.split('.').next().and_then(|n| n.parse().ok()).expect("a version");
        let name = name.trim_start_matches([')', ' ']);
        let is_merged = MERGED.iter().any(|start| name.starts_with(start)) && !name.contains("clock");
        let is_weak = head.split_whitespace().nth(1) == Some("w");
        assert!(
            minor <= 28 || is_weak || is_merged || MOVED.contains(&name),
            "{name} needs the GNU C library 2.{version}"
        );
        checked += 1;
    }
    assert!(checked > 50, "{text}");
}
