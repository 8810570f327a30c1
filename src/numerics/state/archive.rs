//! Serialization of the state. One function visits all fields in a fixed order for writing and reading, so that nothing
//! can be saved without being restored.
//!
//! `#[derive(Persist)]` visits every field: a new field is state unless the type lists it as derived. Data that follow
//! from the plan are not state; reading requires an object created from the same plan.

use std::fs::File;
use std::io::{BufWriter, Write as _};

pub use revolve_derive::Persist;

/// Error: bytes that are not a state of the plan for which they are read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct UnfitState {
    /// First difference from the plan.
    pub reason: String,
}

/// Bytes that are written or read. Numbers are little-endian.
#[derive(Debug)]
pub struct StateArchive<'a> {
    mode: ArchiveMode<'a>,
    /// Reason why the bytes read so far are not a state of this plan.
    fault: Option<String>,
}

#[derive(Debug)]
enum ArchiveMode<'a> {
    Write(&'a mut Vec<u8>),
    Stream(&'a mut BufWriter<File>),
    Count(&'a mut usize),
    Read(&'a [u8]),
}

impl<'a> StateArchive<'a> {
    /// Creates an archive that appends to a buffer.
    pub fn writer(buffer: &'a mut Vec<u8>) -> Self {
        StateArchive { mode: ArchiveMode::Write(buffer), fault: None }
    }

    /// Creates an archive that writes to a file. [`StateArchive::finish`] returns a failure.
    pub fn stream(file: &'a mut BufWriter<File>) -> Self {
        StateArchive { mode: ArchiveMode::Stream(file), fault: None }
    }

    /// Creates an archive that counts the bytes that a writer would append.
    pub fn counter(count: &'a mut usize) -> Self {
        StateArchive { mode: ArchiveMode::Count(count), fault: None }
    }

    /// Creates an archive that reads from bytes.
    pub fn reader(bytes: &'a [u8]) -> Self {
        StateArchive { mode: ArchiveMode::Read(bytes), fault: None }
    }

    /// Returns whether values are restored from the archive; otherwise they are saved to it.
    pub fn reads(&self) -> bool {
        matches!(self.mode, ArchiveMode::Read(_))
    }

    /// Reports that the bytes do not fit the plan; the first reason is kept.
    pub fn reject(&mut self, reason: impl FnOnce() -> String) {
        self.fault.get_or_insert_with(reason);
    }

    /// Writes a name, or checks that it was written here, so that errors can be located.
    pub fn mark(&mut self, name: &str) {
        let mut read = name.to_owned();
        read.persist(self);
        if read != name {
            self.reject(|| format!("the data of `{name}` are missing"));
        }
    }

    /// Writes or reads raw bytes, preceded by their length.
    pub fn blob(&mut self, bytes: &mut Vec<u8>) {
        let length = self.free_length(bytes.len());
        match &mut self.mode {
            ArchiveMode::Write(buffer) => buffer.extend_from_slice(bytes),
            ArchiveMode::Stream(file) => {
                let written = file.write_all(bytes);
                self.reject_unwritten(written);
            }
            ArchiveMode::Count(count) => **count += bytes.len(),
            ArchiveMode::Read(rest) => {
                let (blob, tail) = rest.split_at(length.min(rest.len()));
                (*bytes, *rest) = (blob.to_vec(), tail);
            }
        }
    }

    /// Ends reading, or writing to a file.
    ///
    /// # Errors
    /// Why the bytes are not a state of the plan, or why the file cannot be written.
    pub fn finish(mut self) -> Result<(), UnfitState> {
        if let ArchiveMode::Stream(file) = &mut self.mode {
            let written = file.flush();
            self.reject_unwritten(written);
        }
        if let ArchiveMode::Read(rest) = self.mode
            && !rest.is_empty()
        {
            self.reject(|| format!("{} unexpected bytes at the end", rest.len()));
        }
        self.fault.map_or(Ok(()), |reason| Err(UnfitState { reason }))
    }

    fn reject_unwritten(&mut self, written: std::io::Result<()>) {
        if let Err(why) = written {
            self.reject(|| why.to_string());
        }
    }

    /// Returns the number of bytes left to read; unlimited for writing.
    fn remaining(&self) -> usize {
        match &self.mode {
            ArchiveMode::Write(_) | ArchiveMode::Stream(_) | ArchiveMode::Count(_) => usize::MAX,
            ArchiveMode::Read(rest) => rest.len(),
        }
    }

    #[inline]
    fn raw<const N: usize>(&mut self, value: [u8; N]) -> [u8; N] {
        match &mut self.mode {
            ArchiveMode::Write(buffer) => buffer.extend_from_slice(&value),
            ArchiveMode::Stream(file) => {
                let written = file.write_all(&value);
                self.reject_unwritten(written);
            }
            ArchiveMode::Count(count) => **count += N,
            ArchiveMode::Read(rest) => match rest.split_first_chunk() {
                Some((read, tail)) => {
                    *rest = tail;
                    return *read;
                }
                None => self.reject(|| "unexpected end of data".into()),
            },
        }
        value
    }

    /// Writes or checks the length of a list whose length the plan determines.
    fn fixed_length(&mut self, length: usize) -> bool {
        let mut read = length;
        read.persist(self);
        if read != length {
            self.reject(|| format!("a list has {read} entries, the deck requires {length}"));
        }
        read == length
    }

    /// Writes or reads the length of a list whose length varies during the run.
    fn free_length(&mut self, length: usize) -> usize {
        let mut read = length;
        read.persist(self);
        if self.reads() && read > self.remaining() {
            self.reject(|| format!("a list of {read} entries exceeds the remaining data"));
            return 0;
        }
        read
    }
}

/// State that can be written to an archive and read back.
///
/// `#[derive(Persist)]` visits the fields of a struct in the order of their declaration, or the number of a variant
/// without fields. `#[persist(role: field, field; role: field)]` lists the exceptions:
///
/// - `derived`: follows from plan and step and is not state
/// - `fixed`: a list whose length the plan determines
/// - `fixed_lists`: a list of such lists
/// - `each`: a list of boxed objects
/// - `present`: an `Option` that the plan determines
/// - `blob`: raw bytes
/// - `then`: a function that is called last
///
/// A field whose type is not state does not compile until it is listed:
///
/// ```compile_fail,E0277
/// use revolve_numerics::state::archive::Persist;
///
/// struct Mesh;
///
/// #[derive(Persist)]
/// struct Probe {
///     value: f64,
///     mesh: Mesh, // the trait bound `Mesh: Persist` is not satisfied
/// }
/// ```
///
/// ```
/// # use revolve_numerics::state::archive::Persist;
/// # struct Mesh;
/// #[derive(Persist)]
/// #[persist(derived: mesh)]
/// struct Probe {
///     value: f64,
///     mesh: Mesh,
/// }
/// ```
pub trait Persist {
    /// Visits the state in a fixed order: writes it, or replaces it by the bytes read.
    fn persist(&mut self, archive: &mut StateArchive<'_>);
}

/// Visits a list of boxed objects whose length the plan determines.
pub fn persist_all<T: Persist + ?Sized>(items: &mut [Box<T>], archive: &mut StateArchive<'_>) {
    if archive.fixed_length(items.len()) {
        items.iter_mut().for_each(|item| item.persist(archive));
    }
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Persist for $number {
            #[inline]
            fn persist(&mut self, archive: &mut StateArchive<'_>) {
                *self = <$number>::from_le_bytes(archive.raw(self.to_le_bytes()));
            }
        }
    )*};
}
numbers!(f64, f32, u64, u32, i32, u8);

impl Persist for usize {
    #[inline]
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut wide = *self as u64;
        wide.persist(archive);
        *self = wide as usize;
    }
}

impl Persist for bool {
    #[inline]
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut byte = u8::from(*self);
        byte.persist(archive);
        *self = byte != 0;
    }
}

impl<T: Persist + ?Sized> Persist for Box<T> {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        (**self).persist(archive);
    }
}

impl Persist for () {
    fn persist(&mut self, _archive: &mut StateArchive<'_>) {}
}

impl<T: Persist, const N: usize> Persist for [T; N] {
    #[inline]
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        self.iter_mut().for_each(|item| item.persist(archive));
    }
}

/// A list whose length the plan determines.
impl<T: Persist> Persist for [T] {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        if archive.fixed_length(self.len()) {
            self.iter_mut().for_each(|item| item.persist(archive));
        }
    }
}

/// A list whose length varies during the run.
impl<T: Persist + Default + Clone> Persist for Vec<T> {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let length = archive.free_length(self.len());
        self.resize(length, T::default());
        self.iter_mut().for_each(|item| item.persist(archive));
    }
}

impl<T: Persist + Default> Persist for Option<T> {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut is_present = self.is_some();
        is_present.persist(archive);
        match (is_present, self.is_some()) {
            (true, false) => *self = Some(T::default()),
            (false, true) => *self = None,
            _ => {}
        }
        if let Some(value) = self {
            value.persist(archive);
        }
    }
}

impl Persist for String {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut bytes = std::mem::take(self).into_bytes();
        archive.blob(&mut bytes);
        *self = String::from_utf8_lossy(&bytes).into_owned();
    }
}

impl<A: Persist, B: Persist> Persist for (A, B) {
    #[inline]
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        self.0.persist(archive);
        self.1.persist(archive);
    }
}

/// Visits fields in the given order.
#[macro_export]
macro_rules! persist_fields {
    ($archive:expr; $($field:expr),* $(,)?) => {{ $($crate::state::archive::Persist::persist($field, $archive);)* }};
}
pub use persist_fields;

#[cfg(test)]
mod tests {
    use super::{Persist, StateArchive};

    fn written<T: Persist>(value: &mut T) -> Vec<u8> {
        let mut bytes = Vec::new();
        value.persist(&mut StateArchive::writer(&mut bytes));
        bytes
    }

    #[test]
    fn written_state_is_read_back() {
        let mut state = (vec![1.5, -0.0, f64::NAN], (Some("r\u{e4}dius".to_owned()), [true, false]));
        let bytes = written(&mut state);
        let mut read = (vec![0.0; 7], (None::<String>, [false; 2]));
        let mut archive = StateArchive::reader(&bytes);
        read.persist(&mut archive);
        assert_eq!(archive.finish(), Ok(()));
        let bits = |list: &[f64]| list.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read.0), bits(&state.0));
        assert_eq!(read.1, state.1);
    }

    #[test]
    fn invalid_data_are_rejected_without_panic() {
        let bytes = written(&mut vec![1_u64, 2, 3]);
        for end in 0..bytes.len() {
            let mut archive = StateArchive::reader(&bytes[..end]);
            Vec::<u64>::new().persist(&mut archive);
            assert!(archive.finish().is_err(), "{end} bytes");
        }
        let mut archive = StateArchive::reader(&bytes);
        [0_u64; 2][..].persist(&mut archive);
        assert_eq!(archive.finish().map_err(|e| e.reason), Err("a list has 3 entries, the deck requires 2".into()));
        let mut archive = StateArchive::reader(&bytes);
        0_u64.persist(&mut archive);
        assert_eq!(archive.finish().map_err(|e| e.reason), Err("24 unexpected bytes at the end".into()));
        let huge = u64::MAX.to_le_bytes();
        let mut archive = StateArchive::reader(&huge);
        Vec::<u8>::new().persist(&mut archive);
        assert!(archive.finish().is_err());
    }

    #[derive(Clone, Copy, Debug, PartialEq, Persist)]
    enum Phase {
        Loading,
        Unloading,
    }

    #[derive(Debug, PartialEq, Persist)]
    #[persist(fixed: forces; blob: text; derived: mass)]
    struct Probe {
        phase: Phase,
        mass: f64,
        forces: Vec<f64>,
        text: Vec<u8>,
    }

    #[test]
    fn derive_visits_all_fields_that_are_not_derived() {
        let mut state = Probe { phase: Phase::Unloading, mass: 2.0, forces: vec![3.0], text: vec![4, 5] };
        let bytes = written(&mut state);
        let numbers: Vec<u8> =
            [&[1][..], &1_u64.to_le_bytes(), &3_f64.to_le_bytes(), &2_u64.to_le_bytes(), &[4, 5]].concat();
        assert_eq!(bytes, numbers);
        let mut read = Probe { phase: Phase::Loading, mass: 7.0, forces: vec![0.0], text: Vec::new() };
        let mut archive = StateArchive::reader(&bytes);
        read.persist(&mut archive);
        assert_eq!(archive.finish(), Ok(()));
        assert_eq!(read, Probe { mass: 7.0, ..state });
        let mut archive = StateArchive::reader(&[2]);
        let mut phase = Phase::Loading;
        phase.persist(&mut archive);
        assert_eq!(archive.finish().map_err(|e| e.reason), Err("2 is not a value of Phase".into()));
    }
}
