//! Compiled user subroutines where they are available: exports the symbols of the test executables, so that a user's
//! shared library finds the host routines it calls.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(compiled_routines)");
    let target = |part: &str| std::env::var(format!("CARGO_CFG_TARGET_{part}")).unwrap_or_default();
    let is_supported = ["x86_64", "aarch64"].contains(&target("ARCH").as_str());
    if target("OS") == "linux" && target("ENV") == "gnu" && is_supported {
        println!("cargo::rustc-cfg=compiled_routines");
        println!("cargo::rustc-link-arg=-rdynamic");
    }
    println!("cargo::rerun-if-changed=build.rs");
}
