//! Formatting: the fields of consecutive data lines in columns. Words, lines and comments remain as they are, so that
//! the deck has the same meaning.

use super::context::KeywordLine;
use crate::deck::keywords::{DataShape, Keyword};
use crate::deck::lexer::{LineFields, LineKind, kind, split};
use crate::protocol::TextEdit;
use crate::text::{ColumnEncoding, TextBuffer, TextRange};

/// Longest formatted line, characters.
const LONGEST: usize = 80;
/// Largest number of lines that are formatted at once.
pub const MOST_LINES: u32 = 300_000;

/// Cards whose data lines are not fields.
const FREE_TEXT: [&str; 3] = ["HEADING", "PARAMETER", "OUTPUT EXPRESSION"];

/// Returns the edits that format the lines from `first` to before `last`.
pub fn formatting_edits(buffer: &TextBuffer, first: u32, last: u32, encoding: ColumnEncoding) -> Vec<TextEdit> {
    let mut edits = Vec::new();
    let mut line = first;
    while line < last {
        let data = next_run(buffer, line, last);
        if data.end > data.start && has_columns(buffer, data.start, encoding) {
            format_run(buffer, &data, encoding, &mut edits);
        }
        line = data.end.max(line + 1);
    }
    edits
}

/// Returns the next consecutive data lines.
fn next_run(buffer: &TextBuffer, from: u32, last: u32) -> std::ops::Range<u32> {
    let is_data = |line: &u32| kind(buffer.line(*line)) == LineKind::Data;
    let start = (from..last).find(is_data).unwrap_or(last);
    let end = (start..last).find(|line| !is_data(line)).unwrap_or(last);
    start..end
}

/// Returns whether the data lines of the card at a line have fields.
fn has_columns(buffer: &TextBuffer, line: u32, encoding: ColumnEncoding) -> bool {
    let Some(head) = buffer.keyword_line_at(line).map(|at| KeywordLine::read(buffer, at, encoding)) else {
        return false;
    };
    let is_free = |keyword: &Keyword| FREE_TEXT.contains(&keyword.name);
    let known = head.keyword.is_some_and(|keyword| !is_free(keyword) && !matches!(head.shape(), DataShape::Text(_)));
    known && line >= head.end
}

fn format_run(buffer: &TextBuffer, run: &std::ops::Range<u32>, encoding: ColumnEncoding, edits: &mut Vec<TextEdit>) {
    let rows = || run.clone().map(|line| (line, buffer.line(line)));
    let fields_of = |text: &str| split(text, 0..text.len());
    let mut widths: Vec<usize> = Vec::new();
    for (_, text) in rows() {
        let fields = fields_of(text);
        widths.resize(widths.len().max(fields.ranges.len()), 0);
        for (width, bytes) in widths.iter_mut().zip(fields.ranges) {
            *width = (*width).max(text[bytes].chars().count());
        }
    }
    for (line, text) in rows() {
        let fields = fields_of(text);
        let is_foreign = text.trim_start().starts_with(['$', '#']) || fields.unclosed.is_some();
        let new_text = formatted(text, &fields, &widths);
        if !is_foreign && new_text != text && new_text.chars().count() <= LONGEST {
            edits.push(TextEdit { range: TextRange::on_line(line, 0, encoding.width(text)), new_text });
        }
    }
}

/// Joins fields with commas, right-aligned in their columns.
fn formatted(line: &str, fields: &LineFields, widths: &[usize]) -> String {
    let mut text = String::new();
    for (column, (bytes, width)) in fields.ranges.iter().zip(widths).enumerate() {
        text += if column == 0 { " " } else { ", " };
        text += &format!("{:>width$}", &line[bytes.clone()]);
    }
    // A field that is empty at the end of the line needs its comma.
    if fields.trailing_comma {
        text.push(',');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_aligned_and_remain_the_same() {
        let deck = "*Heading\n a,b\n*Node\n1,0.,0.\n 20, 1.5,  -0.25\n** c\n*Nset, nset=\"A, b\"\n1,\n20,\n*Boundary\n\"A, b\",1\n";
        let buffer = TextBuffer::new(deck);
        let edits = formatting_edits(&buffer, 0, buffer.line_count(), ColumnEncoding::Utf16);
        let mut formatted = buffer.clone();
        for edit in &edits {
            formatted.replace(edit.range, &edit.new_text, ColumnEncoding::Utf16);
        }
        assert_eq!(
            formatted.text(),
            "*Heading\n a,b\n*Node\n  1,  0.,    0.\n 20, 1.5, -0.25\n** c\n*Nset, nset=\"A, b\"\n  1,\n 20,\n*Boundary\n \"A, b\", 1\n"
        );
        assert!(formatting_edits(&formatted, 0, formatted.line_count(), ColumnEncoding::Utf16).is_empty());
    }
}
