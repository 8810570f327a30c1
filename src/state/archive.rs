//! The state as bytes and back: one visit in a fixed order both writes and reads, so that nothing can be saved and not
//! restored. Never here: what a type consists of (each type lists its own fields), files, checksums.
//!
//! [`persist_struct`] takes a type apart without `..`, so that a new field does not compile before it is decided whether it is
//! state. What follows from the plan alone is not state: reading goes into an object made from the same plan.

/// Bytes that are not a state of the plan they are read for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct UnfitState {
    /// Where they part from what the plan has.
    pub reason: String,
}

/// Bytes that are being written or read. Numbers are little-endian.
#[derive(Debug)]
pub struct Archive<'a> {
    mode: Mode<'a>,
    /// Why what was read cannot be the state of this plan.
    fault: Option<String>,
}

#[derive(Debug)]
enum Mode<'a> {
    Write(&'a mut Vec<u8>),
    Read(&'a [u8]),
}

impl<'a> Archive<'a> {
    /// Writes behind what is in a buffer.
    pub fn writer(buffer: &'a mut Vec<u8>) -> Self {
        Archive { mode: Mode::Write(buffer), fault: None }
    }

    pub fn reader(bytes: &'a [u8]) -> Self {
        Archive { mode: Mode::Read(bytes), fault: None }
    }

    pub fn reads(&self) -> bool {
        matches!(self.mode, Mode::Read(_))
    }

    /// Says that what was read does not fit; the first reason stays.
    pub fn refuse(&mut self, reason: impl FnOnce() -> String) {
        self.fault.get_or_insert_with(reason);
    }

    /// A name between the fields: where plan and bytes part, it says where.
    pub fn mark(&mut self, name: &str) {
        let mut found = name.to_owned();
        found.persist(self);
        if found != name {
            self.refuse(|| format!("there is no `{name}` where the deck has it"));
        }
    }

    /// Bytes as they are, with their length.
    pub fn blob(&mut self, bytes: &mut Vec<u8>) {
        let length = self.free_length(bytes.len());
        match &mut self.mode {
            Mode::Write(buffer) => buffer.extend_from_slice(bytes),
            Mode::Read(rest) => {
                let (blob, behind) = rest.split_at(length.min(rest.len()));
                (*bytes, *rest) = (blob.to_vec(), behind);
            }
        }
    }

    /// Ends reading.
    ///
    /// # Errors
    /// Why the bytes are not what was asked of them.
    pub fn finish(mut self) -> Result<(), UnfitState> {
        if let Mode::Read(rest) = self.mode
            && !rest.is_empty()
        {
            self.refuse(|| format!("{} bytes are left over", rest.len()));
        }
        self.fault.map_or(Ok(()), |reason| Err(UnfitState { reason }))
    }

    /// Bytes that are left to read; all there can be while writing.
    fn left(&self) -> usize {
        match &self.mode {
            Mode::Write(_) => usize::MAX,
            Mode::Read(rest) => rest.len(),
        }
    }

    #[inline]
    fn raw<const N: usize>(&mut self, value: [u8; N]) -> [u8; N] {
        match &mut self.mode {
            Mode::Write(buffer) => buffer.extend_from_slice(&value),
            Mode::Read(rest) => match rest.split_first_chunk() {
                Some((read, behind)) => {
                    *rest = behind;
                    return *read;
                }
                None => self.refuse(|| "it ends too early".into()),
            },
        }
        value
    }

    /// The length of a list that the plan gives: it must be the same.
    fn fixed_length(&mut self, length: usize) -> bool {
        let mut found = length;
        found.persist(self);
        if found != length {
            self.refuse(|| format!("a list has {found} entries where the deck has {length}"));
        }
        found == length
    }

    /// The length of a list that grows with the run.
    fn free_length(&mut self, length: usize) -> usize {
        let mut found = length;
        found.persist(self);
        if self.reads() && found > self.left() {
            self.refuse(|| format!("a list of {found} entries is longer than what is left"));
            return 0;
        }
        found
    }
}

pub trait Persist {
    /// Visits the state in a fixed order: writes it, or replaces it by what is read.
    fn persist(&mut self, archive: &mut Archive<'_>);
}

/// A list whose length the plan gives.
pub fn persist_all<T: Persist + ?Sized>(items: &mut [Box<T>], archive: &mut Archive<'_>) {
    if archive.fixed_length(items.len()) {
        items.iter_mut().for_each(|item| item.persist(archive));
    }
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Persist for $number {
            #[inline]
            fn persist(&mut self, archive: &mut Archive<'_>) {
                *self = <$number>::from_le_bytes(archive.raw(self.to_le_bytes()));
            }
        }
    )*};
}
numbers!(f64, f32, u64, u32, i32, u8);

impl Persist for usize {
    #[inline]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut wide = *self as u64;
        wide.persist(archive);
        *self = wide as usize;
    }
}

impl Persist for bool {
    #[inline]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut byte = u8::from(*self);
        byte.persist(archive);
        *self = byte != 0;
    }
}

impl<T: Persist + ?Sized> Persist for Box<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        (**self).persist(archive);
    }
}

impl Persist for () {
    fn persist(&mut self, _archive: &mut Archive<'_>) {}
}

impl<T: Persist, const N: usize> Persist for [T; N] {
    #[inline]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.iter_mut().for_each(|item| item.persist(archive));
    }
}

/// A list whose length the plan gives.
impl<T: Persist> Persist for [T] {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        if archive.fixed_length(self.len()) {
            self.iter_mut().for_each(|item| item.persist(archive));
        }
    }
}

/// A list that grows and shrinks with the run.
impl<T: Persist + Default + Clone> Persist for Vec<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let length = archive.free_length(self.len());
        self.resize(length, T::default());
        self.iter_mut().for_each(|item| item.persist(archive));
    }
}

impl<T: Persist + Default> Persist for Option<T> {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut there = self.is_some();
        there.persist(archive);
        match (there, self.is_some()) {
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
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut bytes = std::mem::take(self).into_bytes();
        archive.blob(&mut bytes);
        *self = String::from_utf8_lossy(&bytes).into_owned();
    }
}

impl<A: Persist, B: Persist> Persist for (A, B) {
    #[inline]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.0.persist(archive);
        self.1.persist(archive);
    }
}

/// Lists the fields that are state, in order.
macro_rules! persist_fields {
    ($archive:expr; $($field:expr),* $(,)?) => {{ $($crate::state::archive::Persist::persist($field, $archive);)* }};
}
pub(crate) use persist_fields;

/// Implements [`Persist`] by one list of the fields of a type: those of its state, in the order in which they are visited, then those that
/// follow from plan and step.
///
/// A field is visited as its type is; `name: fixed` is a list whose length the plan gives, `name: fixed_lists` a list of such lists,
/// `name: each` a list of boxed objects, `name: present` what is there if the plan has it. `then` names what is done in the end.
macro_rules! persist_struct {
    ($name:ident $(<$($argument:ident),+>)? $([$($bound:tt)+])? { $($field:ident $(: $how:ident)?),* $(,)? }
        $(derived { $($derived:ident),+ $(,)? })? $(then $then:path)?) => {
        impl $(<$($bound)+>)? $crate::state::archive::Persist for $name $(<$($argument),+>)? {
            #[allow(unused_variables)] // Of what has no state.
            #[inline]
            fn persist(&mut self, archive: &mut $crate::state::archive::Archive<'_>) {
                let $name { $($field,)* $($($derived: _,)+)? } = self;
                $($crate::state::archive::persist_field!(archive, $field $(, $how)?);)*
                $($then(self, archive);)?
            }
        }
    };
}
pub(crate) use persist_struct;

/// Visits one field as [`persist_struct`] says.
macro_rules! persist_field {
    ($archive:ident, $field:ident) => {
        $crate::state::archive::Persist::persist($field, $archive)
    };
    ($archive:ident, $field:ident, fixed) => {
        $crate::state::archive::Persist::persist(&mut $field[..], $archive)
    };
    ($archive:ident, $field:ident, fixed_lists) => {
        for list in $field.iter_mut() {
            $crate::state::archive::Persist::persist(&mut list[..], $archive);
        }
    };
    ($archive:ident, $field:ident, each) => {{
        $archive.mark(stringify!($field));
        $crate::state::archive::persist_all(&mut $field[..], $archive);
    }};
    ($archive:ident, $field:ident, present) => {
        if let Some(field) = $field {
            $crate::state::archive::Persist::persist(field, $archive);
        }
    };
}
pub(crate) use persist_field;

#[cfg(test)]
mod tests {
    use super::{Archive, Persist};

    fn written<T: Persist>(value: &mut T) -> Vec<u8> {
        let mut bytes = Vec::new();
        value.persist(&mut Archive::writer(&mut bytes));
        bytes
    }

    #[test]
    fn what_is_written_is_read() {
        let mut state = (vec![1.5, -0.0, f64::NAN], (Some("r\u{e4}dius".to_owned()), [true, false]));
        let bytes = written(&mut state);
        let mut read = (vec![0.0; 7], (None::<String>, [false; 2]));
        let mut archive = Archive::reader(&bytes);
        read.persist(&mut archive);
        assert_eq!(archive.finish(), Ok(()));
        let bits = |list: &[f64]| list.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read.0), bits(&state.0));
        assert_eq!(read.1, state.1);
    }

    #[test]
    fn what_does_not_fit_is_refused_without_panic() {
        let bytes = written(&mut vec![1_u64, 2, 3]);
        for end in 0..bytes.len() {
            let mut archive = Archive::reader(&bytes[..end]);
            Vec::<u64>::new().persist(&mut archive);
            assert!(archive.finish().is_err(), "{end} bytes");
        }
        let mut archive = Archive::reader(&bytes);
        [0_u64; 2][..].persist(&mut archive);
        assert_eq!(archive.finish().map_err(|e| e.reason), Err("a list has 3 entries where the deck has 2".into()));
        let mut archive = Archive::reader(&bytes);
        0_u64.persist(&mut archive);
        assert_eq!(archive.finish().map_err(|e| e.reason), Err("24 bytes are left over".into()));
        let huge = u64::MAX.to_le_bytes();
        let mut archive = Archive::reader(&huge);
        Vec::<u8>::new().persist(&mut archive);
        assert!(archive.finish().is_err());
    }
}
