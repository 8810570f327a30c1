//! User subroutines: the traits that Rust plug-ins implement, and compiled Fortran and C subroutines, which implement the
//! same traits. This is the only crate with `unsafe` code. The public interface is in the crate `revolve`.
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

mod address;
pub mod codes;
#[cfg_attr(not(compiled_routines), path = "native/unavailable.rs")]
mod native;

pub use address::load_at;
pub use native::{compile, crash, show_symbols};
pub use revolve_numerics::routines::*;
