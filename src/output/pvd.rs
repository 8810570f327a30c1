//! The series of a job's frames: `<job>_0000.vtu`, … and `<job>.pvd`, which lists them with their times.
//! Never here: what a frame holds.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::checkpoint::CHECKPOINT;
use super::status::STATUS;
use super::vtu::{VtuWriter, escape};
use super::whole::unfinished;
use super::{Frame, Job, Points, write_whole};

/// Writes frames one after the other; the list is whole after each.
#[derive(Debug)]
pub struct FrameWriter {
    job: Job,
    times: Vec<f64>,
    vtu: VtuWriter,
}

impl FrameWriter {
    /// Begins a series, in a folder that is there, and removes what an earlier run of the job left.
    ///
    /// # Errors
    /// Where the folder cannot be cleared.
    pub fn new(job: Job, points: Points) -> io::Result<Self> {
        // The lists first: none shall name a frame that is gone.
        for ending in [".pvd", ".json", "_history.csv", CHECKPOINT, STATUS] {
            remove(&job.path(ending))?;
        }
        let writer = FrameWriter { job, times: Vec::new(), vtu: VtuWriter::new(points) };
        writer.clear_from(0)?;
        Ok(writer)
    }

    /// Goes on with a series behind the frames of these times; frames behind them are removed.
    ///
    /// # Errors
    /// Where the folder cannot be cleared.
    pub fn go_on(job: Job, times: Vec<f64>, points: Points) -> io::Result<Self> {
        let writer = FrameWriter { job, times, vtu: VtuWriter::new(points) };
        remove(&writer.job.path(".json"))?;
        write_whole(&writer.job.path(".pvd"), writer.list().as_bytes())?;
        writer.clear_from(writer.times.len())?;
        Ok(writer)
    }

    /// Times of the frames so far.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Name of the file of the next frame.
    pub fn next_name(&self) -> String {
        format!("{}_{:04}.vtu", self.job.name, self.times.len())
    }

    /// Removes frames from this one on, and what a killed process has not finished.
    fn clear_from(&self, first: usize) -> io::Result<()> {
        for entry in fs::read_dir(&self.job.folder)? {
            let name = entry?.file_name();
            let old = name.to_str().and_then(|n| frame_number(n, &self.job.name)).is_some_and(|n| n >= first);
            let is_own = |n: &str| {
                let listed = [".pvd", ".json", "_history.csv", CHECKPOINT].iter();
                frame_number(n, &self.job.name).is_some()
                    || listed.copied().any(|e| n == format!("{}{e}", self.job.name))
            };
            if old || unfinished(&name).is_some_and(is_own) {
                remove(&self.job.folder.join(name))?;
            }
        }
        Ok(())
    }

    /// Writes the next frame and the list.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        write_whole(&self.job.folder.join(self.next_name()), self.vtu.text(frame).as_bytes())?;
        self.times.push(frame.time);
        write_whole(&self.job.path(".pvd"), self.list().as_bytes())
    }

    fn list(&self) -> String {
        let mut text =
            String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n");
        let name = escape(&self.job.name);
        for (i, time) in self.times.iter().enumerate() {
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}_{i:04}.vtu\"/>");
        }
        text + "</Collection>\n</VTKFile>\n"
    }
}

/// Paths of the first so many frames of a job that are not there, or empty after a loss of power.
pub fn missing_frames(job: &Job, count: usize) -> Vec<PathBuf> {
    let is_there = |path: &PathBuf| path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
    (0..count).map(|i| job.path(&format!("_{i:04}.vtu"))).filter(|path| !is_there(path)).collect()
}

fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => {
            Err(io::Error::new(e.kind(), format!("cannot remove {}: {e}", path.display())))
        }
        _ => Ok(()),
    }
}

fn frame_number(file: &str, job: &str) -> Option<usize> {
    let number = file.strip_prefix(job)?.strip_prefix('_')?.strip_suffix(".vtu")?;
    if number.bytes().all(|b| b.is_ascii_digit()) { number.parse().ok() } else { None }
}
