//! Changes of the process that a routine must not leave: rounding mode, working folder, forked processes, signal handlers,
//! threads, a silent exit. They are detected when they happen and undone when the routine returns.
//! Never here: which routine it was.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::sync::atomic::{AtomicU32, Ordering};

thread_local! {
    /// The working folder before a routine changed it.
    static FOLDER: RefCell<Option<File>> = const { RefCell::new(None) };
    /// Whether there is something to restore, and whether this is a forked process.
    static TOUCHED: Cell<bool> = const { Cell::new(false) };
    static CHILD: Cell<bool> = const { Cell::new(false) };
    /// Whether initialisers of a library may be running.
    static OPENING: Cell<bool> = const { Cell::new(false) };
    /// Signal actions before a routine changed them.
    static HANDLERS: RefCell<Vec<(c_int, libc::sigaction)>> = const { RefCell::new(Vec::new()) };
    /// Numbers of the threads that routines of this run started, with the routine.
    static STARTED: RefCell<Vec<(i32, &'static str)>> = const { RefCell::new(Vec::new()) };
}

/// The process that opened routines; 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Begins to watch this process.
pub fn watch() {
    PROCESS.store(std::process::id(), Ordering::Relaxed);
    // SAFETY: the handler sets flags of the thread that forked.
    unsafe { libc::pthread_atfork(None, None, Some(forked)) };
}

/// Whether this is the process that opened the routines, not a forked one.
pub fn is_own_process() -> bool {
    PROCESS.load(Ordering::Relaxed) == std::process::id()
}

unsafe extern "C" fn forked() {
    if super::call::inside() {
        CHILD.set(true);
        TOUCHED.set(true);
    }
}

/// Opens a library, whose initialisers are watched as routines are.
pub fn opening<R>(open: impl FnOnce() -> R) -> R {
    OPENING.set(true);
    let opened = open();
    OPENING.set(false);
    opened
}

/// Whether this thread executes code of a user.
fn is_users() -> bool {
    super::call::inside() || OPENING.get()
}

/// Undoes what a routine changed, and reports each change; ends a forked process that returned from the routine.
#[inline]
pub fn restore(tell: impl Fn(&str)) {
    if !arithmetic_is_plain() {
        make_arithmetic_plain();
        tell("left another rounding mode, or treatment of small numbers, behind: it is set back");
    }
    if TOUCHED.get() {
        leave_child();
        TOUCHED.set(false);
        HANDLERS.take().into_iter().for_each(|(signal, before)| set_back(signal, &before, &tell));
        let Some(folder) = FOLDER.take() else { return };
        // SAFETY: a folder that is open; by the system's own number, for the name is watched.
        if unsafe { libc::syscall(libc::SYS_fchdir, folder.as_raw_fd()) } == 0 {
            tell("changed the working folder of the process: it is set back");
        } else {
            tell("changed the working folder of the process, and it cannot be set back");
        }
    }
}

/// Ends a forked process, which would write the results a second time.
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

/// Not checked on other processors.
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
    if is_users() && FOLDER.with_borrow(Option::is_none) {
        FOLDER.set(File::options().read(true).custom_flags(libc::O_PATH | libc::O_DIRECTORY).open(".").ok());
        TOUCHED.set(true);
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

unsafe extern "C" {
    /// `sigaction` of the C library under its other name.
    fn __sigaction(signal: c_int, new: *const libc::sigaction, old: *mut libc::sigaction) -> c_int;
}

fn action(signal: c_int) -> libc::sigaction {
    // SAFETY: zeros are an action; it is asked for, not changed.
    unsafe {
        let mut now: libc::sigaction = std::mem::zeroed();
        __sigaction(signal, std::ptr::null(), &raw mut now);
        now
    }
}

/// Restores the action of a signal if it has changed.
fn set_back(signal: c_int, before: &libc::sigaction, tell: &impl Fn(&str)) {
    let now = action(signal);
    if (now.sa_sigaction, now.sa_flags) != (before.sa_sigaction, before.sa_flags) {
        // SAFETY: what was in force before the routine.
        unsafe { __sigaction(signal, before, std::ptr::null_mut()) };
        tell(&format!("changed what the process does about signal {signal}: it is set back"));
    }
}

/// `sigaction` of the C library for all of the process.
pub unsafe extern "C" fn sigaction(signal: c_int, new: *const libc::sigaction, old: *mut libc::sigaction) -> c_int {
    if is_users() && !new.is_null() {
        HANDLERS.with_borrow_mut(|list| {
            if list.iter().all(|(known, _)| *known != signal) {
                list.push((signal, action(signal)));
            }
        });
        TOUCHED.set(true);
    }
    // SAFETY: what the caller promises the C library.
    unsafe { __sigaction(signal, new, old) }
}

/// Sets a handler with flags; returns the previous one.
fn handle(signal: c_int, handler: usize, flags: c_int) -> usize {
    // SAFETY: zeros are an action with an empty mask; both places are actions.
    unsafe {
        let (mut new, mut old): (libc::sigaction, libc::sigaction) = (std::mem::zeroed(), std::mem::zeroed());
        (new.sa_sigaction, new.sa_flags) = (handler, flags);
        if sigaction(signal, &raw const new, &raw mut old) == 0 { old.sa_sigaction } else { libc::SIG_ERR }
    }
}

/// `signal` and `bsd_signal` of the C library.
pub extern "C" fn signal(number: c_int, handler: usize) -> usize {
    handle(number, handler, libc::SA_RESTART)
}

/// `sysv_signal` of the C library: for one time.
pub extern "C" fn sysv_signal(number: c_int, handler: usize) -> usize {
    handle(number, handler, libc::SA_RESETHAND | libc::SA_NODEFER)
}

/// Forgets the threads of an earlier run.
pub fn forget_threads() {
    STARTED.take();
}

/// Routines with the number of their threads that still run.
pub fn threads_running() -> Vec<(&'static str, usize)> {
    let started = STARTED.with_borrow(Vec::clone);
    let now = if started.is_empty() { Vec::new() } else { threads() };
    let mut list: Vec<(&'static str, usize)> = Vec::new();
    for (_, routine) in started.into_iter().filter(|(thread, _)| now.contains(thread)) {
        match list.iter_mut().find(|(known, _)| *known == routine) {
            Some((_, count)) => *count += 1,
            None => list.push((routine, 1)),
        }
    }
    list
}

/// Numbers of the threads of the process.
fn threads() -> Vec<i32> {
    let entries = std::fs::read_dir("/proc/self/task").into_iter().flatten().filter_map(Result::ok);
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect()
}

/// A thread's function, as the C library takes it.
type Body = extern "C" fn(*mut c_void) -> *mut c_void;
type Create = unsafe extern "C" fn(*mut libc::pthread_t, *const libc::pthread_attr_t, Body, *mut c_void) -> c_int;

/// `pthread_create` of the C library for all of the process.
pub unsafe extern "C" fn pthread_create(
    thread: *mut libc::pthread_t,
    attributes: *const libc::pthread_attr_t,
    body: Body,
    argument: *mut c_void,
) -> c_int {
    // SAFETY: the next of that name is the C library's, and has its type.
    let real: Option<Create> = unsafe {
        std::mem::transmute::<*mut c_void, Option<Create>>(libc::dlsym(libc::RTLD_NEXT, c"pthread_create".as_ptr()))
    };
    let Some(real) = real else { return libc::EAGAIN };
    let routine = super::call::routine().filter(|_| !is_of_runtime(body));
    let before = routine.map(|_| threads()).unwrap_or_default();
    // SAFETY: what the caller promises the C library.
    let failed = unsafe { real(thread, attributes, body, argument) };
    if let Some(routine) = routine {
        let new = threads().into_iter().filter(|number| !before.contains(number));
        STARTED.with_borrow_mut(|list| list.extend(new.map(|number| (number, routine))));
    }
    failed
}

/// Whether a thread belongs to OpenMP or linear algebra: these wait for the next call.
fn is_of_runtime(body: Body) -> bool {
    // SAFETY: zeros are such a description; the loader fills in names that last as long as its library.
    let name = unsafe {
        let mut place: libc::Dl_info = std::mem::zeroed();
        let found = libc::dladdr(body as *const c_void, &raw mut place) != 0 && !place.dli_fname.is_null();
        if found { CStr::from_ptr(place.dli_fname).to_string_lossy().into_owned() } else { String::new() }
    };
    ["libgomp", "libopenblas", "libmkl"].iter().any(|runtime| name.contains(runtime))
}

/// `_exit` of the C library: a failure inside a routine.
pub extern "C" fn leave(status: c_int) -> ! {
    let failed = is_own_process() && super::call::last_words("left the process without a word (_exit)");
    // SAFETY: ends the process, as the caller wants.
    unsafe { end(if failed { 1 } else { status }) }
}

/// Flushes the output of Fortran and C.
pub fn flush() {
    // SAFETY: flushes all units of the Fortran runtime, if the process has one, and all streams of C.
    unsafe {
        let flush = libc::dlsym(libc::RTLD_DEFAULT, c"_gfortran_flush_i4".as_ptr());
        if !flush.is_null() {
            let flush = std::mem::transmute::<*mut c_void, extern "C" fn(*const i32)>(flush);
            flush(std::ptr::null());
        }
        libc::fflush(std::ptr::null_mut());
    }
}

/// Ends the process at once, by the system call.
///
/// # Safety
/// Nothing is tidied up.
pub(super) unsafe fn end(status: c_int) -> ! {
    loop {
        // SAFETY: ends the process; it does not come back.
        unsafe { libc::syscall(libc::SYS_exit_group, status) };
    }
}
