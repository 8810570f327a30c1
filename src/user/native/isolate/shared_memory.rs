//! Memory shared by two processes that take turns: one writes a call, the other answers it.
//! Never here: the content of calls, processes.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering, fence};

use super::super::call::FailureText;
use super::message::Message;

/// Checks of the turn before a process sleeps: about ten microseconds, longer than a small routine takes.
const LOOKS: u32 = 1000;
/// Nanoseconds of sleep after which a process checks whether the other is running.
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

/// Purpose of a turn that calls a routine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    Load,
    Amplitude,
    Motion,
    Material,
    Hardening,
    Lengths,
    Moment,
    RestartFollows,
}

/// Purpose of a turn for a request over the stream,
pub const REQUEST: u32 = 100;
/// and of the last one, which ends the process.
pub const LEAVE: u32 = 101;

/// Purposes of calls in order, with the names of the routines.
const PURPOSES: [(Purpose, &str); 8] = [
    (Purpose::Load, "vdload"),
    (Purpose::Amplitude, "vuamp"),
    (Purpose::Motion, "vdisp"),
    (Purpose::Material, "vumat"),
    (Purpose::Hardening, "vuhard"),
    (Purpose::Lengths, "vucharlength"),
    (Purpose::Moment, "vexternaldb"),
    (Purpose::RestartFollows, "vexternaldb"),
];

impl Purpose {
    /// The purpose of a turn, if it calls a routine.
    pub fn of(turn: u32) -> Option<Purpose> {
        PURPOSES.get(turn as usize).map(|(purpose, _)| *purpose)
    }

    /// Name of the routine.
    pub fn routine(self) -> &'static str {
        PURPOSES[self as usize].1
    }
}

/// One call and its answer in the memory.
#[repr(C, align(64))]
pub struct Exchange {
    /// Purpose of the turn.
    pub purpose: u32,
    /// Index of the point that caused a failure, or -1.
    pub point: i32,
    /// Reason of a failure; empty without one.
    pub failure: FailureText,
    /// Arguments.
    pub call: Message,
    /// Answer.
    pub answer: Message,
}

/// A number with a cache line of its own.
#[repr(C, align(64))]
struct CacheLine(AtomicU32);

#[repr(C)]
struct Layout {
    turn: CacheLine,
    /// Whether each side sleeps.
    sleeps: [CacheLine; 2],
    /// The core of each side when it last handed the turn over.
    cores: [CacheLine; 2],
    content: UnsafeCell<Exchange>,
}

/// The shared memory, mapped until the process ends.
#[derive(Clone, Copy)]
pub struct SharedMemory(NonNull<Layout>);

// SAFETY: turns are atomic; the content is looked at by the side whose turn it is.
unsafe impl Send for SharedMemory {}
// SAFETY: as above.
unsafe impl Sync for SharedMemory {}

impl SharedMemory {
    /// Memory of zeros, shared with forked processes; it is the caller's turn.
    ///
    /// # Errors
    /// That of the system.
    pub fn new() -> io::Result<SharedMemory> {
        // Of the room for arguments no more is taken than calls fill.
        let shared = libc::MAP_SHARED | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
        let (protection, flags) = (libc::PROT_READ | libc::PROT_WRITE, shared);
        // SAFETY: new memory, wherever the system likes.
        let at = unsafe { libc::mmap(std::ptr::null_mut(), size_of::<Layout>(), protection, flags, -1, 0) };
        if at == libc::MAP_FAILED {
            Err(io::Error::last_os_error())
        } else {
            Ok(SharedMemory(NonNull::new(at.cast()).ok_or(io::ErrorKind::OutOfMemory)?))
        }
    }

    fn layout(&self) -> &Layout {
        // SAFETY: mapped until the process ends; zeros are such memory.
        unsafe { self.0.as_ref() }
    }

    /// Address of the reason of a failure, for a process that ends in a call.
    pub fn failure(&self) -> *mut FailureText {
        // SAFETY: a place in memory that is mapped; nothing is read.
        unsafe { &raw mut (*self.layout().content.get()).failure }
    }

    /// Accesses the content, during one's turn or after the other process has ended.
    pub fn with<R>(&self, look: impl FnOnce(&mut Exchange) -> R) -> R {
        // SAFETY: the other side waits for its turn, or is gone; all bit patterns are such content.
        look(unsafe { &mut *self.layout().content.get() })
    }

    /// Gives the turn to a side, and wakes it if it sleeps.
    pub fn hand_to(&self, side: Side) {
        let layout = self.layout();
        layout.cores[1 - side as usize].0.store(core(), Ordering::Relaxed);
        layout.turn.0.store(side as u32, Ordering::Release);
        // The other side says that it sleeps, then checks the turn; this one gives the turn, then checks whether the other sleeps.
        fence(Ordering::SeqCst);
        if layout.sleeps[side as usize].0.load(Ordering::Relaxed) != 0 {
            futex(&layout.turn.0, libc::FUTEX_WAKE, 1, None);
        }
    }

    /// Waits for one's turn; `false` once the other side has ended, which is checked now and then.
    pub fn wait(&self, side: Side, mut other_is_there: impl FnMut() -> bool) -> bool {
        let layout = self.layout();
        let mine = || layout.turn.0.load(Ordering::Acquire) == side as u32;
        // On one core a turn begins only when the other side sleeps.
        let alone = layout.cores[1 - side as usize].0.load(Ordering::Relaxed) != core();
        for _ in 0..if alone { LOOKS } else { 0 } {
            if mine() {
                return true;
            }
            std::hint::spin_loop();
        }
        let sleeps = &layout.sleeps[side as usize].0;
        sleeps.store(1, Ordering::Relaxed);
        fence(Ordering::SeqCst);
        let other = 1 - side as u32;
        while !mine() && (futex(&layout.turn.0, libc::FUTEX_WAIT, other, Some(NAP)) || other_is_there()) {}
        sleeps.store(0, Ordering::Relaxed);
        mine()
    }
}

/// The core of this thread.
fn core() -> u32 {
    // SAFETY: asks the system.
    unsafe { libc::sched_getcpu() as u32 }
}

/// Sleeps while the number has the value, or wakes that many; `false` after the time limit.
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

    use super::{SharedMemory, Side};

    /// Also if one of the two sleeps before its turn.
    #[test]
    fn turns_go_to_and_fro() {
        let memory = SharedMemory::new().expect("memory");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for turn in 0..2000 {
                    assert!(memory.wait(Side::Routines, || true));
                    memory.with(|content| {
                        assert_eq!(content.point, turn);
                        content.answer.write().list(&[f64::from(turn); 10]);
                    });
                    if turn % 700 == 3 {
                        std::thread::sleep(Duration::from_millis(30));
                    }
                    memory.hand_to(Side::Caller);
                }
            });
            for turn in 0..2000 {
                memory.with(|content| content.point = turn);
                memory.hand_to(Side::Routines);
                assert!(memory.wait(Side::Caller, || true));
                assert!(memory.with(|content| content.answer.read().list::<f64>()[9]) == f64::from(turn));
            }
        });
    }

    #[test]
    fn a_side_that_is_gone_is_noticed() {
        let memory = SharedMemory::new().expect("memory");
        memory.hand_to(Side::Routines);
        let mut asked = 0;
        let there = memory.wait(Side::Caller, || {
            asked += 1;
            asked < 3
        });
        assert!(!there && asked == 3);
    }
}
