//! The user subroutine call in progress on a thread, and the message about it if the process cannot continue.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicPtr, Ordering};

use super::PointValues;
use super::host::{self, MessageLevel};
use revolve_numerics::state::Instant;

/// A call of a user subroutine in progress.
pub struct ActiveCall<'a> {
    /// Name of the subroutine.
    pub routine: &'static str,
    /// Name of the surface, set, amplitude or material.
    pub name: &'a str,
    /// Time, step and increment.
    pub now: Instant,
    /// Names and values of sensors.
    pub sensors: (&'a [String], &'a [f64]),
    /// Element numbers of the points.
    pub elements: &'a [i32],
    /// Number of points, and access to their values (`vgetvrm`).
    pub points: Option<(usize, &'a dyn PointValues)>,
}

impl<'a> ActiveCall<'a> {
    /// Creates a call without sensors and points.
    pub fn new(routine: &'static str, name: &'a str, now: Instant) -> Self {
        ActiveCall { routine, name, now, sensors: (&[], &[]), elements: &[], points: None }
    }

    /// Adds the element numbers of the points.
    pub fn at(self, elements: &'a [i32]) -> Self {
        ActiveCall { elements, ..self }
    }

    /// Makes this the call in progress, until [`end`].
    #[inline]
    pub fn begin(&self) {
        CURRENT.set(std::ptr::from_ref(self).cast());
    }
}

thread_local! {
    static CURRENT: Cell<*const ActiveCall<'static>> = const { Cell::new(std::ptr::null()) };
}

/// Marks the user subroutine of this thread as returned; later crashes are not attributed to it.
#[inline]
pub fn end() {
    CURRENT.set(std::ptr::null());
}

/// Returns whether this thread executes a user subroutine.
#[inline]
pub fn inside() -> bool {
    !CURRENT.get().is_null()
}

/// Returns the subroutine that this thread executes.
pub fn routine() -> Option<&'static str> {
    current(|call| call.map(|call| call.routine))
}

/// Passes the call in progress on this thread to `read`.
pub fn current<R>(read: impl FnOnce(Option<&ActiveCall<'_>>) -> R) -> R {
    let pointer = CURRENT.get();
    // SAFETY: the pointer is set to a call that outlives the subroutine, and reset when the subroutine returns.
    read(unsafe { pointer.as_ref() })
}

/// Reason of a failed call, in memory shared with another process.
#[repr(C)]
pub struct FailureText {
    length: u32,
    text: [u8; 2044],
}

impl FailureText {
    /// Returns whether there is no reason.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Sets the reason, truncated to the available length. Allocates nothing.
    pub fn set(&mut self, text: &str) {
        let length = text.len().min(self.text.len());
        self.text[..length].copy_from_slice(&text.as_bytes()[..length]);
        self.length = length as u32;
    }

    /// Returns the text of the reason; empty if none was set.
    pub fn get(&self) -> String {
        let length = (self.length as usize).min(self.text.len());
        String::from_utf8_lossy(&self.text[..length]).into_owned()
    }
}

/// Destination of failure reports instead of standard error, if set.
static ELSEWHERE: AtomicPtr<FailureText> = AtomicPtr::new(std::ptr::null_mut());

/// Redirects failure reports to memory of another process, which adds the description of the call.
pub fn report_failure_in(words: *mut FailureText) {
    ELSEWHERE.store(words, Ordering::Relaxed);
}

/// A line of text for standard error, truncated to its capacity.
struct LineBuffer([u8; 512], usize);

impl std::fmt::Write for LineBuffer {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let count = text.len().min(self.0.len() - self.1);
        self.0[self.1..self.1 + count].copy_from_slice(&text.as_bytes()[..count]);
        self.1 += count;
        Ok(())
    }
}

/// Writes a line to standard error without allocation.
fn print_line(text: std::fmt::Arguments<'_>) {
    let mut line = LineBuffer([0; 512], 0);
    let _ = writeln!(line, "{text}");
    line.0[line.1 - 1] = b'\n';
    // SAFETY: the buffer has this length.
    unsafe { libc::write(2, line.0.as_ptr().cast(), line.1) };
}

/// Prints the messages of the subroutine, because the run cannot print them at its end.
fn print_messages() {
    host::print_pending(|level, text| {
        let level = match level {
            MessageLevel::Note => "note",
            MessageLevel::Warning => "warning",
            MessageLevel::Error => "error",
        };
        print_line(format_args!("{level} from a user subroutine: {text}"));
    });
}

/// Reports that the call in progress ended the process; `false` without a call. Allocates nothing, because a signal may
/// interrupt the allocator.
pub fn report_failure(what: &str) -> bool {
    current(|call| {
        let Some(call) = call else { return false };
        print_messages();
        // SAFETY: null, or memory that is mapped until the process ends; the other process reads it afterwards.
        if let Some(words) = unsafe { ELSEWHERE.load(Ordering::Relaxed).as_mut() } {
            words.set(what);
            return true;
        }
        let on = if call.name.is_empty() { "" } else { " for " };
        let mut elements = LineBuffer([0; 512], 0);
        if let [first, .., last] | [first @ last] = call.elements {
            let _ = write!(elements, ", elements {first} to {last},");
        }
        let elements = str::from_utf8(&elements.0[..elements.1]).unwrap_or_default();
        print_line(format_args!(
            "error: {}{on}{}{elements} {what}: step {}, increment {}, total time {:e}. Frames written earlier are complete.",
            call.routine, call.name, call.now.step, call.now.increment, call.now.total_time
        ));
        true
    })
}
