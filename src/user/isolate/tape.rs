//! A call in shared memory: numbers, and lists one behind the other, each from a cache line on. Written in the order in which
//! they are read.
//! Never here: whose turn it is, what a call means.
#![allow(unsafe_code)]

use super::super::LoadFailure;
use crate::state::Instant;

/// Numbers beside lists, lists, and words of 8 bytes in lists that a call may have.
const NUMBERS: usize = 32;
const LISTS: usize = 32;
const ROOM: usize = 1 << 21;
/// Numbers of a cache line.
const LINE: usize = 8;
/// What stands behind each list of an answer while the routine works: a NaN that no arithmetic makes.
const GUARD: u64 = 0x7ff4_dead_beef_0001;

/// A call, or its answer.
#[repr(C, align(64))]
pub struct Tape {
    numbers: [f64; NUMBERS],
    /// Bytes of each list.
    lengths: [u32; LISTS],
    room: [f64; ROOM],
}

/// Writes a call.
pub struct Writer<'t> {
    tape: &'t mut Tape,
    number: usize,
    list: usize,
    at: usize,
    full: bool,
}

/// Reads a call.
pub struct Reader<'t> {
    tape: &'t Tape,
    number: usize,
    list: usize,
    at: usize,
}

/// Takes numbers over; cache lines that hold them already stay where they are, which may be with the other process.
fn update(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.chunks_mut(LINE).zip(from.chunks(LINE)) {
        let differ = to.iter().zip(from).fold(0, |differ, (a, b)| differ | (a.to_bits() ^ b.to_bits()));
        if differ != 0 {
            to.copy_from_slice(from);
        }
    }
}

/// The same for what seldom changes.
fn keep_or_copy<T: Copy + PartialEq>(to: &mut [T], from: &[T]) {
    if to != from {
        to.copy_from_slice(from);
    }
}

/// Where the list behind one of so many numbers begins.
fn behind(at: usize, numbers: usize) -> usize {
    (at + numbers).next_multiple_of(LINE)
}

impl Tape {
    /// Begins to write.
    pub fn write(&mut self) -> Writer<'_> {
        Writer { tape: self, number: 0, list: 0, at: 0, full: false }
    }

    /// Begins to read.
    pub fn read(&self) -> Reader<'_> {
        Reader { tape: self, number: 0, list: 0, at: 0 }
    }
}

impl Writer<'_> {
    /// A number.
    pub fn number(&mut self, value: f64) {
        match self.tape.numbers.get_mut(self.number) {
            Some(place) => *place = value,
            None => self.full = true,
        }
        self.number += 1;
    }

    /// A whole number.
    pub fn whole(&mut self, value: u64) {
        self.number(f64::from_bits(value));
    }

    /// Clock, step and increment.
    pub fn instant(&mut self, now: &Instant) {
        [now.step_time, now.total_time, now.lost].into_iter().for_each(|time| self.number(time));
        self.whole(u64::from(now.step));
        self.whole(now.increment);
    }

    /// What calls for elements begin with: time, increment, counts, a name, and numbers of elements.
    pub fn elements(&mut self, now: &Instant, dt: f64, counts: &[usize], name: &str, elements: &[i32]) {
        self.instant(now);
        self.number(dt);
        counts.iter().for_each(|count| self.whole(*count as u64));
        self.text(name);
        self.integers(elements);
    }

    /// A list of numbers.
    pub fn list(&mut self, values: &[f64]) {
        if let Some(to) = self.place(values.len(), size_of_val(values)) {
            update(to, values);
        }
    }

    /// A list of integers.
    pub fn integers(&mut self, values: &[i32]) {
        if let Some(to) = self.place(values.len().div_ceil(2), size_of_val(values)) {
            // SAFETY: integers may have any bits, and lie no closer than numbers.
            keep_or_copy(&mut unsafe { to.align_to_mut::<i32>() }.1[..values.len()], values);
        }
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        if let Some(to) = self.place(text.len().div_ceil(LINE), text.len()) {
            // SAFETY: as for integers.
            keep_or_copy(&mut unsafe { to.align_to_mut::<u8>() }.1[..text.len()], text.as_bytes());
        }
    }

    fn place(&mut self, numbers: usize, bytes: usize) -> Option<&mut [f64]> {
        let place = self.tape.room.get_mut(self.at..self.at + numbers);
        match (place, self.tape.lengths.get_mut(self.list)) {
            (Some(place), Some(length)) => {
                if *length != bytes as u32 {
                    *length = bytes as u32;
                }
                self.list += 1;
                self.at = behind(self.at, numbers);
                Some(place)
            }
            _ => {
                self.full = true;
                None
            }
        }
    }

    /// The call is written.
    ///
    /// # Errors
    /// Where there was no room for it.
    pub fn end(self) -> Result<(), LoadFailure> {
        let words = || format!("its arguments take more than the {} MB that two processes share", ROOM >> 17);
        if self.full { Err(LoadFailure::new(words())) } else { Ok(()) }
    }
}

impl<'t> Reader<'t> {
    /// A number.
    pub fn number(&mut self) -> f64 {
        self.number += 1;
        self.tape.numbers.get(self.number - 1).copied().unwrap_or_default()
    }

    /// A whole number.
    pub fn whole(&mut self) -> u64 {
        self.number().to_bits()
    }

    /// Clock, step and increment.
    pub fn instant(&mut self) -> Instant {
        let [step_time, total_time, lost] = [(); 3].map(|()| self.number());
        Instant { step_time, total_time, lost, step: self.whole() as u32, increment: self.whole() }
    }

    /// What calls for elements begin with.
    pub fn elements<const N: usize>(&mut self) -> (Instant, f64, [usize; N], &'t str, &'t [i32]) {
        let (now, dt) = (self.instant(), self.number());
        let counts = [(); N].map(|()| self.whole() as usize);
        (now, dt, counts, self.text(), self.integers())
    }

    fn bytes(&mut self, each: usize) -> (&'t [f64], usize) {
        let bytes = self.tape.lengths.get(self.list).map_or(0, |bytes| *bytes as usize);
        let numbers = bytes.div_ceil(size_of::<f64>());
        let place = self.tape.room.get(self.at..self.at + numbers).unwrap_or_default();
        self.list += 1;
        self.at = behind(self.at, numbers);
        (place, bytes / each)
    }

    /// A list of numbers.
    pub fn list(&mut self) -> &'t [f64] {
        self.bytes(size_of::<f64>()).0
    }

    /// A list of integers.
    pub fn integers(&mut self) -> &'t [i32] {
        let (place, count) = self.bytes(size_of::<i32>());
        // SAFETY: integers may have any bits, and lie no closer than numbers.
        unsafe { place.align_to::<i32>() }.1.get(..count).unwrap_or_default()
    }

    /// A text.
    pub fn text(&mut self) -> &'t str {
        let (place, count) = self.bytes(1);
        // SAFETY: as for integers.
        let bytes = unsafe { place.align_to::<u8>() }.1.get(..count).unwrap_or_default();
        std::str::from_utf8(bytes).unwrap_or_default()
    }

    /// Takes an answer over.
    pub fn take(&mut self, to: &mut [f64]) {
        let from = self.list();
        let count = from.len().min(to.len());
        to[..count].copy_from_slice(&from[..count]);
    }
}

/// Lists that a routine writes into, with guards behind them: what it writes past one stays without harm, and is told.
#[derive(Default)]
pub struct Answers {
    room: Vec<f64>,
    lengths: Vec<usize>,
}

impl Answers {
    /// Lists of these lengths, as they were left.
    pub fn lists<const N: usize>(&mut self, lengths: [usize; N]) -> [&mut [f64]; N] {
        self.lengths.clear();
        self.lengths.extend(lengths);
        let all: usize = lengths.iter().map(|length| length + LINE).sum();
        self.room.resize(self.room.len().max(all), 0.0);
        let mut rest = &mut self.room[..all];
        lengths.map(|length| {
            let (list, behind) = std::mem::take(&mut rest).split_at_mut(length);
            let (guard, behind) = behind.split_at_mut(LINE);
            guard.fill(f64::from_bits(GUARD));
            rest = behind;
            list
        })
    }

    /// Writes them all; the place of the first that something was written past.
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
    use super::{Answers, ROOM, Tape};
    use crate::state::Instant;

    fn tape() -> Box<Tape> {
        // SAFETY: zeros are such memory.
        unsafe { Box::new_zeroed().assume_init() }
    }

    #[test]
    fn arguments_arrive_bit_by_bit() {
        let mut tape = tape();
        let numbers = [1.0, -0.0, f64::from_bits(0x7ff4_0000_0000_0001), 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
        let now = Instant { step_time: 1.0, total_time: 2.0, step: 3, increment: 4, lost: 5.0 };
        for _ in 0..2 {
            let mut writer = tape.write();
            writer.instant(&now);
            writer.list(&numbers);
            writer.list(&[]);
            writer.text("PLATE");
            writer.integers(&[1, -2, 3]);
            writer.list(&numbers[..3]);
            writer.whole(u64::MAX);
            assert!(writer.end().is_ok());
            let mut reader = tape.read();
            assert_eq!(reader.instant(), now);
            assert!(reader.list().iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
            assert_eq!((reader.list().len(), reader.text(), reader.integers()), (0, "PLATE", &[1, -2, 3][..]));
            let mut to = [7.0; 4];
            reader.take(&mut to);
            assert_eq!((to[0], to[3], reader.whole()), (1.0, 7.0, u64::MAX));
        }
        tape.write().list(&numbers);
        tape.write().list(&[3.0]);
        assert_eq!(tape.read().list(), [3.0]);
    }

    #[test]
    fn what_has_no_room_is_told() {
        let mut tape = tape();
        let mut writer = tape.write();
        writer.list(&vec![1.0; ROOM]);
        writer.list(&[1.0]);
        let told = writer.end().expect_err("no room").reason;
        assert!(told.contains("16 MB"), "{told}");
    }

    #[test]
    fn what_is_written_past_a_list_is_noticed() {
        let (mut tape, mut answers) = (tape(), Answers::default());
        let [a, b] = answers.lists([3, 2]);
        (a[0], b[1]) = (1.0, 2.0);
        assert_eq!(answers.write(&mut tape.write()), None);
        answers.room[3 + 8 + 2] = f64::NAN;
        assert_eq!(answers.write(&mut tape.write()), Some(1));
        let mut reader = tape.read();
        assert_eq!((reader.list()[0], reader.list()[1]), (1.0, 2.0));
    }
}
