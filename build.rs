//! Exports the symbols of the executables where compiled user subroutines are available, so that a user's shared library
//! finds the host routines it calls.

fn main() {
    let target = |part: &str| std::env::var(format!("CARGO_CFG_TARGET_{part}")).unwrap_or_default();
    if target("OS") == "linux" && target("ENV") == "gnu" {
        println!("cargo::rustc-link-arg=-rdynamic");
    }
    println!("cargo::rerun-if-changed=build.rs");
}
