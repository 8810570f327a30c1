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

/// Largest number of characters of a word in a message.
const LONGEST_WORD: usize = 300;

/// Largest number of characters of a message.
const LONGEST_MESSAGE: usize = 20_000;

/// Returns a message in which words of more than 300 characters, which are names or numbers of an input file, are cut.
///
/// ```
/// let message = revolve::deck::shortened(format!("no set `{}`", "N".repeat(1000)));
/// assert_eq!(message.chars().count(), 308);
/// assert!(message.ends_with("N…"));
/// ```
pub fn shortened(message: String) -> String {
    if message.len() <= LONGEST_WORD {
        return message;
    }
    let mut short = String::new();
    for word in message.split_inclusive(char::is_whitespace) {
        match word.char_indices().nth(LONGEST_WORD) {
            Some((end, c)) if !c.is_whitespace() => {
                short += &word[..end];
                short.push('…');
                short.extend(word.chars().next_back().filter(|last| last.is_whitespace()));
            }
            _ => short += word,
        }
    }
    if let Some((end, _)) = short.char_indices().nth(LONGEST_MESSAGE) {
        short.truncate(end);
        short.push('…');
    }
    short
}

fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}');
    c.is_control() && c != '\n' && c != '\t' || turns
}
