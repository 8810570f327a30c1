//! File and memory functions for Windows and other platforms that are not Unix.

use std::fs::{File, FileType, OpenOptions};
use std::io;
use std::path::Path;
use std::process::Command;

/// Returns default options: only Unix has a flag for opening a file without waiting.
pub fn without_waiting() -> OpenOptions {
    OpenOptions::new()
}

/// Returns default options: only Unix has a flag that rejects symbolic links.
pub fn without_links() -> OpenOptions {
    OpenOptions::new()
}

/// Returns the options unchanged: access rights are inherited from the folder.
pub fn readable_by_all(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

/// Creates a folder with the access rights of its parent folder.
///
/// # Errors
/// Returns the error of the file system.
pub fn create_private_folder(path: &Path) -> io::Result<()> {
    std::fs::create_dir(path)
}

/// Describes a path that is neither a file nor a folder.
pub fn special_file(_kind: FileType) -> &'static str {
    "not a file"
}

/// Returns `None`: only Linux has `/proc`.
pub fn process_status(_id: u32) -> Option<String> {
    None
}

/// Returns whether the path exists. The system does not remove open files.
pub fn is_still(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Does nothing: folders cannot be opened as files.
///
/// # Errors
/// Never.
pub fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// Returns `None`: the memory size is not determined on these platforms.
pub fn memory_limit() -> Option<super::MemoryLimit> {
    None
}

/// Returns the name of the processor: `None`, it is not determined here.
pub fn processor_name() -> Option<String> {
    None
}

/// Returns `None`: the free disk space is not determined on these platforms.
#[cfg(feature = "disk-space")]
pub fn free_space(_folder: &Path) -> Option<u64> {
    None
}

/// Returns the command that opens an address in the user's browser.
pub fn browser_command(address: &str) -> Option<Command> {
    let mut command = Command::new("explorer");
    command.arg(address);
    Some(command)
}
