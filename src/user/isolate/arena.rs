//! Memory that two processes share, and whose turn it is there: one writes a call, the other answers it.
//! Never here: what a call means, processes.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering, fence};

use super::super::MAX_BLOCK;
use super::super::call::Words;

/// Looks at the turn before a process lies down: some ten microseconds, longer than a small routine takes.
const LOOKS: u32 = 1000;
/// Nanoseconds after which one that lies looks whether the other is still there.
const NAP: i64 = 20_000_000;

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// The run.
    Caller = 0,
    /// The routines.
    Routines = 1,
}

/// A turn for a call of `vdload`,
pub const PRESSURE: u32 = 1;
/// one for something that comes over the stream,
pub const ASK: u32 = 2;
/// and the last one: the routines are not needed any more.
pub const LEAVE: u32 = 3;

/// What stands in the memory: one call and its answer, of `vdload`.
#[repr(C, align(64))]
pub struct Content {
    /// What the turn is for.
    pub purpose: u32,
    /// Points.
    pub count: u32,
    /// `jltyp`.
    pub load_type: i32,
    /// Number of the step.
    pub step: u32,
    /// Increments behind.
    pub increment: u64,
    /// Step time, total time, and what rounding has taken from the first.
    pub times: [f64; 3],
    /// The amplitude's value, and the magnitude.
    pub factors: [f64; 2],
    /// Bytes of the name, and they.
    pub name_length: u32,
    /// The point to blame from 0, or -1.
    pub point: i32,
    /// The name of the surface.
    pub name: [u8; 512],
    /// Why the call failed; empty where it did not.
    pub words: Words,
    /// `curCoords`.
    pub coordinates: Slab<{ 3 * MAX_BLOCK }>,
    /// `velocity`.
    pub motion: Slab<{ 6 * MAX_BLOCK }>,
    /// `dirCos`.
    pub directions: Slab<{ 9 * MAX_BLOCK }>,
    /// The answer.
    pub value: Slab<MAX_BLOCK>,
}

/// Numbers from the beginning of a cache line on.
#[repr(C, align(64))]
pub struct Slab<const N: usize>(pub [f64; N]);

impl<const N: usize> Slab<N> {
    /// Takes numbers over; cache lines that hold them already stay where they are, which may be with the other process.
    pub fn update(&mut self, from: &[f64]) {
        let count = from.len().min(N);
        for (to, from) in self.0[..count].chunks_mut(8).zip(from[..count].chunks(8)) {
            let differ = to.iter().zip(from).fold(0, |differ, (a, b)| differ | (a.to_bits() ^ b.to_bits()));
            if differ != 0 {
                to.copy_from_slice(from);
            }
        }
    }
}

/// A number with a cache line of its own.
#[repr(C, align(64))]
struct Line(AtomicU32);

#[repr(C)]
struct Memory {
    turn: Line,
    /// Whether each side lies.
    lies: [Line; 2],
    /// The core on which each side was when it gave its turn away.
    cores: [Line; 2],
    content: UnsafeCell<Content>,
}

/// The memory, as one process sees it. It stays until the process ends.
#[derive(Clone, Copy)]
pub struct Arena(NonNull<Memory>);

// SAFETY: turns are atomic; the content is looked at by the side whose turn it is.
unsafe impl Send for Arena {}
// SAFETY: as above.
unsafe impl Sync for Arena {}

impl Arena {
    /// Memory of zeros, which a child of this process shares; it is the caller's turn.
    ///
    /// # Errors
    /// That of the system.
    pub fn new() -> io::Result<Arena> {
        let (protection, flags) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_SHARED | libc::MAP_ANONYMOUS);
        // SAFETY: new memory, wherever the system likes.
        let at = unsafe { libc::mmap(std::ptr::null_mut(), size_of::<Memory>(), protection, flags, -1, 0) };
        if at == libc::MAP_FAILED {
            Err(io::Error::last_os_error())
        } else {
            Ok(Arena(NonNull::new(at.cast()).ok_or(io::ErrorKind::OutOfMemory)?))
        }
    }

    fn memory(&self) -> &Memory {
        // SAFETY: mapped until the process ends; zeros are such memory.
        unsafe { self.0.as_ref() }
    }

    /// Where the words of a process are that goes.
    pub fn words(&self) -> *mut Words {
        // SAFETY: a place in memory that is mapped; nothing is read.
        unsafe { &raw mut (*self.memory().content.get()).words }
    }

    /// Looks at the content, on one's turn, or when the other side is gone.
    pub fn with<R>(&self, look: impl FnOnce(&mut Content) -> R) -> R {
        // SAFETY: the other side waits for its turn, or is gone; all bit patterns are such content.
        look(unsafe { &mut *self.memory().content.get() })
    }

    /// Gives the turn to a side, and wakes it if it lies.
    pub fn hand_to(&self, side: Side) {
        let memory = self.memory();
        memory.cores[1 - side as usize].0.store(core(), Ordering::Relaxed);
        memory.turn.0.store(side as u32, Ordering::Release);
        // The other side says that it lies, then looks at the turn; this one gives the turn, then looks whether it lies.
        fence(Ordering::SeqCst);
        if memory.lies[side as usize].0.load(Ordering::Relaxed) != 0 {
            futex(&memory.turn.0, libc::FUTEX_WAKE, 1, None);
        }
    }

    /// Waits for one's turn; `false` once the other side is gone, which is asked now and then.
    pub fn wait(&self, side: Side, mut other_is_there: impl FnMut() -> bool) -> bool {
        let memory = self.memory();
        let mine = || memory.turn.0.load(Ordering::Acquire) == side as u32;
        // Of two on one core neither comes to its turn before the other lies.
        let alone = memory.cores[1 - side as usize].0.load(Ordering::Relaxed) != core();
        for _ in 0..if alone { LOOKS } else { 0 } {
            if mine() {
                return true;
            }
            std::hint::spin_loop();
        }
        let lies = &memory.lies[side as usize].0;
        lies.store(1, Ordering::Relaxed);
        fence(Ordering::SeqCst);
        let other = 1 - side as u32;
        while !mine() && (futex(&memory.turn.0, libc::FUTEX_WAIT, other, Some(NAP)) || other_is_there()) {}
        lies.store(0, Ordering::Relaxed);
        mine()
    }
}

/// The core on which this thread is.
fn core() -> u32 {
    // SAFETY: asks the system.
    unsafe { libc::sched_getcpu() as u32 }
}

/// Lies down while the number is that, or wakes so many; `false` if the time was over.
fn futex(number: &AtomicU32, operation: i32, value: u32, nanoseconds: Option<i64>) -> bool {
    let time = nanoseconds.map(|tv_nsec| libc::timespec { tv_sec: 0, tv_nsec });
    let time = time.as_ref().map_or(std::ptr::null(), std::ptr::from_ref);
    // SAFETY: a number in memory that both processes have mapped; the time is there while the call lasts.
    let done = unsafe { libc::syscall(libc::SYS_futex, number.as_ptr(), operation, value, time) };
    done >= 0 || io::Error::last_os_error().raw_os_error() != Some(libc::ETIMEDOUT)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{Arena, Side};

    /// Also where one of the two lies down before its turn comes.
    #[test]
    fn turns_go_to_and_fro() {
        let arena = Arena::new().expect("memory");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for turn in 0..2000 {
                    assert!(arena.wait(Side::Routines, || true));
                    arena.with(|content| {
                        assert_eq!(content.count, turn);
                        content.value.0[..10].fill(f64::from(turn));
                    });
                    if turn % 700 == 3 {
                        std::thread::sleep(Duration::from_millis(30));
                    }
                    arena.hand_to(Side::Caller);
                }
            });
            for turn in 0..2000_u32 {
                arena.with(|content| content.count = turn);
                arena.hand_to(Side::Routines);
                assert!(arena.wait(Side::Caller, || true));
                assert!(arena.with(|content| content.value.0[9]) == f64::from(turn));
            }
        });
    }

    #[test]
    fn a_side_that_is_gone_is_noticed() {
        let arena = Arena::new().expect("memory");
        arena.hand_to(Side::Routines);
        let mut asked = 0;
        let there = arena.wait(Side::Caller, || {
            asked += 1;
            asked < 3
        });
        assert!(!there && asked == 3);
    }

    #[test]
    fn arguments_arrive_bit_by_bit() {
        let arena = Arena::new().expect("memory");
        let numbers = [1.0, -0.0, f64::from_bits(0x7ff4_0000_0000_0001), 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
        arena.with(|content| {
            content.motion.update(&[0.0; 10]);
            content.motion.update(&numbers);
            assert!(content.motion.0[..10].iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
            content.motion.update(&[3.0]);
            assert_eq!(
                content.motion.0[..2].iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
                [3.0, -0.0].map(f64::to_bits)
            );
        });
    }
}
