//! Functions that depend on the operating system or its C library: file options, signals, memory size, disk space, portable
//! `hypot`. Unsafe code is in `user/native`.

mod hypot;
#[cfg(feature = "signals")]
#[cfg_attr(not(unix), path = "other_signals.rs")]
pub mod signals;
#[cfg_attr(not(unix), path = "other.rs")]
mod unix;

pub use hypot::PortableMath;
pub use unix::*;
