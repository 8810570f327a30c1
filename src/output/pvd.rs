//! The series of a job's frames: `<job>_0000.vtu`, … and `<job>.pvd`, which lists them with their times.
//! Never here: what a frame holds.

use std::fmt::Write as _;
use std::{fs, io};

use super::vtu::{VtuWriter, escape};
use super::{Frame, Job, write_whole};

/// Writes frames one after the other; the list is whole after each.
#[derive(Debug)]
pub struct FrameWriter {
    job: Job,
    times: Vec<f64>,
    vtu: VtuWriter,
}

impl FrameWriter {
    /// Begins a series and removes frames that an earlier run of the job left.
    ///
    /// # Errors
    /// Where the folder cannot be made or cleared.
    pub fn new(job: Job) -> io::Result<Self> {
        fs::create_dir_all(&job.folder)
            .map_err(|e| io::Error::new(e.kind(), format!("cannot make the folder {}: {e}", job.folder.display())))?;
        for entry in fs::read_dir(&job.folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if is_frame(&name, &job.name) {
                fs::remove_file(job.folder.join(name))?;
            }
        }
        Ok(FrameWriter { job, times: Vec::new(), vtu: VtuWriter::default() })
    }

    /// Writes the next frame and the list.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        write_whole(&self.job.path(&format!("_{:04}.vtu", self.times.len())), self.vtu.text(frame).as_bytes())?;
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

fn is_frame(file: &str, job: &str) -> bool {
    let number = file.strip_prefix(job).and_then(|r| r.strip_prefix('_')).and_then(|r| r.strip_suffix(".vtu"));
    number.is_some_and(|n| !n.is_empty() && n.chars().all(|c| c.is_ascii_digit()))
}
