//! The text of an open file in blocks of lines. An edit builds the blocks that it touches again, and a copy shares all
//! blocks, so that another thread can check the text while it is edited.

use std::ops::Range;
use std::sync::Arc;

use super::block::TextBlock;
use super::position::{ColumnEncoding, TextPosition, TextRange};

/// An editable text.
#[derive(Clone, Debug, Default)]
pub struct TextBuffer {
    blocks: Vec<Arc<TextBlock>>,
    /// First line of each block.
    first_lines: Vec<u32>,
}

/// Place of a byte: block, and byte in it.
type BlockPlace = (usize, usize);

impl TextBuffer {
    /// Creates a buffer with a text.
    pub fn new(text: &str) -> TextBuffer {
        let mut buffer =
            TextBuffer { blocks: TextBlock::split(text).into_iter().map(Arc::new).collect(), first_lines: Vec::new() };
        buffer.count_lines(0);
        buffer
    }

    /// Returns the whole text.
    pub fn text(&self) -> String {
        let mut text = String::with_capacity(self.byte_count());
        self.blocks.iter().for_each(|block| text += block.text());
        text
    }

    /// Returns the number of bytes.
    pub fn byte_count(&self) -> usize {
        self.blocks.iter().map(|block| block.text().len()).sum()
    }

    /// Returns the number of lines; a text that ends with a line break has an empty last line.
    pub fn line_count(&self) -> u32 {
        let ends_line = self.blocks.last().is_none_or(|block| block.ends_line());
        self.lines_before(self.blocks.len()) + u32::from(ends_line)
    }

    /// Returns a line without its line break; empty after the last one.
    pub fn line(&self, line: u32) -> &str {
        let block = self.block_of(line);
        self.blocks.get(block).map_or("", |found| found.line((line - self.first_lines[block]) as usize))
    }

    /// Returns the blocks with their first lines.
    pub fn blocks(&self) -> impl Iterator<Item = (u32, &TextBlock)> {
        self.first_lines.iter().copied().zip(self.blocks.iter().map(|block| &**block))
    }

    /// Returns the last keyword line at or before a line.
    pub fn keyword_line_at(&self, line: u32) -> Option<u32> {
        let last = self.block_of(line);
        let in_block = |block: usize| {
            let first = self.first_lines[block];
            let lines = self.blocks[block].keywords();
            lines[..lines.partition_point(|at| first + at <= line)].last().map(|at| first + at)
        };
        (0..self.blocks.len().min(last + 1)).rev().find_map(in_block)
    }

    /// Returns the first keyword line after a line; the number of lines without one.
    pub fn next_keyword_line(&self, line: u32) -> u32 {
        let in_block = |block: usize| {
            let first = self.first_lines[block];
            self.blocks[block].keywords().iter().map(|at| first + at).find(|at| *at > line)
        };
        (self.block_of(line)..self.blocks.len()).find_map(in_block).unwrap_or(self.line_count())
    }

    /// Returns the position at the end of the text.
    pub fn end(&self, encoding: ColumnEncoding) -> TextPosition {
        let line = self.line_count() - 1;
        TextPosition { line, character: encoding.width(self.line(line)) }
    }

    /// Replaces a range by a text. Positions after the end of a line or of the text are at this end. Returns the lines
    /// of the range before the edit.
    pub fn replace(&mut self, range: TextRange, text: &str, encoding: ColumnEncoding) -> Range<u32> {
        let start = self.place(range.start.min(range.end), encoding);
        let end = self.place(range.end.max(range.start), encoding);
        let lines = self.line_at(start)..self.line_at(end) + 1;
        let (mut first, mut last) = (start.0, (end.0 + 1).min(self.blocks.len()));
        let head = self.blocks.get(start.0).map_or("", |block| &block.text()[..start.1]);
        let tail = self.blocks.get(end.0).map_or("", |block| &block.text()[end.1..]);
        let mut joined = [head, text, tail].concat();
        // A line, and a line break of two characters, must not be divided.
        if (joined.is_empty() || joined.starts_with('\n')) && first > 0 {
            first -= 1;
            joined.insert_str(0, self.blocks[first].text());
        }
        while last < self.blocks.len() && !joined.ends_with('\n') {
            joined += self.blocks[last].text();
            last += 1;
        }
        let blocks = TextBlock::split(&joined).into_iter().map(Arc::new);
        self.blocks.splice(first..last, blocks);
        self.count_lines(first);
        lines
    }

    fn place(&self, position: TextPosition, encoding: ColumnEncoding) -> BlockPlace {
        if position.line >= self.line_count() {
            return self.end_place();
        }
        let block = self.block_of(position.line);
        let Some(found) = self.blocks.get(block) else { return (block, 0) };
        let line = (position.line - self.first_lines[block]) as usize;
        (block, found.line_start(line) + encoding.byte(found.line(line), position.character))
    }

    /// Returns the place after the last character.
    fn end_place(&self) -> BlockPlace {
        match self.blocks.last() {
            Some(block) => (self.blocks.len() - 1, block.text().len()),
            None => (0, 0),
        }
    }

    fn line_at(&self, (block, byte): BlockPlace) -> u32 {
        let Some(found) = self.blocks.get(block) else { return 0 };
        self.first_lines[block] + found.line_of(byte) as u32
    }

    /// Returns the block in which a line begins; for the empty last line the last block.
    fn block_of(&self, line: u32) -> usize {
        self.first_lines.partition_point(|first| *first <= line).saturating_sub(1)
    }

    fn lines_before(&self, block: usize) -> u32 {
        match block.checked_sub(1) {
            Some(last) => self.first_lines[last] + self.blocks[last].line_count() as u32,
            None => 0,
        }
    }

    fn count_lines(&mut self, first: usize) {
        self.first_lines.truncate(first);
        let mut line = self.lines_before(first);
        for block in &self.blocks[first..] {
            self.first_lines.push(line);
            line += block.line_count() as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Applies an edit to a text without blocks.
    fn edited(text: &str, range: TextRange, new: &str, encoding: ColumnEncoding) -> String {
        let offset = |position: TextPosition| {
            let mut start = 0;
            for _ in 0..position.line {
                let following = &text[start..];
                let Some(end) = following.find(['\n', '\r']) else { return text.len() };
                start += end + if following[end..].starts_with("\r\n") { 2 } else { 1 };
            }
            let line = text[start..].split(['\n', '\r']).next().unwrap_or_default();
            start + encoding.byte(line, position.character)
        };
        let (a, b) = (offset(range.start.min(range.end)), offset(range.end.max(range.start)));
        [&text[..a], new, &text[b..]].concat()
    }

    fn lines(text: &str) -> Vec<String> {
        let breaks = text.replace("\r\n", "\n").replace('\r', "\n");
        breaks.split('\n').map(str::to_owned).collect()
    }

    fn assert_same(buffer: &TextBuffer, text: &str) {
        assert_eq!(buffer.text(), text);
        let expected_lines = lines(text);
        assert_eq!(buffer.line_count() as usize, expected_lines.len());
        for (i, line) in expected_lines.iter().enumerate() {
            assert_eq!(buffer.line(i as u32), line, "line {i}");
        }
        let is_keyword = |line: &String| line.trim_start().starts_with('*') && !line.trim_start().starts_with("**");
        let mut last = None;
        for (i, line) in expected_lines.iter().enumerate() {
            last = if is_keyword(line) { Some(i as u32) } else { last };
            assert_eq!(buffer.keyword_line_at(i as u32), last, "keyword of line {i}");
        }
    }

    /// Texts that edits insert.
    const PIECES: &[&str] =
        &["*Node\n", "1, 2.5, 3\r\n", "\r", "\n", "** \u{e4}\u{1f600}\n", "", "x", "**", "*", "a\r\nb\rc\nd"];

    fn piece() -> impl Strategy<Value = String> {
        prop::collection::vec(prop::sample::select(PIECES), 0..4).prop_map(|all| all.concat())
    }

    proptest! {
        #[test]
        fn edits_give_the_text_of_the_client(
            lines in 0_usize..4000,
            edits in prop::collection::vec((0_u32..5000, 0_u32..12, 0_u32..3, 0_u32..12, piece()), 1..12),
            utf8: bool,
        ) {
            let encoding = if utf8 { ColumnEncoding::Utf8 } else { ColumnEncoding::Utf16 };
            let mut text: String = (0..lines).map(|i| format!("{i}, 0.5, \u{e4}{}", if i % 3 == 0 { "\r\n" } else { "\n" })).collect();
            let mut buffer = TextBuffer::new(&text);
            for (line, character, more, end, new) in edits {
                let last = buffer.line_count();
                let line = line % (last + 2);
                let range = TextRange {
                    start: TextPosition { line, character },
                    end: TextPosition { line: line + more, character: end },
                };
                text = edited(&text, range, &new, encoding);
                buffer.replace(range, &new, encoding);
                prop_assert_eq!(&buffer.text(), &text);
            }
            assert_same(&buffer, &text);
        }
    }

    #[test]
    fn line_breaks_are_joined_and_divided() {
        let mut buffer = TextBuffer::new("a\rb\nc");
        buffer.replace(
            TextRange { start: TextPosition { line: 1, character: 0 }, end: TextPosition { line: 1, character: 1 } },
            "",
            ColumnEncoding::Utf16,
        );
        assert_same(&buffer, "a\r\nc");
        buffer.replace(
            TextRange { start: TextPosition::default(), end: buffer.end(ColumnEncoding::Utf16) },
            "",
            ColumnEncoding::Utf16,
        );
        assert_same(&buffer, "");
        buffer.replace(TextRange::default(), "*A\n", ColumnEncoding::Utf16);
        assert_same(&buffer, "*A\n");
    }
}
