//! File and memory functions for Linux and macOS.

use std::fs::{DirBuilder, File, FileType, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, FileTypeExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::process::Command;

use super::MemoryLimit;

/// Returns options that open a pipe without waiting for its other end.
pub fn without_waiting() -> OpenOptions {
    with_flags(libc::O_NONBLOCK)
}

/// Returns options that open a pipe without waiting and refuse symbolic links.
pub fn without_links() -> OpenOptions {
    with_flags(libc::O_NONBLOCK | libc::O_NOFOLLOW)
}

fn with_flags(flags: i32) -> OpenOptions {
    let mut options = OpenOptions::new();
    options.custom_flags(flags);
    options
}

/// Makes a new file readable by all users.
pub fn readable_by_all(options: &mut OpenOptions) -> &mut OpenOptions {
    options.mode(0o644)
}

/// Creates a folder that only its owner can access.
///
/// # Errors
/// Returns the error of the file system.
pub fn create_private_folder(path: &Path) -> io::Result<()> {
    DirBuilder::new().mode(0o700).create(path)
}

/// Describes a path that is neither a file nor a folder.
pub fn special_file(kind: FileType) -> &'static str {
    if kind.is_fifo() {
        "a pipe"
    } else if kind.is_char_device() || kind.is_block_device() {
        "a device"
    } else {
        "not a file"
    }
}

/// Returns the text of `/proc/<id>/status` of a process; `None` without `/proc`.
pub fn process_status(id: u32) -> Option<String> {
    std::fs::read_to_string(format!("/proc/{id}/status")).ok()
}

/// Returns whether the path still refers to this open file.
pub fn is_still(file: &File, path: &Path) -> bool {
    let same = || Some((file.metadata().ok()?, std::fs::symlink_metadata(path).ok()?));
    same().is_some_and(|(a, b)| (a.dev(), a.ino()) == (b.dev(), b.ino()))
}

/// Waits until the directory entries of a folder are written to disk.
///
/// # Errors
/// Returns the error of the file system.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Returns the bytes that the user can write to the disk of a folder; `None` if it cannot be determined.
#[cfg(feature = "disk-space")]
pub fn free_space(folder: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    Some(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Returns the smallest limit of the memory of this process; `None` if none can be determined.
pub fn memory_limit() -> Option<MemoryLimit> {
    let limit = |name, bytes: Option<u128>| bytes.map(|bytes| MemoryLimit { name, bytes });
    let limits = [
        limit("the memory of the machine", memory_of_machine()),
        limit("the limit of the process (ulimit -v)", limit_of_process()),
        limit("the limit of the control group or container (memory.max)", limit_of_group()),
    ];
    limits.into_iter().flatten().min_by_key(|limit| limit.bytes)
}

/// Returns the memory size of the machine in bytes.
fn memory_of_machine() -> Option<u128> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kilobytes = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?.trim().trim_end_matches("kB");
    Some(1024 * kilobytes.trim().parse::<u128>().ok()?)
}

/// Returns the limit of the address space of this process; `None` if it is unlimited.
fn limit_of_process() -> Option<u128> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let limits = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    limits.split_whitespace().next()?.parse().ok()
}

/// Returns the limit of the control group (version 2) of this process; `None` without one.
fn limit_of_group() -> Option<u128> {
    let text = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let group = text.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let limit = std::fs::read_to_string(Path::new("/sys/fs/cgroup").join(group).join("memory.max")).ok()?;
    limit.trim().parse().ok()
}

/// Returns the name of the processor, on Linux.
pub fn processor_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Returns the command that opens an address in the user's browser; `None` without a display.
pub fn browser_command(address: &str) -> Option<Command> {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let (is_mac, has_display) = (cfg!(target_os = "macos"), is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"));
    if !is_mac && !has_display {
        return None;
    }
    let mut command = Command::new(if is_mac { "open" } else { "xdg-open" });
    command.arg(address);
    Some(command)
}
