//! Words on standard output and standard error. Where nobody takes them a run goes on all the same.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, IsTerminal as _, Write};
use std::sync::atomic::{AtomicU8, Ordering};

use crate::deck::printable;

/// What has become of standard output; where it has failed that is told once, and nothing more is written there.
static STATE: AtomicU8 = AtomicU8::new(OPEN);
const OPEN: u8 = 0;
/// Its reader has gone.
const CLOSED: u8 = 1;
/// It takes nothing more.
const FULL: u8 = 2;

/// Writes a line on standard output, as `println!` does.
macro_rules! say {
    ($($words:tt)*) => { $crate::command::words::write(::std::format_args!($($words)*), true) };
}

/// Writes a line on standard error, as `eprintln!` does.
macro_rules! tell {
    ($($words:tt)*) => { $crate::command::words::tell_line(&::std::format!($($words)*)) };
}

pub(crate) use {say, tell};

/// Writes on standard output. Names of strangers steer no terminal.
pub fn write(words: Arguments<'_>, line: bool) {
    if STATE.load(Ordering::Relaxed) != OPEN {
        return;
    }
    let text = words.to_string();
    let mut out = io::stdout().lock();
    let end = if line { "\n" } else { "" };
    let written = write!(out, "{}{end}", printable(&text)).and_then(|()| out.flush());
    let Err(error) = written else { return };
    let state = if error.kind() == ErrorKind::BrokenPipe { CLOSED } else { FULL };
    if STATE.swap(state, Ordering::Relaxed) == OPEN && state == FULL {
        tell_line(&format!("error: cannot write on standard output: {error}"));
    }
}

/// Writes a line on standard error; where that fails nobody is left to be told.
pub fn tell_line(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}

/// The same of a text that is styled already.
pub fn tell_styled(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Whether standard error is a terminal.
pub fn is_watched() -> bool {
    io::stderr().is_terminal()
}

/// Whether standard error takes colours: a terminal, unless `NO_COLOR` asks for none (no-color.org).
pub fn is_coloured() -> bool {
    is_watched() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Whether all that was written on standard output has arrived, or its reader had enough.
pub fn arrived() -> bool {
    STATE.load(Ordering::Relaxed) != FULL
}
