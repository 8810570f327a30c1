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

/// Limit of the memory of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    /// What limits the memory.
    pub name: &'static str,
    /// Number of bytes.
    pub bytes: u128,
}
