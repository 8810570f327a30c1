//! What differs between operating systems and their C libraries: file options, signals, the memory of the machine, last bits.
//! Never here: what is unsafe (`user/native`).

mod hypot;
#[cfg(feature = "cli")]
#[cfg_attr(not(unix), path = "other_signals.rs")]
pub mod signals;
#[cfg_attr(not(unix), path = "other.rs")]
mod unix;

pub use hypot::PortableMath;
pub use unix::*;
