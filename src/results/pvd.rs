//! Frame series of a job: `<job>_0000.vtu`, … and `<job>.pvd`, which lists them with their times.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::{fs, io};

use super::checkpoint::CHECKPOINT;
use super::sums::{Checksums, SUMS, SummedWriter};
use super::vtu::{VtuWriter, escape};
use super::whole::{AtomicFile, remove, unfinished};
use super::{FramePoints, HISTORY, INPUT, JobFiles, OutputFrame, SETUP, STATUS, write_whole};

/// Files of a job other than frames.
const OTHERS: [&str; 8] = [SUMS, ".pvd", ".json", HISTORY, CHECKPOINT, STATUS, SETUP, INPUT];

/// Time of a frame that has been written, and the checksum of its file.
pub type WrittenFrame = (f64, u32);

/// Writer of frames; the PVD file is complete after each frame.
#[derive(Debug)]
pub struct FrameWriter {
    job: JobFiles,
    frames: Vec<WrittenFrame>,
    vtu: VtuWriter,
}

impl FrameWriter {
    /// Begins a series in an existing folder and removes the files of an earlier run of the job.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn new(job: JobFiles, points: FramePoints) -> io::Result<Self> {
        // Lists are removed first, so that none names a missing frame.
        for ending in OTHERS {
            remove(&job.path(ending))?;
        }
        let writer = FrameWriter { job, frames: Vec::new(), vtu: VtuWriter::new(points) };
        writer.clear_from(0)?;
        Ok(writer)
    }

    /// Continues a series after these frames; later frames are removed.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn resume(job: JobFiles, frames: Vec<WrittenFrame>, points: FramePoints) -> io::Result<Self> {
        let writer = FrameWriter { job, frames, vtu: VtuWriter::new(points) };
        remove(&writer.job.path(SUMS))?;
        remove(&writer.job.path(".json"))?;
        write_whole(&writer.job.path(".pvd"), writer.list().as_bytes())?;
        writer.clear_from(writer.frames.len())?;
        Ok(writer)
    }

    /// Returns the frames written so far.
    pub fn frames(&self) -> &[WrittenFrame] {
        &self.frames
    }

    /// Returns the checksums of the frames and of their list.
    pub fn sums(&self) -> Checksums {
        let mut sums = Checksums::default();
        for (i, (_, sum)) in self.frames.iter().enumerate() {
            sums.add_sum(&self.job, &ending(i), *sum);
        }
        sums.add(&self.job, ".pvd", self.list().as_bytes());
        sums
    }

    /// Returns the file name of the next frame.
    pub fn next_name(&self) -> String {
        format!("{}{}", self.job.name, ending(self.frames.len()))
    }

    /// Removes frames from index `first` on, and incomplete files of a killed process.
    fn clear_from(&self, first: usize) -> io::Result<()> {
        for entry in fs::read_dir(&self.job.folder)? {
            let name = entry?.file_name();
            let old = name.to_str().and_then(|n| frame_number(n, &self.job.name)).is_some_and(|n| n >= first);
            let is_own = |n: &str| {
                frame_number(n, &self.job.name).is_some() || OTHERS.iter().any(|e| n == format!("{}{e}", self.job.name))
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
    /// If a file cannot be written.
    pub fn write(&mut self, frame: &OutputFrame) -> io::Result<()> {
        let mut out = SummedWriter::new(AtomicFile::begin(&self.job.path(&ending(self.frames.len())))?);
        self.vtu.write(frame, &mut out)?;
        let (file, sum) = out.finish();
        file.finish()?;
        self.frames.push((frame.time, sum));
        write_whole(&self.job.path(".pvd"), self.list().as_bytes())
    }

    fn list(&self) -> String {
        let mut text =
            String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n");
        let name = escape(&self.job.name);
        for (i, (time, _)) in self.frames.iter().enumerate() {
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}{}\"/>", ending(i));
        }
        text + "</Collection>\n</VTKFile>\n"
    }
}

/// Returns the part of a frame's file name after the name of the job.
fn ending(frame: usize) -> String {
    format!("_{frame:04}.vtu")
}

/// Returns the paths of the first `count` frames that do not exist or are empty.
pub fn missing_frames(job: &JobFiles, count: usize) -> Vec<PathBuf> {
    let is_there = |path: &PathBuf| path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
    (0..count).map(|i| job.path(&ending(i))).filter(|path| !is_there(path)).collect()
}

fn frame_number(file: &str, job: &str) -> Option<usize> {
    let number = file.strip_prefix(job)?.strip_prefix('_')?.strip_suffix(".vtu")?;
    if number.bytes().all(|b| b.is_ascii_digit()) { number.parse().ok() } else { None }
}
