//! Frame series of a job: `<job>_0000.vtu`, … and `<job>.pvd`, which lists them with their times, or `<job>.vtkhdf`.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::checkpoint::CHECKPOINT;
use super::sums::{Checksums, SUMS, SummedWriter};
use super::vtkhdf::VtkHdfWriter;
use super::vtu::{VtuWriter, escape};
use super::whole::{AtomicFile, remove, unfinished};
use super::{FrameFormat, FrameStyle, HISTORY, INPUT, JobFiles, OutputFrame, SETUP, STATUS, VTKHDF, write_whole};

/// Files of a job other than frames.
const OTHERS: [&str; 9] = [SUMS, ".pvd", VTKHDF, ".json", HISTORY, CHECKPOINT, STATUS, SETUP, INPUT];

/// Time of a frame that has been written, and the checksum of its file; 0 in a VTKHDF file.
pub type WrittenFrame = (f64, u32);

/// Writer of frames; the PVD file or the VTKHDF file is complete after each frame.
#[derive(Debug)]
pub struct FrameWriter {
    job: JobFiles,
    frames: Vec<WrittenFrame>,
    style: FrameStyle,
    /// Origin of the results, a line of text.
    origin: String,
    files: FrameFiles,
}

/// Writer of the files of one format.
#[derive(Debug)]
enum FrameFiles {
    Pvd(VtuWriter),
    /// `None` before the first frame.
    Vtkhdf(Option<Box<VtkHdfWriter>>),
}

impl FrameFiles {
    fn new(style: FrameStyle, origin: &str) -> FrameFiles {
        match style.format {
            FrameFormat::Pvd => FrameFiles::Pvd(VtuWriter::new(style.points, origin)),
            FrameFormat::Vtkhdf => FrameFiles::Vtkhdf(None),
        }
    }
}

impl FrameWriter {
    /// Begins a series in an existing folder and removes the files of an earlier run of the job. The origin of the results
    /// is a line of text, which each `.vtu` file has as a comment, and a `.vtkhdf` file as the attribute Origin.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn new(job: JobFiles, style: FrameStyle, origin: String) -> io::Result<Self> {
        // Lists are removed first, so that none names a missing frame.
        for ending in OTHERS {
            remove(&job.path(ending))?;
        }
        let files = FrameFiles::new(style, &origin);
        let writer = FrameWriter { job, frames: Vec::new(), style, origin, files };
        writer.clear_from(0)?;
        Ok(writer)
    }

    /// Continues a series after these frames; later frames are removed.
    ///
    /// # Errors
    /// If files cannot be removed or read, or the frames so far have another format.
    pub fn resume(job: JobFiles, frames: Vec<WrittenFrame>, style: FrameStyle, origin: String) -> io::Result<Self> {
        let files = FrameFiles::new(style, &origin);
        let mut writer = FrameWriter { job, frames, style, origin, files };
        writer.check_format()?;
        remove(&writer.job.path(SUMS))?;
        remove(&writer.job.path(".json"))?;
        if let FrameFiles::Vtkhdf(file) = &mut writer.files {
            let path = writer.job.path(VTKHDF);
            if path.is_file() {
                let opened = VtkHdfWriter::open(&path, style.points, writer.frames.len());
                let opened = opened.map_err(|e| in_file(&path, "continue", &e))?;
                writer.frames.truncate(opened.steps());
                *file = Some(Box::new(opened));
            } else {
                writer.frames.clear();
            }
        } else {
            write_whole(&writer.job.path(".pvd"), writer.list().as_bytes())?;
        }
        writer.clear_from(writer.frames.len())?;
        Ok(writer)
    }

    /// Checks that the frames before a restart do not have another format.
    fn check_format(&self) -> io::Result<()> {
        let other = if self.style.format == FrameFormat::Pvd { FrameFormat::Vtkhdf } else { FrameFormat::Pvd };
        let [path, other_path] = [self.style.format, other].map(|format| self.job.path(format.suffix()));
        if path.is_file() || !other_path.is_file() {
            return Ok(());
        }
        let format = &other.suffix()[1..];
        let why = format!("the frames before the restart are in {}: use --format {format}", other_path.display());
        Err(io::Error::new(io::ErrorKind::InvalidInput, why))
    }

    /// Returns the frames written so far.
    pub fn frames(&self) -> &[WrittenFrame] {
        &self.frames
    }

    /// Returns the checksums of the frames and of their list.
    ///
    /// # Errors
    /// If the VTKHDF file cannot be read.
    pub fn sums(&self) -> io::Result<Checksums> {
        let mut sums = Checksums::default();
        match &self.files {
            FrameFiles::Pvd(_) => {
                for (i, (_, sum)) in self.frames.iter().enumerate() {
                    sums.add_sum(&self.job, &ending(i), *sum);
                }
                sums.add(&self.job, ".pvd", self.list().as_bytes());
            }
            FrameFiles::Vtkhdf(None) => {}
            FrameFiles::Vtkhdf(Some(_)) => {
                let mut summed = SummedWriter::new(io::sink());
                io::copy(&mut File::open(self.job.path(VTKHDF))?, &mut summed)?;
                sums.add_sum(&self.job, VTKHDF, summed.finish().1);
            }
        }
        Ok(sums)
    }

    /// Returns the name of the file of the next frame.
    pub fn next_name(&self) -> String {
        match self.style.format {
            FrameFormat::Pvd => format!("{}{}", self.job.name, ending(self.frames.len())),
            FrameFormat::Vtkhdf => format!("{}{VTKHDF}", self.job.name),
        }
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
        let path = self.job.path(&ending(self.frames.len()));
        match &mut self.files {
            FrameFiles::Pvd(vtu) => {
                let mut out = SummedWriter::new(AtomicFile::begin(&path)?);
                vtu.write(frame, &mut out)?;
                let (file, sum) = out.finish();
                file.finish()?;
                self.frames.push((frame.time, sum));
                write_whole(&self.job.path(".pvd"), self.list().as_bytes())
            }
            FrameFiles::Vtkhdf(file) => {
                let path = self.job.path(VTKHDF);
                let written = match file {
                    Some(file) => file.write(frame),
                    None => VtkHdfWriter::create(&path, self.style.points, &self.origin, frame)
                        .map(|created| *file = Some(Box::new(created))),
                };
                written.map_err(|e| in_file(&path, "write", &e))?;
                self.frames.push((frame.time, 0));
                Ok(())
            }
        }
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

fn in_file(path: &Path, verb: &str, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("cannot {verb} {}: {error}", path.display()))
}

/// Returns the part of a frame's file name after the name of the job.
fn ending(frame: usize) -> String {
    format!("_{frame:04}.vtu")
}

/// Returns the paths of the first `count` frames that do not exist or are empty.
pub fn missing_frames(job: &JobFiles, count: usize) -> Vec<PathBuf> {
    if job.path(VTKHDF).is_file() {
        return Vec::new();
    }
    let is_there = |path: &PathBuf| path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
    (0..count).map(|i| job.path(&ending(i))).filter(|path| !is_there(path)).collect()
}

fn frame_number(file: &str, job: &str) -> Option<usize> {
    let number = file.strip_prefix(job)?.strip_prefix('_')?.strip_suffix(".vtu")?;
    if number.bytes().all(|b| b.is_ascii_digit()) { number.parse().ok() } else { None }
}
