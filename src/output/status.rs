//! The status file `<job>.sta`: how far a run is, line by line, in the columns of ABAQUS/Explicit (Analysis User's Guide, "Output",
//! status file), so that it can be watched with `tail -f`. It grows as the run does; a line once written stays.
//! Never here: when a line is due.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::time::Duration;

use super::Job;

/// Ending of its name.
pub const STATUS: &str = ".sta";

const HEADER: &str = "
              STEP     TOTAL      WALL    STABLE     CRITICAL   KINETIC     TOTAL
INCREMENT     TIME      TIME      TIME INCREMENT      ELEMENT    ENERGY    ENERGY
";

/// One line.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// Increments so far.
    pub increment: u64,
    /// Time of the step.
    pub step_time: f64,
    /// Time of all steps.
    pub total_time: f64,
    /// Time on the clock since the run began or went on.
    pub wall: Duration,
    /// Length of the increment behind.
    pub stable: f64,
    /// Element that limits it; empty where none does.
    pub element: &'a str,
    /// ALLKE.
    pub kinetic: f64,
    /// ETOTAL.
    pub total: f64,
}

/// A status file that is open.
#[derive(Debug)]
pub struct Status {
    file: File,
}

impl Status {
    /// Begins the file of a job, or goes on with it.
    ///
    /// # Errors
    /// Where it cannot be opened, with its path.
    pub fn open(job: &Job, goes_on: bool) -> io::Result<Self> {
        let path = job.path(STATUS);
        let open = || OpenOptions::new().create(true).append(goes_on).truncate(!goes_on).write(true).open(&path);
        open()
            .map(|file| Status { file })
            .map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))
    }

    /// A step begins, or goes on.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn step(&mut self, number: u32, name: &str) -> io::Result<()> {
        self.put(&format!("\nSTEP {number}  {name}\n{HEADER}"))
    }

    /// A line of the table.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn line(&mut self, line: &Line<'_>) -> io::Result<()> {
        let [step, total, stable, kinetic, energy] =
            [line.step_time, line.total_time, line.stable, line.kinetic, line.total].map(scientific);
        let seconds = line.wall.as_secs();
        let wall = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
        let (increment, element) = (line.increment, line.element);
        self.put(&format!("{increment:>9} {step} {total} {wall:>9} {stable} {element:>12} {kinetic} {energy}\n"))
    }

    /// A sentence.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn note(&mut self, text: &str) -> io::Result<()> {
        self.put(&format!("{text}\n"))
    }

    fn put(&mut self, text: &str) -> io::Result<()> {
        self.file.write_all(text.as_bytes())
    }
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
