//! One job at a time in a folder of results.
//! Never here: what a job writes there.

use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use crate::deck::{Diagnostic, printable};
use crate::platform::{is_still, readable_by_all, without_links};

/// Name of the file that holds the lock.
const NAME: &str = ".revolve-lock";
/// The most that is read of it.
const MOST: u64 = 400;
/// Times that a file which goes while it is opened is looked for again.
const TRIES: usize = 100;

/// A folder that is this job's until it is dropped. The system lets go of it when the process ends, however that comes, so
/// no lock is ever stale.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// Open as long as the lock is held; `None` on a file system without locks.
    file: Option<File>,
}

/// Why a folder is not to be had.
#[derive(Debug)]
pub enum LockError {
    /// A job is at work in it.
    Busy(Box<Diagnostic>),
    /// The lock cannot be written.
    File(io::Error),
}

impl FolderLock {
    /// Takes a folder, which is there, for a job.
    ///
    /// # Errors
    /// Which job has it, or that of the file system.
    pub fn take(folder: &Path, job: &str) -> Result<FolderLock, LockError> {
        let path = folder.join(NAME);
        let cannot =
            |e: io::Error| LockError::File(io::Error::new(e.kind(), format!("cannot lock {}: {e}", path.display())));
        for _ in 0..TRIES {
            let mut options = without_links();
            options.read(true).write(true).create(true).truncate(false);
            let mut file = readable_by_all(&mut options).open(&path).map_err(cannot)?;
            match file.try_lock() {
                Ok(()) if is_still(&file, &path) => {
                    // A name that cannot be written leaves the lock what it is.
                    let _ = file.set_len(0).and_then(|()| writeln!(file, "{} {}", std::process::id(), job));
                    return Ok(FolderLock { path, file: Some(file) });
                }
                // Its holder ended and took the file away.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(LockError::Busy(Box::new(busy(folder, &mut file)))),
                Err(TryLockError::Error(_)) => return Ok(FolderLock { path, file: None }),
            }
        }
        Err(cannot(io::Error::other("it comes and goes")))
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // The name first: who opens it from now on has a file, and a lock, of their own.
        let own = self.file.as_ref().is_none_or(|file| is_still(file, &self.path));
        if own {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn busy(folder: &Path, file: &mut File) -> Diagnostic {
    let mut text = String::new();
    let _ = file.rewind().and_then(|()| file.take(MOST).read_to_string(&mut text));
    let holder = match text.trim_end().split_once(' ') {
        Some((process, job)) => format!("job `{}` of process {}", printable(job), printable(process)),
        None => "another job".into(),
    };
    let message = format!("{holder} is writing into the folder {}", folder.display());
    Diagnostic::error("K007", message).help("wait for its end, or give another folder with --out")
}

#[cfg(test)]
mod tests {
    use super::{FolderLock, LockError};

    #[test]
    fn a_folder_has_one_job_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = FolderLock::take(folder.path(), "bar").expect("the lock");
        let Err(LockError::Busy(finding)) = FolderLock::take(folder.path(), "rod") else { panic!("taken twice") };
        let told = format!("job `bar` of process {}", std::process::id());
        assert!(finding.code == "K007" && finding.message.contains(&told), "{}", finding.message);
        drop(first);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
        // What a killed process leaves is no lock.
        std::fs::write(folder.path().join(super::NAME), "1 ghost\n").expect("a file");
        drop(FolderLock::take(folder.path(), "rod").expect("the lock"));
    }
}
