//! Memory that two processes share, and whose turn it is there: one writes a call, the other answers it.
//! Never here: what a call means, processes.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering, fence};

use super::super::call::Words;
use super::tape::Tape;

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

/// What a turn is for that calls a routine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    Load = 1,
    Amplitude,
    Motion,
    Material,
    Hardening,
    Lengths,
    Moment,
    RestartFollows,
}

/// A turn for something that comes over the stream,
pub const ASK: u32 = 100;
/// and the last one: the routines are not needed any more.
pub const LEAVE: u32 = 101;

impl Purpose {
    /// All of them.
    const ALL: [Purpose; 8] = [
        Purpose::Load,
        Purpose::Amplitude,
        Purpose::Motion,
        Purpose::Material,
        Purpose::Hardening,
        Purpose::Lengths,
        Purpose::Moment,
        Purpose::RestartFollows,
    ];

    /// That of a turn, if it calls a routine.
    pub fn of(turn: u32) -> Option<Purpose> {
        Self::ALL.into_iter().find(|purpose| *purpose as u32 == turn)
    }

    /// Name of the routine.
    pub fn routine(self) -> &'static str {
        match self {
            Purpose::Load => "vdload",
            Purpose::Amplitude => "vuamp",
            Purpose::Motion => "vdisp",
            Purpose::Material => "vumat",
            Purpose::Hardening => "vuhard",
            Purpose::Lengths => "vucharlength",
            Purpose::Moment | Purpose::RestartFollows => "vexternaldb",
        }
    }

    /// The lists of its answer, in words.
    pub fn answers(self) -> &'static [&'static str] {
        match self {
            Purpose::Load => &["nblock points of its argument value"],
            Purpose::Amplitude => &["end of its answer", "end of its argument svars"],
            Purpose::Material => &[
                "end of its argument stressNew",
                "end of its argument stateNew",
                "end of its argument enerInternNew",
                "end of its argument enerInelasNew",
            ],
            Purpose::Hardening => &[
                "end of its argument yield",
                "end of its argument dyieldDtemp",
                "end of its argument dyieldDeqps",
                "end of its argument stateNew",
            ],
            Purpose::Lengths => &["end of its argument charLength"],
            Purpose::Motion | Purpose::Moment | Purpose::RestartFollows => &[],
        }
    }
}

/// What stands in the memory: one call and its answer.
#[repr(C, align(64))]
pub struct Content {
    /// What the turn is for.
    pub purpose: u32,
    /// The point to blame from 0, or -1.
    pub point: i32,
    /// Why the call failed; empty where it did not.
    pub words: Words,
    /// Arguments.
    pub call: Tape,
    /// Answer.
    pub answer: Tape,
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
        // Of the room for arguments no more is taken than calls fill.
        let shared = libc::MAP_SHARED | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
        let (protection, flags) = (libc::PROT_READ | libc::PROT_WRITE, shared);
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
                        assert_eq!(content.point, turn);
                        content.answer.write().list(&[f64::from(turn); 10]);
                    });
                    if turn % 700 == 3 {
                        std::thread::sleep(Duration::from_millis(30));
                    }
                    arena.hand_to(Side::Caller);
                }
            });
            for turn in 0..2000 {
                arena.with(|content| content.point = turn);
                arena.hand_to(Side::Routines);
                assert!(arena.wait(Side::Caller, || true));
                assert!(arena.with(|content| content.answer.read().list()[9]) == f64::from(turn));
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
}
