//! Looks for changes of the result files of a job, reads changed files, and posts the changes for the pages.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use serde_json::{Value, json};

use super::board::StateBoard;
use super::changed_files;
use super::status::JobStatus;
use super::store::{FrameStore, ViewField};
use crate::deck::files;
use crate::output::sums::{Checksums, SUMS};
use crate::output::{HISTORY, JobFiles, SETUP, STATUS};
use crate::report::units::UnitNames;
use crate::report::{frames, limits, run_without_frames};

/// Time between two looks at the files.
const LOOK: Duration = Duration::from_millis(50);
/// A file is read again after this multiple of the time that reading it took, so that reading takes at most this part of
/// a processor.
const PAUSE: u32 = 50;
/// Time after which a file that cannot be read is tried again.
const RETRY: Duration = Duration::from_millis(500);

/// Length and time of the last change of a file; `None` if it does not exist.
type FileStamp = Option<(u64, SystemTime)>;

fn stamp(path: &Path) -> FileStamp {
    let file = path.metadata().ok()?;
    Some((file.len(), file.modified().ok()?))
}

/// Files that are read together, and when.
#[derive(Default)]
struct WatchedFiles {
    /// State of the files that was read last.
    seen: Vec<FileStamp>,
    next: Option<Instant>,
}

impl WatchedFiles {
    /// Calls `read` if the files have changed since it was called, but not too often.
    fn look(&mut self, paths: &[PathBuf], read: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
        let now = Instant::now();
        if self.next.is_some_and(|next| now < next) {
            return Ok(());
        }
        let stamps: Vec<FileStamp> = paths.iter().map(|path| stamp(path)).collect();
        if stamps == self.seen {
            return Ok(());
        }
        let outcome = read();
        let pause = if outcome.is_err() { RETRY } else { now.elapsed() * PAUSE };
        self.next = Some(Instant::now() + pause);
        // A file that cannot be read now is read again although it does not change.
        self.seen = if outcome.is_err() { Vec::new() } else { stamps };
        outcome
    }
}

/// Watch on the folder of a job.
pub struct FolderWatch {
    job: JobFiles,
    board: Arc<StateBoard>,
    store: Arc<FrameStore>,
    /// Names of the files of the deck, from the setup or the summary.
    deck: Vec<PathBuf>,
    sums: Arc<Checksums>,
    /// Times of the frames, and the state of the first file.
    series: (Vec<f64>, FileStamp),
    /// Number of the run in the folder, and of the fields that have been posted.
    generation: u64,
    field_count: usize,
    units: UnitNames,
    ended: bool,
}

impl FolderWatch {
    pub fn new(job: JobFiles, board: Arc<StateBoard>, store: Arc<FrameStore>) -> FolderWatch {
        let (deck, sums, series, generation, field_count, units) = Default::default();
        FolderWatch { job, board, store, deck, sums, series, generation, field_count, units, ended: false }
    }

    /// Looks at the files until the process ends.
    pub fn run(mut self) {
        let mut watched: [WatchedFiles; 4] = Default::default();
        let [setup, status, list, summary] = [SETUP, STATUS, ".pvd", ".json"].map(|ending| self.job.path(ending));
        let [history, sums] = [HISTORY, SUMS].map(|ending| self.job.path(ending));
        loop {
            let faults = [
                watched[3].look(std::slice::from_ref(&setup), || self.read_setup(&setup)),
                watched[0].look(std::slice::from_ref(&status), || self.read_status()),
                watched[1].look(&[summary.clone(), history.clone(), sums.clone()], || self.read_run()),
                watched[2].look(&[list.clone(), summary.clone(), sums.clone()], || self.read_frames()),
                self.post_new_fields(),
            ];
            let faults: Vec<String> = faults.into_iter().filter_map(Result::err).collect();
            self.board.post("faults", json!(faults).to_string());
            let changed = changed_files(self.deck.iter().map(PathBuf::as_path), &self.job);
            self.board.post("changed", json!(changed).to_string());
            std::thread::sleep(LOOK);
        }
    }

    /// Reads the setup of a run that has not ended.
    fn read_setup(&mut self, path: &Path) -> Result<(), String> {
        if !path.is_file() {
            return Ok(());
        }
        let text = files::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let setup: Value = serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        self.take_facts(&setup);
        self.board.post("setup", setup.to_string());
        Ok(())
    }

    /// Takes units and files of the deck from a setup or summary.
    fn take_facts(&mut self, facts: &Value) {
        self.units = UnitNames::of(facts);
        let names = facts["deck"]["files"].as_array().into_iter().flatten().filter_map(Value::as_str);
        self.deck = names.map(PathBuf::from).collect();
    }

    fn read_status(&mut self) -> Result<(), String> {
        let path = self.job.path(STATUS);
        let text = if path.is_file() {
            files::read(&path).map_err(|e| format!("{}: {e}", path.display()))?
        } else {
            Vec::new()
        };
        let JobStatus { last, warnings, ended, limits } = JobStatus::parse(&String::from_utf8_lossy(&text));
        let increments = limits::chart(&limits, &self.units);
        self.ended = !ended.is_empty();
        self.board.post("status", json!({"last": last, "ended": ended, "increments": increments}).to_string());
        self.board.post("warnings", json!(warnings).to_string());
        Ok(())
    }

    /// Reads histories and summary.
    fn read_run(&mut self) -> Result<(), String> {
        self.sums = Arc::new(self.checksums()?);
        let run = run_without_frames(&self.job.folder, &self.job.name, &self.sums)?;
        if run.summary.is_object() {
            self.take_facts(&run.summary);
        }
        self.board.post("run", serde_json::to_string(&run).map_err(|e| e.to_string())?);
        Ok(())
    }

    /// Reads the checksums; a running job has none.
    fn checksums(&self) -> Result<Checksums, String> {
        if self.job.path(SUMS).is_file() { Checksums::of(&self.job.folder) } else { Ok(Checksums::default()) }
    }

    fn read_frames(&mut self) -> Result<(), String> {
        let path = self.job.path(".pvd");
        let files = if path.is_file() { frames::series(&path)? } else { Vec::new() };
        let times: Vec<f64> = files.iter().map(|file| file.0).collect();
        let first = files.first().and_then(|file| stamp(&file.1));
        let is_restarted = first != self.series.1 || !times.starts_with(&self.series.0);
        self.generation = self.store.set_files(files, self.sums.clone(), is_restarted);
        self.series = (times, first);
        self.post_frames()
    }

    /// Posts the fields again if a frame with others has been read for a page.
    fn post_new_fields(&mut self) -> Result<(), String> {
        if self.store.field_count() > self.field_count { self.post_frames() } else { Ok(()) }
    }

    /// Posts the times of all frames, and the fields of the frames that have been read.
    fn post_frames(&mut self) -> Result<(), String> {
        let no_frames = self.series.0.is_empty();
        let fields = if no_frames { Vec::new() } else { self.store.fields().map_err(|why| why.reason)? };
        self.field_count = fields.len();
        let field = |field: &ViewField| json!({"name": field.name, "on_cells": field.on_cells, "unit": self.units.of_column(&field.name)});
        let fields: Vec<Value> = fields.iter().map(field).collect();
        let frames = json!({"generation": self.generation, "times": self.series.0, "fields": fields, "units": self.units.length_and_time()});
        self.board.post("frames", frames.to_string());
        Ok(())
    }
}
