//! Diagnostics: what is wrong, where, why, and what would be right.
//! Never here: the checks that find them.

use std::collections::HashMap;

use super::source::{Sources, Span};

/// Places that one finding shows at most.
const MOST_PLACES: usize = 4;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; nothing the result depends on.
    Note,
    /// Probably not what was meant; the run goes on.
    Warning,
    /// The deck is refused.
    Error,
}

/// A place in a file and what to say of it.
#[derive(Clone, Debug)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What to write under the carets.
    pub text: String,
}

/// One finding. As an error of Rust it shows code and message; [`Diagnostics::render`] shows all of it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{code}: {message}")]
pub struct Diagnostic {
    /// How bad.
    pub severity: Severity,
    /// Stable code (`D…` deck, `M…` model, `P…` plan); `revolve explain CODE` tells more.
    pub code: &'static str,
    /// One sentence: what is wrong.
    pub message: String,
    /// The place (first) and related places.
    pub labels: Vec<Label>,
    /// What would be right.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A finding of the given severity.
    pub fn new(severity: Severity, code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic { severity, code, message: message.into(), labels: Vec::new(), help: None }
    }

    /// The deck is refused because of this.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// Probably a slip; the run goes on.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message)
    }

    /// Worth knowing.
    pub fn note(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, message)
    }

    /// Adds a place; the first added is the one the finding is about.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Says what would be right.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

/// Findings collected over a whole deck: reading goes on after an error so that all are shown at once.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Adds a finding.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Adds a finding in place of what would have been read.
    pub fn refuse<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.push(diagnostic);
        None
    }

    /// All findings in the order found.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter()
    }

    /// Whether the deck must be refused.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many findings there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Drops findings that follow from others.
    pub fn retain(&mut self, keep: impl FnMut(&Diagnostic) -> bool) {
        self.list.retain(keep);
    }

    /// Makes one finding of those that say the same of several places.
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
                        merged[at].labels.extend(label.map(|l| Label { text: "also here".into(), ..l }));
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

    /// Drops everything but errors.
    pub fn keep_errors(&mut self) {
        self.list.retain(|d| d.severity == Severity::Error);
    }

    /// Takes over the findings of `other`.
    pub fn append(&mut self, mut other: Diagnostics) {
        self.list.append(&mut other.list);
    }

    /// How many errors there are.
    pub fn error_count(&self) -> usize {
        self.list.iter().filter(|d| d.severity == Severity::Error).count()
    }

    /// The findings as plain text: file, line, column, caret, reason, help; about twenty of each severity.
    pub fn render(&self, sources: &Sources) -> String {
        super::render::render(&self.list, sources, false)
    }

    /// The same with colours, for a terminal.
    pub fn render_styled(&self, sources: &Sources) -> String {
        super::render::render(&self.list, sources, true)
    }
}
