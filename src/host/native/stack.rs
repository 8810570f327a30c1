//! Stacks of the threads that call user subroutines, and the detection of their overflow.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ffi::c_void;

use super::STACK;

/// Message of a stack overflow.
pub const OVERFLOW: &str = "needs more than the 64 MB of its stack: declare large local arrays ALLOCATABLE or SAVE";
const _: () = assert!(STACK == 64 << 20);

/// Bytes next to the end of a stack: an access there is an overflow.
const MARGIN: usize = 64 << 10;
/// Size of the stack of signal handlers in bytes.
const SIGNAL_STACK: usize = 64 << 10;

thread_local! {
    /// Lowest address of the stack of this thread; 0 before its first call.
    static END: Cell<usize> = const { Cell::new(0) };
    static SIGNALS: RefCell<Option<SignalStack>> = const { RefCell::new(None) };
}

/// Permits the main thread a stack of [`STACK`] bytes. Its stack grows up to the limit, also if it is raised later.
pub fn enlarge() {
    // SAFETY: reads and sets a limit of this process.
    unsafe {
        let mut limit: libc::rlimit = std::mem::zeroed();
        if libc::getrlimit(libc::RLIMIT_STACK, &raw mut limit) == 0 && limit.rlim_cur < STACK as u64 {
            limit.rlim_cur = limit.rlim_max.min(STACK as u64);
            libc::setrlimit(libc::RLIMIT_STACK, &raw const limit);
        }
    }
}

/// Prepares this thread for calls of user subroutines: an overflow of its stack can be reported.
#[inline]
pub fn prepare() {
    if END.get() == 0 {
        END.set(end_of_stack());
        SIGNALS.set(SignalStack::new());
    }
}

/// Returns the lowest address of the stack of this thread, 1 if it is not known.
#[cold]
fn end_of_stack() -> usize {
    // SAFETY: the attributes are initialised by the first function, and destroyed at the end.
    unsafe {
        let mut attributes: libc::pthread_attr_t = std::mem::zeroed();
        if libc::pthread_getattr_np(libc::pthread_self(), &raw mut attributes) != 0 {
            return 1;
        }
        let (mut lowest, mut size) = (std::ptr::null_mut(), 0);
        libc::pthread_attr_getstack(&raw const attributes, &raw mut lowest, &raw mut size);
        libc::pthread_attr_destroy(&raw mut attributes);
        (lowest as usize).max(1)
    }
}

/// Returns whether a memory error is an overflow of the stack: the stack pointer or the address is next to its end, or the
/// stack pointer is beyond it.
pub fn has_overflowed(info: &libc::siginfo_t, context: &libc::ucontext_t) -> bool {
    let end = END.get();
    // SAFETY: the signals of memory errors have an address.
    let address = unsafe { info.si_addr() } as usize;
    let is_next = address.abs_diff(end) < MARGIN;
    end > 1 && (is_next || stack_pointer(context) < end + MARGIN)
}

#[cfg(target_arch = "x86_64")]
fn stack_pointer(context: &libc::ucontext_t) -> usize {
    context.uc_mcontext.gregs[libc::REG_RSP as usize] as usize
}

#[cfg(target_arch = "aarch64")]
fn stack_pointer(context: &libc::ucontext_t) -> usize {
    context.uc_mcontext.sp as usize
}

/// A stack for signal handlers of this thread, which a thread of Rust has, and one of another program has not.
struct SignalStack(*mut c_void);

impl SignalStack {
    /// Allocates a stack; `None` if the thread has one, or without memory.
    fn new() -> Option<SignalStack> {
        let (protection, flags) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
        // SAFETY: reads the current stack, and sets new memory that stays mapped until the thread ends.
        unsafe {
            let mut current: libc::stack_t = std::mem::zeroed();
            libc::sigaltstack(std::ptr::null(), &raw mut current);
            if current.ss_flags & libc::SS_DISABLE == 0 {
                return None;
            }
            let memory = libc::mmap(std::ptr::null_mut(), SIGNAL_STACK, protection, flags, -1, 0);
            if memory == libc::MAP_FAILED {
                return None;
            }
            let new = libc::stack_t { ss_sp: memory, ss_flags: 0, ss_size: SIGNAL_STACK };
            libc::sigaltstack(&raw const new, std::ptr::null_mut());
            Some(SignalStack(memory))
        }
    }
}

impl Drop for SignalStack {
    fn drop(&mut self) {
        // SAFETY: the stack of this thread is disabled before its memory is released.
        unsafe {
            let none = libc::stack_t { ss_sp: std::ptr::null_mut(), ss_flags: libc::SS_DISABLE, ss_size: 0 };
            libc::sigaltstack(&raw const none, std::ptr::null_mut());
            libc::munmap(self.0, SIGNAL_STACK);
        }
    }
}
