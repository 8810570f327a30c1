//! Lock that allows one job at a time in a results folder.

use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use revolve_diagnostics::{Diagnostic, printable};
use revolve_numerics::platform::{is_still, readable_by_all, without_links};

/// Name of the lock file.
const NAME: &str = ".revolve-lock";
/// Largest number of bytes read from the lock file.
const MOST: u64 = 400;
/// Number of attempts if the file is removed while it is opened.
const TRIES: usize = 100;

/// Lock on a folder, held until it is dropped. The operating system releases it at the end of the process in any case,
/// so no lock is ever stale.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// Open while the lock is held; `None` on a file system without locks.
    file: Option<File>,
}

/// Reason why a folder cannot be locked.
#[derive(Debug)]
pub enum LockError {
    /// Another job uses it.
    Busy(Box<Diagnostic>),
    /// The lock file cannot be written.
    File(io::Error),
}

impl FolderLock {
    /// Locks an existing folder for a job.
    ///
    /// # Errors
    /// If another job uses it, or the lock file cannot be written.
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
                    // The lock is valid even if the name of the job cannot be written.
                    let _ = file.set_len(0).and_then(|()| writeln!(file, "{} {}", std::process::id(), job));
                    return Ok(FolderLock { path, file: Some(file) });
                }
                // The previous owner ended and removed the file.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(LockError::Busy(Box::new(busy(folder, &mut file)))),
                Err(TryLockError::Error(_)) => return Ok(FolderLock { path, file: None }),
            }
        }
        Err(cannot(io::Error::other("the lock file is repeatedly removed")))
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Removed before unlocking: a process that opens it later creates a new file and lock.
        let is_own = self.file.as_ref().is_none_or(|file| is_still(file, &self.path));
        if is_own {
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
    let message = format!("{holder} is writing to the folder {}", folder.display());
    Diagnostic::error("K007", message).help("wait until it ends, or use another folder with --out")
}

#[cfg(test)]
mod tests {
    use super::{FolderLock, LockError};

    #[test]
    fn a_folder_has_one_job_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = FolderLock::take(folder.path(), "bar").expect("the lock");
        let Err(LockError::Busy(diagnostic)) = FolderLock::take(folder.path(), "rod") else { panic!("taken twice") };
        let holder = format!("job `bar` of process {}", std::process::id());
        assert!(diagnostic.code == "K007" && diagnostic.message.contains(&holder), "{}", diagnostic.message);
        drop(first);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
        // A file left by a killed process is not locked.
        std::fs::write(folder.path().join(super::NAME), "1 ghost\n").expect("a file");
        drop(FolderLock::take(folder.path(), "rod").expect("the lock"));
    }
}
