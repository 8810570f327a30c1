//! Positions in a text: line and column, counted in the units that client and server have agreed on.

use serde::{Deserialize, Serialize};

/// Unit of columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColumnEncoding {
    /// Bytes of UTF-8.
    Utf8,
    /// Code units of UTF-16, the default of the protocol.
    #[default]
    Utf16,
}

/// Line and column, both counted from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TextPosition {
    /// Line.
    pub line: u32,
    /// Column, in units of the agreed [`ColumnEncoding`].
    pub character: u32,
}

/// Range from the first position to the one after the last character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TextRange {
    /// First position.
    pub start: TextPosition,
    /// Position after the last character.
    pub end: TextPosition,
}

impl TextRange {
    /// Returns the range between two columns of a line.
    pub fn on_line(line: u32, start: u32, end: u32) -> TextRange {
        TextRange { start: TextPosition { line, character: start }, end: TextPosition { line, character: end } }
    }

    /// Returns whether a position is in the range, its end included.
    pub fn touches(&self, position: TextPosition) -> bool {
        self.start <= position && position <= self.end
    }

    /// Returns whether two ranges have a position in common, their ends included.
    pub fn meets(&self, other: &TextRange) -> bool {
        self.start <= other.end && other.start <= self.end
    }
}

impl ColumnEncoding {
    /// Returns the length of a text in units of columns.
    pub fn width(self, text: &str) -> u32 {
        match self {
            ColumnEncoding::Utf8 => text.len() as u32,
            ColumnEncoding::Utf16 if text.is_ascii() => text.len() as u32,
            ColumnEncoding::Utf16 => text.chars().map(|c| c.len_utf16() as u32).sum(),
        }
    }

    /// Returns the byte of a column in a line; the end of the line for columns after it. A column inside a character is
    /// that of its first byte.
    pub fn byte(self, line: &str, column: u32) -> usize {
        let column = column as usize;
        match self {
            _ if line.is_ascii() => column.min(line.len()),
            ColumnEncoding::Utf8 => {
                let mut byte = column.min(line.len());
                while !line.is_char_boundary(byte) {
                    byte -= 1;
                }
                byte
            }
            ColumnEncoding::Utf16 => {
                let mut units = 0;
                for (byte, c) in line.char_indices() {
                    units += c.len_utf16();
                    if units > column {
                        return byte;
                    }
                }
                line.len()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ColumnEncoding;

    #[test]
    fn columns_count_units_of_the_encoding() {
        let line = "a\u{e4}\u{1f600}b";
        assert_eq!((ColumnEncoding::Utf8.width(line), ColumnEncoding::Utf16.width(line)), (8, 5));
        assert_eq!([0, 1, 2, 3, 4, 5, 9].map(|c| ColumnEncoding::Utf16.byte(line, c)), [0, 1, 3, 3, 7, 8, 8]);
        assert_eq!([0, 1, 2, 3, 4, 7, 9].map(|c| ColumnEncoding::Utf8.byte(line, c)), [0, 1, 1, 3, 3, 7, 8]);
    }
}
