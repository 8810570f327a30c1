//! Checksum file of a job, `<job>.sfv`: one line with name and CRC-32 for each file, as cksfv and rhash read it.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use flate2::Crc;
use indexmap::IndexMap;

use super::{JobFiles, write_whole};
use revolve_diagnostics::files;

/// Suffix of the checksum file of a run; sweeps and studies add a word before it.
pub const SUMS: &str = ".sfv";

/// Start of the first line; the number of files follows.
const HEAD: &str = "; CRC-32 of ";

/// Returns the CRC-32 (IEEE 802.3).
pub fn sum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Writer that computes length and CRC-32 of what it passes on.
pub struct SummedWriter<W> {
    out: W,
    crc: Crc,
    length: u64,
}

impl<W: Write> SummedWriter<W> {
    /// Creates a writer that passes everything on to `out`.
    pub fn new(out: W) -> SummedWriter<W> {
        SummedWriter { out, crc: Crc::new(), length: 0 }
    }

    /// Returns the number of bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Ends writing. Returns the destination and the checksum.
    pub fn finish(self) -> (W, u32) {
        (self.out, self.crc.sum())
    }
}

impl<W: Write> Write for SummedWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.crc.update(&bytes[..count]);
        self.length += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Checksums by file name in one folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checksums(IndexMap<String, u32>);

impl Checksums {
    /// Adds a file of a job with these bytes.
    pub fn add(&mut self, job: &JobFiles, ending: &str, bytes: &[u8]) {
        self.add_sum(job, ending, sum(bytes));
    }

    /// Adds a file with a known checksum.
    pub fn add_sum(&mut self, job: &JobFiles, ending: &str, sum: u32) {
        self.0.insert(format!("{}{ending}", job.name), sum);
    }

    /// Writes the list as a file of the job.
    ///
    /// # Errors
    /// If it cannot be written; the message contains the path.
    pub fn write(&self, job: &JobFiles, ending: &str) -> io::Result<()> {
        let mut text = format!("{HEAD}{} files as they were written\n", self.0.len());
        for (name, sum) in &self.0 {
            let _ = writeln!(text, "{name} {sum:08X}");
        }
        write_whole(&job.path(ending), text.as_bytes())
    }

    /// Reads all checksum files of a folder.
    ///
    /// # Errors
    /// If the folder or a list cannot be read, or a line is invalid; the message contains the path.
    pub fn of(folder: &Path) -> Result<Checksums, String> {
        let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let mut paths: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        let mut sums = Checksums::default();
        for path in paths.iter().filter(|path| path.extension().is_some_and(|ending| ending == &SUMS[1..])) {
            sums.add_file(path)?;
        }
        Ok(sums)
    }

    /// Reads one checksum file.
    ///
    /// # Errors
    /// If it cannot be read, or a line is invalid; the message contains the path.
    pub fn of_file(path: &Path) -> Result<Checksums, String> {
        let mut sums = Checksums::default();
        sums.add_file(path)?;
        Ok(sums)
    }

    fn add_file(&mut self, path: &Path) -> Result<(), String> {
        let text = files::read_text(path).map_err(|e| format!("{}: {e}", path.display()))?;
        self.take(&text).map_err(|why| format!("{}: {why}", path.display()))
    }

    fn take(&mut self, text: &str) -> Result<(), String> {
        // An incomplete list has fewer files than its first line states.
        let written = text.strip_prefix(HEAD).and_then(|rest| rest.split(' ').next()?.parse::<usize>().ok());
        let count = text.lines().filter(|line| !line.is_empty() && !line.starts_with(';')).count();
        if written.is_some_and(|written| written != count) || !text.ends_with('\n') {
            return Err(format!("the list of checksums is incomplete: it has {count} files"));
        }
        for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with(';')) {
            let pair = line.rsplit_once(' ');
            let read = pair.and_then(|(name, sum)| Some((name, u32::from_str_radix(sum, 16).ok()?)));
            let (name, sum) =
                read.ok_or_else(|| format!("line {} is not a file name followed by a checksum", i + 1))?;
            self.0.insert(name.to_owned(), sum);
        }
        Ok(())
    }

    /// Returns whether a file is listed.
    pub fn has(&self, path: &Path) -> bool {
        path.file_name().and_then(|name| name.to_str()).is_some_and(|name| self.0.contains_key(name))
    }

    /// Checks that a file, if it is listed, matches its checksum.
    ///
    /// # Errors
    /// If it differs or cannot be read; the message contains the path.
    pub fn verify(&self, path: &Path) -> Result<(), String> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(written) = self.0.get(name) else { return Ok(()) };
        let bytes = files::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        if sum(&bytes) == *written {
            return Ok(());
        }
        Err(format!(
            "{} has changed since it was written: its checksum is {:08X}, but the .sfv file lists {written:08X}; run again, or \
             remove the .sfv file to read it anyway",
            path.display(),
            sum(&bytes)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::{Checksums, SUMS, sum};
    use crate::JobFiles;

    #[test]
    fn changed_files_are_detected() {
        // The check value of the polynomial.
        assert_eq!(sum(b"123456789"), 0xCBF4_3926);
        let folder = tempfile::tempdir().expect("a folder");
        let job = JobFiles { folder: folder.path().to_owned(), name: "a b".into() };
        let path = job.path("_history.csv");
        let mut sums = Checksums::default();
        sums.add(&job, "_history.csv", b"time\n0\n");
        sums.write(&job, SUMS).expect("a list");
        let read = Checksums::of(folder.path()).expect("a list");
        assert_eq!(read, sums);
        std::fs::write(&path, b"time\n0\n").expect("a file");
        assert_eq!(read.verify(&path), Ok(()));
        std::fs::write(&path, b"time\n1\n").expect("a file");
        assert!(read.verify(&path).is_err_and(|why| why.contains("a b_history.csv")));
        assert_eq!(read.verify(&job.path("_other.csv")), Ok(()));
        for wrong in ["; CRC-32 of 2 files\na b.json 1234\n", "a b.json 1234", "a b.json\n", "a b.json xyz\n"] {
            std::fs::write(job.path(SUMS), wrong).expect("a list");
            assert!(Checksums::of(folder.path()).is_err(), "{wrong:?}");
        }
    }
}
