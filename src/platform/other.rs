//! Windows, and other platforms that are not Unix.

use std::fs::{File, FileType, OpenOptions};
use std::io;
use std::path::Path;

/// Returns options for opening a file.
pub fn without_waiting() -> OpenOptions {
    OpenOptions::new()
}

/// Returns options for opening a file.
pub fn without_links() -> OpenOptions {
    OpenOptions::new()
}

/// Changes nothing: the folder decides who may read a file.
pub fn readable_by_all(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

/// Creates a folder with the rights of the folder above it.
///
/// # Errors
/// That of the file system.
pub fn create_private_folder(path: &Path) -> io::Result<()> {
    std::fs::create_dir(path)
}

/// Returns what a path names that is neither a file nor a folder.
pub fn special_file(_kind: FileType) -> &'static str {
    "no file"
}

/// Returns whether the path still names a file: the system does not remove one that is open.
pub fn is_still(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Does nothing: a folder cannot be opened as a file.
///
/// # Errors
/// None.
pub fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// Returns the bytes of memory of the machine, if the system shows them.
pub fn memory_of_machine() -> Option<u128> {
    None
}
