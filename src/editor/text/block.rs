//! A block of whole lines, with what is looked up without reading the lines again.

/// Some consecutive lines of a text. All lines but the last one of the text end with a line break.
#[derive(Clone, Debug, Default)]
pub struct TextBlock {
    text: String,
    /// First byte of each line. A line break at the end of the block does not begin a line in it.
    starts: Vec<u32>,
    /// Lines of the block that begin with a keyword.
    keywords: Vec<u32>,
    /// Whether the block has only comments and data lines of numbers.
    is_numeric: bool,
}

/// Target size of a block, bytes.
const SIZE: usize = 1 << 14;

impl TextBlock {
    fn new(text: String) -> TextBlock {
        let mut block = TextBlock { starts: Vec::new(), keywords: Vec::new(), is_numeric: true, text };
        let mut start = 0;
        while start < block.text.len() {
            let end = line_end(&block.text, start);
            let line = block.text[start..end].trim_start();
            if line.starts_with('*') && !line.starts_with("**") {
                block.keywords.push(block.starts.len() as u32);
            }
            block.is_numeric &= line.starts_with("**") || is_numeric(line);
            block.starts.push(start as u32);
            start = end + break_length(&block.text[end..]);
        }
        block
    }

    /// Splits a text into blocks of about the target size, at the ends of lines.
    pub(super) fn split(text: &str) -> Vec<TextBlock> {
        let mut blocks = Vec::with_capacity(text.len() / SIZE + 1);
        let mut remaining = text;
        while remaining.len() > 2 * SIZE {
            let mut middle = SIZE;
            while !remaining.is_char_boundary(middle) {
                middle += 1;
            }
            let end = line_end(remaining, middle);
            let cut = end + break_length(&remaining[end..]);
            blocks.push(TextBlock::new(remaining[..cut].to_owned()));
            remaining = &remaining[cut..];
        }
        if !remaining.is_empty() {
            blocks.push(TextBlock::new(remaining.to_owned()));
        }
        blocks
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the number of lines that begin in the block.
    pub fn line_count(&self) -> usize {
        self.starts.len()
    }

    /// Returns the first byte of a line; the end of the block for lines after it.
    pub fn line_start(&self, line: usize) -> usize {
        self.starts.get(line).map_or(self.text.len(), |start| *start as usize)
    }

    /// Returns the line of a byte; the number of lines for the end of a block that ends with a line break.
    pub fn line_of(&self, byte: usize) -> usize {
        let begun = self.starts.partition_point(|start| *start as usize <= byte);
        if byte == self.text.len() && self.ends_line() { self.starts.len() } else { begun.saturating_sub(1) }
    }

    /// Returns a line without its line break; empty after the last one.
    pub fn line(&self, line: usize) -> &str {
        let start = self.line_start(line);
        &self.text[start..line_end(&self.text, start)]
    }

    /// Returns the lines of the block that begin with a keyword.
    pub fn keywords(&self) -> &[u32] {
        &self.keywords
    }

    /// Returns whether the block has only comments, blank lines and lines of numbers.
    pub fn is_numeric(&self) -> bool {
        self.is_numeric
    }

    /// Returns whether the block ends with a line break.
    pub(super) fn ends_line(&self) -> bool {
        self.text.ends_with(['\n', '\r'])
    }
}

/// Returns the position of the line break that ends the line of a byte; the end of the text without one.
fn line_end(text: &str, start: usize) -> usize {
    text.as_bytes()[start..].iter().position(|b| *b == b'\n' || *b == b'\r').map_or(text.len(), |i| start + i)
}

/// Returns the length of the line break at the start of a text.
fn break_length(text: &str) -> usize {
    match text.as_bytes() {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// Returns whether a line has only numbers, commas and blanks.
fn is_numeric(line: &str) -> bool {
    line.bytes()
        .all(|b| matches!(b, b'0'..=b'9' | b'.' | b',' | b'+' | b'-' | b'e' | b'E' | b'd' | b'D' | b' ' | b'\t'))
}

#[cfg(test)]
mod tests {
    use super::TextBlock;

    #[test]
    fn lines_end_with_any_line_break() {
        let block = TextBlock::new("*Node\r\n1, 2.\r** c\n\n3".into());
        let lines: Vec<&str> = (0..6).map(|line| block.line(line)).collect();
        assert_eq!(lines, ["*Node", "1, 2.", "** c", "", "3", ""]);
        assert_eq!((block.line_count(), block.keywords(), block.is_numeric()), (5, &[0][..], false));
        assert!(TextBlock::new("** words\n1, 2.e-3\n".into()).is_numeric());
    }
}
