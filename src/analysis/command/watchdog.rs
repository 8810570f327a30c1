//! Watchdog of a run: ends it if a signal does not end it in time, and reports where it does not advance.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::plan::Plan;
use crate::platform::signals;
use crate::solve::RunPosition;

use super::words::print_err;

/// Time after a signal in which the current increment can be completed.
const GRACE: Duration = Duration::from_millis(800);
/// Time without progress after which the position of the run is printed.
const SILENCE: Duration = Duration::from_secs(10);
/// Multiple of the longest increment so far that both times are at least.
const LONGER: u32 = 3;
/// Stack of the thread in bytes.
const STACK: usize = 512 << 10;
/// Time between two looks at the run.
const LOOK: Duration = Duration::from_millis(50);

/// Ends the watchdog, also after a panic.
struct EndOnDrop<'a>(&'a RunPosition, std::thread::Thread);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.end();
        self.1.unpark();
    }
}

/// Watchdog of a run in another thread.
pub struct Watchdog<'a> {
    pub plan: &'a Plan,
    pub position: &'a RunPosition,
    /// Number of the signal that has arrived, 0 before.
    pub signal: &'a AtomicUsize,
    /// Whether warnings are suppressed.
    pub quiet: bool,
}

impl Watchdog<'_> {
    /// Watches a run in another thread while `work` runs; if the system starts no thread, the run is not watched.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        std::thread::scope(|threads| {
            let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(threads, || self.watch());
            if let Err(error) = &thread {
                print_err!("warning: runs without progress are not reported: no thread could be started: {error}");
            }
            let _end = thread.ok().map(|thread| EndOnDrop(self.position, thread.thread().clone()));
            work()
        })
    }

    fn watch(&self) {
        let (mut increment, mut since, mut longest) = (0, Instant::now(), Duration::ZERO);
        let (mut arrival, mut silence) = (None, SILENCE);
        while !self.position.is_ending() {
            std::thread::park_timeout(LOOK);
            if increment != self.position.increment() {
                longest = longest.max(since.elapsed());
                (increment, since) = (self.position.increment(), Instant::now());
                silence = SILENCE.max(longest * LONGER);
            }
            let signal = self.signal.load(Ordering::Relaxed);
            if signal != 0 {
                let waited = arrival.get_or_insert_with(Instant::now).elapsed();
                if waited > GRACE.max(longest * LONGER) && !self.position.is_ending() {
                    self.end(signal);
                }
            } else if since.elapsed() > silence {
                if !self.quiet {
                    print_err!("warning: R314: no progress for {} s: {}", since.elapsed().as_secs(), self.place());
                }
                silence *= 2;
            }
        }
    }

    /// Ends the program within an increment.
    fn end(&self, signal: usize) {
        print_err!(
            "halted: R207: interrupted by signal {signal} within an increment, which did not end: {}. The results since the last \
             frame and checkpoint are lost",
            self.place()
        );
        signals::end_program(signal);
    }

    /// Returns the increment and the effect that is evaluated.
    fn place(&self) -> String {
        let (increment, time) = (self.position.increment(), self.position.time());
        let effect = self.plan.ledger.effects.get(self.position.effect());
        let effect =
            effect.map_or_else(String::new, |row| format!(", in {} ({})", row.effect, row.asked_by.join(", ")));
        let (group, element) = self.position.limiting();
        let limiting = match self.plan.element_name(group, element) {
            "" => String::new(),
            name => format!("; element {name} limits the time increment"),
        };
        format!("increment {}, from time {time:e}{effect}{limiting}", increment + 1)
    }
}
