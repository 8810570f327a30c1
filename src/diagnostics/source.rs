//! Source files and spans, which locate every word of a deck by file, line and column.

use std::panic::Location;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A byte range of a source file.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// Index of the file in [`Sources`].
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

/// File index of spans of models that are composed in Rust, without a deck.
const COMPOSED: u32 = u32::MAX;
/// Counter that gives each composed item its own span, also if one line of Rust creates several.
static PIECES: AtomicU32 = AtomicU32::new(0);

impl Span {
    /// Returns a span for a model item composed in Rust: the line of the caller. Each call returns a different span, so
    /// that each item has its own ledger row.
    #[track_caller]
    pub fn composed() -> Span {
        Span { file: COMPOSED, start: Location::caller().line(), end: PIECES.fetch_add(1, Ordering::Relaxed) }
    }

    /// Returns the smallest span that covers both. `other` is ignored if it is in another file.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        if self.file != other.file {
            return self;
        }
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// All composed spans print as `composed`.
impl std::fmt::Debug for Span {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Span { file: COMPOSED, .. } => f.write_str("composed"),
            Span { file, start, end } => write!(f, "{file}:{start}..{end}"),
        }
    }
}

/// Name and text of one file of the deck: the deck itself or an included file.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Name of the file in messages.
    pub name: String,
    /// Path of the file. Relative paths of included files start at its folder.
    pub path: PathBuf,
    /// Decoded text with line ends `\n`.
    pub text: String,
    /// Span of the `*INCLUDE` that reads the file; `None` for the main file.
    pub included_at: Option<Span>,
}

/// Returns the text of a file that is open in an editor; `None` for a file that is read from disk.
pub type OpenTexts<'a> = dyn Fn(&Path) -> Option<String> + 'a;

/// All files of a deck.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
    line_starts: Vec<Vec<u32>>,
}

impl Sources {
    /// Adds a file and returns its index.
    pub fn add(&mut self, file: SourceFile) -> u32 {
        self.line_starts.push(line_starts(&file.text));
        self.files.push(file);
        (self.files.len() - 1) as u32
    }

    /// Sets the text of a file. The parser adds the file before it parses the text, to have its index.
    pub fn fill(&mut self, file: u32, text: String) {
        if let Some(entry) = self.files.get_mut(file as usize) {
            self.line_starts[file as usize] = line_starts(&text);
            entry.text = text;
        }
    }

    /// Frees the texts of files that can be read again. Places remain valid, words cannot be looked up meanwhile.
    pub fn release_texts(&mut self, is_open: impl Fn(&Path) -> bool) {
        self.files.iter_mut().filter(|file| is_open(&file.path)).for_each(|file| file.text = String::new());
    }

    /// Sets the texts that have been released.
    pub fn restore_texts(&mut self, open_texts: &OpenTexts<'_>) {
        for file in self.files.iter_mut().filter(|file| file.text.is_empty()) {
            file.text = open_texts(&file.path).map(normalise).unwrap_or_default();
        }
    }

    /// Returns the files in the order in which they were opened.
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// Returns the file that contains a span.
    pub fn file(&self, span: Span) -> Option<&SourceFile> {
        self.files.get(span.file as usize)
    }

    /// Returns the characters of a span, as written in its file.
    pub fn text(&self, span: Span) -> &str {
        self.file(span).and_then(|f| f.text.get(span.start as usize..span.end as usize)).unwrap_or("")
    }

    /// Returns line and column of a span's start, counted from 1; the column counts characters.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let Some(file) = self.file(span) else { return (1, 1) };
        let line = self.line_of(span.file, span.start);
        let start = self.line_range(span.file, line).start;
        let column = file.text.get(start..span.start as usize).map_or(0, |t| t.chars().count());
        (line, column + 1)
    }

    /// Returns the line of a byte, counted from 1.
    pub fn line_of(&self, file: u32, byte: u32) -> usize {
        self.line_starts.get(file as usize).map_or(1, |s| s.partition_point(|&b| b <= byte).max(1))
    }

    /// Returns the byte range of a line (counted from 1) without its line end.
    pub fn line_range(&self, file: u32, line: usize) -> std::ops::Range<usize> {
        let (Some(source), Some(starts)) = (self.files.get(file as usize), self.line_starts.get(file as usize)) else {
            return 0..0;
        };
        let length = source.text.len();
        let start = starts.get(line.saturating_sub(1)).map_or(length, |&b| b as usize);
        let end = starts.get(line).map_or(length, |&b| (b as usize).saturating_sub(1));
        start..end.max(start)
    }

    /// Returns `file:line` of a span, as the ledger shows it, or the text `composed in Rust`.
    pub fn describe(&self, span: Span) -> String {
        match self.file(span) {
            Some(file) => format!("{}:{}", file.name, self.line_column(span).0),
            None if span.file == COMPOSED => format!("composed in Rust, line {}", span.start),
            None => "composed in Rust".into(),
        }
    }

    /// Returns the file name of a span; `None` for items composed in Rust.
    pub fn name(&self, span: Span) -> Option<&str> {
        self.file(span).map(|file| file.name.as_str())
    }

    /// Returns the folder of the span's file, at which relative paths start.
    pub fn folder(&self, span: Span) -> &Path {
        self.file(span).and_then(|f| f.path.parent()).unwrap_or(Path::new(""))
    }
}

fn line_starts(text: &str) -> Vec<u32> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i as u32 + 1)).collect()
}

/// Decodes bytes as UTF-8 or, with a byte-order mark, UTF-16; invalid UTF-8 is read as latin-1. Line ends become `\n`.
pub fn decode(bytes: Vec<u8>) -> String {
    let text = match &bytes[..] {
        [0xEF, 0xBB, 0xBF, rest @ ..] => utf8_or_latin1(rest.to_vec()),
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => utf8_or_latin1(bytes),
    };
    normalise(text)
}

fn utf8_or_latin1(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| char::from(b)).collect())
}

fn utf16(bytes: &[u8], order: fn([u8; 2]) -> u16) -> String {
    let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| order([pair[0], pair[1]])).collect();
    String::from_utf16_lossy(&units)
}

/// Removes the byte-order mark and changes line ends to `\n`.
pub fn normalise(text: String) -> String {
    let text = match text.strip_prefix('\u{FEFF}') {
        Some(rest) => rest.to_owned(),
        None => text,
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}
