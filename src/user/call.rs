//! The call of a routine that is under way on a thread, and the words about it where the process cannot go on.
//! Never here: calling, what becomes of the process.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::fmt::Write as _;

use super::PointValues;
use crate::state::Instant;

/// The call that is under way.
pub struct Call<'a> {
    /// The routine.
    pub routine: &'static str,
    /// Surface, set or amplitude.
    pub name: &'a str,
    /// Clock, step and increment.
    pub now: Instant,
    /// Names and values of sensors.
    pub sensors: (&'a [String], &'a [f64]),
    /// User's numbers of the elements whose points are shown.
    pub elements: &'a [i32],
    /// What the points of the call hold.
    pub points: Option<(usize, &'a dyn PointValues)>,
}

impl<'a> Call<'a> {
    /// Without sensors and points.
    pub fn new(routine: &'static str, name: &'a str, now: Instant) -> Self {
        Call { routine, name, now, sensors: (&[], &[]), elements: &[], points: None }
    }

    /// At points of elements.
    pub fn at(self, elements: &'a [i32]) -> Self {
        Call { elements, ..self }
    }

    /// The routine is entered, until [`end`].
    #[inline]
    pub fn begin(&self) {
        CURRENT.set(std::ptr::from_ref(self).cast());
    }
}

thread_local! {
    static CURRENT: Cell<*const Call<'static>> = const { Cell::new(std::ptr::null()) };
}

/// The routine has been left.
#[inline]
pub fn end() {
    CURRENT.set(std::ptr::null());
}

/// Whether this thread is inside a routine.
#[inline]
pub fn inside() -> bool {
    !CURRENT.get().is_null()
}

/// The routine that this thread is inside of.
pub fn routine() -> Option<&'static str> {
    current(|call| call.map(|call| call.routine))
}

/// Runs `ask` on the call under way on this thread, if there is one.
pub fn current<R>(ask: impl FnOnce(Option<&Call<'_>>) -> R) -> R {
    let pointer = CURRENT.get();
    // SAFETY: the pointer is set to a call that outlives the routine, and taken back when the routine is left.
    ask(unsafe { pointer.as_ref() })
}

/// Says which call was under way; `false` if none was. Allocates nothing: a signal may come from inside the allocator.
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
