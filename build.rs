//! Exports the symbols of the executables, so that a user's shared library finds the host routines it calls.

fn main() {
    println!("cargo:rustc-link-arg=-rdynamic");
    println!("cargo:rerun-if-changed=build.rs");
}
