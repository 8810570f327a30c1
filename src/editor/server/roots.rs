//! Decks that are checked: open files that no other deck includes, and decks on disk that include an open file.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::publish::FileDiagnostic;
use crate::deck::files;
use crate::features::DeckFacts;
use crate::outline::DeckOutline;
use crate::text::TextRange;

#[derive(Default)]
pub struct RootDeck {
    /// Outline of the newest text.
    pub outline: DeckOutline,
    /// Whether a file of the deck has been edited after the outline was made.
    pub needs_outline: bool,
    /// Whether the newest text has not been sent to the check.
    pub needs_check: bool,
    /// Number of the newest check request.
    pub generation: u64,
    /// Diagnostics to show: those of the last check, moved by later edits, and those of the newest syntax.
    pub diagnostics: Vec<FileDiagnostic>,
    /// Properties of the model at the last check without errors.
    pub facts: Option<DeckFacts>,
    pub duration: Option<Duration>,
}

impl RootDeck {
    /// Creates a deck that has not been read.
    pub fn unread() -> RootDeck {
        RootDeck { needs_outline: true, needs_check: true, ..RootDeck::default() }
    }

    pub fn mark_edited(&mut self) {
        self.needs_outline = true;
        self.needs_check = true;
    }

    /// Moves the diagnostics of a file with an edit of the lines `edited`, after which the text has `added` more lines.
    pub fn move_diagnostics(&mut self, path: &Path, edited: &std::ops::Range<u32>, added: i64) {
        let moved = |line: u32| (i64::from(line) + added).max(i64::from(edited.start)) as u32;
        let move_range = |range: &mut TextRange| {
            for position in [&mut range.start, &mut range.end] {
                if position.line >= edited.end {
                    position.line = moved(position.line);
                }
            }
        };
        for diagnostic in &mut self.diagnostics {
            if diagnostic.path == path {
                move_range(&mut diagnostic.range);
                diagnostic.correction = None;
            }
            let of_file = diagnostic.related.iter_mut().filter(|related| related.path == path);
            of_file.for_each(|related| move_range(&mut related.range));
        }
    }
}

/// Largest number of files in a folder in which decks are searched, and their largest size, bytes.
const SEARCH_LIMIT: (usize, u64) = (200, 4 << 20);

/// Searches the folder of a file and the folder above for a deck that includes the file.
pub fn find_including_deck(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?.to_lowercase();
    let folder = path.parent()?;
    [Some(folder), folder.parent()].into_iter().flatten().find_map(|folder| {
        let entries = std::fs::read_dir(folder).ok()?.flatten().take(SEARCH_LIMIT.0);
        let mut decks: Vec<PathBuf> =
            entries.map(|entry| entry.path()).filter(|other| is_deck(other) && other != path).collect();
        decks.sort();
        decks.into_iter().find(|deck| includes(deck, &name))
    })
}

fn is_deck(path: &Path) -> bool {
    let is_inp = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("inp"));
    is_inp && path.metadata().is_ok_and(|metadata| metadata.is_file() && metadata.len() <= SEARCH_LIMIT.1)
}

/// Returns whether a deck has a step and a line `*INCLUDE` with a file of this name.
fn includes(deck: &Path, name: &str) -> bool {
    let Ok(text) = files::read_text(deck) else { return false };
    let text = text.to_lowercase();
    let mut lines = text.lines().map(str::trim_start);
    let is_include = |line: &str| line.starts_with("*include") && line.contains(name);
    lines.clone().any(|line| line.starts_with("*step")) && lines.any(is_include)
}
