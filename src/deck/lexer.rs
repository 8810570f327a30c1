//! Lines and fields: where one ends and the next begins.
//! Never here: what a keyword or field means.

use std::ops::Range;

use super::source::Span;
use super::syntax::Word;

/// One physical line: its bytes in the file, line end left out.
pub type Line = Range<usize>;

/// What kind of line it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// Only blanks.
    Blank,
    /// `**`.
    Comment,
    /// `*`.
    Keyword,
    /// Anything else.
    Data,
}

/// The lines of a text, one after the other.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    text: &'a str,
    next: usize,
}

impl<'a> Lines<'a> {
    /// All lines of the text.
    pub fn new(text: &'a str) -> Self {
        Lines { text, next: 0 }
    }

    /// The next line that says something, without taking it, and the position behind it.
    pub fn peek_significant(&self) -> Option<(Line, Lines<'a>)> {
        let mut ahead = self.clone();
        while let Some(line) = ahead.next() {
            if !matches!(kind(&self.text[line.clone()]), LineKind::Blank | LineKind::Comment) {
                return Some((line, ahead));
            }
        }
        None
    }
}

impl Iterator for Lines<'_> {
    type Item = Line;

    fn next(&mut self) -> Option<Line> {
        let start = self.next;
        if start >= self.text.len() {
            return None;
        }
        let end = self.text[start..].find('\n').map_or(self.text.len(), |i| start + i);
        self.next = end + 1;
        Some(start..end)
    }
}

/// What kind of line it is.
pub fn kind(line: &str) -> LineKind {
    let line = line.trim_start();
    match () {
        () if line.is_empty() => LineKind::Blank,
        () if line.starts_with("**") => LineKind::Comment,
        () if line.starts_with('*') => LineKind::Keyword,
        () => LineKind::Data,
    }
}

/// The comma-separated fields of a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// The bytes between the commas, blanks trimmed. A trailing comma gives no extra field.
    pub ranges: Vec<Range<usize>>,
    /// Whether the line ended in a comma.
    pub trailing_comma: bool,
    /// Where a quote was opened that nothing closes.
    pub unclosed: Option<usize>,
}

/// Splits a line at the commas that stand outside quotes.
pub fn split(text: &str, line: Line) -> Fields {
    let (mut fields, mut start, mut quote) = (Fields::default(), line.start, None);
    for (i, byte) in text.as_bytes()[line.clone()].iter().enumerate() {
        let at = line.start + i;
        match (byte, quote) {
            (b'"', None) => quote = Some(at),
            (b'"', Some(_)) => quote = None,
            (b',', None) => {
                fields.ranges.push(trim(text, start..at));
                start = at + 1;
            }
            _ => {}
        }
    }
    let rest = trim(text, start..line.end);
    fields.trailing_comma = rest.is_empty() && !fields.ranges.is_empty();
    if !rest.is_empty() {
        fields.ranges.push(rest);
    }
    fields.unclosed = quote;
    fields
}

/// The range without the blanks at its ends.
pub fn trim(text: &str, range: Range<usize>) -> Range<usize> {
    let inner = &text[range.clone()];
    let start = range.start + (inner.len() - inner.trim_start().len());
    start..start + inner.trim().len()
}

/// The first `=` outside quotes.
pub fn equals_sign(text: &str, range: Range<usize>) -> Option<usize> {
    let mut quoted = false;
    text.as_bytes()[range.clone()]
        .iter()
        .position(|&b| {
            quoted ^= b == b'"';
            b == b'=' && !quoted
        })
        .map(|i| range.start + i)
}

/// A word of the text: quotes removed.
pub fn word(text: &str, file: u32, range: Range<usize>) -> Word {
    let raw = &text[range.clone()];
    let quoted = raw.contains('"');
    let content = if quoted { raw.replace('"', "") } else { raw.to_owned() };
    Word { text: content, span: span(file, range), quoted }
}

/// A span of bytes of a file.
pub fn span(file: u32, range: Range<usize>) -> Span {
    Span { file, start: range.start as u32, end: range.end as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str) -> Vec<&str> {
        split(line, 0..line.len()).ranges.into_iter().map(|r| &line[r]).collect()
    }

    #[test]
    fn commas() {
        assert_eq!(fields("1, 2.,\t3"), ["1", "2.", "3"]);
        assert_eq!(fields("1, 2,"), ["1", "2"]);
        assert_eq!(fields(", 8e-05"), ["", "8e-05"]);
        assert_eq!(fields(","), [""]);
        assert_eq!(fields(",,"), ["", ""]);
        assert_eq!(fields("\"a, b\", c"), ["\"a, b\"", "c"]);
    }

    #[test]
    fn quotes() {
        let w = word("\"Set, 1\"", 0, 0..8);
        assert_eq!((w.text.as_str(), w.quoted), ("Set, 1", true));
        assert_eq!(split("a, \"b", 0..5).unclosed, Some(3));
        assert_eq!(equals_sign("\"a=b\"=c", 0..7), Some(5));
    }

    #[test]
    fn kinds() {
        assert_eq!(kind(" *Node"), LineKind::Keyword);
        assert_eq!(kind("***controls"), LineKind::Comment);
        assert_eq!(kind(" \t"), LineKind::Blank);
        assert_eq!(kind("1,2"), LineKind::Data);
    }
}
