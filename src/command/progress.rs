//! How far a run is, on the terminal: a bar by the clock with the time simulated, the time left, the increment and the energies.

use std::path::Path;
use std::time::Duration;

use crate::deck::printable;
use crate::output::clock::span;
use crate::solve::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::words;

/// Parts of a bar.
const PARTS: u64 = 1000;
/// Times a second that it is drawn.
const RATE: u8 = 4;

/// A bar on standard error; hidden where nobody watches.
fn bar(length: u64, template: &str, quiet: bool) -> ProgressBar {
    if quiet || !words::is_watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(RATE)).with_style(style)
}

/// A bar over a number of runs.
pub fn over_runs(runs: u64, quiet: bool) -> ProgressBar {
    bar(runs, "{bar:40} {pos} of {len} runs, {elapsed} ({eta} left)", quiet)
}

/// A line while a deck is read, which takes seconds where it is large.
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

    /// The bar, for what writes above it.
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

/// The time left by the pace of about the last half of the run: increments may shorten, and elements die.
#[derive(Debug, Default)]
pub struct TimeLeft {
    /// Time on the clock and fraction done, where the last half begins and where the next one will.
    from: Option<(Duration, f64)>,
    middle: Option<(Duration, f64)>,
}

impl TimeLeft {
    /// With so much time behind and this fraction done; `None` while too little is known.
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

    /// A run that halves its pace in the middle: what is left is told by the pace now, not by that of the beginning.
    #[test]
    fn the_time_left_follows_the_pace() {
        let mut left = TimeLeft::default();
        let fraction = |second: u64| if second < 50 { second as f64 / 100.0 } else { 0.25 + second as f64 / 200.0 };
        let mut told = None;
        for second in 0..=130 {
            told = left.after(Duration::from_secs(second), fraction(second));
        }
        let truth = 150.0 - 130.0;
        let told = told.expect("a time").as_secs_f64();
        assert!((told / truth - 1.0).abs() < 0.2, "{told} {truth}");
        let mut even = TimeLeft::default();
        let times = (1..=10).map(|s| even.after(Duration::from_secs(s), s as f64 / 100.0));
        let told = times.last().flatten().expect("a time").as_secs_f64();
        assert!((told / 90.0 - 1.0).abs() < 0.01, "{told}");
    }
}
