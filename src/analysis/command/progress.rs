//! Progress bars on the terminal, with simulated time, remaining wall-clock time, increment and energy drift.

use std::path::Path;
use std::time::Duration;

use crate::deck::printable;
use crate::output::clock::span;
use crate::solve::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::words;

/// Number of positions of a progress bar.
const PARTS: u64 = 1000;
/// Refresh rate in 1/s.
const RATE: u8 = 4;

/// Creates a bar on standard error; it is hidden if `quiet` or if standard error is not a terminal.
fn bar(length: u64, template: &str, quiet: bool) -> ProgressBar {
    if quiet || !words::is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(RATE)).with_style(style)
}

/// Creates a bar that counts runs.
pub fn over_runs(runs: u64, quiet: bool) -> ProgressBar {
    bar(runs, "{bar:40} {pos} of {len} runs, {elapsed} ({eta} left)", quiet)
}

/// Creates a line that is shown while a deck is read; large decks take seconds.
pub fn over_reading(deck: &Path, quiet: bool) -> ProgressBar {
    let line = bar(1, "reading {msg}", quiet);
    line.set_message(printable(&deck.display().to_string()).to_string());
    line.tick();
    line
}

pub struct RunBar {
    bar: ProgressBar,
    left: TimeLeft,
}

impl RunBar {
    pub fn new(quiet: bool) -> Self {
        RunBar { bar: bar(PARTS, "{bar:24} {percent:>3} % {msg}", quiet), left: TimeLeft::default() }
    }

    pub fn follow(&mut self, progress: &Progress<'_>) {
        if self.bar.is_hidden() {
            return;
        }
        self.bar.set_position((PARTS as f64 * progress.fraction) as u64);
        let left = self.left.after(self.bar.elapsed(), progress.fraction);
        self.bar.set_message(sentence(progress, left));
    }

    /// Returns the bar, for messages that are printed above it.
    pub fn handle(&self) -> ProgressBar {
        self.bar.clone()
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn sentence(progress: &Progress<'_>, left: Option<Duration>) -> String {
    let left = left.map_or(String::new(), |time| format!(", {} left", span(time)));
    format!(
        "{}: t {:.3e}{left}, dt {:.2e}, drift {:.1e}",
        printable(progress.step),
        progress.now.total_time,
        progress.increment,
        progress.energy.drift
    )
}

/// Estimate of the remaining wall-clock time from the speed of about the last half of the run: increments can shorten
/// and elements can be deleted.
#[derive(Debug, Default)]
pub struct TimeLeft {
    /// Elapsed time and completed fraction at the start of the averaging interval, and at the start of the next one
    /// (`middle`).
    from: Option<(Duration, f64)>,
    middle: Option<(Duration, f64)>,
}

impl TimeLeft {
    /// Returns the remaining time after `elapsed` with `fraction` of the run completed; `None` if no progress has been
    /// measured yet.
    pub fn after(&mut self, elapsed: Duration, fraction: f64) -> Option<Duration> {
        let now = (elapsed, fraction);
        let (begin, done) = *self.from.get_or_insert(now);
        let middle = *self.middle.get_or_insert(now);
        if elapsed > middle.0 * 2 {
            (self.from, self.middle) = (Some(middle), Some(now));
        }
        let (time, part) = (elapsed.saturating_sub(begin).as_secs_f64(), fraction - done);
        if part <= 0.0 || time <= 0.0 {
            return None;
        }
        Duration::try_from_secs_f64((1.0 - fraction).max(0.0) * time / part).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::TimeLeft;
    use std::time::Duration;

    /// The speed of the run halves in the middle; the estimate must follow the new speed.
    #[test]
    fn remaining_time_follows_a_change_of_speed() {
        let mut left = TimeLeft::default();
        let fraction = |second: u64| if second < 50 { second as f64 / 100.0 } else { 0.25 + second as f64 / 200.0 };
        let mut estimate = None;
        for second in 0..=130 {
            estimate = left.after(Duration::from_secs(second), fraction(second));
        }
        let truth = 150.0 - 130.0;
        let estimate = estimate.expect("a time").as_secs_f64();
        assert!((estimate / truth - 1.0).abs() < 0.2, "{estimate} {truth}");
        let mut even = TimeLeft::default();
        let times = (1..=10).map(|s| even.after(Duration::from_secs(s), s as f64 / 100.0));
        let estimate = times.last().flatten().expect("a time").as_secs_f64();
        assert!((estimate / 90.0 - 1.0).abs() < 0.01, "{estimate}");
    }
}
