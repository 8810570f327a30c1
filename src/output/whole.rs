//! Files that are there whole or not at all.
//! Never here: what is in them.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;

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
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let write = || -> io::Result<()> {
        let prefix = format!("{MARK}{}-", path.file_name().unwrap_or_default().to_string_lossy());
        let mut builder = tempfile::Builder::new();
        let builder = builder.prefix(&prefix).rand_bytes(RANDOM).permissions(permissions());
        let mut file = builder.tempfile_in(folder)?;
        file.write_all(bytes)?;
        file.flush()?;
        if durable {
            file.as_file().sync_all()?;
        }
        file.persist(path).map_err(|e| e.error)?;
        // The name, too, must be on the disk.
        if durable { File::open(folder)?.sync_all() } else { Ok(()) }
    };
    write().map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))
}

/// The file that a temporary one was to become, if it is one: what a killed process leaves behind.
pub fn unfinished(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?.strip_prefix(MARK)?;
    name.get(..name.len().checked_sub(RANDOM)?)?.strip_suffix('-')
}

/// Result files may be read by others, as files usually may.
fn permissions() -> std::fs::Permissions {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::Permissions::from_mode(0o644)
}
