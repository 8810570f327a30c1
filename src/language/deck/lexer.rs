//! Lexer: splits the text of a deck into lines, and lines into comma-separated fields.

use std::ops::Range;

use super::source::Span;
use super::syntax::Word;

/// Byte range of a physical line in its file, without the line end.
pub type LineRange = Range<usize>;

/// Meaning of a line, determined from its first characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// A line of blanks only.
    Blank,
    /// A comment: begins with `**`.
    Comment,
    /// A keyword line: begins with `*`.
    Keyword,
    /// A data line: any other line.
    Data,
}

/// Iterator over the lines of a text.
#[derive(Clone, Debug)]
pub struct LineIterator<'a> {
    text: &'a str,
    next: usize,
}

impl<'a> LineIterator<'a> {
    /// Iterates over all lines of `text`.
    pub fn new(text: &'a str) -> Self {
        LineIterator { text, next: 0 }
    }

    /// Returns the next line that is neither blank nor a comment, and the iterator after it, without advancing.
    pub fn peek_significant(&self) -> Option<(LineRange, LineIterator<'a>)> {
        let mut ahead = self.clone();
        while let Some(line) = ahead.next() {
            if !matches!(kind(&self.text[line.clone()]), LineKind::Blank | LineKind::Comment) {
                return Some((line, ahead));
            }
        }
        None
    }
}

impl Iterator for LineIterator<'_> {
    type Item = LineRange;

    fn next(&mut self) -> Option<LineRange> {
        let start = self.next;
        if start >= self.text.len() {
            return None;
        }
        let end = self.text[start..].find('\n').map_or(self.text.len(), |i| start + i);
        self.next = end + 1;
        Some(start..end)
    }
}

/// Determines whether a line is a keyword, comment, data or blank line.
pub fn kind(line: &str) -> LineKind {
    let line = line.trim_start();
    match () {
        () if line.is_empty() => LineKind::Blank,
        () if line.starts_with("**") => LineKind::Comment,
        () if line.starts_with('*') => LineKind::Keyword,
        () => LineKind::Data,
    }
}

/// Comma-separated fields of a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineFields {
    /// Byte ranges of the fields in the file, without blanks at their ends. A trailing comma adds no field.
    pub ranges: Vec<Range<usize>>,
    /// Whether the line ends with a comma.
    pub trailing_comma: bool,
    /// Position of an opening quote without a closing one.
    pub unclosed: Option<usize>,
}

/// Splits a line at the commas outside quotes.
pub fn split(text: &str, line: LineRange) -> LineFields {
    let (mut fields, mut start, mut quote) = (LineFields::default(), line.start, None);
    for (i, byte) in text.as_bytes()[line.clone()].iter().enumerate() {
        let position = line.start + i;
        match (byte, quote) {
            (b'"', None) => quote = Some(position),
            (b'"', Some(_)) => quote = None,
            (b',', None) => {
                fields.ranges.push(trim(text, start..position));
                start = position + 1;
            }
            _ => {}
        }
    }
    let last = trim(text, start..line.end);
    fields.trailing_comma = last.is_empty() && !fields.ranges.is_empty();
    if !last.is_empty() {
        fields.ranges.push(last);
    }
    fields.unclosed = quote;
    fields
}

/// Returns the range without blanks at its ends.
pub fn trim(text: &str, range: Range<usize>) -> Range<usize> {
    let inner = &text[range.clone()];
    let start = range.start + (inner.len() - inner.trim_start().len());
    start..start + inner.trim().len()
}

/// Returns the position of the first `=` outside quotes.
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

/// Returns the text of a range as a word, without its quotes.
pub fn word(text: &str, file: u32, range: Range<usize>) -> Word {
    let raw = &text[range.clone()];
    let quoted = raw.contains('"');
    let content = if quoted { raw.replace('"', "") } else { raw.to_owned() };
    Word { text: content, span: span(file, range), quoted }
}

/// Converts a byte range of a file to a span.
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
    fn fields_are_separated_by_commas() {
        assert_eq!(fields("1, 2.,\t3"), ["1", "2.", "3"]);
        assert_eq!(fields("1, 2,"), ["1", "2"]);
        assert_eq!(fields(", 8e-05"), ["", "8e-05"]);
        assert_eq!(fields(","), [""]);
        assert_eq!(fields(",,"), ["", ""]);
        assert_eq!(fields("\"a, b\", c"), ["\"a, b\"", "c"]);
    }

    #[test]
    fn quotes_protect_commas_and_equals_signs() {
        let w = word("\"Set, 1\"", 0, 0..8);
        assert_eq!((w.text.as_str(), w.quoted), ("Set, 1", true));
        assert_eq!(split("a, \"b", 0..5).unclosed, Some(3));
        assert_eq!(equals_sign("\"a=b\"=c", 0..7), Some(5));
    }

    #[test]
    fn first_characters_determine_the_line_kind() {
        assert_eq!(kind(" *Node"), LineKind::Keyword);
        assert_eq!(kind("***controls"), LineKind::Comment);
        assert_eq!(kind(" \t"), LineKind::Blank);
        assert_eq!(kind("1,2"), LineKind::Data);
    }
}
