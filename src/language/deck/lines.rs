//! Lines of a deck in reading order, with those of included files in place of `*INCLUDE`.

use std::collections::HashMap;

use super::keywords::{NameLookup, find_keyword};
use super::lexer::{self, LineIterator, LineKind};
use super::source::Span;
use super::syntax::{Card, Deck};

/// Part of a card that a line contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRole {
    /// The keyword line or its continuation.
    Keyword,
    /// A data line.
    Data,
    /// A comment, a blank line, or a line of a `*PARAMETER` block.
    Other,
}

/// A line of a deck.
#[derive(Clone, Copy, Debug)]
pub struct DeckLine {
    /// Position of the whole line, without its line end.
    pub span: Span,
    /// Index of the card that contains the line, or of the last card before the line.
    pub card: Option<usize>,
    /// Part of the card that the line contains.
    pub role: LineRole,
}

/// Returns the lines of a deck without errors.
pub fn in_reading_order(deck: &Deck) -> Vec<DeckLine> {
    let by_position = |(index, card): (usize, &Card)| ((card.span.file, card.span.start), index);
    let included = deck.sources.files().iter().zip(0..).filter_map(|(file, index)| Some((file.included_at?, index)));
    let mut reader = LineReader {
        deck,
        cards: deck.cards.iter().enumerate().map(by_position).collect(),
        included: included.collect(),
        lines: Vec::new(),
        card: None,
    };
    reader.file(0);
    reader.lines
}

struct LineReader<'a> {
    deck: &'a Deck,
    /// Indices of cards by file and first byte.
    cards: HashMap<(u32, u32), usize>,
    /// File names in the deck, and the files that they include.
    included: Vec<(Span, u32)>,
    lines: Vec<DeckLine>,
    /// Last card; `None` in a `*PARAMETER` block.
    card: Option<usize>,
}

impl LineReader<'_> {
    fn file(&mut self, file: u32) {
        let Some(source) = self.deck.sources.files().get(file as usize) else { return };
        let inside: Vec<(Span, u32)> = self.included.iter().filter(|i| i.0.file == file).copied().collect();
        let (mut keyword_end, mut include_end) = (0, 0);
        for range in LineIterator::new(&source.text) {
            let trimmed = lexer::span(file, lexer::trim(&source.text, range.clone()));
            let span = lexer::span(file, range.clone());
            let kind = lexer::kind(&source.text[range]);
            if kind == LineKind::Keyword {
                let card = self.cards.get(&(file, trimmed.start)).copied();
                if is_include(&source.text[trimmed.start as usize..trimmed.end as usize]) {
                    include_end = inside.iter().map(|i| i.0.end).find(|end| *end > trimmed.start).unwrap_or(0);
                } else {
                    self.card = card;
                    keyword_end = card.map_or(0, |card| self.deck.cards[card].keyword_end());
                }
            }
            let role = match kind {
                LineKind::Blank | LineKind::Comment => LineRole::Other,
                _ if self.card.is_none() => LineRole::Other,
                _ if trimmed.start < keyword_end || kind == LineKind::Keyword => LineRole::Keyword,
                _ => LineRole::Data,
            };
            if trimmed.start >= include_end || role == LineRole::Other && kind == LineKind::Comment {
                self.lines.push(DeckLine { span, card: self.card, role });
            }
            let is_on_line = |i: &&(Span, u32)| (span.start..span.end).contains(&i.0.start);
            inside.iter().filter(is_on_line).for_each(|i| self.file(i.1));
        }
    }
}

fn is_include(line: &str) -> bool {
    let keyword = line.trim_start_matches('*').split(',').next().unwrap_or_default();
    matches!(find_keyword(keyword), NameLookup::Found(keyword) if keyword.name == "INCLUDE")
}
