//! A call in shared memory: numbers, and lists one after the other, each from a cache line on. Written in the order in which
//! they are read.
//! Never here: whose turn it is, what a call means.
#![allow(unsafe_code)]

use super::super::LoadFailure;
use crate::state::Instant;

/// Largest count of numbers, of lists, and of words of 8 bytes in all lists of a call.
const NUMBERS: usize = 32;
const LISTS: usize = 32;
const ROOM: usize = 1 << 21;
/// Numbers of a cache line.
const LINE: usize = 8;
/// Guard after each list of an answer during a call: a NaN that no arithmetic makes.
const GUARD: u64 = 0x7ff4_dead_beef_0001;

/// A call, or its answer.
#[repr(C, align(64))]
pub struct Message {
    numbers: [f64; NUMBERS],
    /// Bytes of each list.
    lengths: [u32; LISTS],
    room: [f64; ROOM],
}

/// Writes a call.
pub struct Writer<'t> {
    message: &'t mut Message,
    number: usize,
    list: usize,
    at: usize,
    full: bool,
}

/// Reads a call.
pub struct Reader<'t> {
    message: &'t Message,
    number: usize,
    list: usize,
    at: usize,
}

/// Values of lists.
///
/// # Safety
/// Any bits are a value, there is no padding, and the alignment is not above that of a number.
pub unsafe trait Plain: Copy {}
// SAFETY: numbers.
unsafe impl Plain for f64 {}
// SAFETY: numbers.
unsafe impl Plain for i32 {}
// SAFETY: numbers.
unsafe impl Plain for u8 {}

/// Start of the list after one of `numbers` words.
fn behind(at: usize, numbers: usize) -> usize {
    (at + numbers).next_multiple_of(LINE)
}

impl Message {
    /// A writer from the start.
    pub fn write(&mut self) -> Writer<'_> {
        Writer { message: self, number: 0, list: 0, at: 0, full: false }
    }

    /// A reader from the start.
    pub fn read(&self) -> Reader<'_> {
        Reader { message: self, number: 0, list: 0, at: 0 }
    }
}

impl Writer<'_> {
    /// A number.
    pub fn number(&mut self, value: f64) {
        match self.message.numbers.get_mut(self.number) {
            Some(place) => *place = value,
            None => self.full = true,
        }
        self.number += 1;
    }

    /// A list. Cache lines that are equal already stay as they are, which may be in the cache of the other process.
    pub fn list<T: Plain>(&mut self, values: &[T]) {
        // SAFETY: plain values are bytes without gaps.
        let from = unsafe { values.align_to::<u8>() }.1;
        let words = from.len().div_ceil(size_of::<f64>());
        let place = self.message.room.get_mut(self.at..self.at + words);
        let (Some(place), Some(length)) = (place, self.message.lengths.get_mut(self.list)) else {
            self.full = true;
            return;
        };
        if *length != from.len() as u32 {
            *length = from.len() as u32;
        }
        // SAFETY: as above.
        let to = &mut unsafe { place.align_to_mut::<u8>() }.1[..from.len()];
        let ((to, last), (from, rest)) = (to.as_chunks_mut::<64>(), from.as_chunks::<64>());
        for (to, from) in to.iter_mut().zip(from) {
            if to != from {
                *to = *from;
            }
        }
        if last != rest {
            last.copy_from_slice(rest);
        }
        self.list += 1;
        self.at = behind(self.at, words);
    }

    /// Ends the call.
    ///
    /// # Errors
    /// If the call exceeds the shared memory.
    pub fn end(self) -> Result<(), LoadFailure> {
        let words = || format!("its arguments take more than the {} MB that two processes share", ROOM >> 17);
        if self.full { Err(LoadFailure::new(words())) } else { Ok(()) }
    }
}

impl<'t> Reader<'t> {
    /// A number.
    pub fn number(&mut self) -> f64 {
        self.number += 1;
        self.message.numbers.get(self.number - 1).copied().unwrap_or_default()
    }

    /// A list.
    pub fn list<T: Plain>(&mut self) -> &'t [T] {
        let bytes = self.message.lengths.get(self.list).map_or(0, |bytes| *bytes as usize);
        let words = bytes.div_ceil(size_of::<f64>());
        let place = self.message.room.get(self.at..self.at + words).unwrap_or_default();
        self.list += 1;
        self.at = behind(self.at, words);
        // SAFETY: any bits are plain values, which are no further apart than numbers.
        unsafe { place.align_to::<T>() }.1.get(..bytes / size_of::<T>()).unwrap_or_default()
    }

    /// Copies a list.
    pub fn take(&mut self, to: &mut [f64]) {
        let from = self.list();
        let count = from.len().min(to.len());
        to[..count].copy_from_slice(&from[..count]);
    }
}

/// A value in a message, read in the order of writing.
pub trait Field<'m>: Sized {
    fn put(&self, to: &mut Writer<'_>);
    fn get(from: &mut Reader<'m>) -> Self;
}

/// Writes values one after the other.
macro_rules! put {
    ($to:expr; $($value:expr),*) => {{ $($crate::user::native::isolate::message::Field::put(&$value, $to);)* }};
}

/// Reads variables in the same order.
macro_rules! get {
    ($from:expr; $($name:ident),*) => { $(let $name = $crate::user::native::isolate::message::Field::get($from);)* };
}
pub(super) use {get, put};

/// Types of fields, with how they are written and read.
macro_rules! fields {
    ($($type:ty: |$value:ident, $to:ident| $put:expr, |$from:ident| $get:expr;)*) => {$(
        impl<'m> Field<'m> for $type {
            fn put(&self, $to: &mut Writer<'_>) {
                let $value = *self;
                $put
            }

            fn get($from: &mut Reader<'m>) -> Self {
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

impl<'m, T: Field<'m>, const N: usize> Field<'m> for [T; N] {
    fn put(&self, to: &mut Writer<'_>) {
        self.iter().for_each(|value| value.put(to));
    }

    fn get(from: &mut Reader<'m>) -> Self {
        std::array::from_fn(|_| T::get(from))
    }
}

/// Lists that a routine writes into, with guards behind them: writing past the end of one does no harm, and is detected.
#[derive(Default)]
pub struct Answers {
    room: Vec<f64>,
    lengths: Vec<usize>,
}

impl Answers {
    /// The lists of a message, as they were before the call.
    pub fn take<const N: usize>(&mut self, from: &mut Reader<'_>) -> [&mut [f64]; N] {
        let before: [&[f64]; N] = Field::get(from);
        self.lengths.clear();
        self.lengths.extend(before.iter().map(|list| list.len()));
        let all: usize = self.lengths.iter().map(|length| length + LINE).sum();
        self.room.resize(self.room.len().max(all), 0.0);
        let mut rest = &mut self.room[..all];
        before.map(|before| {
            let (list, behind) = std::mem::take(&mut rest).split_at_mut(before.len());
            let (guard, behind) = behind.split_at_mut(LINE);
            list.copy_from_slice(before);
            guard.fill(f64::from_bits(GUARD));
            rest = behind;
            list
        })
    }

    /// Writes all lists; returns the index of the first that was exceeded.
    pub fn write(&self, writer: &mut Writer<'_>) -> Option<usize> {
        let (mut at, mut overrun) = (0, None);
        for (place, length) in self.lengths.iter().enumerate() {
            let (list, guard) = (&self.room[at..at + length], &self.room[at + length..at + length + LINE]);
            if guard.iter().any(|number| number.to_bits() != GUARD) {
                overrun.get_or_insert(place);
            }
            writer.list(list);
            at += length + LINE;
        }
        overrun
    }
}

#[cfg(test)]
mod tests {
    use super::{Answers, Field as _, Message, ROOM};
    use crate::state::Instant;

    fn message() -> Box<Message> {
        // SAFETY: zeros are such memory.
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
            let mut to = [7.0; 4];
            reader.take(&mut to);
            assert_eq!((to[0], to[3], u64::get(&mut reader)), (1.0, 7.0, u64::MAX));
        }
        message.write().list(&numbers);
        message.write().list(&[3.0]);
        assert_eq!(message.read().list::<f64>(), [3.0]);
    }

    #[test]
    fn what_has_no_room_is_told() {
        let mut message = message();
        let mut writer = message.write();
        writer.list(&vec![1.0; ROOM]);
        writer.list(&[1.0]);
        let told = writer.end().expect_err("no room").reason;
        assert!(told.contains("16 MB"), "{told}");
    }

    #[test]
    fn what_is_written_past_a_list_is_noticed() {
        let (mut call, mut message, mut answers) = (message(), message(), Answers::default());
        let mut writer = call.write();
        writer.list(&[0.0; 3]);
        writer.list(&[0.0; 2]);
        let [a, b] = answers.take(&mut call.read());
        (a[0], b[1]) = (1.0, 2.0);
        assert_eq!(answers.write(&mut message.write()), None);
        answers.room[3 + 8 + 2] = f64::NAN;
        assert_eq!(answers.write(&mut message.write()), Some(1));
        let mut reader = message.read();
        assert_eq!((reader.list::<f64>()[0], reader.list::<f64>()[1]), (1.0, 2.0));
    }
}
