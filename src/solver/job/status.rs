//! The status file `<job>.sta`: progress of a run in the columns of ABAQUS/Explicit (Analysis User's Guide, "Output",
//! status file). Lines are only appended, so `tail -f` can follow the file.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::time::{Duration, Instant as Stopwatch};

use crate::output::{JobFiles, STATUS};
use crate::solve::Progress;

/// Interval of lines, in addition to those at frames and at the start of steps.
const EVERY: Duration = Duration::from_secs(5);

const HEADER: &str = "
              STEP     TOTAL      WALL    STABLE     CRITICAL   KINETIC     TOTAL
INCREMENT     TIME      TIME      TIME INCREMENT      ELEMENT    ENERGY    ENERGY
";

/// An open status file. If it cannot be written, the run continues and the error is reported at its end.
pub(super) struct StatusFile {
    file: File,
    begin: Stopwatch,
    written: Option<Stopwatch>,
    step: u32,
    /// First error of writing the file.
    pub(super) failed: Option<io::Error>,
}

impl StatusFile {
    /// Creates the status file of a job, or opens it for appending if `goes_on` (a restart).
    pub(super) fn open(job: &JobFiles, goes_on: bool) -> io::Result<Self> {
        let path = job.path(STATUS);
        let file = OpenOptions::new().create(true).append(goes_on).truncate(!goes_on).write(true).open(&path);
        let file = file.map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))?;
        let mut status = StatusFile { file, begin: Stopwatch::now(), written: None, step: 0, failed: None };
        let begins = if goes_on { "restarts" } else { "starts" };
        status.note(&format!("Revolve {}: {} {begins}", env!("CARGO_PKG_VERSION"), job.name));
        Ok(status)
    }

    /// Appends a line at a new step, at a frame, at the end, or after `EVERY`; also appends the file name of the frame.
    pub(super) fn report_progress(&mut self, progress: &Progress<'_>, frame: Option<&str>) {
        let new = progress.now.step != self.step;
        let due = new || frame.is_some() || progress.ends || self.written.is_none_or(|w| w.elapsed() >= EVERY);
        if !due {
            return;
        }
        if new {
            self.step = progress.now.step;
            self.append(&format!("\nSTEP {}  {}\n{HEADER}", progress.now.step, progress.step));
        }
        self.written = Some(Stopwatch::now());
        self.append(&line(progress, self.begin.elapsed()));
        if let Some(name) = frame {
            self.note(&format!("          frame {name}"));
        }
    }

    /// Appends a line of text.
    pub(super) fn note(&mut self, text: &str) {
        self.append(&format!("{text}\n"));
    }

    fn append(&mut self, text: &str) {
        if self.failed.is_none() {
            self.failed = self.file.write_all(text.as_bytes()).err();
        }
    }
}

/// Formats one line of the table; `wall` is the wall-clock time since the start or restart of the run.
fn line(progress: &Progress<'_>, wall: Duration) -> String {
    let (now, energy) = (progress.now, &progress.energy);
    let [step, total, stable, kinetic, energy] =
        [now.step_time, now.total_time, progress.increment, energy.kinetic, energy.total].map(scientific);
    let seconds = wall.as_secs();
    let wall = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    let (increment, element) = (now.increment, progress.limiting);
    format!("{increment:>9} {step} {total} {wall:>9} {stable} {element:>12} {kinetic} {energy}\n")
}

/// Formats a number in nine characters like Fortran: `1.82E-06`.
fn scientific(value: f64) -> String {
    let text = format!("{value:.2E}");
    let Some((digits, exponent)) = text.split_once('E') else { return format!("{text:>9}") };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>9}", format!("{digits}E{sign}{:02}", exponent.abs()))
}

#[cfg(test)]
mod tests {
    use super::scientific;

    #[test]
    fn numbers_have_the_width_and_format_of_fortran() {
        let numbers = [1.819_4e-6, -2.5e12, 0.0, f64::NAN, 1e-300].map(scientific);
        assert_eq!(numbers, [" 1.82E-06", "-2.50E+12", " 0.00E+00", "      NaN", "1.00E-300"]);
    }
}
