//! Source text and spans: every word of a deck can be traced to file, line and column.
//! Never here: meaning of what the text says.

use std::path::{Path, PathBuf};

/// A range of bytes of one source file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// Index of the file in [`Sources`].
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The smallest span that covers both; `other` is ignored if it lies in another file.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        if self.file != other.file {
            return self;
        }
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
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
}

impl Sources {
    /// Adds a file and returns its index.
    pub fn add(&mut self, file: SourceFile) -> u32 {
        self.files.push(file);
        (self.files.len() - 1) as u32
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
        let Some(before) = self.file(span).and_then(|f| f.text.get(..span.start as usize)) else { return (1, 1) };
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
        (line, column)
    }

    /// `file:line` of a span, as the ledger shows it.
    pub fn describe(&self, span: Span) -> String {
        let name = self.file(span).map_or("?", |f| f.name.as_str());
        format!("{name}:{}", self.line_column(span).0)
    }

    /// The folder that relative file names in this span's file refer to.
    pub fn folder(&self, span: Span) -> &Path {
        self.file(span).and_then(|f| f.path.parent()).unwrap_or(Path::new(""))
    }
}
