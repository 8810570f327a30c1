//! Signals: a limit on files is no reason to die; the first asks the run to end behind its increment, a later one ends the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};

/// Signals closer to the first than this are the same one: `timeout` sends its own to the program and then to its group, a
/// terminal to all that run in it.
const SAME: Duration = Duration::from_millis(500);

/// A file that grows beyond a limit is an error like a full disk, and no reason to die.
pub fn outlive_limits() {
    // Where that cannot be asked for the program ends at the limit, as others do.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// The number of the first SIGINT or SIGTERM, 0 before.
pub fn watch_signals() -> Result<Arc<AtomicUsize>, String> {
    let signal = Arc::new(AtomicUsize::new(0));
    let signals = Signals::new([SIGINT, SIGTERM]).map_err(|e| format!("cannot watch for signals: {e}"))?;
    let told = signal.clone();
    let listen = std::thread::Builder::new().name("signals".into()).spawn(move || listen(signals, &told));
    listen.map_err(|e| format!("cannot watch for signals: {e}"))?;
    Ok(signal)
}

fn listen(mut signals: Signals, told: &AtomicUsize) {
    let mut first = None;
    for number in &mut signals {
        let first = *first.get_or_insert_with(Instant::now);
        if told.load(Ordering::Relaxed) == 0 {
            told.store(number as usize, Ordering::Relaxed);
        } else if first.elapsed() > SAME {
            low_level::exit(128 + number);
        }
    }
}
