//! Restrictions of a process that reads decks from unknown sources: `--untrusted`, `REVOLVE_UNTRUSTED=1`.

use std::fs::File;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use revolve_numerics::platform::is_still;

/// Environment variable that turns the restrictions on.
pub const VARIABLE: &str = "REVOLVE_UNTRUSTED";
/// Largest number of nodes, and of elements.
pub const MAX_COUNT: u128 = 1_000_000;
/// Largest number of bytes of the results of a run.
pub const MAX_OUTPUT: f64 = 2e9;
/// Longest wall-clock time of a command.
pub const MAX_TIME: Duration = Duration::from_secs(900);
/// Environment variable with a shorter time in seconds.
pub const TIME_VARIABLE: &str = "REVOLVE_UNTRUSTED_SECONDS";

static RESTRICTED: AtomicBool = AtomicBool::new(false);

/// Turns the restrictions on for the rest of the process.
pub fn restrict() {
    RESTRICTED.store(true, Ordering::Relaxed);
}

/// Returns whether the restrictions are on.
pub fn is_restricted() -> bool {
    RESTRICTED.load(Ordering::Relaxed)
}

/// Returns whether the environment variable turns the restrictions on.
pub fn is_requested() -> bool {
    std::env::var_os(VARIABLE).is_some_and(|value| !value.is_empty() && value != "0")
}

/// Returns the wall-clock time after which a restricted command ends.
///
/// # Errors
/// If the environment variable is not a number of seconds above 0 and at most [`MAX_TIME`].
pub fn time_limit() -> Result<Duration, String> {
    let Some(text) = std::env::var_os(TIME_VARIABLE) else { return Ok(MAX_TIME) };
    let text = text.to_string_lossy();
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.filter(|time| !time.is_zero() && *time <= MAX_TIME).ok_or_else(|| {
        format!("{TIME_VARIABLE}={text}: expected a number of seconds above 0, at most {}", MAX_TIME.as_secs())
    })
}

/// Returns whether the restrictions forbid to read a file: it is not in the folder of the deck or below it.
pub fn forbids(folder: &Path, file: &Path) -> bool {
    is_restricted() && is_outside(folder, file)
}

fn is_outside(folder: &Path, file: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (folder.canonicalize(), file.canonicalize()) {
        (Ok(folder), Ok(file)) => !file.starts_with(folder),
        // A file that does not exist: the message must not depend on this if it is outside.
        (Ok(folder), Err(_)) => !resolved(file).is_some_and(|file| file.starts_with(folder)),
        _ => true,
    }
}

/// Returns whether a file that has been opened by a path is neither in a folder nor below it.
pub(crate) fn is_open_outside(folder: &Path, path: &Path, file: &File) -> bool {
    // The path without links must still lead to the open file.
    path.canonicalize().map_or(true, |path| is_outside(folder, &path) || !is_still(file, &path))
}

/// Returns an absolute path without `..`.
fn resolved(file: &Path) -> Option<PathBuf> {
    let mut path = PathBuf::new();
    for part in std::path::absolute(file).ok()?.components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            other => path.push(other),
        }
    }
    Some(path)
}

#[cfg(test)]
mod tests {
    #[cfg(unix)]
    use super::is_open_outside;
    use super::is_outside;

    #[test]
    fn files_below_the_folder_are_inside() {
        let scratch = tempfile::tempdir().expect("a folder");
        let folder = scratch.path().canonicalize().expect("a folder").join("deck");
        std::fs::create_dir_all(folder.join("parts")).expect("a folder");
        for (file, outside) in [
            ("a.inc", false),
            ("parts/a.inc", false),
            ("parts/../a.inc", false),
            ("../a.inc", true),
            ("../deck2/a.inc", true),
            ("/etc/hostname", true),
            ("/no/such/file", true),
        ] {
            assert_eq!(is_outside(&folder, &folder.join(file)), outside, "{file}");
        }
        #[cfg(unix)]
        {
            let link = folder.join("link.inc");
            std::os::unix::fs::symlink("/etc/hostname", &link).expect("a link");
            assert!(is_outside(&folder, &link));
            // A path that led into the folder when it was checked, and outside when it was opened, or the other way round.
            let path = folder.join("a.inc");
            std::fs::write(&path, "text").expect("a file");
            let [inside, outside] = [&path, &link].map(|path| std::fs::File::open(path).expect("a file"));
            assert!(!is_open_outside(&folder, &path, &inside));
            assert!(is_open_outside(&folder, &link, &outside));
            assert!(is_open_outside(&folder, &link, &inside));
            assert!(is_open_outside(&folder, &path, &outside));
        }
    }
}
