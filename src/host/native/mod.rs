//! Compiled user subroutines: Fortran and C code that implements the traits of `user`. It requires the loader, signals
//! and processes of Linux with the GNU C library; other platforms use `unavailable.rs` instead of this file.

mod cache;
mod call;
pub mod compile;
mod compiled;
pub mod crash;
mod fortran;
mod guard;
mod host_routines;
mod isolate;
mod library;
mod memory;
mod own_symbols;
mod prototype;
mod source;
mod stack;
mod subroutines;
mod symbols;

pub use own_symbols::show_symbols;

use super::*;
