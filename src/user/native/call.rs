//! The call in progress on a thread, and the message about it if the process cannot continue.
//! Never here: calling, ending the process.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicPtr, Ordering};

use super::PointValues;
use crate::state::Instant;

/// A call in progress.
pub struct ActiveCall<'a> {
    /// The routine.
    pub routine: &'static str,
    /// Surface, set or amplitude.
    pub name: &'a str,
    /// Clock, step and increment.
    pub now: Instant,
    /// Names and values of sensors.
    pub sensors: (&'a [String], &'a [f64]),
    /// User's numbers of the elements of the points.
    pub elements: &'a [i32],
    /// Values of the points.
    pub points: Option<(usize, &'a dyn PointValues)>,
}

impl<'a> ActiveCall<'a> {
    /// Without sensors and points.
    pub fn new(routine: &'static str, name: &'a str, now: Instant) -> Self {
        ActiveCall { routine, name, now, sensors: (&[], &[]), elements: &[], points: None }
    }

    /// At points of elements.
    pub fn at(self, elements: &'a [i32]) -> Self {
        ActiveCall { elements, ..self }
    }

    /// Begins the call, until [`end`].
    #[inline]
    pub fn begin(&self) {
        CURRENT.set(std::ptr::from_ref(self).cast());
    }
}

thread_local! {
    static CURRENT: Cell<*const ActiveCall<'static>> = const { Cell::new(std::ptr::null()) };
}

/// Ends the call.
#[inline]
pub fn end() {
    CURRENT.set(std::ptr::null());
}

/// Whether this thread is inside a routine.
#[inline]
pub fn inside() -> bool {
    !CURRENT.get().is_null()
}

/// The routine in which this thread is.
pub fn routine() -> Option<&'static str> {
    current(|call| call.map(|call| call.routine))
}

/// Runs `ask` on the call in progress on this thread, if there is one.
pub fn current<R>(ask: impl FnOnce(Option<&ActiveCall<'_>>) -> R) -> R {
    let pointer = CURRENT.get();
    // SAFETY: the pointer is set to a call that outlives the routine, and taken back when the routine is left.
    ask(unsafe { pointer.as_ref() })
}

/// Reason why a call failed, in memory shared with another process.
#[repr(C)]
pub struct FailureText {
    length: u32,
    text: [u8; 2044],
}

impl FailureText {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Sets it, cut to the available length. Allocates nothing.
    pub fn set(&mut self, text: &str) {
        let length = text.len().min(self.text.len());
        self.text[..length].copy_from_slice(&text.as_bytes()[..length]);
        self.length = length as u32;
    }

    /// The text.
    pub fn get(&self) -> String {
        let length = (self.length as usize).min(self.text.len());
        String::from_utf8_lossy(&self.text[..length]).into_owned()
    }
}

/// Destination of last words in place of standard error, if any.
static ELSEWHERE: AtomicPtr<FailureText> = AtomicPtr::new(std::ptr::null_mut());

/// Directs last words into memory of another process, which adds the call.
pub fn report_failure_in(words: *mut FailureText) {
    ELSEWHERE.store(words, Ordering::Relaxed);
}

/// Reports the call in progress; `false` if there is none. Allocates nothing: a signal may come from inside the allocator.
pub fn last_words(what: &str) -> bool {
    struct Line([u8; 512], usize);
    impl std::fmt::Write for Line {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            let count = text.len().min(self.0.len() - self.1);
            self.0[self.1..self.1 + count].copy_from_slice(&text.as_bytes()[..count]);
            self.1 += count;
            Ok(())
        }
    }
    current(|call| {
        let Some(call) = call else { return false };
        // SAFETY: null, or memory that is there until the process ends, and which the other process reads when it has.
        if let Some(words) = unsafe { ELSEWHERE.load(Ordering::Relaxed).as_mut() } {
            words.set(what);
            return true;
        }
        let mut line = Line([0; 512], 0);
        let on = if call.name.is_empty() { "" } else { " for " };
        let _ = write!(line, "error: {}{on}{}", call.routine, call.name);
        if let [first, .., last] | [first @ last] = call.elements {
            let _ = write!(line, ", elements {first} to {last},");
        }
        let _ = writeln!(
            line,
            " {what}: step {}, increment {}, total time {:e}. The frames written before are complete; \
             --check-user finds indices out of bounds.",
            call.now.step, call.now.increment, call.now.total_time
        );
        // SAFETY: the buffer is as long as said.
        unsafe { libc::write(2, line.0.as_ptr().cast(), line.1) };
        true
    })
}
