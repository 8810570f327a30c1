//! The outline of a deck: its cards without long tables of numbers, the diagnostics of its syntax, and its names. It is
//! made again after each edit, so that it must not take longer for a large mesh.

mod names;
mod reduced;

use std::path::{Path, PathBuf};

use crate::deck::{self, Deck, Diagnostics, Sources, Span};
use crate::text::{ColumnEncoding, TextBuffer, TextPosition, TextRange};
pub use names::{NameTable, NameUse};
pub use reduced::{LineMap, reduced};

#[derive(Debug, Default)]
pub struct DeckOutline {
    /// The deck without long tables of numbers.
    pub deck: Deck,
    /// Diagnostics of the syntax.
    pub diagnostics: Diagnostics,
    pub names: NameTable,
    /// Paths of the files, in the order of the sources of the deck, with their lines.
    files: Vec<(PathBuf, LineMap)>,
}

impl DeckOutline {
    /// Reads the outline of a deck. `included` returns the text of an included file.
    pub fn read(path: &Path, text: &TextBuffer, included: &dyn Fn(&Path) -> Option<TextBuffer>) -> DeckOutline {
        let (main, map) = reduced(text);
        let maps = std::cell::RefCell::new(vec![(path.to_owned(), map)]);
        let open = |path: &Path| {
            let (text, map) = reduced(&included(path)?);
            maps.borrow_mut().push((path.to_owned(), map));
            Some(text)
        };
        let (deck, diagnostics) = deck::read_open(path, main, &open);
        let maps = maps.into_inner();
        let file_map = |path: &PathBuf| {
            let known = maps.iter().find(|(of, _)| of == path).map(|(_, map)| map.clone());
            (path.clone(), known.unwrap_or_default())
        };
        let files = deck.sources.files().iter().map(|file| file_map(&file.path)).collect();
        let names = NameTable::of(&deck);
        DeckOutline { deck, diagnostics, names, files }
    }

    /// Returns the paths of the files of the deck; the first one is the deck itself.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }

    /// Returns the line at which a span begins.
    pub fn line(&self, span: Span) -> Option<u32> {
        let (_, map) = self.files.get(span.file as usize)?;
        Some(map.line(self.deck.sources.line_column(span).0.checked_sub(1)? as u32))
    }

    /// Returns the path and range of a span.
    pub fn locate(&self, span: Span, encoding: ColumnEncoding) -> Option<(&Path, TextRange)> {
        let (path, map) = self.files.get(span.file as usize)?;
        let range = range_of_span(&self.deck.sources, span, encoding)?;
        let real = |position: TextPosition| TextPosition { line: map.line(position.line), ..position };
        Some((path, TextRange { start: real(range.start), end: real(range.end) }))
    }
}

/// Returns the range of a span in the text of its file; `None` if it is in no file.
pub fn range_of_span(sources: &Sources, span: Span, encoding: ColumnEncoding) -> Option<TextRange> {
    let file = sources.file(span)?;
    let first = sources.line_column(span).0.checked_sub(1)? as u32;
    let start = span.start as usize;
    let line_start = file.text.get(..start)?.rfind('\n').map_or(0, |at| at + 1);
    let start = TextPosition { line: first, character: encoding.width(&file.text[line_start..start]) };
    let marked = sources.text(span);
    let end = match marked.rfind('\n') {
        None => TextPosition { line: first, character: start.character + encoding.width(marked) },
        Some(at) => {
            let line = first + marked.bytes().filter(|b| *b == b'\n').count() as u32;
            TextPosition { line, character: encoding.width(&marked[at + 1..]) }
        }
    };
    Some(TextRange { start, end })
}
