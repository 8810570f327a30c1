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
        let time_left = self.left.after(self.bar.elapsed(), progress.fraction, progress.now.increment);
        self.bar.set_message(sentence(progress, time_left));
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
    let time_left = left.map_or(String::new(), |time| format!(", {} left", span(time)));
    format!(
        "{}: t {:.3e}{time_left}, dt {:.2e}, drift {:.1e}",
        printable(progress.step),
        progress.now.total_time,
        progress.increment,
        progress.energy.drift
    )
}

/// State of a run at a report.
#[derive(Clone, Copy, Debug)]
struct ProgressMark {
    elapsed: Duration,
    fraction: f64,
    increments: u64,
}

/// Estimate of the remaining wall-clock time: the number of remaining increments at the time increment since the last
/// report, times the time for an increment in about the last half of the run. Increments can become shorter and
/// elements can be deleted.
#[derive(Debug, Default)]
pub struct TimeLeft {
    /// Start of the averaging interval, and of the next one (`middle`).
    from: Option<ProgressMark>,
    middle: Option<ProgressMark>,
    last: Option<ProgressMark>,
    /// Remaining increments relative to the remaining fraction of the run.
    density: f64,
}

impl TimeLeft {
    /// Returns the remaining time after `elapsed` and `increments` with `fraction` of the run completed; `None` if no
    /// progress has been measured yet.
    pub fn after(&mut self, elapsed: Duration, fraction: f64, increments: u64) -> Option<Duration> {
        let now = ProgressMark { elapsed, fraction, increments };
        let begin = *self.from.get_or_insert(now);
        let middle = *self.middle.get_or_insert(now);
        if elapsed > middle.elapsed * 2 {
            (self.from, self.middle) = (Some(middle), Some(now));
        }
        let last = *self.last.get_or_insert(now);
        if fraction > last.fraction {
            self.density = increments.saturating_sub(last.increments) as f64 / (fraction - last.fraction);
            self.last = Some(now);
        }
        let count = increments.saturating_sub(begin.increments) as f64;
        if self.density <= 0.0 || count <= 0.0 {
            return None;
        }
        let each = elapsed.saturating_sub(begin.elapsed).as_secs_f64() / count;
        Duration::try_from_secs_f64((1.0 - fraction).max(0.0) * self.density * each).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::TimeLeft;
    use std::time::Duration;

    /// The time increment becomes a hundred times shorter at half of the run, at 1000 increments a second.
    #[test]
    fn remaining_time_follows_the_time_increment() {
        let mut time_left = TimeLeft::default();
        let fraction_at =
            |second: u64| if second <= 50 { second as f64 / 100.0 } else { 0.5 + (second - 50) as f64 / 1e4 };
        let mut estimate =
            |second: u64| time_left.after(Duration::from_secs(second), fraction_at(second), 1000 * second);
        assert_eq!(estimate(0), None);
        for second in 1..200 {
            let truth = if second <= 50 { 100 - second } else { 5050 - second } as f64;
            let remaining = estimate(second).expect("a time").as_secs_f64();
            assert!((remaining / truth - 1.0).abs() < 0.01, "{second}: {remaining} {truth}");
        }
    }

    /// Increments take twice the time from the middle of the run on.
    #[test]
    fn remaining_time_follows_a_change_of_speed() {
        let mut time_left = TimeLeft::default();
        let fraction = |second: u64| if second < 50 { second as f64 / 100.0 } else { 0.25 + second as f64 / 200.0 };
        let mut estimate = None;
        for second in 0..=130 {
            let completed = fraction(second);
            estimate = time_left.after(Duration::from_secs(second), completed, (1e4 * completed) as u64);
        }
        let truth = 150.0 - 130.0;
        let estimate = estimate.expect("a time").as_secs_f64();
        assert!((estimate / truth - 1.0).abs() < 0.2, "{estimate} {truth}");
    }
}
