//! Memory shared by two processes that take turns: one writes a call, the other answers it.
#![allow(unsafe_code)]

use std::cell::UnsafeCell;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering, fence};

use super::super::call::FailureText;
use super::message::CallMessage;

/// Number of checks of the turn before a process sleeps: about 10 µs, longer than a small subroutine takes.
const LOOKS: u32 = 1000;
/// Sleep time in nanoseconds after which a process checks whether the other one is running.
const NAP: i64 = 20_000_000;

/// The two processes that take turns on the shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ProcessSide {
    /// The process of the run, which requests the calls.
    Caller = 0,
    /// The process that executes the user subroutines.
    Routines = 1,
}

/// Purpose of a turn that calls a user subroutine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum TurnPurpose {
    Load,
    Amplitude,
    Motion,
    Material,
    Energy,
    Hardening,
    NodalFields,
    Friction,
    Lengths,
    Moment,
    RestartFollows,
}

/// Purpose of a turn with a request over the stream.
pub const REQUEST: u32 = 100;
/// Purpose of the last turn, which ends the process.
pub const LEAVE: u32 = 101;

/// Purposes of calls in the order of their numbers, with the names of the subroutines.
const PURPOSES: [(TurnPurpose, &str); 11] = [
    (TurnPurpose::Load, "vdload"),
    (TurnPurpose::Amplitude, "vuamp"),
    (TurnPurpose::Motion, "vdisp"),
    (TurnPurpose::Material, "vumat"),
    (TurnPurpose::Energy, "vuanisohyper_inv"),
    (TurnPurpose::Hardening, "vuhard"),
    (TurnPurpose::NodalFields, "vufield"),
    (TurnPurpose::Friction, "vfriction"),
    (TurnPurpose::Lengths, "vucharlength"),
    (TurnPurpose::Moment, "vexternaldb"),
    (TurnPurpose::RestartFollows, "vexternaldb"),
];

impl TurnPurpose {
    /// Returns the purpose of a turn; `None` for a turn that does not call a subroutine.
    pub fn of(turn: u32) -> Option<TurnPurpose> {
        PURPOSES.get(turn as usize).map(|(purpose, _)| *purpose)
    }

    /// Returns the lower-case name of the subroutine.
    pub fn routine(self) -> &'static str {
        PURPOSES[self as usize].1
    }
}

/// One call and its results in shared memory.
#[repr(C, align(64))]
pub struct CallExchange {
    /// Number of the [`TurnPurpose`], or [`REQUEST`] or [`LEAVE`].
    pub purpose: u32,
    /// Index of the point that caused a failure, or -1.
    pub point: i32,
    /// Reason of a failure; empty without one.
    pub failure: FailureText,
    /// Arguments of the subroutine.
    pub call: CallMessage,
    /// Results of the subroutine.
    pub answer: CallMessage,
}

/// A number in its own cache line.
#[repr(C, align(64))]
struct CacheLine(AtomicU32);

#[repr(C)]
struct MemoryLayout {
    turn: CacheLine,
    /// Whether each side sleeps.
    sleeps: [CacheLine; 2],
    /// Processor core of each side when it last handed over the turn.
    cores: [CacheLine; 2],
    content: UnsafeCell<CallExchange>,
}

/// The shared memory, mapped until the process ends.
#[derive(Clone, Copy)]
pub struct SharedMemory(NonNull<MemoryLayout>);

// SAFETY: turns are atomic; only the side whose turn it is accesses the content.
unsafe impl Send for SharedMemory {}
// SAFETY: as above.
unsafe impl Sync for SharedMemory {}

impl SharedMemory {
    /// Allocates zeroed memory that is shared with forked processes; the first turn is the caller's.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn new() -> io::Result<SharedMemory> {
        // MAP_NORESERVE: only the memory that calls use is allocated.
        let shared = libc::MAP_SHARED | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
        let (protection, flags) = (libc::PROT_READ | libc::PROT_WRITE, shared);
        // SAFETY: new memory at an address chosen by the system.
        let address = unsafe { libc::mmap(std::ptr::null_mut(), size_of::<MemoryLayout>(), protection, flags, -1, 0) };
        if address == libc::MAP_FAILED {
            Err(io::Error::last_os_error())
        } else {
            Ok(SharedMemory(NonNull::new(address.cast()).ok_or(io::ErrorKind::OutOfMemory)?))
        }
    }

    fn layout(&self) -> &MemoryLayout {
        // SAFETY: mapped until the process ends; zeros are a valid layout.
        unsafe { self.0.as_ref() }
    }

    /// Returns the address of the failure reason, for a process that ends in a call.
    pub fn failure(&self) -> *mut FailureText {
        // SAFETY: an address in mapped memory; nothing is read.
        unsafe { &raw mut (*self.layout().content.get()).failure }
    }

    /// Accesses the content. It is called when this process has the turn, or after the other process has ended.
    pub fn with<R>(&self, look: impl FnOnce(&mut CallExchange) -> R) -> R {
        // SAFETY: the other side waits for its turn or has ended; all bit patterns are valid.
        look(unsafe { &mut *self.layout().content.get() })
    }

    /// Gives the turn to a side, and wakes it if it sleeps.
    pub fn hand_to(&self, side: ProcessSide) {
        let layout = self.layout();
        layout.cores[1 - side as usize].0.store(core(), Ordering::Relaxed);
        layout.turn.0.store(side as u32, Ordering::Release);
        // The other side sets its sleep flag and then checks the turn; this side sets the turn and then checks the
        // flag.
        fence(Ordering::SeqCst);
        if layout.sleeps[side as usize].0.load(Ordering::Relaxed) != 0 {
            futex(&layout.turn.0, libc::FUTEX_WAKE, 1, None);
        }
    }

    /// Waits for the turn of `side`; `false` if the other process has ended, which is checked periodically.
    pub fn wait(&self, side: ProcessSide, mut other_is_running: impl FnMut() -> bool) -> bool {
        let layout = self.layout();
        let mine = || layout.turn.0.load(Ordering::Acquire) == side as u32;
        // On one core, spinning would only delay the other side.
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
        while !mine() && (futex(&layout.turn.0, libc::FUTEX_WAIT, other, Some(NAP)) || other_is_running()) {}
        sleeps.store(0, Ordering::Relaxed);
        mine()
    }
}

/// Returns the processor core of this thread.
fn core() -> u32 {
    // SAFETY: a system call without side effects.
    unsafe { libc::sched_getcpu() as u32 }
}

/// Sleeps while the number has the value, or wakes `value` sleepers; `false` after the time limit.
fn futex(number: &AtomicU32, operation: i32, value: u32, nanoseconds: Option<i64>) -> bool {
    let time = nanoseconds.map(|tv_nsec| libc::timespec { tv_sec: 0, tv_nsec });
    let time = time.as_ref().map_or(std::ptr::null(), std::ptr::from_ref);
    // SAFETY: the number is in memory that both processes have mapped; the time outlives the call.
    let result = unsafe { libc::syscall(libc::SYS_futex, number.as_ptr(), operation, value, time) };
    result >= 0 || io::Error::last_os_error().raw_os_error() != Some(libc::ETIMEDOUT)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{ProcessSide, SharedMemory};

    /// Turns alternate even if one side sleeps before its turn.
    #[test]
    fn turns_alternate() {
        let memory = SharedMemory::new().expect("memory");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for turn in 0..2000 {
                    assert!(memory.wait(ProcessSide::Routines, || true));
                    memory.with(|content| {
                        assert_eq!(content.point, turn);
                        content.answer.write().list(&[f64::from(turn); 10]);
                    });
                    if turn % 700 == 3 {
                        std::thread::sleep(Duration::from_millis(30));
                    }
                    memory.hand_to(ProcessSide::Caller);
                }
            });
            for turn in 0..2000 {
                memory.with(|content| content.point = turn);
                memory.hand_to(ProcessSide::Routines);
                assert!(memory.wait(ProcessSide::Caller, || true));
                assert!(memory.with(|content| content.answer.read().list::<f64>()[9]) == f64::from(turn));
            }
        });
    }

    #[test]
    fn end_of_the_other_process_is_detected() {
        let memory = SharedMemory::new().expect("memory");
        memory.hand_to(ProcessSide::Routines);
        let mut checks = 0;
        let waiting = memory.wait(ProcessSide::Caller, || {
            checks += 1;
            checks < 3
        });
        assert!(!waiting && checks == 3);
    }
}
