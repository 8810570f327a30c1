//! Diagnostics: errors, warnings and notes with their places in the deck and a suggested correction.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::printable::shortened;
use crate::source::{Sources, Span};
use crate::untrusted::is_restricted;

/// Maximum number of places that one diagnostic shows.
const MOST_PLACES: usize = 4;

/// Level of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Information that does not affect the result.
    Note,
    /// A probable mistake; the run continues.
    Warning,
    /// An invalid or unsupported input; the deck is not run.
    Error,
}

impl Severity {
    /// Returns the word for the level.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// A place in a file with its text.
#[derive(Clone, Debug)]
pub struct SourceLabel {
    /// Range of the text in its file.
    pub span: Span,
    /// Text next to the carets that mark the span.
    pub text: String,
}

/// A diagnostic message. `Display` prints the code and the message; [`Diagnostics::render`] also prints places and
/// help.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{code}: {message}")]
pub struct Diagnostic {
    /// Whether the message is an error, a warning or a note.
    pub severity: Severity,
    /// Code (`D…` deck, `M…` model, `P…` plan), explained by `revolve explain CODE`.
    pub code: &'static str,
    /// One sentence that states the problem.
    pub message: String,
    /// The place of the problem, then related places.
    pub labels: Vec<SourceLabel>,
    /// Suggested correction.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Creates a diagnostic without places and help.
    pub fn new(severity: Severity, code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic { severity, code, message: shortened(message.into()), labels: Vec::new(), help: None }
    }

    /// Creates an error: invalid or unsupported input, which prevents the run.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// Creates a warning: input that is probably a mistake; the run continues.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message)
    }

    /// Creates a note: information that does not affect the result.
    pub fn note(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, message)
    }

    /// Adds a place. The first one is the place of the problem, the others are related places.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(SourceLabel { span, text: shortened(text.into()) });
        self
    }

    /// Sets the suggested correction.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(shortened(text.into()));
        self
    }
}

impl Diagnostic {
    /// Returns the diagnostic as it is shown: with `--untrusted`, that of a place in an included file has only a general text,
    /// because its words may be those of the file.
    pub(crate) fn shown<'a>(&'a self, sources: &Sources) -> Cow<'a, Diagnostic> {
        let is_included = |label: &SourceLabel| sources.file(label.span).is_some_and(|file| file.included_at.is_some());
        if !is_restricted() || !self.labels.iter().any(is_included) {
            return Cow::Borrowed(self);
        }
        let place = |label: &SourceLabel| SourceLabel { span: label.span, text: "here".into() };
        Cow::Owned(Diagnostic {
            message: "a finding in an included file".into(),
            labels: self.labels.iter().map(place).collect(),
            help: Some(format!("`revolve explain {}` describes it; words of included files are not shown", self.code)),
            ..self.clone()
        })
    }
}

/// A correction that an editor can apply: text in place of a span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Correction {
    /// Replaced range.
    pub span: Span,
    /// The text in its place.
    pub text: String,
}

impl Diagnostic {
    /// Returns the correction that the help or the label of the diagnostic names, as `did you mean X?` or as a number to
    /// write; `None` if it describes one in words.
    pub fn correction(&self, sources: &Sources) -> Option<Correction> {
        let label = self.labels.first()?;
        let in_place = |text: String| Some(Correction { span: label.span, text });
        let texts = [self.help.as_deref().unwrap_or_default(), label.text.as_str()];
        if let Some(meant) = texts.iter().find_map(|text| meant_word(text)) {
            return in_place(meant.to_owned());
        }
        let written = sources.text(label.span);
        if let Some(meant) = texts[0].strip_prefix("if this is a decimal comma, write ") {
            // The span is that of the decimals, and the number before the comma is as long as in the text.
            let more = meant.len().checked_sub(written.len())? as u32;
            let span = Span { start: label.span.start.checked_sub(more)?, ..label.span };
            return Some(Correction { span, text: meant.to_owned() });
        }
        let begins_alike =
            |text: &str| text.get(..written.len()).is_some_and(|head| head.eq_ignore_ascii_case(written));
        let completes = |text: &str| written.starts_with('*') && self.code != "D007" && begins_alike(text);
        let is_meant = |text: &&str| text.parse::<i64>().is_ok() || completes(text);
        if let Some(meant) = texts[0].strip_prefix("write ").filter(is_meant) {
            return in_place(meant.to_owned());
        }
        match self.code {
            "D108" => in_place(format!("{}\"", written.trim_end())),
            "D109" => in_place(format!("** {}", written.trim_start_matches('$').trim_start_matches('#').trim_start())),
            "D101" if texts[0].contains("if this is a comment") => in_place(format!("*{written}")),
            "D301" => missing_comma(written).and_then(in_place),
            _ => None,
        }
    }
}

/// Returns the word of `did you mean WORD?`.
fn meant_word(text: &str) -> Option<&str> {
    let (_, suggestion) = text.split_once("did you mean ")?;
    let (word, _) = suggestion.split_once('?')?;
    Some(word.trim_matches('`'))
}

/// Returns numbers that are separated by blanks with commas between them; `None` for other texts.
fn missing_comma(text: &str) -> Option<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let numbers = words.len() > 1 && words.iter().all(|word| crate::number::parse_number(word).is_ok());
    numbers.then(|| words.join(", "))
}

/// Diagnostics of a deck. Checks continue after an error, so that all errors are reported together.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(list: I) -> Diagnostics {
        Diagnostics { list: list.into_iter().collect() }
    }
}

impl Diagnostics {
    /// Adds a diagnostic to the list.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Adds a diagnostic and returns `None`, for use in place of the value that could not be read.
    pub fn refuse<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.push(diagnostic);
        None
    }

    /// Iterates over all diagnostics in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Iterates over all diagnostics, which can be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Diagnostic> {
        self.list.iter_mut()
    }

    /// Returns whether the list contains an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Returns whether there is no diagnostic.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns the number of diagnostics.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Keeps the diagnostics for which `keep` returns true.
    pub fn retain(&mut self, keep: impl FnMut(&Diagnostic) -> bool) {
        self.list.retain(keep);
    }

    /// Merges diagnostics with the same code, message and help into one with several places.
    pub fn merge_repeats(&mut self) {
        let mut first: HashMap<(&'static str, String, Option<String>), usize> = HashMap::new();
        let mut counts: Vec<usize> = Vec::new();
        let mut merged: Vec<Diagnostic> = Vec::new();
        for finding in self.list.drain(..) {
            let key = (finding.code, finding.message.clone(), finding.help.clone());
            match first.get(&key) {
                Some(&at) => {
                    counts[at] += 1;
                    if counts[at] <= MOST_PLACES {
                        let label = finding.labels.into_iter().next();
                        merged[at].labels.extend(label.map(|l| SourceLabel { text: "also here".into(), ..l }));
                    }
                }
                None => {
                    first.insert(key, merged.len());
                    merged.push(finding);
                    counts.push(1);
                }
            }
        }
        for (finding, count) in merged.iter_mut().zip(counts).filter(|(_, count)| *count > MOST_PLACES) {
            finding.message += &format!(" (in {count} places)");
        }
        self.list = merged;
    }

    /// Removes warnings and notes.
    pub fn keep_errors(&mut self) {
        self.list.retain(|d| d.severity == Severity::Error);
    }

    /// Appends the diagnostics of `other` after the existing ones.
    pub fn append(&mut self, mut other: Diagnostics) {
        self.list.append(&mut other.list);
    }

    /// Returns the number of errors in the list.
    pub fn error_count(&self) -> usize {
        self.list.iter().filter(|d| d.severity == Severity::Error).count()
    }

    /// Returns the diagnostics as plain text with excerpts of the deck; at most 20 of each severity.
    pub fn render(&self, sources: &Sources) -> String {
        crate::render::render(&self.list, sources, false)
    }

    /// Returns the same text as [`Diagnostics::render`] with terminal colours.
    pub fn render_styled(&self, sources: &Sources) -> String {
        crate::render::render(&self.list, sources, true)
    }
}
