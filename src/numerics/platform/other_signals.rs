//! Interruption by Ctrl-C: the first signal ends the run after the current increment, the second one ends the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// Does nothing: these platforms send no signal when a file reaches its size limit.
pub fn outlive_limits() {}

/// Registers the signal handlers. The returned counter has the number of the first signal, 0 before.
///
/// # Errors
/// Returns the message of the operating system.
pub fn watch_signals() -> Result<Arc<AtomicUsize>, String> {
    let (signal, interrupted) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let watch = || {
        // Handlers run in the order of registration: the first one ends the program only if an earlier signal has set
        // the flag.
        flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, interrupted.clone())?;
        flag::register(SIGINT, interrupted.clone())?;
        flag::register_usize(SIGINT, signal.clone(), SIGINT as usize)
    };
    watch().map_err(|e: std::io::Error| format!("cannot watch for signals: {e}"))?;
    Ok(signal)
}

/// Ends the program at once with the exit status of a signal.
pub fn end_program(signal: usize) -> ! {
    signal_hook::low_level::exit(128 + signal as i32)
}
