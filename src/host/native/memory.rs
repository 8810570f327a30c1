//! Variables of compiled user subroutines between calls: SAVE, COMMON, modules, static variables. Memory of the
//! libraries that has changed since loading is saved, and written back into newly loaded libraries. State that is not
//! valid in another process (addresses, thread-local variables, open files, seeds) is reported instead.
#![allow(unsafe_code)]

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{CStr, c_int, c_void};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use libloading::os::unix::Library;

use super::host::{self, MessageLevel};
use super::symbols::LibrarySymbols;
use super::{PersistentMemory, SavedMemory, guard};
use revolve_diagnostics::digest::hash;
use revolve_numerics::state::archive::{Persist, StateArchive, UnfitState, persist_fields};

/// Number of bytes that are compared at once, and size of a saved cell in bytes.
const PAGE: usize = 4096;
const CELL: usize = 4;
/// Largest number of findings of one kind that are listed.
const MOST: usize = 4;

/// System, compiler and linear algebra libraries. Their variables are not saved because they affect no result.
const RUNTIMES: &[&str] = &[
    "ld-linux",
    "libblas",
    "libc.",
    "libdl.",
    "libgcc_s",
    "libgfortran",
    "libgomp",
    "liblapack",
    "libm.",
    "libmkl",
    "libmvec",
    "libopenblas",
    "libpthread",
    "libquadmath",
    "librt.",
    "libstdc++",
];

/// Functions that use a random seed of the process.
const SEEDS: &[&str] = &[
    "_gfortran_random_r4",
    "_gfortran_random_r8",
    "_gfortran_random_r10",
    "_gfortran_random_r16",
    "_gfortran_arandom_r4",
    "_gfortran_arandom_r8",
    "_gfortran_arandom_r10",
    "_gfortran_arandom_r16",
    "_gfortran_rand",
    "_gfortran_irand",
    "rand",
    "random",
    "drand48",
    "lrand48",
    "mrand48",
];

/// Variables of the libraries of a job.
pub struct RoutineMemory {
    parts: Vec<LibraryMemory>,
    /// Descriptions of state that cannot be saved, known before the first call.
    unsaved: Vec<String>,
    /// Files that were open before the first call.
    open: Mutex<BTreeSet<(PathBuf, PathBuf)>>,
    _keep: Arc<[Library]>,
}

/// Variables of one library: that of the user, or one that it needs.
pub struct LibraryMemory {
    /// Name of the library in messages.
    name: String,
    base: usize,
    symbols: LibrarySymbols,
    areas: Vec<WritableRange>,
    /// Thread-local variables: offset and size of their initial values, and total size.
    of_thread: Option<[usize; 3]>,
    /// Hash of the addresses of the variables relative to the base.
    layout: String,
    /// Whether libraries opened earlier use it, too.
    shared: bool,
}

struct WritableRange {
    /// Offset from the base of the library.
    at: usize,
    length: usize,
    /// Content after loading, by page; pages that are not listed were zero.
    initial: BTreeMap<usize, Box<[u8; PAGE]>>,
}

/// A run of consecutive changed cells.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
#[persist(blob: bytes)]
struct ChangedBytes {
    area: usize,
    at: usize,
    bytes: Vec<u8>,
}

impl RoutineMemory {
    /// Records the memory of newly loaded libraries.
    pub fn of(parts: Vec<LibraryMemory>, libraries: Arc<[Library]>) -> RoutineMemory {
        let seeds = |part: &LibraryMemory| {
            let imported = part.symbols.imported.iter().find(|name| SEEDS.contains(&name.as_str()))?;
            Some(format!("{} draws random numbers (`{imported}`), whose seed belongs to the process", part.name))
        };
        let shared = parts.iter().filter(|part| part.shared);
        let shared = shared.map(|part| format!("{} is shared with other libraries of the process", part.name));
        let unsaved = parts.iter().filter_map(seeds).chain(shared).collect();
        RoutineMemory { parts, unsaved, open: Mutex::default(), _keep: libraries }
    }
}

impl PersistentMemory for RoutineMemory {
    fn begin(&self) {
        guard::forget_threads();
        *self.open.lock().unwrap_or_else(PoisonError::into_inner) = open_files();
    }

    fn end(&self) {
        for (routine, count) in guard::threads_running() {
            let threads =
                if count == 1 { "a thread that still runs".into() } else { format!("{count} threads that still run") };
            host::report_message(
                MessageLevel::Warning,
                format!("{routine} started {threads}: the run has ended and does not wait"),
            );
        }
        guard::flush();
    }

    fn save(&self) -> SavedMemory {
        let Some(used) = mappings() else {
            return SavedMemory::not_saved("the system does not report which memory is in use");
        };
        let mut bytes = Vec::new();
        let mut archive = StateArchive::writer(&mut bytes);
        let mut bound = Vec::new();
        for part in &self.parts {
            let mut changes = part.changes();
            bound.extend(part.addresses(&changes, &used));
            bound.extend(part.of_threads());
            persist_fields!(&mut archive; &mut part.layout.clone(), &mut changes);
        }
        host::persist_arrays(&mut archive);
        let memory = bound.is_empty().then_some(bytes);
        let open_before = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let files = open_files().into_iter().filter(|file| !open_before.contains(file));
        let files = files.map(|(_, path)| format!("the file {} is open", path.display())).collect();
        let threads = guard::threads_running().into_iter();
        let threads = threads.map(|(routine, _)| format!("a thread that {routine} started still runs")).collect();
        let lost = [self.unsaved.clone(), shortened(bound), shortened(files), threads].concat();
        SavedMemory { memory, lost }
    }

    fn restore(&self, kept: &SavedMemory) -> Result<(), UnfitState> {
        let Some(memory) = &kept.memory else { return Ok(()) };
        let mut archive = StateArchive::reader(memory);
        let mut list = Vec::new();
        for part in &self.parts {
            let (mut layout, mut changes) = (String::new(), Vec::<ChangedBytes>::new());
            persist_fields!(&mut archive; &mut layout, &mut changes);
            if layout != part.layout || !changes.iter().all(|change| part.holds(change)) {
                archive
                    .reject(|| format!("the variables of {} have other addresses than in the checkpoint", part.name));
            }
            list.push(changes);
        }
        host::persist_arrays(&mut archive);
        archive.finish()?;
        self.parts.iter().zip(&list).for_each(|(part, changes)| part.set(changes));
        Ok(())
    }
}

/// Returns the first few entries of a list and the number of the others.
fn shortened(mut list: Vec<String>) -> Vec<String> {
    if list.len() > MOST {
        let more = list.len() - MOST;
        list.truncate(MOST);
        list.push(format!("and {more} more of this kind"));
    }
    list
}

impl LibraryMemory {
    /// Returns the library loaded from a path with these bytes, and the libraries it needs; `before` are the bases of
    /// libraries loaded earlier.
    pub fn of(path: &Path, name: &Path, bytes: &[u8], before: &[usize]) -> Vec<LibraryMemory> {
        let loaded = loaded();
        let mut parts: Vec<LibraryMemory> = Vec::new();
        let object_of_path = loaded.iter().find(|object| Path::new(&object.name) == path);
        parts.extend(object_of_path.map(|object| LibraryMemory::new(object, name, bytes, false)));
        let mut next = 0;
        while let Some(part) = parts.get(next) {
            for needed in part.symbols.needed.clone() {
                let is_named = |object: &&LoadedObject| object.name.rsplit('/').next() == Some(&needed);
                let known = |object: &&LoadedObject| parts.iter().all(|part| part.base != object.base);
                if RUNTIMES.iter().any(|runtime| needed.starts_with(runtime)) {
                    continue;
                }
                if let Some(object) = loaded.iter().find(is_named).filter(known) {
                    let bytes = std::fs::read(&object.name).unwrap_or_default();
                    let shared = before.contains(&object.base);
                    parts.push(LibraryMemory::new(object, Path::new(&object.name), &bytes, shared));
                }
            }
            next += 1;
        }
        parts
    }

    fn new(object: &LoadedObject, name: &Path, bytes: &[u8], shared: bool) -> LibraryMemory {
        let symbols = LibrarySymbols::read(bytes);
        let areas =
            object.writable().into_iter().map(|(at, length)| WritableRange::new(object.base, at, length)).collect();
        let mut text = format!("{:?} {:?}", object.writable(), object.of_thread);
        symbols.variables.iter().for_each(|variable| text += &format!(" {variable:?}"));
        let layout = hash([text.as_bytes()]);
        let name = format!("`{}`", name.display());
        LibraryMemory { name, base: object.base, symbols, areas, of_thread: object.of_thread, layout, shared }
    }

    /// Returns the memory that has changed since the library was loaded.
    fn changes(&self) -> Vec<ChangedBytes> {
        let mut changes: Vec<ChangedBytes> = Vec::new();
        let mut now = [0; PAGE];
        for (index, area) in self.areas.iter().enumerate() {
            for page in (0..area.length).step_by(PAGE) {
                let now = area.read(self.base, page, &mut now);
                let initial = area.initial(page, now.len());
                if now == initial {
                    continue;
                }
                for (i, (cell, _)) in cells(now).zip(cells(initial)).enumerate().filter(|(_, (a, b))| a != b) {
                    let start = page + i * CELL;
                    match changes.last_mut().filter(|last| last.area == index && last.at + last.bytes.len() == start) {
                        Some(last) => last.bytes.extend(cell),
                        None => changes.push(ChangedBytes { area: index, at: start, bytes: cell.to_vec() }),
                    }
                }
            }
        }
        changes
    }

    /// Returns descriptions of changed variables that hold an address: eight bytes, not always aligned.
    fn addresses(&self, changes: &[ChangedBytes], used: &[(u64, u64)]) -> Vec<String> {
        let lowest = used.first().map_or(u64::MAX, |range| range.0);
        let is_address = |word: u64| {
            word >= lowest && used.get(used.partition_point(|range| range.1 <= word)).is_some_and(|r| r.0 <= word)
        };
        let mut areas = BTreeSet::new();
        for change in changes {
            let area = &self.areas[change.area];
            // Including one cell before and one after the change.
            let from = change.at.saturating_sub(CELL);
            let end_of_change = (change.at + change.bytes.len() + CELL).min(area.length);
            let mut bytes = vec![0; end_of_change - from];
            area.copy(self.base, from, &mut bytes);
            let windows = bytes.windows(2 * CELL).step_by(CELL).enumerate();
            for (i, window) in windows {
                let word = window.try_into().map_or(0, u64::from_le_bytes);
                if is_address(word) {
                    areas.insert(self.place((area.at + from + i * CELL).max(area.at + change.at), false));
                }
            }
        }
        areas.into_iter().map(|place| format!("{place} holds an address (allocated memory, a pointer)")).collect()
    }

    /// Returns the description of a thread-local variable that this thread has changed, if any.
    fn of_threads(&self) -> Option<String> {
        let [image, filled, length] = self.of_thread?;
        let now = loaded().into_iter().find(|object| object.base == self.base)?.threads_own?;
        let (mut first, mut values) = (vec![0; length], vec![0; length]);
        copy(self.base + image, &mut first[..filled]);
        copy(now, &mut values);
        let first_difference = first.iter().zip(&values).position(|(a, b)| a != b)?;
        Some(format!("{} is a thread-local variable", self.place(first_difference, true)))
    }

    /// Returns the name of a memory location in messages.
    fn place(&self, at: usize, of_thread: bool) -> String {
        match self.symbols.variable(at, of_thread) {
            Some((variable, 0)) => format!("{} of {}", variable.plain_name(), self.name),
            Some((variable, into)) => format!("{}, byte {into}, of {}", variable.plain_name(), self.name),
            None => format!("byte {at} of the memory of {}", self.name),
        }
    }

    fn holds(&self, change: &ChangedBytes) -> bool {
        let end = change.at.checked_add(change.bytes.len());
        self.areas.get(change.area).is_some_and(|area| end.is_some_and(|end| end <= area.length))
    }

    /// Restores the content after loading, with these changes; unchanged bytes are not written.
    fn set(&self, changes: &[ChangedBytes]) {
        let mut now = [0; PAGE];
        for area in &self.areas {
            for page in (0..area.length).step_by(PAGE) {
                let now = area.read(self.base, page, &mut now);
                let initial = area.initial(page, now.len());
                if now != initial {
                    area.write(self.base, page, initial);
                }
            }
        }
        changes.iter().for_each(|change| self.areas[change.area].write(self.base, change.at, &change.bytes));
    }
}

fn cells(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.chunks_exact(CELL)
}

impl WritableRange {
    /// Records the content of a newly loaded library.
    fn new(base: usize, at: usize, length: usize) -> WritableRange {
        let mut area = WritableRange { at, length, initial: BTreeMap::new() };
        for page in (0..length).step_by(PAGE) {
            let mut bytes = Box::new([0; PAGE]);
            if area.read(base, page, &mut bytes).iter().any(|byte| *byte != 0) {
                area.initial.insert(page, bytes);
            }
        }
        area
    }

    /// Reads a page; the last one may be shorter.
    fn read<'a>(&self, base: usize, page: usize, to: &'a mut [u8; PAGE]) -> &'a [u8] {
        let bytes = &mut to[..PAGE.min(self.length - page)];
        self.copy(base, page, bytes);
        bytes
    }

    fn initial(&self, page: usize, length: usize) -> &[u8] {
        &self.initial.get(&page).map_or(&[0; PAGE], |bytes| bytes)[..length]
    }

    fn copy(&self, base: usize, from: usize, to: &mut [u8]) {
        assert!(from + to.len() <= self.length);
        copy(base + self.at + from, to);
    }

    fn write(&self, base: usize, at: usize, bytes: &[u8]) {
        assert!(at + bytes.len() <= self.length);
        // SAFETY: writable memory of a library that stays loaded; it contains no Rust objects.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), (base + self.at + at) as *mut u8, bytes.len()) }
    }
}

fn copy(from: usize, to: &mut [u8]) {
    // SAFETY: readable memory of a library that stays loaded; no subroutine runs on this thread.
    unsafe { std::ptr::copy_nonoverlapping(from as *const u8, to.as_mut_ptr(), to.len()) }
}

/// An object that the loader has loaded.
struct LoadedObject {
    name: String,
    base: usize,
    /// Offset and length of writable memory, and of the part that is read-only after loading (RELRO).
    written: Vec<(usize, usize)>,
    read_only: Option<(usize, usize)>,
    /// Thread-local variables as in [`LibraryMemory::of_thread`], and their address in this thread, if used.
    of_thread: Option<[usize; 3]>,
    threads_own: Option<usize>,
}

impl LoadedObject {
    /// Returns the writable memory without the read-only part, in whole cells.
    fn writable(&self) -> Vec<(usize, usize)> {
        let (from, length) = self.read_only.unwrap_or_default();
        let mut list = Vec::new();
        for &(at, size) in &self.written {
            let end = (at + size).next_multiple_of(2 * CELL);
            let (first, last) = ((at, from.clamp(at, end)), ((from + length).clamp(at, end), end));
            let ranges = if length == 0 { [(at, end), (end, end)] } else { [first, last] };
            let aligned = ranges.map(|(start, end)| (start.next_multiple_of(2 * CELL), end));
            list.extend(
                aligned.into_iter().filter(|(start, end)| start < end).map(|(start, end)| (start, end - start)),
            );
        }
        list
    }
}

/// Returns the base addresses of the libraries of the process.
pub fn bases() -> Vec<usize> {
    loaded().into_iter().map(|object| object.base).collect()
}

fn loaded() -> Vec<LoadedObject> {
    let mut list: Vec<LoadedObject> = Vec::new();
    // SAFETY: the callback gets a pointer to the list, which is valid during this call.
    unsafe { libc::dl_iterate_phdr(Some(add_loaded), (&raw mut list).cast()) };
    list
}

unsafe extern "C" fn add_loaded(info: *mut libc::dl_phdr_info, _size: usize, list: *mut c_void) -> c_int {
    const MAY_WRITE: u32 = 2;
    // SAFETY: the loader passes a valid description; `list` is that of `loaded`.
    let (info, list) = unsafe { (&*info, &mut *list.cast::<Vec<LoadedObject>>()) };
    if info.dlpi_name.is_null() || info.dlpi_phdr.is_null() {
        return 0;
    }
    // SAFETY: as above.
    let (name, headers) =
        unsafe { (CStr::from_ptr(info.dlpi_name), std::slice::from_raw_parts(info.dlpi_phdr, info.dlpi_phnum.into())) };
    let mut object = LoadedObject {
        name: name.to_string_lossy().into_owned(),
        base: info.dlpi_addr as usize,
        written: Vec::new(),
        read_only: None,
        of_thread: None,
        threads_own: (!info.dlpi_tls_data.is_null()).then_some(info.dlpi_tls_data as usize),
    };
    for header in headers {
        let (address, length) = (header.p_vaddr as usize, header.p_memsz as usize);
        match header.p_type {
            libc::PT_LOAD if header.p_flags & MAY_WRITE != 0 => object.written.push((address, length)),
            libc::PT_GNU_RELRO => object.read_only = Some((address, length)),
            libc::PT_TLS => object.of_thread = Some([address, header.p_filesz as usize, length]),
            _ => {}
        }
    }
    list.push(object);
    0
}

/// Returns the address ranges in use, ascending; `None` if the system does not report them.
fn mappings() -> Option<Vec<(u64, u64)>> {
    let text = std::fs::read_to_string("/proc/self/maps").ok()?;
    let range = |line: &str| {
        let (from, end) = line.split(' ').next()?.split_once('-')?;
        Some((u64::from_str_radix(from, 16).ok()?, u64::from_str_radix(end, 16).ok()?))
    };
    text.lines().map(range).collect()
}

/// Returns the open files of the process, by descriptor and name.
fn open_files() -> BTreeSet<(PathBuf, PathBuf)> {
    let entries = std::fs::read_dir("/proc/self/fd").into_iter().flatten().filter_map(Result::ok);
    let files = entries.filter_map(|entry| Some((entry.path(), std::fs::read_link(entry.path()).ok()?)));
    files.filter(|(_, path)| !path.starts_with("/proc") && !path.starts_with("anon_inode:")).collect()
}

#[cfg(test)]
mod tests {
    use super::{LoadedObject, mappings};

    #[test]
    fn read_only_memory_is_excluded() {
        let object = |written: &[(usize, usize)], read_only| LoadedObject {
            name: String::new(),
            base: 0,
            written: written.to_vec(),
            read_only,
            of_thread: None,
            threads_own: None,
        };
        assert_eq!(object(&[(0x3de8, 0x21f8)], Some((0x3de8, 0x218))).writable(), [(0x4000, 0x1fe0)]);
        assert_eq!(object(&[(0x1000, 13), (0x3000, 8)], Some((0x3000, 8))).writable(), [(0x1000, 16)]);
        assert_eq!(object(&[(0x1000, 13)], None).writable(), [(0x1000, 16)]);
    }

    #[test]
    fn memory_of_this_process_is_among_its_mappings() {
        let local = 7_u64;
        let address = (&raw const local) as u64;
        let ranges = mappings().expect("the system shows it");
        assert!(ranges.iter().any(|(from, to)| (*from..*to).contains(&address)));
        assert!(ranges.is_sorted());
    }
}
