//! Files that are written atomically, and temporary folders.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use revolve_numerics::platform::{create_private_folder, readable_by_all, sync_folder};

/// Prefix of temporary files; the name of the final file follows.
const MARK: &str = ".revolve-";
/// Number of random letters at the end.
const RANDOM: usize = 6;

/// Writes bytes to a temporary file in the same folder and renames it to `path`.
///
/// # Errors
/// If it cannot be written; the message contains the path.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write(path, &[bytes], false)
}

/// Writes parts like [`write_whole`] and waits until the file is on the disk, so that it survives a power failure.
///
/// # Errors
/// If it cannot be written; the message contains the path.
pub fn write_durable(path: &Path, parts: &[&[u8]]) -> io::Result<()> {
    write(path, parts, true)
}

fn write(path: &Path, parts: &[&[u8]], durable: bool) -> io::Result<()> {
    let write = || -> io::Result<()> {
        let mut whole = AtomicFile::open(path)?;
        parts.iter().try_for_each(|part| whole.file.write_all(part))?;
        if durable {
            whole.file.sync_all()?;
        }
        whole.rename()?;
        // The renaming must be on the disk, too.
        if durable { sync_folder(folder_of(path)) } else { Ok(()) }
    };
    write().map_err(|e| cannot_write(path, &e))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn temporary_name(path: &Path, letters: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder_of(path).join(format!("{MARK}{name}-{letters}"))
}

fn cannot_write(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()))
}

/// File that is written under a temporary name and renamed when it is finished; otherwise it is removed.
pub struct AtomicFile {
    file: File,
    temporary: TemporaryFile,
    path: PathBuf,
}

impl AtomicFile {
    /// Begins a file that will get this path.
    ///
    /// # Errors
    /// If it cannot be created; the message contains the path.
    pub fn begin(path: &Path) -> io::Result<AtomicFile> {
        AtomicFile::open(path).map_err(|e| cannot_write(path, &e))
    }

    fn open(path: &Path) -> io::Result<AtomicFile> {
        let (file, temporary) = unique(|letters| {
            let temporary = temporary_name(path, letters);
            // Result files may be read by other users, as usual.
            let file = readable_by_all(OpenOptions::new().write(true).create_new(true)).open(&temporary)?;
            Ok((file, TemporaryFile(temporary)))
        })?;
        Ok(AtomicFile { file, temporary, path: path.to_owned() })
    }

    fn rename(self) -> io::Result<()> {
        std::fs::rename(&self.temporary.0, &self.path)
    }

    /// Renames the file to its path.
    ///
    /// # Errors
    /// If it cannot be renamed; the message contains the path.
    pub fn finish(self) -> io::Result<()> {
        let path = self.path.clone();
        self.rename().map_err(|e| cannot_write(&path, &e))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|e| cannot_write(&self.path, &e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Removes a file, if it exists.
///
/// # Errors
/// If it cannot be removed; the message contains the path.
pub fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => {
            Err(io::Error::new(e.kind(), format!("cannot remove {}: {e}", path.display())))
        }
        _ => Ok(()),
    }
}

/// File that is removed on drop, unless it was renamed.
struct TemporaryFile(PathBuf);

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Creates a file without a name in the folder of `path`, for data that would take much memory. It exists until it is
/// closed. If the process is killed before the name is removed, that is a temporary name of `path`.
///
/// # Errors
/// If it cannot be created, or not be removed from the folder while it is open.
pub fn unnamed_file(path: &Path) -> io::Result<File> {
    let (file, temporary) = unique(|letters| {
        let temporary = temporary_name(path, letters);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&temporary)?;
        Ok((file, temporary))
    })?;
    std::fs::remove_file(temporary).map(|()| file)
}

/// Temporary folder; it is removed with its contents on drop.
pub struct ScratchFolder(PathBuf);

impl ScratchFolder {
    /// Creates a folder in another one that only its owner may open.
    ///
    /// # Errors
    /// If the folder cannot be created.
    pub fn within(folder: &Path) -> io::Result<ScratchFolder> {
        unique(|letters| {
            let path = folder.join(format!("revolve-{letters}"));
            create_private_folder(&path).map(|()| ScratchFolder(path))
        })
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Creates an item with a unique name: tries random letters until the name is free.
fn unique<T>(make: impl Fn(&str) -> io::Result<T>) -> io::Result<T> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        // Threads differ by the count, processes by their number, machines with a shared folder usually by the time.
        let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| u64::from(t.subsec_nanos()));
        let mut mixed = (u64::from(std::process::id()) << 32 ^ count << 20 ^ time).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let letter = |_| {
            let rotation = mixed >> 59;
            mixed = mixed.wrapping_mul(0xd129_42a7_5f8d_6bd5).wrapping_add(count | 1);
            char::from(b'a' + (rotation % 26) as u8)
        };
        let letters: String = (0..RANDOM).map(letter).collect();
        match make(&letters) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            made => return made,
        }
    }
}

/// Returns the name of the final file if `name` is a temporary file, which a killed process may leave.
pub fn unfinished(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?.strip_prefix(MARK)?;
    name.get(..name.len().checked_sub(RANDOM)?)?.strip_suffix('-')
}
