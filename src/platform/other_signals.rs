//! Interruption of the program by the user (Ctrl-C): the first asks the run to end after its increment, the next ends the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// Does nothing: no signal is sent at the limit of a file's size.
pub fn outlive_limits() {}

/// Returns the number of the first signal, 0 before.
///
/// # Errors
/// That of the system.
pub fn watch_signals() -> Result<Arc<AtomicUsize>, String> {
    let (signal, interrupted) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let watch = || {
        // In the order of registration: the program ends only if an earlier signal has set the flag.
        flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, interrupted.clone())?;
        flag::register(SIGINT, interrupted.clone())?;
        flag::register_usize(SIGINT, signal.clone(), SIGINT as usize)
    };
    watch().map_err(|e: std::io::Error| format!("cannot watch for signals: {e}"))?;
    Ok(signal)
}
