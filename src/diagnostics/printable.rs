//! Escaping of control characters in text from input files before it is printed on a terminal.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Returns the text with control characters (except line ends and tabs) and bidirectional formatting characters escaped
/// as `\u{…}`.
///
/// ```
/// assert_eq!(revolve::deck::printable("red\u{1b}[31m"), "red\\u{1b}[31m");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut printable = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if steers(c) {
            let _ = write!(printable, "{}", c.escape_unicode());
        } else {
            printable.push(c);
        }
    }
    Cow::Owned(printable)
}

fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}');
    c.is_control() && c != '\n' && c != '\t' || turns
}
