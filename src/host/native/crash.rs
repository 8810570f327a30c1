//! User subroutines that crash or end the process: a message about the call, then an immediate exit.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::call::report_failure;
use super::{guard, stack};

/// Installs the exit and signal handlers, which name the user subroutine that was running. Only the first call has an
/// effect.
pub fn watch() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        guard::watch();
        stack::enlarge();
        // SAFETY: the handlers only read a thread-local pointer and write to standard error.
        unsafe {
            libc::atexit(at_exit);
            for signal in [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGABRT] {
                let mut action: libc::sigaction = std::mem::zeroed();
                action.sa_sigaction = on_signal as *const () as usize;
                action.sa_flags = libc::SA_ONSTACK | libc::SA_NODEFER | libc::SA_SIGINFO;
                libc::sigaction(signal, &action, std::ptr::null_mut());
            }
        }
    });
}

/// Whether a subroutine has been called: memory that it damaged may be detected later, when it is freed.
static CALLED: AtomicBool = AtomicBool::new(false);

/// Records that a subroutine is called.
#[inline]
pub fn note_call() {
    stack::prepare();
    CALLED.store(true, Ordering::Relaxed);
}

/// Message about damaged memory.
const DAMAGED: &[u8] =
    b"error: the memory of the process is damaged, probably by a user subroutine that wrote past one of its \
arrays; --check-user finds indices out of bounds, but not in arrays that are declared with `*`: declare \
stateNew(nblock,nstatev), not stateNew(nblock,*)\n";

/// Whether a subroutine may have damaged memory, so that a later signal is attributed to it.
static HURT: AtomicBool = AtomicBool::new(false);

/// The thread whose signal is reported; 0 before the first signal.
static REPORTING: AtomicUsize = AtomicUsize::new(0);

/// Milliseconds for the report of another thread.
const REPORT: u32 = 5000;

/// Makes this thread the one whose signal is reported. Of threads that crash together, the first one reports and ends the process,
/// and the others wait for it. A second crash of the first thread, in its report, ends the process: its memory is damaged.
fn begin_report() {
    // SAFETY: system calls that are safe in a signal handler.
    unsafe {
        let own = libc::pthread_self() as usize;
        let Err(first) = REPORTING.compare_exchange(0, own, Ordering::SeqCst, Ordering::SeqCst) else { return };
        if first == own {
            libc::write(2, DAMAGED.as_ptr().cast(), DAMAGED.len());
        } else {
            (0..REPORT).for_each(|_| {
                libc::usleep(1000);
            });
        }
        guard::end(1)
    }
}

/// Exits after a user subroutine halted the run, without destructors of Rust: the subroutine may have damaged memory that
/// they would use. Exit handlers of its libraries, which close its files, run; a crash of one ends the process silently.
pub fn leave(status: u8) -> ! {
    HURT.store(true, Ordering::Relaxed);
    std::process::exit(status.into())
}

extern "C" fn at_exit() {
    // A process forked by a subroutine may end in any way.
    if guard::is_own_process() && report_failure("ended the process") {
        HURT.store(true, Ordering::Relaxed);
        // SAFETY: in the C library, a nested exit runs the remaining handlers, which close the files of the subroutine,
        // and ends the process with the new status.
        unsafe { libc::exit(1) }
    }
}

extern "C" fn on_signal(signal: c_int, info: *mut libc::siginfo_t, context: *mut libc::ucontext_t) {
    begin_report();
    let what = match signal {
        // SAFETY: the system passes both.
        libc::SIGSEGV | libc::SIGBUS if unsafe { stack::has_overflowed(&*info, &*context) } => stack::OVERFLOW,
        libc::SIGSEGV | libc::SIGBUS => "accessed invalid memory (an array index out of bounds? --check-user finds it)",
        libc::SIGFPE => "divided an integer by zero",
        libc::SIGABRT => "aborted",
        _ => "executed an illegal instruction",
    };
    // SAFETY: all calls are safe in a signal handler.
    unsafe {
        if report_failure(what) || HURT.load(Ordering::Relaxed) {
            guard::end(1);
        }
        if CALLED.load(Ordering::Relaxed) {
            libc::write(2, DAMAGED.as_ptr().cast(), DAMAGED.len());
            guard::end(1);
        }
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}
