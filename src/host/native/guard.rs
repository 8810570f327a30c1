//! Changes of the process that a user subroutine must not leave: rounding mode, working folder, forked processes,
//! signal handlers, threads, a silent exit. They are detected when they happen and undone when the subroutine returns.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

thread_local! {
    /// The working folder before a subroutine changed it.
    static FOLDER: RefCell<Option<File>> = const { RefCell::new(None) };
    /// Whether something must be restored, and whether this is a forked process.
    static TOUCHED: Cell<bool> = const { Cell::new(false) };
    static CHILD: Cell<bool> = const { Cell::new(false) };
    /// Whether initialisers of a library may be running.
    static OPENING: Cell<bool> = const { Cell::new(false) };
    /// Signal actions before a subroutine changed them.
    static HANDLERS: RefCell<Vec<(c_int, libc::sigaction)>> = const { RefCell::new(Vec::new()) };
    /// Ids of the threads started in this run, with the subroutine that started them.
    static STARTED: RefCell<Vec<(i32, &'static str)>> = const { RefCell::new(Vec::new()) };
}

/// Id of the process that opened the libraries; 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Starts monitoring this process.
pub fn watch() {
    PROCESS.store(std::process::id(), Ordering::Relaxed);
    // SAFETY: the handler sets flags of the thread that forked.
    unsafe { libc::pthread_atfork(None, None, Some(forked)) };
}

/// Returns whether this is the process that opened the libraries, not a forked one.
pub fn is_own_process() -> bool {
    PROCESS.load(Ordering::Relaxed) == std::process::id()
}

unsafe extern "C" fn forked() {
    if super::call::inside() {
        CHILD.set(true);
        TOUCHED.set(true);
    }
}

/// Opens a library; its initialisers are monitored like subroutines.
pub fn opening<R>(open: impl FnOnce() -> R) -> R {
    OPENING.set(true);
    let opened = open();
    OPENING.set(false);
    opened
}

/// Returns whether this thread executes user code.
fn is_users() -> bool {
    super::call::inside() || OPENING.get()
}

/// Undoes the changes of a subroutine and reports each; ends a forked process that returned from the subroutine.
#[inline]
pub fn restore(report: impl Fn(&str)) {
    if !arithmetic_is_plain() {
        make_arithmetic_plain();
        report("changed the rounding mode or the treatment of subnormal numbers: it was restored");
    }
    if TOUCHED.get() {
        leave_child();
        TOUCHED.set(false);
        HANDLERS.take().into_iter().for_each(|(signal, before)| set_back(signal, &before, &report));
        let Some(folder) = FOLDER.take() else { return };
        // SAFETY: an open folder; a direct system call, because `fchdir` is replaced below.
        if unsafe { libc::syscall(libc::SYS_fchdir, folder.as_raw_fd()) } == 0 {
            report("changed the working folder of the process: it was restored");
        } else {
            report("changed the working folder of the process, and it cannot be restored");
        }
    }
}

/// Ends a forked process, which would write the results a second time.
#[cold]
fn leave_child() {
    const WORDS: &[u8] = b"note: a process that a user subroutine forked returned from the subroutine; it is ended\n";
    if CHILD.get() {
        // SAFETY: writes a message and ends without cleanup of resources of the parent.
        unsafe {
            libc::write(2, WORDS.as_ptr().cast(), WORDS.len());
            end(0)
        }
    }
}

/// Default control bits of the SSE unit, without the flags: all exceptions masked, round to nearest, no flush to zero
/// (Intel 64 and IA-32 Architectures Software Developer's Manual, volume 1, 10.2.3 and 11.6.4).
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
    // SAFETY: sets registers of this thread to their defaults; the flags are kept. 0 is FE_TONEAREST, also for the x87
    // unit.
    unsafe {
        fesetround(0);
        core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags));
    }
}

/// Returns whether the floating-point control register has its default, 0 (Arm Architecture Reference Manual, FPCR).
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
    // SAFETY: sets a register of this thread to its default.
    unsafe { core::arch::asm!("msr fpcr, {}", in(reg) 0_u64, options(nostack, preserves_flags)) };
}

/// Returns true: the register is not checked on other processors.
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

/// Stores the working folder before a subroutine changes it.
fn note_folder() {
    if is_users() && FOLDER.with_borrow(Option::is_none) {
        FOLDER.set(File::options().read(true).custom_flags(libc::O_PATH | libc::O_DIRECTORY).open(".").ok());
        TOUCHED.set(true);
    }
}

/// Replaces `chdir` of the C library in the whole process.
pub unsafe extern "C" fn chdir(path: *const c_char) -> c_int {
    note_folder();
    // SAFETY: the caller fulfils the contract of the C function.
    unsafe { libc::syscall(libc::SYS_chdir, path) as c_int }
}

/// Replaces `fchdir` of the C library.
pub unsafe extern "C" fn fchdir(folder: c_int) -> c_int {
    note_folder();
    // SAFETY: the caller fulfils the contract of the C function.
    unsafe { libc::syscall(libc::SYS_fchdir, folder) as c_int }
}

unsafe extern "C" {
    /// Function `sigaction` of the C library, by its internal name, which is not replaced.
    fn __sigaction(signal: c_int, new: *const libc::sigaction, old: *mut libc::sigaction) -> c_int;
}

fn action(signal: c_int) -> libc::sigaction {
    // SAFETY: zeros are a valid action; the call only reads the current one.
    unsafe {
        let mut now: libc::sigaction = std::mem::zeroed();
        __sigaction(signal, std::ptr::null(), &raw mut now);
        now
    }
}

/// Restores the action of a signal if it has changed.
fn set_back(signal: c_int, before: &libc::sigaction, report: &impl Fn(&str)) {
    let now = action(signal);
    if (now.sa_sigaction, now.sa_flags) != (before.sa_sigaction, before.sa_flags) {
        // SAFETY: the action that was active before the subroutine.
        unsafe { __sigaction(signal, before, std::ptr::null_mut()) };
        report(&format!("changed the action of signal {signal}: it was restored"));
    }
}

/// Replaces `sigaction` of the C library in the whole process.
pub unsafe extern "C" fn sigaction(signal: c_int, new: *const libc::sigaction, old: *mut libc::sigaction) -> c_int {
    if is_users() && !new.is_null() {
        HANDLERS.with_borrow_mut(|list| {
            if list.iter().all(|(known, _)| *known != signal) {
                list.push((signal, action(signal)));
            }
        });
        TOUCHED.set(true);
    }
    // SAFETY: the caller fulfils the contract of the C function.
    unsafe { __sigaction(signal, new, old) }
}

/// Sets a handler with flags; returns the previous one.
fn handle(signal: c_int, handler: usize, flags: c_int) -> usize {
    // SAFETY: zeros are a valid action with an empty mask; both pointers are to actions.
    unsafe {
        let (mut new, mut old): (libc::sigaction, libc::sigaction) = (std::mem::zeroed(), std::mem::zeroed());
        (new.sa_sigaction, new.sa_flags) = (handler, flags);
        if sigaction(signal, &raw const new, &raw mut old) == 0 { old.sa_sigaction } else { libc::SIG_ERR }
    }
}

/// Replaces `signal` and `bsd_signal` of the C library.
pub extern "C" fn signal(number: c_int, handler: usize) -> usize {
    handle(number, handler, libc::SA_RESTART)
}

/// Replaces `sysv_signal` of the C library: the handler is reset after one signal.
pub extern "C" fn sysv_signal(number: c_int, handler: usize) -> usize {
    handle(number, handler, libc::SA_RESETHAND | libc::SA_NODEFER)
}

/// Clears the list of threads of an earlier run.
pub fn forget_threads() {
    STARTED.take();
}

/// Returns subroutines with the number of their threads that still run.
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

/// Returns the ids of the threads of the process.
fn threads() -> Vec<i32> {
    let entries = std::fs::read_dir("/proc/self/task").into_iter().flatten().filter_map(Result::ok);
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect()
}

/// Start function of a thread in the C library.
type ThreadBody = extern "C" fn(*mut c_void) -> *mut c_void;
type CreateThread =
    unsafe extern "C" fn(*mut libc::pthread_t, *const libc::pthread_attr_t, ThreadBody, *mut c_void) -> c_int;

/// Replaces `pthread_create` of the C library in the whole process.
pub unsafe extern "C" fn pthread_create(
    thread: *mut libc::pthread_t,
    attributes: *const libc::pthread_attr_t,
    body: ThreadBody,
    argument: *mut c_void,
) -> c_int {
    // SAFETY: the next symbol of this name is that of the C library and has its type.
    let real: Option<CreateThread> = unsafe {
        std::mem::transmute::<*mut c_void, Option<CreateThread>>(libc::dlsym(
            libc::RTLD_NEXT,
            c"pthread_create".as_ptr(),
        ))
    };
    let Some(real) = real else { return libc::EAGAIN };
    let routine = super::call::routine().filter(|_| !is_of_runtime(body));
    let threads_before = routine.map(|_| threads()).unwrap_or_default();
    // SAFETY: the caller fulfils the contract of the C function.
    let failed = unsafe { real(thread, attributes, body, argument) };
    if let Some(routine) = routine {
        let new = threads().into_iter().filter(|number| !threads_before.contains(number));
        STARTED.with_borrow_mut(|list| list.extend(new.map(|number| (number, routine))));
    }
    failed
}

/// Returns whether a thread belongs to OpenMP or to a linear algebra library; such threads wait for the next call.
fn is_of_runtime(body: ThreadBody) -> bool {
    // SAFETY: zeros are a valid Dl_info; the loader fills in names that live as long as the library.
    let name = unsafe {
        let mut object: libc::Dl_info = std::mem::zeroed();
        let is_known = libc::dladdr(body as *const c_void, &raw mut object) != 0 && !object.dli_fname.is_null();
        if is_known { CStr::from_ptr(object.dli_fname).to_string_lossy().into_owned() } else { String::new() }
    };
    ["libgomp", "libopenblas", "libmkl"].iter().any(|runtime| name.contains(runtime))
}

/// Replaces `_exit` of the C library: a failure inside a subroutine.
pub extern "C" fn leave(status: c_int) -> ! {
    let failed = is_own_process() && super::call::report_failure("left the process without a word (_exit)");
    // SAFETY: ends the process, as requested.
    unsafe { end(if failed { 1 } else { status }) }
}

/// Run-time libraries of gfortran.
pub const FORTRAN_RUNTIMES: [&CStr; 3] = [c"libgfortran.so.5", c"libgfortran.so.4", c"libgfortran.so.3"];

/// Longest time for flushing: a unit stays locked if a routine stopped within a WRITE statement.
const FLUSH_TIME: Duration = Duration::from_secs(1);

/// Flushes the output of Fortran and C.
pub fn flush() {
    let functions: Vec<FlushUnits> = FORTRAN_RUNTIMES.iter().filter_map(|name| flush_function(name)).collect();
    let (ended, ends) = std::sync::mpsc::channel();
    let flush_all = move || {
        // SAFETY: a null unit number means all units; a null stream means all streams of C.
        unsafe {
            functions.iter().for_each(|flush| flush(std::ptr::null()));
            libc::fflush(std::ptr::null_mut());
        }
        // The receiver may have been dropped.
        let _ = ended.send(());
    };
    if std::thread::Builder::new().name("flush".into()).spawn(flush_all).is_ok() {
        let _ = ends.recv_timeout(FLUSH_TIME);
    }
}

/// Function `flush` of a Fortran run-time library.
type FlushUnits = unsafe extern "C" fn(*const i32);

/// Returns the function of a Fortran run-time library that flushes units, if the library is loaded. Libraries of the user
/// are opened with local symbols, so that a search among the global ones does not find it.
fn flush_function(runtime: &CStr) -> Option<FlushUnits> {
    // SAFETY: RTLD_NOLOAD only affects loaded libraries, so no initialiser runs; the function has this type.
    unsafe {
        let library = libc::dlopen(runtime.as_ptr(), libc::RTLD_NOW | libc::RTLD_NOLOAD);
        if library.is_null() {
            return None;
        }
        let function = libc::dlsym(library, c"_gfortran_flush_i4".as_ptr());
        libc::dlclose(library);
        std::mem::transmute::<*mut c_void, Option<FlushUnits>>(function)
    }
}

/// Ends the process at once by a system call.
///
/// # Safety
/// No destructors or exit handlers run.
pub(super) unsafe fn end(status: c_int) -> ! {
    loop {
        // SAFETY: ends the process and does not return.
        unsafe { libc::syscall(libc::SYS_exit_group, status) };
    }
}
