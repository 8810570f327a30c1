//! The status file `<job>.sta`: how far a run is, line by line, in the columns of ABAQUS/Explicit (Analysis User's Guide, "Output",
//! status file), so that it can be watched with `tail -f`. It grows as the run does; a line once written stays.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::time::{Duration, Instant as Stopwatch};

use crate::output::{Job, STATUS};
use crate::solve::Progress;

/// It gets a line this often, beside those of frames and steps.
const EVERY: Duration = Duration::from_secs(5);

const HEADER: &str = "
              STEP     TOTAL      WALL    STABLE     CRITICAL   KINETIC     TOTAL
INCREMENT     TIME      TIME      TIME INCREMENT      ELEMENT    ENERGY    ENERGY
";

/// A status file that is open. Where it cannot be written the run goes on; the end tells.
pub(super) struct Status {
    file: File,
    begin: Stopwatch,
    written: Option<Stopwatch>,
    step: u32,
    /// Why it could not be written.
    pub(super) failed: Option<io::Error>,
}

impl Status {
    /// Begins the file of a job, or goes on with it.
    pub(super) fn open(job: &Job, goes_on: bool) -> io::Result<Self> {
        let path = job.path(STATUS);
        let file = OpenOptions::new().create(true).append(goes_on).truncate(!goes_on).write(true).open(&path);
        let file = file.map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))?;
        let mut status = Status { file, begin: Stopwatch::now(), written: None, step: 0, failed: None };
        let begins = if goes_on { "goes on" } else { "begins" };
        status.note(&format!("Revolve {}: {} {begins}", env!("CARGO_PKG_VERSION"), job.name));
        Ok(status)
    }

    /// Writes a line where one is due, and the name of a frame that comes with it.
    pub(super) fn tell(&mut self, progress: &Progress<'_>, frame: Option<&str>) {
        let new = progress.now.step != self.step;
        let due = new || frame.is_some() || progress.ends || self.written.is_none_or(|w| w.elapsed() >= EVERY);
        if !due {
            return;
        }
        if new {
            self.step = progress.now.step;
            self.put(&format!("\nSTEP {}  {}\n{HEADER}", progress.now.step, progress.step));
        }
        self.written = Some(Stopwatch::now());
        self.put(&line(progress, self.begin.elapsed()));
        if let Some(name) = frame {
            self.note(&format!("          frame {name}"));
        }
    }

    /// Writes a sentence.
    pub(super) fn note(&mut self, text: &str) {
        self.put(&format!("{text}\n"));
    }

    fn put(&mut self, text: &str) {
        if self.failed.is_none() {
            self.failed = self.file.write_all(text.as_bytes()).err();
        }
    }
}

/// A line of the table; `wall` is the time on the clock since the run began or went on.
fn line(progress: &Progress<'_>, wall: Duration) -> String {
    let (now, energy) = (progress.now, &progress.energy);
    let [step, total, stable, kinetic, energy] =
        [now.step_time, now.total_time, progress.increment, energy.kinetic, energy.total].map(scientific);
    let seconds = wall.as_secs();
    let wall = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    let (increment, element) = (now.increment, progress.limiting);
    format!("{increment:>9} {step} {total} {wall:>9} {stable} {element:>12} {kinetic} {energy}\n")
}

/// A number in nine places as Fortran prints it: `1.819E-06`.
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
    fn numbers_fill_their_columns_as_fortran_does() {
        let all = [1.819_4e-6, -2.5e12, 0.0, f64::NAN, 1e-300].map(scientific);
        assert_eq!(all, [" 1.82E-06", "-2.50E+12", " 0.00E+00", "      NaN", "1.00E-300"]);
    }
}
