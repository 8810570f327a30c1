//! A call in shared memory: numbers, and lists that each start at a cache line. Values are read in the order in which
//! they were written.
#![allow(unsafe_code)]

use super::super::{LoadFailure, MAX_MATERIAL_BLOCK};
use revolve_numerics::state::Instant;

/// Largest number of scalars, of lists, and of 8-byte words in all lists of a call.
const NUMBERS: usize = 32;
const LISTS: usize = 32;
const WORDS: usize = 1 << 21;
/// Number of 8-byte words per cache line.
const LINE: usize = 8;
/// Guard value after each result list during a call: a NaN that no arithmetic produces.
const GUARD: u64 = 0x7ff4_dead_beef_0001;

/// Arguments or results of a call.
#[repr(C, align(64))]
pub struct CallMessage {
    numbers: [f64; NUMBERS],
    /// Size of each list in bytes.
    lengths: [u32; LISTS],
    data: [f64; WORDS],
}

/// Writes values to a message.
pub struct MessageWriter<'t> {
    message: &'t mut CallMessage,
    number: usize,
    list: usize,
    at: usize,
    full: bool,
}

/// Reads values from a message.
pub struct MessageReader<'t> {
    message: &'t CallMessage,
    number: usize,
    list: usize,
    at: usize,
}

/// Types that lists may contain.
///
/// # Safety
/// Every bit pattern is a valid value, there is no padding, and the alignment is at most that of an f64.
pub unsafe trait PlainValue: Copy {}
// SAFETY: a number type.
unsafe impl PlainValue for f64 {}
// SAFETY: a number type.
unsafe impl PlainValue for i32 {}
// SAFETY: a number type.
unsafe impl PlainValue for u8 {}

/// Returns the start of the list that follows one of `numbers` words.
fn next_list_start(at: usize, numbers: usize) -> usize {
    (at + numbers).next_multiple_of(LINE)
}

impl CallMessage {
    /// Returns a writer at the start of the message.
    pub fn write(&mut self) -> MessageWriter<'_> {
        MessageWriter { message: self, number: 0, list: 0, at: 0, full: false }
    }

    /// Returns a reader at the start of the message.
    pub fn read(&self) -> MessageReader<'_> {
        MessageReader { message: self, number: 0, list: 0, at: 0 }
    }
}

impl MessageWriter<'_> {
    /// Writes the next number.
    pub fn number(&mut self, value: f64) {
        match self.message.numbers.get_mut(self.number) {
            Some(place) => *place = value,
            None => self.full = true,
        }
        self.number += 1;
    }

    /// Writes a list. Cache lines that are already equal are not written, because they may be in the cache of the other
    /// process.
    pub fn list<T: PlainValue>(&mut self, values: &[T]) {
        // SAFETY: plain values have no padding bytes.
        let from = unsafe { values.align_to::<u8>() }.1;
        let words = from.len().div_ceil(size_of::<f64>());
        let target = self.message.data.get_mut(self.at..self.at + words);
        let (Some(target), Some(length)) = (target, self.message.lengths.get_mut(self.list)) else {
            self.full = true;
            return;
        };
        if *length != from.len() as u32 {
            *length = from.len() as u32;
        }
        // SAFETY: as above.
        let target = &mut unsafe { target.align_to_mut::<u8>() }.1[..from.len()];
        let ((lines, tail), (new_lines, new_tail)) = (target.as_chunks_mut::<64>(), from.as_chunks::<64>());
        for (line, new_line) in lines.iter_mut().zip(new_lines) {
            if line != new_line {
                *line = *new_line;
            }
        }
        if tail != new_tail {
            tail.copy_from_slice(new_tail);
        }
        self.list += 1;
        self.at = next_list_start(self.at, words);
    }

    /// Ends the message.
    ///
    /// # Errors
    /// If the values exceed the shared memory.
    pub fn end(self) -> Result<(), LoadFailure> {
        let reason = || format!("its arguments exceed the {} MB of memory that two processes share", WORDS >> 17);
        if self.full { Err(LoadFailure::new(reason())) } else { Ok(()) }
    }
}

impl<'t> MessageReader<'t> {
    /// Reads the next number; zero after the last one.
    pub fn number(&mut self) -> f64 {
        self.number += 1;
        self.message.numbers.get(self.number - 1).copied().unwrap_or_default()
    }

    /// Reads the next list, without copying it; empty after the last one.
    pub fn list<T: PlainValue>(&mut self) -> &'t [T] {
        let bytes = self.message.lengths.get(self.list).map_or(0, |bytes| *bytes as usize);
        let words = bytes.div_ceil(size_of::<f64>());
        let words_of_list = self.message.data.get(self.at..self.at + words).unwrap_or_default();
        self.list += 1;
        self.at = next_list_start(self.at, words);
        // SAFETY: every bit pattern is a plain value, and the alignment is at most that of an f64.
        unsafe { words_of_list.align_to::<T>() }.1.get(..bytes / size_of::<T>()).unwrap_or_default()
    }

    /// Reads a list into `to`.
    pub fn take(&mut self, to: &mut [f64]) {
        let from = self.list();
        let count = from.len().min(to.len());
        to[..count].copy_from_slice(&from[..count]);
    }
}

/// A value that can be written to and read from a message.
pub trait MessageField<'m>: Sized {
    fn put(&self, to: &mut MessageWriter<'_>);
    fn get(from: &mut MessageReader<'m>) -> Self;
}

/// Writes several values.
macro_rules! put {
    ($to:expr; $($value:expr),*) => {{ $($crate::native::isolate::message::MessageField::put(&$value, $to);)* }};
}

/// Reads several variables in the order of writing.
macro_rules! get {
    ($from:expr; $($name:ident),*) => { $(let $name = $crate::native::isolate::message::MessageField::get($from);)* };
}
pub(super) use {get, put};

/// Implements [`MessageField`] for types, with their writing and reading.
macro_rules! fields {
    ($($type:ty: |$value:ident, $to:ident| $put:expr, |$from:ident| $get:expr;)*) => {$(
        impl<'m> MessageField<'m> for $type {
            fn put(&self, $to: &mut MessageWriter<'_>) {
                let $value = *self;
                $put
            }

            fn get($from: &mut MessageReader<'m>) -> Self {
                $get
            }
        }
    )*};
}

fields! {
    f64: |value, to| to.number(value), |from| from.number();
    u64: |value, to| to.number(f64::from_bits(value)), |from| from.number().to_bits();
    u32: |value, to| u64::from(value).put(to), |from| u64::get(from) as u32;
    i32: |value, to| (value as u64).put(to), |from| u64::get(from) as i32;
    usize: |value, to| (value as u64).put(to), |from| u64::get(from) as usize;
    bool: |value, to| u64::from(value).put(to), |from| u64::get(from) != 0;
    &'m str: |value, to| to.list(value.as_bytes()), |from| std::str::from_utf8(from.list()).unwrap_or_default();
    &'m [f64]: |value, to| to.list(value), |from| from.list();
    &'m [i32]: |value, to| to.list(value), |from| from.list();
    Instant: |value, to| {
        put!(to; value.step_time, value.total_time, value.lost, value.step, value.increment);
    }, |from| {
        get!(from; step_time, total_time, lost, step, increment);
        Instant { step_time, total_time, lost, step, increment }
    };
}

impl<'m, T: MessageField<'m>, const N: usize> MessageField<'m> for [T; N] {
    fn put(&self, to: &mut MessageWriter<'_>) {
        self.iter().for_each(|value| value.put(to));
    }

    fn get(from: &mut MessageReader<'m>) -> Self {
        std::array::from_fn(|_| T::get(from))
    }
}

/// Number of guard values after each list: 16 components of all points of a material, which a subroutine can write if it
/// declares the array with `*`.
const GUARDS: usize = 16 * MAX_MATERIAL_BLOCK;

/// Buffers for the result lists of a subroutine, each followed by guard values: writing past the end of a list is
/// detected and does no damage.
#[derive(Default)]
pub struct AnswerLists {
    data: Vec<f64>,
    lengths: Vec<usize>,
    /// Whether the guard values are valid for the present lengths of the lists.
    is_guarded: bool,
}

impl AnswerLists {
    /// Returns the buffers, filled with the lists of a message.
    pub fn take<const N: usize>(&mut self, from: &mut MessageReader<'_>) -> [&mut [f64]; N] {
        let previous: [&[f64]; N] = MessageField::get(from);
        let lengths = previous.iter().map(|list| list.len());
        let is_guarded = self.is_guarded && lengths.clone().eq(self.lengths.iter().copied());
        self.lengths.clear();
        self.lengths.extend(lengths);
        let size: usize = self.lengths.iter().map(|length| length + GUARDS).sum();
        self.data.resize(self.data.len().max(size), 0.0);
        let mut unused = &mut self.data[..size];
        self.is_guarded = true;
        previous.map(|previous| {
            let (list, after) = std::mem::take(&mut unused).split_at_mut(previous.len());
            let (guard, after) = after.split_at_mut(GUARDS);
            list.copy_from_slice(previous);
            if !is_guarded {
                guard.fill(f64::from_bits(GUARD));
            }
            unused = after;
            list
        })
    }

    /// Writes all lists; returns the index of the first list that was exceeded.
    pub fn write(&mut self, writer: &mut MessageWriter<'_>) -> Option<usize> {
        let (mut start, mut overrun) = (0, None);
        for (place, length) in self.lengths.iter().enumerate() {
            let (list, guard) =
                (&self.data[start..start + length], &self.data[start + length..start + length + GUARDS]);
            // Without a branch per value, so that the loop is vectorised.
            if guard.iter().fold(0, |changed, number| changed | (number.to_bits() ^ GUARD)) != 0 {
                overrun.get_or_insert(place);
            }
            writer.list(list);
            start += length + GUARDS;
        }
        self.is_guarded = overrun.is_none();
        overrun
    }
}

#[cfg(test)]
mod tests {
    use super::{AnswerLists, CallMessage, GUARDS, MessageField as _, WORDS};
    use revolve_numerics::state::Instant;

    fn message() -> Box<CallMessage> {
        // SAFETY: zeros are a valid message.
        unsafe { Box::new_zeroed().assume_init() }
    }

    #[test]
    fn arguments_arrive_bit_by_bit() {
        let mut message = message();
        let numbers = [1.0, -0.0, f64::from_bits(0x7ff4_0000_0000_0001), 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
        let now = Instant { step_time: 1.0, total_time: 2.0, step: 3, increment: 4, lost: 5.0 };
        for _ in 0..2 {
            let mut writer = message.write();
            now.put(&mut writer);
            writer.list(&numbers);
            writer.list::<f64>(&[]);
            "PLATE".put(&mut writer);
            writer.list(&[1_i32, -2, 3]);
            writer.list(&numbers[..3]);
            u64::MAX.put(&mut writer);
            assert!(writer.end().is_ok());
            let mut reader = message.read();
            assert_eq!(Instant::get(&mut reader), now);
            assert!(reader.list::<f64>().iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
            assert_eq!(
                (reader.list::<f64>().len(), <&str>::get(&mut reader), reader.list()),
                (0, "PLATE", &[1_i32, -2, 3][..])
            );
            let mut values = [7.0; 4];
            reader.take(&mut values);
            assert_eq!((values[0], values[3], u64::get(&mut reader)), (1.0, 7.0, u64::MAX));
        }
        message.write().list(&numbers);
        message.write().list(&[3.0]);
        assert_eq!(message.read().list::<f64>(), [3.0]);
    }

    #[test]
    fn oversized_messages_are_reported() {
        let mut message = message();
        let mut writer = message.write();
        writer.list(&vec![1.0; WORDS]);
        writer.list(&[1.0]);
        let reason = writer.end().expect_err("too large").reason;
        assert!(reason.contains("16 MB"), "{reason}");
    }

    #[test]
    fn writing_past_a_list_is_detected() {
        let (mut call, mut message, mut answers) = (message(), message(), AnswerLists::default());
        let mut writer = call.write();
        writer.list(&[0.0; 3]);
        writer.list(&[0.0; 2]);
        let [a, b] = answers.take(&mut call.read());
        (a[0], b[1]) = (1.0, 2.0);
        assert_eq!(answers.write(&mut message.write()), None);
        answers.data[3 + GUARDS + 2] = f64::NAN;
        assert_eq!(answers.write(&mut message.write()), Some(1));
        let mut reader = message.read();
        assert_eq!((reader.list::<f64>()[0], reader.list::<f64>()[1]), (1.0, 2.0));
    }
}
