//! What differs between operating systems: file options, signals, the memory of the machine.
//! Never here: what is unsafe (`user/native`).

#[cfg(feature = "cli")]
#[cfg_attr(not(unix), path = "other_signals.rs")]
pub mod signals;
#[cfg_attr(not(unix), path = "other.rs")]
mod unix;

pub use unix::*;
