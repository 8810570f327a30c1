//! Compiled user subroutines: Fortran and C behind the traits of `user`. This needs the loader, the signals and the processes of
//! Linux with the GNU C library; other platforms have `unavailable.rs` in place of this file.
//! Never here: what a subroutine may ask the run for (`host.rs`).

mod cache;
mod call;
pub mod compile;
mod compiled;
pub mod crash;
mod guard;
mod host_routines;
mod isolate;
mod library;
mod memory;
mod own_symbols;
mod prototype;
mod source;
mod subroutines;
mod symbols;

pub use own_symbols::show_symbols;

use super::*;
