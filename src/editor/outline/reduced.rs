//! The text of a file without long tables of numbers, whose lines neither define names nor have errors of syntax.

use crate::text::TextBuffer;

/// Lines of a file by the lines of its reduced text.
#[derive(Clone, Debug, Default)]
pub struct LineMap {
    /// First line of each kept piece: in the reduced text, and in the file.
    pieces: Vec<(u32, u32)>,
}

impl LineMap {
    /// Returns the line of the file for a line of the reduced text.
    pub fn line(&self, line: u32) -> u32 {
        let piece = self.pieces.partition_point(|(first, _)| *first <= line).checked_sub(1);
        piece.map_or(line, |at| self.pieces[at].1 + line - self.pieces[at].0)
    }
}

/// Returns a text without the blocks that have only numbers and comments, and its lines. The first block is kept: data
/// lines before the first keyword are an error.
pub fn reduced(buffer: &TextBuffer) -> (String, LineMap) {
    let (mut text, mut map, mut count) = (String::new(), LineMap::default(), 0);
    for (i, (first, block)) in buffer.blocks().enumerate() {
        if i == 0 || !block.is_numeric() {
            map.pieces.push((count, first));
            text += block.text();
            count += block.line_count() as u32;
        }
    }
    (text, map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_tables_are_left_out_and_lines_are_found() {
        let nodes: String = (1..9000).map(|i| format!("{i}, 0.5, {i}.\n")).collect();
        let buffer = TextBuffer::new(&format!("*Node\n{nodes}*Elset, elset=A\n7\n"));
        let (text, map) = reduced(&buffer);
        assert!(text.len() < 70_000 && text.starts_with("*Node\n1, "), "{}", text.len());
        let line = text.lines().position(|line| line.starts_with("*Elset")).expect("kept") as u32;
        assert_eq!((map.line(0), map.line(3), map.line(line)), (0, 3, 9000));
    }
}
