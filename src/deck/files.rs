//! Files that are read whole: regular ones, as long as they say.
//! Never here: what is in them, and what is said where one cannot be read.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use crate::platform::{special_file, without_waiting};

/// Room beyond the length that a file tells: some tell none.
const SLACK: u64 = 1 << 26;

/// Opens a regular file. Pipes, devices, sockets and folders are refused without waiting for anybody.
///
/// # Errors
/// That of the file system, or what the file is.
pub fn open(path: &Path) -> io::Result<File> {
    // A pipe is opened at once, written to or not, and found out then.
    let file = without_waiting().read(true).open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_file() {
        return Ok(file);
    }
    let what = if kind.is_dir() { "a folder" } else { special_file(kind) };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}, and only regular files are read")))
}

/// The bytes of a regular file.
///
/// # Errors
/// As [`open`]; where there is no memory for it, or no end of it.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    let room = usize::try_from(length).ok().and_then(|length| bytes.try_reserve_exact(length).ok());
    if room.is_none() {
        return Err(io::Error::new(io::ErrorKind::OutOfMemory, format!("no memory for its {length} bytes")));
    }
    let most = length.saturating_add(SLACK);
    if file.take(most).read_to_end(&mut bytes)? as u64 == most {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "it goes on behind the length that it tells"));
    }
    Ok(bytes)
}

/// Stands for standard input in place of a path.
pub const STANDARD_INPUT: &str = "-";

/// The bytes of standard input, one more than `most` at most.
///
/// # Errors
/// That of the system.
pub fn read_standard_input(most: u64) -> io::Result<Vec<u8>> {
    // It ends once and for all, and a sweep reads its deck for each run.
    static READ: Mutex<Option<Vec<u8>>> = Mutex::new(None);
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bytes) = &*read {
        return Ok(bytes.clone());
    }
    let mut bytes = Vec::new();
    io::stdin().lock().take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(read.insert(bytes).clone())
}

/// The text of a regular file.
///
/// # Errors
/// As [`read`]; where it is no UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn what_is_no_regular_file_is_named() {
        for (path, what) in [("/dev/zero", "a device"), ("/", "a folder")] {
            let error = super::read(Path::new(path)).expect_err("no file").to_string();
            assert!(error.contains(what), "{error}");
        }
        assert!(super::read_text(Path::new("Cargo.toml")).expect("a file").contains("revolve"));
    }
}
