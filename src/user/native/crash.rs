//! Routines that crash or end the process: a message about the call, then an immediate exit.
//! Never here: changes of a process that continues (`guard.rs`).
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use super::call::last_words;
use super::guard;

/// Installs, once in the process, the exit and signal handlers that report the call.
pub fn watch() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        guard::watch();
        // SAFETY: the handlers only read a thread's own pointer and write to standard error.
        unsafe {
            libc::atexit(at_exit);
            for signal in [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGABRT] {
                let mut action: libc::sigaction = std::mem::zeroed();
                action.sa_sigaction = on_signal as *const () as usize;
                action.sa_flags = libc::SA_ONSTACK | libc::SA_RESETHAND | libc::SA_NODEFER;
                libc::sigaction(signal, &action, std::ptr::null_mut());
            }
        }
    });
}

/// Whether a routine has been called: memory that it damaged may be detected later, when it is freed.
static CALLED: AtomicBool = AtomicBool::new(false);

/// Notes that a routine is called.
#[inline]
pub fn note_call() {
    CALLED.store(true, Ordering::Relaxed);
}

/// The message about that.
const DAMAGED: &[u8] =
    b"error: the memory of the process is damaged, most likely by a user's routine that wrote past an array \
of its own; --check-user finds indices out of bounds\n";

/// Whether a routine may have damaged memory, so that a later signal is attributed to it.
static HURT: AtomicBool = AtomicBool::new(false);

/// Exits at once after a routine halted the run, because it may have damaged memory that destructors would use. The output
/// of Fortran is flushed first.
pub fn leave(status: u8) -> ! {
    HURT.store(true, Ordering::Relaxed);
    let _ = std::io::Write::flush(&mut std::io::stdout());
    guard::flush();
    // SAFETY: leaves; what is not tidied up is of no use to anybody.
    unsafe { guard::end(status.into()) }
}

extern "C" fn at_exit() {
    // A child that a routine made may end as it likes.
    if guard::is_own_process() && last_words("ended the process") {
        // SAFETY: leaves without running what the routine interrupted.
        unsafe { guard::end(1) }
    }
}

extern "C" fn on_signal(signal: c_int) {
    let what = match signal {
        libc::SIGSEGV | libc::SIGBUS => "touched memory that is not its own (an array index out of bounds?)",
        libc::SIGFPE => "divided an integer by zero",
        libc::SIGABRT => "aborted",
        _ => "ran into an illegal instruction",
    };
    // SAFETY: both calls are safe in a signal handler; the action is the default one again.
    unsafe {
        if last_words(what) || HURT.load(Ordering::Relaxed) {
            guard::end(1);
        }
        if CALLED.load(Ordering::Relaxed) {
            libc::write(2, DAMAGED.as_ptr().cast(), DAMAGED.len());
            guard::end(1);
        }
        libc::raise(signal);
    }
}
