//! Reading of whole files. Only regular files are read, up to the length that the file system reports.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use revolve_numerics::platform::{special_file, without_waiting};

use crate::untrusted::{is_open_outside, is_restricted};

/// Bytes that a file may have beyond its reported length. Files in virtual file systems report a length of zero.
const SLACK: u64 = 1 << 26;

/// Opens a regular file. Pipes, devices, sockets and folders are refused without blocking.
///
/// # Errors
/// Returns the error of the file system, or `InvalidInput` if the path is not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    // The options open a pipe without waiting for a writer, so that its type can be checked.
    let file = without_waiting().read(true).open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_file() {
        return Ok(file);
    }
    let what = if kind.is_dir() { "a folder" } else { special_file(kind) };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}; only regular files can be read")))
}

/// Reads the bytes of a regular file.
///
/// # Errors
/// Fails like [`open`], and if there is not enough memory, or if the file is longer than its reported length.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    read_opened(open(path)?)
}

/// Reads a file that a deck in `folder` names. A restricted process reads it only if the file that has been opened is in the
/// folder or below it: links that change after a check of the path have no effect.
///
/// # Errors
/// Fails like [`read`], and if the file is outside.
pub fn read_below(folder: &Path, path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    if is_restricted() && is_open_outside(folder, path, &file) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is not in the folder of the deck"));
    }
    read_opened(file)
}

fn read_opened(file: File) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    let room = usize::try_from(length).ok().and_then(|length| bytes.try_reserve_exact(length).ok());
    if room.is_none() {
        return Err(io::Error::new(io::ErrorKind::OutOfMemory, format!("no memory for its {length} bytes")));
    }
    let limit = length.saturating_add(SLACK);
    if file.take(limit).read_to_end(&mut bytes)? as u64 == limit {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "the file is longer than its reported length"));
    }
    Ok(bytes)
}

/// Path that means standard input.
pub const STANDARD_INPUT: &str = "-";

/// Reads standard input, at most `most` + 1 bytes.
///
/// # Errors
/// Returns the error of the operating system.
pub fn read_standard_input(most: u64) -> io::Result<Vec<u8>> {
    // Standard input can be read once, and a sweep reads its deck for each run.
    static READ: Mutex<Option<Vec<u8>>> = Mutex::new(None);
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bytes) = &*read {
        return Ok(bytes.clone());
    }
    let mut bytes = Vec::new();
    io::stdin().lock().take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(read.insert(bytes).clone())
}

/// Reads the text of a regular file.
///
/// # Errors
/// Fails like [`read`], and if the file is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "the file is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn devices_and_folders_are_refused() {
        for (path, what) in [("/dev/zero", "a device"), ("/", "a folder")] {
            let error = super::read(Path::new(path)).expect_err("no file").to_string();
            assert!(error.contains(what), "{error}");
        }
        assert!(super::read_text(Path::new("Cargo.toml")).expect("a file").contains("revolve"));
    }
}
