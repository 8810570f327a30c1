//! Rendering of diagnostics as text with excerpts of the deck.

use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};

use crate::diagnostic::{Diagnostic, Severity, SourceLabel};
use crate::printable::printable;
use crate::source::{Sources, Span};
use crate::untrusted::is_restricted;

/// Maximum number of diagnostics shown per severity; the others are counted.
const MOST: usize = 20;
/// Labels that are more lines apart than this are shown in separate excerpts.
const FAR: usize = 60;
/// Maximum length of a line that is shown completely, bytes.
const LONGEST: usize = 400;

/// Renders all diagnostics: errors, then warnings, then notes.
pub fn render(list: &[Diagnostic], sources: &Sources, styled: bool) -> String {
    let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for severity in [Severity::Error, Severity::Warning, Severity::Note] {
        let of_severity: Vec<&Diagnostic> = list.iter().filter(|d| d.severity == severity).collect();
        for diagnostic in of_severity.iter().take(MOST) {
            text += &renderer.render(&[group(&diagnostic.shown(sources), sources)]);
            text += "\n\n";
        }
        if of_severity.len() > MOST {
            text +=
                &format!("… and {} more {}\n\n", of_severity.len() - MOST, plural(severity, of_severity.len() - MOST));
        }
    }
    text
}

fn plural(severity: Severity, count: usize) -> String {
    let word = match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    format!("{word}{}", if count == 1 { "" } else { "s" })
}

fn group<'a>(diagnostic: &'a Diagnostic, sources: &'a Sources) -> Group<'a> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let mut group = Group::with_title(level.primary_title(printable(&diagnostic.message)).id(diagnostic.code));
    for window in windows(&diagnostic.labels, sources) {
        group = group.element(snippet(&window, &diagnostic.labels, sources));
    }
    for label in diagnostic.labels.iter().filter(|l| !is_quoted(l, sources)) {
        group = group.element(
            Level::NOTE.message(printable(&format!("{}: {}", sources.describe(label.span), label.text)).into_owned()),
        );
    }
    for place in trail(diagnostic, sources) {
        group = group.element(Level::NOTE.message(printable(&format!("included from {place}")).into_owned()));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(printable(help)));
    }
    group
}

/// Excerpt of a file: a range of lines and the indices of the labels in it.
struct ExcerptWindow {
    file: u32,
    first: usize,
    last: usize,
    labels: Vec<usize>,
}

/// Returns whether the line of a label is shown. Lines of included files are not shown with `--untrusted`.
fn is_quoted(label: &SourceLabel, sources: &Sources) -> bool {
    sources.file(label.span).is_some_and(|file| file.included_at.is_none() || !is_restricted())
}

fn windows(labels: &[SourceLabel], sources: &Sources) -> Vec<ExcerptWindow> {
    let mut windows: Vec<ExcerptWindow> = Vec::new();
    for (i, label) in labels.iter().enumerate().filter(|(_, l)| is_quoted(l, sources)) {
        let line = sources.line_of(label.span.file, label.span.start);
        let near = |w: &&mut ExcerptWindow| w.file == label.span.file && w.last.max(line) - w.first.min(line) <= FAR;
        match windows.iter_mut().find(near) {
            Some(w) => {
                (w.first, w.last) = (w.first.min(line), w.last.max(line));
                w.labels.push(i);
            }
            None => windows.push(ExcerptWindow { file: label.span.file, first: line, last: line, labels: vec![i] }),
        }
    }
    windows
}

fn snippet<'a>(window: &ExcerptWindow, labels: &'a [SourceLabel], sources: &'a Sources) -> Snippet<'a, Annotation<'a>> {
    let text = sources.files().get(window.file as usize).map_or("", |f| f.text.as_str());
    let name = sources.files().get(window.file as usize).map_or("?", |f| f.name.as_str());
    let start = sources.line_range(window.file, window.first).start;
    let mut end = sources.line_range(window.file, window.last).end;
    if window.first == window.last {
        end = end.min(excerpt_end(window, labels, start));
    }
    let (start, end) = (boundary(text, start), boundary(text, end));
    let source = &text[start..end.max(start)];
    let annotations = window.labels.iter().map(|&i| annotation(i, &labels[i], source, start));
    Snippet::source(source).line_start(window.first).path(printable(name)).annotations(annotations)
}

/// Returns the position at which a very long line is cut: after the last label.
fn excerpt_end(window: &ExcerptWindow, labels: &[SourceLabel], start: usize) -> usize {
    let last = window.labels.iter().map(|&i| labels[i].span.start as usize).max().unwrap_or(start);
    last.max(start) + LONGEST
}

fn annotation<'a>(index: usize, label: &'a SourceLabel, source: &str, offset: usize) -> Annotation<'a> {
    let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
    let start = boundary(source, (label.span.start as usize).saturating_sub(offset));
    let line_end = source[start..].find('\n').map_or(source.len(), |i| start + i);
    let end = boundary(source, (label.span.end as usize).saturating_sub(offset)).clamp(start, line_end);
    kind.span(start..end).label(printable(&label.text))
}

/// Returns the last character boundary at or before `at`.
fn boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0)
}

/// Returns the places of the `*INCLUDE`s that lead to the file of a diagnostic, innermost first.
fn trail(diagnostic: &Diagnostic, sources: &Sources) -> Vec<String> {
    let mut places = Vec::new();
    let mut span: Option<Span> = diagnostic.labels.first().and_then(|l| sources.file(l.span)?.included_at);
    while let Some(at) = span.filter(|_| places.len() < 40) {
        places.push(sources.describe(at));
        span = sources.file(at).and_then(|f| f.included_at);
    }
    places
}
