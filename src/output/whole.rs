//! Files that are there whole or not at all, and folders for files that go.
//! Never here: what is in them.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::platform::{create_private_folder, readable_by_all, sync_folder};

/// What names of temporary files begin with; the name of the file follows.
const MARK: &str = ".revolve-";
/// Letters behind it.
const RANDOM: usize = 6;

/// Writes bytes into a temporary file beside `path` and renames it.
///
/// # Errors
/// With the path in the message.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write(path, bytes, false)
}

/// The same, and waits until the disk has it: it outlives a loss of power.
///
/// # Errors
/// With the path in the message.
pub fn write_durable(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write(path, bytes, true)
}

fn write(path: &Path, bytes: &[u8], durable: bool) -> io::Result<()> {
    let write = || -> io::Result<()> {
        let mut whole = Whole::open(path)?;
        whole.file.write_all(bytes)?;
        if durable {
            whole.file.sync_all()?;
        }
        whole.rename()?;
        // The name, too, must be on the disk.
        if durable { sync_folder(folder_of(path)) } else { Ok(()) }
    };
    write().map_err(|e| cannot_write(path, &e))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn cannot_write(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()))
}

/// A file that grows beside its place and takes it when it is finished; if it is not, nothing is left of it.
pub struct Whole {
    file: File,
    temporary: TemporaryFile,
    path: PathBuf,
}

impl Whole {
    /// For a place.
    ///
    /// # Errors
    /// With the path in the message.
    pub fn begin(path: &Path) -> io::Result<Whole> {
        Whole::open(path).map_err(|e| cannot_write(path, &e))
    }

    fn open(path: &Path) -> io::Result<Whole> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let (file, temporary) = unique(|letters| {
            let temporary = folder_of(path).join(format!("{MARK}{name}-{letters}"));
            // Result files may be read by others, as files usually may.
            let file = readable_by_all(OpenOptions::new().write(true).create_new(true)).open(&temporary)?;
            Ok((file, TemporaryFile(temporary)))
        })?;
        Ok(Whole { file, temporary, path: path.to_owned() })
    }

    fn rename(self) -> io::Result<()> {
        std::fs::rename(&self.temporary.0, &self.path)
    }

    /// Gives it its place.
    ///
    /// # Errors
    /// With the path in the message.
    pub fn finish(self) -> io::Result<()> {
        let path = self.path.clone();
        self.rename().map_err(|e| cannot_write(&path, &e))
    }
}

impl Write for Whole {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|e| cannot_write(&self.path, &e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Removes a file, if it is there.
///
/// # Errors
/// With the path in the message.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => {
            Err(io::Error::new(e.kind(), format!("cannot remove {}: {e}", path.display())))
        }
        _ => Ok(()),
    }
}

/// A file that goes unless it was renamed.
struct TemporaryFile(PathBuf);

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A folder for files that nothing needs later; it goes with what is in it.
#[cfg_attr(not(compiled_routines), allow(dead_code))]
pub(crate) struct ScratchFolder(PathBuf);

#[cfg_attr(not(compiled_routines), allow(dead_code))]
impl ScratchFolder {
    /// A new folder in another, which only its owner may open.
    ///
    /// # Errors
    /// That of the file system.
    pub(crate) fn within(folder: &Path) -> io::Result<ScratchFolder> {
        unique(|letters| {
            let path = folder.join(format!("revolve-{letters}"));
            create_private_folder(&path).map(|()| ScratchFolder(path))
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Makes what has a name that nothing else has: tries letters until they are free.
fn unique<T>(make: impl Fn(&str) -> io::Result<T>) -> io::Result<T> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        // Threads differ in the count, processes in their number, machines that share a folder mostly in the time.
        let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| u64::from(t.subsec_nanos()));
        let mut mixed = (u64::from(std::process::id()) << 32 ^ count << 20 ^ time).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let letter = |_| {
            let at = mixed >> 59;
            mixed = mixed.wrapping_mul(0xd129_42a7_5f8d_6bd5).wrapping_add(count | 1);
            char::from(b'a' + (at % 26) as u8)
        };
        let letters: String = (0..RANDOM).map(letter).collect();
        match make(&letters) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            made => return made,
        }
    }
}

/// The file that a temporary one was to become, if it is one: what a killed process leaves behind.
pub fn unfinished(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?.strip_prefix(MARK)?;
    name.get(..name.len().checked_sub(RANDOM)?)?.strip_suffix('-')
}
