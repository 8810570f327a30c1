//! Text on standard output and standard error, and the words of the command line. A run continues if the output cannot be
//! written.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, IsTerminal as _, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::deck::printable;

/// State of standard output. A failure is reported once; after that nothing is written to it.
static STATE: AtomicU8 = AtomicU8::new(OPEN);
const OPEN: u8 = 0;
/// The reader has closed the pipe.
const CLOSED: u8 = 1;
/// A write has failed, for example because the disk is full.
const FULL: u8 = 2;

/// Writes a line to standard output, like `println!`.
macro_rules! print_out {
    ($($words:tt)*) => { $crate::command::words::write(::std::format_args!($($words)*), true) };
}

/// Writes a line to standard error, like `eprintln!`.
macro_rules! print_err {
    ($($words:tt)*) => { $crate::command::words::write_error_line(&::std::format!($($words)*)) };
}

pub(crate) use {print_err, print_out};

/// Writes to standard output. Control characters are replaced, so that names in foreign files cannot control the
/// terminal.
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
        write_error_line(&format!("error: cannot write to standard output: {error}"));
    }
}

/// Writes a line to standard error; a failure is ignored because it cannot be reported.
pub fn write_error_line(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}

/// Writes a line to standard error with its terminal styles.
pub fn write_styled_error(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Returns whether standard error is a terminal.
pub fn is_terminal() -> bool {
    io::stderr().is_terminal()
}

/// Returns whether text on standard error is coloured: it is a terminal and `NO_COLOR` is not set (no-color.org).
pub fn is_coloured() -> bool {
    is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Returns whether no write to standard output has failed; a pipe closed by its reader counts as success.
pub fn output_succeeded() -> bool {
    STATE.load(Ordering::Relaxed) != FULL
}

/// Words of the command line after the name of the program.
static WORDS: OnceLock<Vec<String>> = OnceLock::new();

/// Records the words of the command line; those of a second command in the process are ignored.
pub fn record_command(words: Vec<String>) {
    let _ = WORDS.set(words);
}

/// Returns the words of the command line after the name of the program.
pub fn words_of_command() -> Vec<String> {
    WORDS.get().cloned().unwrap_or_default()
}
