//! What a routine must not leave behind in the process that calls it: another arithmetic, another working folder, a second
//! process that runs the job on, an end without a word. Noticed where it happens, set right when the routine is left.
//! Never here: which routine it was.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ffi::{c_char, c_int};
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::sync::atomic::{AtomicU32, Ordering};

thread_local! {
    /// The working folder before a routine changed it.
    static FOLDER: RefCell<Option<File>> = const { RefCell::new(None) };
    /// Whether there is one, or this is a child.
    static TOUCHED: Cell<bool> = const { Cell::new(false) };
    static CHILD: Cell<bool> = const { Cell::new(false) };
}

/// The process that opened routines; 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Begins to watch this process.
pub fn watch() {
    PROCESS.store(std::process::id(), Ordering::Relaxed);
    // SAFETY: the handler sets flags of the thread that forked.
    unsafe { libc::pthread_atfork(None, None, Some(forked)) };
}

/// Whether this is the process that opened the routines, and no child that one of them made.
pub fn is_own_process() -> bool {
    PROCESS.load(Ordering::Relaxed) == std::process::id()
}

unsafe extern "C" fn forked() {
    if super::library::inside() {
        CHILD.set(true);
        TOUCHED.set(true);
    }
}

/// Sets right what a routine that was left changed, and tells each change; ends a child that came back in its place.
#[inline]
pub fn restore(tell: impl Fn(&str)) {
    if !arithmetic_is_plain() {
        make_arithmetic_plain();
        tell("left another rounding mode, or treatment of small numbers, behind: it is set back after the call");
    }
    if TOUCHED.get() {
        leave_child();
        TOUCHED.set(false);
        let Some(folder) = FOLDER.take() else { return };
        // SAFETY: a folder that is open; by the system's own number, for the name is watched.
        if unsafe { libc::syscall(libc::SYS_fchdir, folder.as_raw_fd()) } == 0 {
            tell("changed the working folder of the process: it is set back after the call");
        } else {
            tell("changed the working folder of the process, and it cannot be set back");
        }
    }
}

/// A copy of the process would write the results a second time.
#[cold]
fn leave_child() {
    const WORDS: &[u8] = b"note: a process that a user's routine forked came back from it, and ends here\n";
    if CHILD.get() {
        // SAFETY: writes words, and leaves without tidying up what belongs to the parent.
        unsafe {
            libc::write(2, WORDS.as_ptr().cast(), WORDS.len());
            end(0)
        }
    }
}

/// Control bits of the SSE unit without the flags; as every program starts: all exceptions masked, to nearest, no number
/// flushed to zero (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 1, 10.2.3 and 11.6.4).
#[cfg(target_arch = "x86_64")]
const PLAIN: u32 = 0x1f80;

#[cfg(target_arch = "x86_64")]
#[inline]
fn control() -> u32 {
    let mut word = 0_u32;
    // SAFETY: stores a register of this thread.
    unsafe { core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags)) };
    word
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn arithmetic_is_plain() -> bool {
    control() & 0xffc0 == PLAIN
}

#[cfg(target_arch = "x86_64")]
#[cold]
fn make_arithmetic_plain() {
    let word = control() & 0x3f | PLAIN;
    // SAFETY: sets registers of this thread to what every program starts with; the flags stay. 0 is FE_TONEAREST, for the
    // x87 unit, too.
    unsafe {
        fesetround(0);
        core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags));
    }
}

/// The floating-point control register; 0 is what every program starts with (Arm Architecture Reference Manual, FPCR).
#[cfg(target_arch = "aarch64")]
#[inline]
fn arithmetic_is_plain() -> bool {
    let word: u64;
    // SAFETY: reads a register of this thread.
    unsafe { core::arch::asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags)) };
    word == 0
}

#[cfg(target_arch = "aarch64")]
#[cold]
fn make_arithmetic_plain() {
    // SAFETY: sets a register of this thread to what every program starts with.
    unsafe { core::arch::asm!("msr fpcr, {}", in(reg) 0_u64, options(nostack, preserves_flags)) };
}

/// Other processors are not looked at.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn arithmetic_is_plain() -> bool {
    true
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn make_arithmetic_plain() {}

#[cfg(target_arch = "x86_64")]
unsafe extern "C" {
    fn fesetround(mode: c_int) -> c_int;
}

/// Remembers the working folder before a routine leaves it.
fn note_folder() {
    if super::library::inside() && !TOUCHED.get() {
        let here = File::options().read(true).custom_flags(libc::O_PATH | libc::O_DIRECTORY).open(".");
        FOLDER.set(here.ok());
        TOUCHED.set(FOLDER.with_borrow(Option::is_some));
    }
}

/// `chdir` of the C library for all of the process.
pub unsafe extern "C" fn chdir(path: *const c_char) -> c_int {
    note_folder();
    // SAFETY: what the caller promises the C library.
    unsafe { libc::syscall(libc::SYS_chdir, path) as c_int }
}

/// `fchdir` of the C library.
pub unsafe extern "C" fn fchdir(folder: c_int) -> c_int {
    note_folder();
    // SAFETY: what the caller promises the C library.
    unsafe { libc::syscall(libc::SYS_fchdir, folder) as c_int }
}

/// `_exit` of the C library: inside a routine it is no success.
pub extern "C" fn leave(status: c_int) -> ! {
    let failed = is_own_process() && super::library::last_words("left the process without a word (_exit)");
    // SAFETY: ends the process, as the caller wants.
    unsafe { end(if failed { 1 } else { status }) }
}

/// Ends the process at once, not by way of what is watched.
///
/// # Safety
/// Nothing is tidied up.
pub(super) unsafe fn end(status: c_int) -> ! {
    loop {
        // SAFETY: ends the process; it does not come back.
        unsafe { libc::syscall(libc::SYS_exit_group, status) };
    }
}
