//! Signal handling on Unix: the first SIGINT or SIGTERM ends the run after the current increment, a later one ends the
//! program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};

/// Signals within this time of the first one are ignored: `timeout` sends a signal to the program and again to its
/// process group, and a terminal sends it to all its processes.
const SAME: Duration = Duration::from_millis(500);

/// Makes the operating system report a file-size limit as a write error instead of ending the program.
pub fn outlive_limits() {
    // If the registration fails, the program ends at the limit, which is the default of the operating system.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Registers the signal handlers. The returned counter has the number of the first SIGINT or SIGTERM, 0 before.
///
/// # Errors
/// Returns the message of the operating system.
pub fn watch_signals() -> Result<Arc<AtomicUsize>, String> {
    let signal = Arc::new(AtomicUsize::new(0));
    let signals = Signals::new([SIGINT, SIGTERM]).map_err(|e| format!("cannot watch for signals: {e}"))?;
    let first_signal = signal.clone();
    let listen = std::thread::Builder::new().name("signals".into()).spawn(move || listen(signals, &first_signal));
    listen.map_err(|e| format!("cannot watch for signals: {e}"))?;
    Ok(signal)
}

/// Ends the program at once with the exit status of a signal.
pub fn end_program(signal: usize) -> ! {
    low_level::exit(128 + signal as i32)
}

fn listen(mut signals: Signals, first_signal: &AtomicUsize) {
    let mut first = None;
    for number in &mut signals {
        let first = *first.get_or_insert_with(Instant::now);
        if first_signal.load(Ordering::Relaxed) == 0 {
            first_signal.store(number as usize, Ordering::Relaxed);
        } else if first.elapsed() > SAME {
            low_level::exit(128 + number);
        }
    }
}
