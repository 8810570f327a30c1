//! Lists of finished runs, from which an interrupted command continues.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant as Stopwatch};

use super::StudyError;
use crate::deck::files;
use crate::output::{JobFiles, csv, whole};

/// Ending of the list of finished runs of `limit`, `scatter`, `identify`, `sensitivity` and `study`.
pub const RUNS: &str = "_runs_log.csv";
/// Time between two writings of a list.
const WRITE_EVERY: Duration = Duration::from_millis(500);
/// Run time below which a run is not listed: to run it again takes no longer than to read its line.
const SHORTEST: Duration = Duration::from_millis(1);

/// File to which lines are appended, written every half second. A process that is killed leaves complete lines, and at most
/// one incomplete line at the end.
pub struct AppendedFile {
    path: PathBuf,
    state: Mutex<AppendedLines>,
}

struct AppendedLines {
    file: File,
    /// Lines that are not written yet.
    text: String,
    written: Stopwatch,
    failed: Option<io::Error>,
}

impl AppendedLines {
    fn write(&mut self) {
        // After an incomplete line, further lines could not be read.
        if self.failed.is_none() {
            self.failed = self.file.write_all(self.text.as_bytes()).err();
        }
        self.text.clear();
        self.written = Stopwatch::now();
    }
}

impl AppendedFile {
    /// Writes a file with this text, to which lines are appended later.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(path: PathBuf, text: &str) -> Result<AppendedFile, StudyError> {
        whole::write_whole(&path, text.as_bytes()).map_err(|e| StudyError::Setting(e.to_string()))?;
        let opened = OpenOptions::new().append(true).open(&path);
        let file = opened.map_err(|e| StudyError::Setting(format!("cannot write {}: {e}", path.display())))?;
        let state = AppendedLines { file, text: String::new(), written: Stopwatch::now(), failed: None };
        Ok(AppendedFile { path, state: Mutex::new(state) })
    }

    /// Appends a line, which ends with a line break.
    pub fn add(&self, line: &str) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.text += line;
        if state.written.elapsed() > WRITE_EVERY {
            state.write();
        }
    }

    /// Writes the remaining lines. Returns a warning if a line could not be written.
    pub fn finish(&self) -> Option<String> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.write();
        let error = state.failed.take()?;
        Some(format!(
            "cannot write {}: {error}; --resume would repeat the runs that are not in it",
            self.path.display()
        ))
    }
}

impl Drop for AppendedFile {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Reads the complete lines of an appended file; `None` if it does not exist.
///
/// # Errors
/// If the file cannot be read.
pub fn complete_lines(path: &Path) -> Result<Option<String>, StudyError> {
    match files::read_text(path) {
        Ok(mut text) => {
            text.truncate(text.rfind('\n').map_or(0, |end| end + 1));
            Ok(Some(text))
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(StudyError::Setting(format!("{}: {e}", path.display()))),
    }
}

/// Results of a finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinishedValues {
    /// Numbers, whose meaning is that of the command.
    pub values: Vec<f64>,
    /// Warnings of the run.
    pub warnings: Vec<String>,
}

impl FinishedValues {
    /// Formats a line; numbers have all digits, so that reading them back is exact.
    fn line(&self, key: &str) -> String {
        let values = self.values.iter().map(|value| format!("{value:e}"));
        let warnings = serde_json::to_string(&self.warnings).unwrap_or_default();
        csv::line([key.to_owned(), warnings].into_iter().chain(values))
    }

    fn parse(line: &str) -> Option<(String, FinishedValues)> {
        let mut fields = csv::fields(line).into_iter();
        let (key, warnings) = (fields.next()?, serde_json::from_str(&fields.next()?).ok()?);
        let values = fields.map(|field| field.parse().ok()).collect::<Option<_>>()?;
        Some((key, FinishedValues { values, warnings }))
    }
}

/// List of the finished runs of a command, each with a key: the hash of everything on which its results depend. Runs of other
/// settings therefore are never taken for those of this command.
pub struct RunLog {
    file: AppendedFile,
    known: HashMap<String, FinishedValues>,
    reused: AtomicUsize,
}

impl RunLog {
    /// Begins the list of a job, with the runs of an interrupted command if `resume`.
    ///
    /// # Errors
    /// If the list cannot be read or written.
    pub fn begin(job: &JobFiles, resume: bool) -> Result<RunLog, StudyError> {
        let path = job.path(RUNS);
        let text = if resume { complete_lines(&path)?.unwrap_or_default() } else { String::new() };
        let known = text.lines().filter_map(FinishedValues::parse).collect();
        Ok(RunLog { file: AppendedFile::begin(path, &text)?, known, reused: AtomicUsize::new(0) })
    }

    /// Returns the results of a run of the interrupted command.
    pub fn known(&self, key: &str) -> Option<&FinishedValues> {
        let found = self.known.get(key)?;
        self.reused.fetch_add(1, Ordering::Relaxed);
        Some(found)
    }

    /// Adds a finished run that took this time.
    pub fn add(&self, key: &str, run: &FinishedValues, time: Duration) {
        if time >= SHORTEST {
            self.file.add(&run.line(key));
        }
    }

    /// Removes the list of a command that has written its results. Returns a warning if it could not be written.
    pub fn finish(&self) -> Option<String> {
        let failed = self.file.finish();
        // A list that stays is not used without --resume, and with it is still valid.
        let _ = std::fs::remove_file(&self.file.path);
        failed
    }

    /// Returns a sentence on the runs that were taken from the list.
    pub fn reused(&self) -> String {
        match (self.known.len(), self.reused.load(Ordering::Relaxed)) {
            (0, _) => "--resume: no finished runs are listed; all runs are new".into(),
            (known, reused) => format!("--resume: {reused} results were taken from a list of {known} finished runs"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{FinishedValues, RUNS, RunLog, SHORTEST};
    use crate::output::JobFiles;

    #[test]
    fn finished_runs_are_read_back_with_all_bits() {
        let folder = tempfile::tempdir().expect("a folder");
        let job = JobFiles { folder: folder.path().to_owned(), name: "a".into() };
        let values = vec![0.1 + 0.2, f64::NAN, f64::INFINITY, -0.0, 5e-324];
        let run = FinishedValues { values, warnings: vec!["R301: a, \"b\"".into()] };
        let log = RunLog::begin(&job, false).expect("a list");
        log.add("long", &run, SHORTEST);
        log.add("short", &run, Duration::ZERO);
        drop(log);
        // A process that was killed while it wrote a line.
        let path = job.path(RUNS);
        let text = std::fs::read_to_string(&path).expect("a list");
        std::fs::write(&path, text + "torn,[],1.2").expect("a list");
        let log = RunLog::begin(&job, true).expect("a list");
        let bits = |run: &FinishedValues| run.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let known = log.known("long").expect("the run");
        assert_eq!((bits(known), &known.warnings), (bits(&run), &run.warnings));
        assert!(log.known("short").is_none() && log.known("torn").is_none());
        assert_eq!(log.reused(), "--resume: 1 results were taken from a list of 1 finished runs");
        assert_eq!(log.finish(), None);
        assert!(!path.exists());
    }
}
