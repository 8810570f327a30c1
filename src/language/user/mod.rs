//! User subroutines: the traits that Rust plug-ins implement, and compiled Fortran and C subroutines, which implement the
//! same traits.

mod address;
pub mod codes;
#[cfg_attr(not(compiled_routines), path = "native/unavailable.rs")]
mod native;

pub use address::load_at;
pub use native::{compile, crash, show_symbols};
pub use revolve_numerics::routines::*;
