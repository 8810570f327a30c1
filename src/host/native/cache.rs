//! The cache of compiled libraries: a folder that only the user may write, with a list of the inputs next to each
//! library. A library is compiled again if an input has changed.

use std::collections::BTreeSet;
use std::fs::{DirBuilder, File, Metadata};
use std::io::{self, Read as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::UncallableRoutine;
use revolve_diagnostics::digest::hash;
use revolve_diagnostics::files;
use revolve_diagnostics::whole::{ScratchFolder, write_whole};

/// Largest number of cached libraries; the least recently used ones are removed.
const KEPT: usize = 64;
/// Environment variables with search paths of compilers.
const SEARCH: &[&str] = &["CPATH", "C_INCLUDE_PATH", "LIBRARY_PATH", "COMPILER_PATH", "GCC_EXEC_PREFIX"];

/// A shared library that the compiler built.
#[derive(Debug)]
pub struct BuiltLibrary {
    /// Bytes of the shared library.
    pub bytes: Vec<u8>,
    /// Hash of the inputs: sources, flags, compiler, and all files that the compiler read.
    pub identity: String,
    /// Subroutines of the library that cannot be called.
    pub uncallable: Vec<UncallableRoutine>,
    /// Files with subroutines in single precision that were compiled in double precision.
    pub promoted: Vec<PathBuf>,
}

/// The files from which a library was compiled.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct BuildInputs {
    /// Files that were read, with hashes of their bytes.
    read: Vec<(PathBuf, String)>,
    /// Absent files that would be read instead of others.
    absent: BTreeSet<PathBuf>,
    /// Start of the compilation (seconds, nanoseconds). A file that changed later may differ from the one the compiler
    /// read.
    #[serde(skip)]
    begun: Option<(i64, i64)>,
    /// Whether a file changed after the start.
    #[serde(skip)]
    changed: bool,
}

/// The description of a cached library.
#[derive(Serialize, Deserialize)]
struct CacheEntry {
    library: String,
    identity: String,
    origin: BuildInputs,
    uncallable: Vec<UncallableRoutine>,
    promoted: Vec<PathBuf>,
}

/// The cache folder; `None` without a private one.
pub struct LibraryCache(Option<PathBuf>);

impl LibraryCache {
    /// Finds the cache folder in `XDG_CACHE_HOME` or `HOME`; without both there is no cache.
    ///
    /// # Errors
    /// The reason why the folder is not used; libraries are then compiled for every run.
    pub fn find() -> Result<LibraryCache, String> {
        let under = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = under("XDG_CACHE_HOME").or_else(|| under("HOME").map(|h| h.join(".cache")));
        let Some(folder) = home.map(|h| h.join("revolve").join("user")) else { return Ok(LibraryCache(None)) };
        let usable = || -> io::Result<bool> {
            DirBuilder::new().recursive(true).mode(0o700).create(&folder)?;
            // A user who may rename the folder could replace it.
            let parent = folder.parent().unwrap_or(Path::new("/"));
            Ok(private(&folder.metadata()?) && private(&parent.metadata()?))
        };
        match usable() {
            Ok(true) => Ok(LibraryCache(Some(folder))),
            Ok(false) => Err(format!("the cache folder {} is writable by another user", folder.display())),
            Err(error) => Err(format!("the cache folder {} cannot be created: {error}", folder.display())),
        }
    }

    /// Returns a cache that stores and finds nothing, so that each source is compiled.
    pub fn none() -> LibraryCache {
        LibraryCache(None)
    }

    /// Creates a temporary folder for compilation.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn scratch_folder(&self) -> io::Result<ScratchFolder> {
        match &self.0 {
            Some(folder) => ScratchFolder::within(folder),
            None => ScratchFolder::within(&std::env::temp_dir()),
        }
    }

    /// Returns the library of a key, if it is complete and its inputs are unchanged.
    pub fn get(&self, key: &str) -> Option<BuiltLibrary> {
        let (library, description) = self.places(key)?;
        let entry: CacheEntry = serde_json::from_slice(&own_file(&description).ok()?).ok()?;
        if !entry.origin.is_current() {
            return None;
        }
        let bytes = own_file(&library).ok()?;
        if hash([bytes.as_slice()]) != entry.library {
            return None;
        }
        // Marks the entry as recently used. A failure only means that it is removed earlier.
        let _ = File::open(&description).and_then(|file| file.set_modified(SystemTime::now()));
        Some(BuiltLibrary { bytes, identity: entry.identity, uncallable: entry.uncallable, promoted: entry.promoted })
    }

    /// Stores a library; failures are ignored.
    pub fn put(&self, key: &str, built: &BuiltLibrary, origin: &BuildInputs) {
        let Some((library, description)) = self.places(key).filter(|_| !origin.changed) else { return };
        let entry = CacheEntry {
            library: hash([built.bytes.as_slice()]),
            identity: built.identity.clone(),
            origin: origin.clone(),
            uncallable: built.uncallable.clone(),
            promoted: built.promoted.clone(),
        };
        let Ok(text) = serde_json::to_vec(&entry) else { return };
        let _ = write_whole(&library, &built.bytes).and_then(|()| write_whole(&description, &text));
        self.prune();
    }

    /// Returns the paths of a library and its description.
    fn places(&self, key: &str) -> Option<(PathBuf, PathBuf)> {
        let folder = self.0.as_ref()?;
        Some((folder.join(format!("{key}.so")), folder.join(format!("{key}.json"))))
    }

    /// Removes the least recently used libraries, and those without a description.
    fn prune(&self) {
        let Some(folder) = &self.0 else { return };
        let names = |ending: &'static str| {
            let files = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok).map(|e| e.path());
            files.filter(move |path| path.extension().is_some_and(|e| e == ending))
        };
        let age = |path: &PathBuf| path.metadata().and_then(|m| m.modified()).ok();
        let mut entries: Vec<_> = names("json").map(|path| (age(&path), path)).collect();
        entries.sort();
        for (_, old) in &entries[..entries.len().saturating_sub(KEPT)] {
            let _ = std::fs::remove_file(old);
        }
        // The library is written before its description, so a new one may still get its description.
        let is_old = |path: &PathBuf| age(path).and_then(|t| t.elapsed().ok()).is_some_and(|t| t.as_secs() > 60);
        for orphan in names("so").filter(|path| !path.with_extension("json").exists() && is_old(path)) {
            let _ = std::fs::remove_file(orphan);
        }
    }
}

/// Returns the user id of this process; `None` if the system does not report it.
fn user() -> Option<u32> {
    std::fs::metadata("/proc/self").map(|process| process.uid()).ok()
}

/// Returns whether only this user may write.
fn private(metadata: &Metadata) -> bool {
    user().is_some_and(|user| may_trust(metadata.uid(), metadata.mode(), user))
}

fn may_trust(owner: u32, mode: u32, user: u32) -> bool {
    owner == user && mode & 0o022 == 0
}

/// Reads a regular file (not a link) that only this user may write.
fn own_file(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::options().read(true).custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK).open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() || !private(&metadata) {
        return Err(io::ErrorKind::PermissionDenied.into());
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Returns the environment that determines where compilers search.
pub fn search_environment() -> String {
    let values = SEARCH.iter().map(std::env::var_os);
    format!("{:?} {:?}", std::env::current_dir().ok(), values.collect::<Vec<_>>())
}

impl BuildInputs {
    /// Records the sources of a compilation that begins now.
    pub fn of<'a>(sources: impl Iterator<Item = &'a Path>, now: SystemTime) -> BuildInputs {
        let begun = now.duration_since(UNIX_EPOCH).ok();
        let begun = begun.map(|t| (t.as_secs() as i64, i64::from(t.subsec_nanos())));
        let mut origin = BuildInputs { begun, ..BuildInputs::default() };
        sources.for_each(|file| origin.note_change(file));
        origin
    }

    /// Records whether a file changed after the start, by its change time (ctime), which users cannot set.
    fn note_change(&mut self, path: &Path) {
        let changed = path.metadata().ok().map(|m| (m.ctime(), m.ctime_nsec()));
        self.changed |= changed.is_none() || changed >= self.begun;
    }

    /// Adds the files of a make rule written by `-MD`, except those in `own`; `folder` is that of the source. Returns
    /// `None` if not all inputs are known; the library is then not cached.
    pub fn add(&mut self, rule: &str, folder: &Path, own: &Path) -> Option<()> {
        let mut named = Vec::new();
        for name in prerequisites(rule)? {
            let path = std::path::absolute(name).ok()?;
            if !path.starts_with(own) && self.read.iter().all(|(known, _)| *known != path) {
                let bytes = files::read(&path).ok()?;
                if !is_systems(&path) && reads_unlisted_files(&bytes) {
                    return None;
                }
                self.note_change(&path);
                self.read.push((path.clone(), hash([bytes.as_slice()])));
                named.push(path);
            }
        }
        self.absent.extend(shadowing_files(&named, folder));
        Some(())
    }

    /// Returns the hashes of the files read.
    pub fn hashes(&self) -> impl Iterator<Item = &str> {
        self.read.iter().map(|(_, hash)| hash.as_str())
    }

    fn is_current(&self) -> bool {
        let same = |(path, was): &(PathBuf, String)| files::read(path).is_ok_and(|bytes| hash([&bytes[..]]) == *was);
        self.read.iter().all(same) && !self.absent.iter().any(|path| path.exists())
    }
}

/// Returns whether a file is a system header, which is found by a name of at most three components.
fn is_systems(path: &Path) -> bool {
    path.starts_with("/usr") || path.starts_with("/lib")
}

/// Returns whether a source depends on files that compilers do not list.
fn reads_unlisted_files(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    ["__has_include", "incbin", "__has_embed", "#embed"].iter().any(|word| text.contains(word))
}

/// Returns absent files that would be found before some of the files read.
fn shadowing_files(read: &[PathBuf], folder: &Path) -> BTreeSet<PathBuf> {
    let mut folders: BTreeSet<PathBuf> = read.iter().filter(|p| !is_systems(p)).filter_map(|p| parent(p)).collect();
    folders.extend(std::path::absolute(folder));
    folders.extend(std::env::current_dir());
    for list in SEARCH.iter().filter_map(std::env::var_os) {
        folders.extend(std::env::split_paths(&list).filter_map(|path| std::path::absolute(path).ok()));
    }
    let mut absent = BTreeSet::new();
    for path in read {
        let parts: Vec<_> = path.components().skip(1).collect();
        let depth = if is_systems(path) { 3 } else { parts.len() };
        for count in 1..=depth.min(parts.len()) {
            let name: PathBuf = parts[parts.len() - count..].iter().collect();
            absent.extend(folders.iter().map(|folder| folder.join(&name)).filter(|rival| !rival.exists()));
        }
    }
    absent
}

fn parent(path: &Path) -> Option<PathBuf> {
    path.parent().map(Path::to_owned)
}

/// Returns the files after the colon of a make rule, in which blanks, `#` and backslashes are escaped and `$` is
/// doubled.
fn prerequisites(rule: &str) -> Option<Vec<String>> {
    let joined = rule.replace("\\\n", " ");
    let (_, list) = joined.split_once(": ")?;
    let mut names = vec![String::new()];
    let mut letters = list.chars().peekable();
    while let Some(letter) = letters.next() {
        let name = names.last_mut()?;
        match (letter, letters.peek()) {
            ('\\', Some(' ' | '#' | '\\')) | ('$', Some('$')) => name.extend(letters.next()),
            (letter, _) if letter.is_whitespace() => names.push(String::new()),
            (letter, _) => name.push(letter),
        }
    }
    names.retain(|name| !name.is_empty());
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::{may_trust, prerequisites};

    #[test]
    fn make_rules_are_parsed() {
        let rule = "a.o a.o: a.f /usr/x.h \\\n b\\ c.inc m$$.mod \\#d\n";
        assert_eq!(
            prerequisites(rule).as_deref(),
            Some(&["a.f", "/usr/x.h", "b c.inc", "m$.mod", "#d"].map(str::to_owned)[..])
        );
        assert_eq!(prerequisites("no rule"), None);
    }

    #[test]
    fn folders_writable_by_others_are_not_trusted() {
        assert!(may_trust(7, 0o40700, 7) && may_trust(7, 0o40755, 7));
        assert!(!may_trust(8, 0o40700, 7) && !may_trust(7, 0o40775, 7) && !may_trust(7, 0o41777, 7));
    }
}
