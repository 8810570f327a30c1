//! Folding: each card with its data lines, and parts, steps and similar blocks.

use serde_json::{Value, json};

use crate::deck::keywords::{NameLookup, find_keyword};
use crate::deck::lexer::{LineKind, kind};
use crate::text::TextBuffer;

/// Returns the ranges that can be folded.
pub fn folding_ranges(buffer: &TextBuffer) -> Vec<Value> {
    let mut ranges = Vec::new();
    let mut blocks: Vec<(String, u32)> = Vec::new();
    let mut push = |start: u32, end: u32| {
        if end > start {
            ranges.push(json!({ "startLine": start, "endLine": end }));
        }
    };
    let lines: Vec<u32> =
        buffer.blocks().flat_map(|(first, block)| block.keywords().iter().map(move |line| first + line)).collect();
    for (i, &line) in lines.iter().enumerate() {
        let next = lines.get(i + 1).copied().unwrap_or(buffer.line_count());
        push(line, last_data_line(buffer, line, next));
        let Some(name) = block_keyword(buffer.line(line)) else { continue };
        match name.strip_prefix("END ") {
            Some(begun) => {
                if let Some(at) = blocks.iter().rposition(|(open, _)| open == begun) {
                    push(blocks[at].1, line);
                    blocks.truncate(at);
                }
            }
            None => blocks.push((name.to_owned(), line)),
        }
    }
    ranges
}

/// Returns the last data line before the next keyword, without comments and blank lines at the end.
fn last_data_line(buffer: &TextBuffer, line: u32, next: u32) -> u32 {
    (line + 1..next).rev().find(|at| kind(buffer.line(*at)) == LineKind::Data).unwrap_or(line)
}

/// Returns the keyword of a line that begins or ends a block.
fn block_keyword(line: &str) -> Option<&'static str> {
    let text = line.trim().trim_start_matches('*').split(',').next()?;
    let NameLookup::Found(keyword) = find_keyword(text) else { return None };
    let blocks = ["PART", "ASSEMBLY", "INSTANCE", "STEP"];
    blocks.contains(&keyword.name.trim_start_matches("END ")).then_some(keyword.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_and_blocks_are_folded() {
        let buffer = TextBuffer::new("*Part, name=P\n*Node\n1, 0.\n2, 0.\n** c\n*End Part\n*Step\n*End Step\n");
        let folded: Vec<(u64, u64)> = folding_ranges(&buffer)
            .iter()
            .filter_map(|range| Some((range["startLine"].as_u64()?, range["endLine"].as_u64()?)))
            .collect();
        assert_eq!(folded, [(1, 3), (0, 5), (6, 7)]);
    }
}
