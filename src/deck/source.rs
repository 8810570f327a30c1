//! Source text and spans: every word of a deck can be traced to file, line and column.
//! Never here: meaning of what the text says.

use std::panic::Location;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A range of bytes of one source file.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// Index of the file in [`Sources`].
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

/// File of spans that lead to no deck.
const COMPOSED: u32 = u32::MAX;
/// Tells pieces apart that one line of Rust makes. It is shown nowhere.
static PIECES: AtomicU32 = AtomicU32::new(0);

impl Span {
    /// The place of a piece that is composed in Rust: the line of the caller. Each call gives another span, so that the ledger
    /// keeps a row for each piece.
    #[track_caller]
    pub fn composed() -> Span {
        Span { file: COMPOSED, start: Location::caller().line(), end: PIECES.fetch_add(1, Ordering::Relaxed) }
    }

    /// The smallest span that covers both; `other` is ignored if it lies in another file.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        if self.file != other.file {
            return self;
        }
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// What is composed in Rust looks alike, wherever and however often it is.
impl std::fmt::Debug for Span {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Span { file: COMPOSED, .. } => f.write_str("composed"),
            Span { file, start, end } => write!(f, "{file}:{start}..{end}"),
        }
    }
}

/// One file of a deck.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// The name as shown to the user.
    pub name: String,
    /// Where it was read from; relative files are looked up beside it.
    pub path: PathBuf,
    /// The whole text, decoded, with line ends normalised to `\n`.
    pub text: String,
    /// The `*INCLUDE` that brought it in; `None` for the deck itself.
    pub included_at: Option<Span>,
}

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

    /// Gives a file its text; for a reader that numbers the file before it is done with the text.
    pub(super) fn fill(&mut self, file: u32, text: String) {
        if let Some(entry) = self.files.get_mut(file as usize) {
            self.line_starts[file as usize] = line_starts(&text);
            entry.text = text;
        }
    }

    /// The files in the order they were opened.
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// The file a span lies in.
    pub fn file(&self, span: Span) -> Option<&SourceFile> {
        self.files.get(span.file as usize)
    }

    /// The text of a span.
    pub fn text(&self, span: Span) -> &str {
        self.file(span).and_then(|f| f.text.get(span.start as usize..span.end as usize)).unwrap_or("")
    }

    /// Line and column of a span's start, both counted from 1, the column in characters.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let Some(file) = self.file(span) else { return (1, 1) };
        let line = self.line_of(span.file, span.start);
        let start = self.line_range(span.file, line).start;
        let column = file.text.get(start..span.start as usize).map_or(0, |t| t.chars().count());
        (line, column + 1)
    }

    /// The line, counted from 1, that a byte of a file lies in.
    pub(super) fn line_of(&self, file: u32, byte: u32) -> usize {
        self.line_starts.get(file as usize).map_or(1, |s| s.partition_point(|&b| b <= byte).max(1))
    }

    /// The bytes of a line (counted from 1) without its line end.
    pub(super) fn line_range(&self, file: u32, line: usize) -> std::ops::Range<usize> {
        let (Some(source), Some(starts)) = (self.files.get(file as usize), self.line_starts.get(file as usize)) else {
            return 0..0;
        };
        let length = source.text.len();
        let start = starts.get(line.saturating_sub(1)).map_or(length, |&b| b as usize);
        let end = starts.get(line).map_or(length, |&b| (b as usize).saturating_sub(1));
        start..end.max(start)
    }

    /// `file:line` of a span, as the ledger shows it; of what no deck asked for, that it was composed in Rust.
    pub fn describe(&self, span: Span) -> String {
        match self.file(span) {
            Some(file) => format!("{}:{}", file.name, self.line_column(span).0),
            None if span.file == COMPOSED => format!("composed in Rust, line {}", span.start),
            None => "composed in Rust".into(),
        }
    }

    /// Name of the file of a span; `None` of what no deck asked for.
    pub fn name(&self, span: Span) -> Option<&str> {
        self.file(span).map(|file| file.name.as_str())
    }

    /// The folder that relative file names in this span's file refer to.
    pub fn folder(&self, span: Span) -> &Path {
        self.file(span).and_then(|f| f.path.parent()).unwrap_or(Path::new(""))
    }
}

fn line_starts(text: &str) -> Vec<u32> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i as u32 + 1)).collect()
}

/// Bytes as text: byte-order marks (UTF-8, UTF-16) are obeyed, what is not UTF-8 is taken as latin-1, line ends become `\n`.
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

/// Text in memory brought to the same shape as text read from a file: no byte-order mark, line ends `\n`.
pub(super) fn normalise(text: String) -> String {
    let text = match text.strip_prefix('\u{FEFF}') {
        Some(rest) => rest.to_owned(),
        None => text,
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}
