//! From text to cards: a parser that never fails. What it cannot read it reports and leaves out.
//! Never here: what a name refers to.

use std::path::{Path, PathBuf};

use super::diagnostic::{Diagnostic, Diagnostics};
use super::expression::{Expression, Value};
use super::keywords::{Keyword, Lookup, Tier, find_keyword, find_parameter, nearest};
use super::source::{SourceFile, Span};
use super::syntax::{Card, DataLine, Deck, Parameter, Word};

/// How deep files may include each other.
const DEEPEST_INCLUDE: usize = 32;

/// A parser over all files of a deck.
pub(super) struct Parser<'a> {
    deck: Deck,
    diagnostics: Diagnostics,
    overrides: &'a [(String, String)],
    values: Vec<(String, Value)>,
    open: Vec<PathBuf>,
    /// Whether data lines belong to a card that was not understood, and are dropped.
    lost: bool,
}

/// A physical line: byte range in its file.
#[derive(Clone, Copy)]
struct Line {
    start: usize,
    end: usize,
}

impl<'a> Parser<'a> {
    pub(super) fn new(overrides: &'a [(String, String)]) -> Self {
        Parser {
            deck: Deck::default(),
            diagnostics: Diagnostics::default(),
            overrides,
            values: Vec::new(),
            open: Vec::new(),
            lost: false,
        }
    }

    /// Reads a file into cards. `included_at` is the card that asked for it.
    pub(super) fn file(&mut self, name: String, path: PathBuf, text: String, included_at: Option<Span>) {
        self.open.push(path.clone());
        let index = self.deck.sources.add(SourceFile { name, path, text: text.clone(), included_at });
        let lines = lines(&text);
        let mut at = 0;
        while at < lines.len() {
            at = self.line(index, &text, &lines, at);
        }
        self.open.pop();
    }

    pub(super) fn finish(mut self) -> (Deck, Diagnostics) {
        for (name, _) in self.overrides {
            if !self.values.iter().any(|v| v.0 == *name) {
                let message = format!("--set {name}: the deck defines no parameter of that name");
                let near = nearest(name, self.values.iter().map(|v| v.0.as_str()));
                let names: Vec<_> = self.values.iter().map(|v| v.0.as_str()).collect();
                let help = near.map_or_else(
                    || {
                        if names.is_empty() {
                            "it has no *PARAMETER".into()
                        } else {
                            format!("it has {}", names.join(", "))
                        }
                    },
                    |n| format!("did you mean {n}? (names are case-sensitive)"),
                );
                self.diagnostics.push(Diagnostic::error("D108", message).help(help));
            }
        }
        for (name, value) in &self.values {
            if let Value::Number(number) = value {
                self.deck.parameters.push((name.clone(), *number));
            }
        }
        (self.deck, self.diagnostics)
    }

    /// Handles the line at `at` and returns the index of the next one to read.
    fn line(&mut self, file: u32, text: &str, lines: &[Line], at: usize) -> usize {
        let span = span(file, lines[at]);
        let content = text[lines[at].start..lines[at].end].trim();
        if content.is_empty() || content.starts_with("**") {
            return at + 1;
        }
        if content.starts_with('*') {
            return self.keyword_line(file, text, lines, at);
        }
        self.data_line(file, text, lines[at], span);
        at + 1
    }

    fn keyword_line(&mut self, file: u32, text: &str, lines: &[Line], at: usize) -> usize {
        let mut pieces = split(text, lines[at]);
        let word = text[pieces[0].start..pieces[0].end].trim();
        let word_span = span(file, trimmed(text, pieces[0]));
        let keyword = self.keyword(word.trim_start_matches('*'), word_span);
        self.lost = keyword.is_none();
        let mut next = at + 1;
        if let Some(keyword) = keyword {
            while ends_in_comma(text, lines[next - 1]) {
                let Some(more) = (next..lines.len()).find(|&i| !is_comment(text, lines[i])) else { break };
                if !looks_like_parameters(text, lines[more], keyword) {
                    break;
                }
                pieces.extend(split(text, lines[more]));
                next = more + 1;
            }
            let parameters = pieces[1..].iter().filter_map(|p| self.parameter(keyword, file, text, *p)).collect();
            let card = Card { keyword, span: word_span, parameters, lines: Vec::new() };
            if keyword.name == "INCLUDE" { self.include(&card) } else { self.deck.cards.push(card) }
        }
        next
    }

    fn keyword(&mut self, word: &str, at: Span) -> Option<&'static Keyword> {
        match find_keyword(word) {
            Lookup::Found(keyword) => Some(keyword),
            Lookup::Ambiguous(names) => {
                let message = format!("*{} could be any of *{}", word.trim(), names.join(", *"));
                self.diagnostics.push(Diagnostic::error("D102", message).at(at, "write more of the word"));
                None
            }
            // A bare *END closes nothing by itself; some meshers write it last.
            Lookup::Unknown(near) => {
                let finding = Diagnostic::error("D101", format!("unknown keyword *{}", word.trim())).at(at, "unknown");
                let help = near.map_or("`revolve explain keywords` lists all that are known".into(), |n| {
                    format!("did you mean *{n}?")
                });
                self.diagnostics.push(finding.help(help));
                None
            }
        }
    }

    fn parameter(&mut self, keyword: &'static Keyword, file: u32, text: &str, piece: Line) -> Option<Parameter> {
        let raw = &text[piece.start..piece.end];
        if raw.trim().is_empty() {
            return None;
        }
        let equals = find_unquoted(raw, '=');
        let name_range = trimmed(text, Line { start: piece.start, end: piece.start + equals.unwrap_or(raw.len()) });
        let name_span = span(file, name_range);
        let name = self.parameter_name(keyword, &text[name_range.start..name_range.end], name_span)?;
        let value = equals.map(|e| self.word(file, text, Line { start: piece.start + e + 1, end: piece.end }));
        if let (Some(word), Some(_)) = (&value, equals) {
            if word.text.is_empty() && !word.quoted {
                let message = format!("{name}= has no value");
                self.diagnostics.push(Diagnostic::error("D105", message).at(name_span, "a value was expected after ="));
                return None;
            }
        }
        Some(Parameter { name, span: name_span, value })
    }

    fn parameter_name(&mut self, keyword: &'static Keyword, word: &str, at: Span) -> Option<&'static str> {
        match find_parameter(keyword, word) {
            Lookup::Found(name) => Some(name),
            _ if keyword.tier != Tier::Used => None,
            Lookup::Ambiguous(names) => {
                let message = format!("{word} could be any of {}", names.join(", "));
                self.diagnostics.push(Diagnostic::error("D104", message).at(at, "write more of the word"));
                None
            }
            Lookup::Unknown(near) => {
                let message = format!("*{} has no parameter {word}", keyword.name);
                let known: Vec<_> = keyword.parameters.iter().map(|p| p.name).collect();
                let help =
                    near.map_or_else(|| format!("it has {}", known.join(", ")), |n| format!("did you mean {n}?"));
                let help = if known.is_empty() { "it takes none".to_owned() } else { help };
                self.diagnostics.push(Diagnostic::error("D103", message).at(at, "unknown").help(help));
                None
            }
        }
    }

    fn data_line(&mut self, file: u32, text: &str, line: Line, span: Span) {
        if self.lost {
            return;
        }
        let Some(keyword) = self.deck.cards.last().map(|c| c.keyword.name) else {
            let finding = Diagnostic::error("D106", "a data line before any keyword").at(span, "belongs to no card");
            self.diagnostics.push(finding.help("an input deck begins with a keyword line such as *HEADING"));
            self.lost = true;
            return;
        };
        if keyword == "PARAMETER" {
            self.definition(file, text, line);
            return;
        }
        let mut pieces = split(text, line);
        if pieces.len() > 1 && text[pieces[pieces.len() - 1].start..line.end].trim().is_empty() {
            pieces.pop();
        }
        let fields = match keyword {
            "HEADING" => vec![self.plain(file, text, line)],
            _ => pieces.into_iter().map(|p| self.word(file, text, p)).collect(),
        };
        if let Some(card) = self.deck.cards.last_mut() {
            card.lines.push(DataLine { fields, span });
        }
    }

    fn plain(&self, file: u32, text: &str, line: Line) -> Word {
        Word {
            text: text[line.start..line.end].trim().to_owned(),
            span: span(file, trimmed(text, line)),
            quoted: false,
        }
    }

    /// A field or value: blanks trimmed, quotes removed, `<names>` replaced.
    fn word(&mut self, file: u32, text: &str, piece: Line) -> Word {
        let range = trimmed(text, piece);
        let at = span(file, range);
        let raw = &text[range.start..range.end];
        let inner = raw.strip_prefix('"').and_then(|r| r.strip_suffix('"'));
        let inner = inner.or_else(|| raw.strip_prefix('\'').and_then(|r| r.strip_suffix('\'')));
        let quoted = inner.is_some();
        let content = inner.unwrap_or(raw);
        let text = if content.contains('<') { self.substitute(content, at) } else { content.to_owned() };
        Word { text, span: at, quoted }
    }

    fn substitute(&mut self, text: &str, at: Span) -> String {
        let (mut result, mut rest) = (String::new(), text);
        while let Some(open) = rest.find('<') {
            let Some(length) = rest[open..].find('>') else { break };
            let name = rest[open + 1..open + length].trim();
            result += &rest[..open];
            result += &self.value_text(name, at);
            rest = &rest[open + length + 1..];
        }
        result + rest
    }

    fn value_text(&mut self, name: &str, at: Span) -> String {
        if let Some((_, value)) = self.values.iter().find(|v| v.0 == name) {
            return value.text();
        }
        let near = nearest(name, self.values.iter().map(|v| v.0.as_str()));
        let help = near.map_or("define it with *PARAMETER above".into(), |n| {
            format!("did you mean <{n}>? (names are case-sensitive)")
        });
        let finding = Diagnostic::error("D107", format!("no parameter is called {name}")).at(at, "used here");
        self.diagnostics.push(finding.help(help));
        // A neutral value keeps one slip from causing a second finding.
        "1".into()
    }

    /// `name = expression`, with `#` comments.
    fn definition(&mut self, file: u32, text: &str, line: Line) {
        let raw = &text[line.start..line.end];
        let end = line.start + find_unquoted(raw, '#').unwrap_or(raw.len());
        let body = &text[line.start..end];
        if body.trim().is_empty() {
            return;
        }
        let name = body.split('=').next().unwrap_or("").trim();
        let is_name = name.chars().next().is_some_and(|c| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let at = span(file, trimmed(text, Line { start: line.start, end }));
        let (Some(equals), true) = (body.find('='), is_name) else {
            let finding =
                Diagnostic::error("D109", "a parameter is defined by `name = expression`").at(at, "not of that form");
            self.diagnostics.push(finding);
            return;
        };
        let overridden = self.overrides.iter().rev().find(|o| o.0 == name).map(|o| o.1.clone());
        let from = line.start + equals + 1;
        let place = |start: usize, end: usize| span(file, Line { start: from + start, end: from + end });
        let value = match &overridden {
            Some(given) => self.evaluate(given, |_, _| at, &format!("--set {name}={given}: ")),
            None => self.evaluate(&text[from..end], place, ""),
        };
        let value = value.unwrap_or(Value::Number(1.0));
        match self.values.iter_mut().find(|v| v.0 == name) {
            Some(known) => known.1 = value,
            None => self.values.push((name.to_owned(), value)),
        }
    }

    fn evaluate(&mut self, text: &str, place: impl Fn(usize, usize) -> Span, origin: &str) -> Option<Value> {
        let expression = match Expression::parse(text, &[]) {
            Ok(expression) => expression,
            Err(e) => {
                let message = format!("{origin}{}", e.message);
                self.diagnostics.push(Diagnostic::error("D110", message).at(place(e.start, e.end), "here"));
                return None;
            }
        };
        let lookup = |name: &str| {
            let known = self.values.iter().find(|v| v.0 == name).map(|v| v.1.clone());
            known.ok_or_else(|| {
                format!("no parameter is called {name} (names are case-sensitive, and defined before use)")
            })
        };
        match expression.evaluate(&lookup, &|f, _| Err(format!("there is no function `{f}`"))) {
            Ok(value) => Some(value),
            Err(message) => {
                let message = format!("{origin}{message}");
                self.diagnostics.push(Diagnostic::error("D111", message).at(place(0, text.len()), "this expression"));
                None
            }
        }
    }

    fn include(&mut self, card: &Card) {
        let Some(input) = card.value("INPUT") else {
            let finding = Diagnostic::error("D112", "*INCLUDE needs INPUT=file").at(card.span, "no file named");
            self.diagnostics.push(finding);
            return;
        };
        let name = input.text.replace('\\', "/");
        let path = self.deck.sources.folder(card.span).join(&name);
        let shown = beside(self.deck.sources.file(card.span).map_or("", |f| f.name.as_str()), &name);
        if self.open.contains(&path) || self.open.len() >= DEEPEST_INCLUDE {
            let message = format!("`{name}` includes itself, directly or through another file");
            self.diagnostics.push(Diagnostic::error("D114", message).at(input.span, "this include goes in a circle"));
            return;
        }
        match std::fs::read(&path) {
            Ok(bytes) => {
                self.lost = false;
                self.file(shown, path, decode(&bytes), Some(input.span));
            }
            Err(e) => {
                let message = format!("cannot read the included file `{name}`: {}", plain_error(&e));
                let help = format!("it was looked for at {shown}");
                self.diagnostics.push(Diagnostic::error("D113", message).at(input.span, "included here").help(help));
            }
        }
    }
}

/// An input error without the operating system's number.
pub(super) fn plain_error(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}

fn beside(deck: &str, name: &str) -> String {
    Path::new(deck).parent().unwrap_or(Path::new("")).join(name).display().to_string()
}

/// Bytes as text: UTF-8, otherwise Latin-1; without byte order mark; line ends as `\n`.
pub(super) fn decode(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}

fn lines(text: &str) -> Vec<Line> {
    let mut start = 0;
    let mut found = Vec::new();
    for line in text.split('\n') {
        found.push(Line { start, end: start + line.len() });
        start += line.len() + 1;
    }
    found
}

fn span(file: u32, line: Line) -> Span {
    Span { file, start: line.start as u32, end: line.end as u32 }
}

fn trimmed(text: &str, piece: Line) -> Line {
    let raw = &text[piece.start..piece.end];
    let start = piece.start + (raw.len() - raw.trim_start().len());
    Line { start, end: (start + raw.trim().len()).max(start) }
}

/// The pieces between commas that stand outside quotes.
fn split(text: &str, line: Line) -> Vec<Line> {
    let raw = &text[line.start..line.end];
    let mut pieces = Vec::new();
    let (mut start, mut quote) = (0, None);
    for (i, c) in raw.char_indices() {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '"' || c == '\'' => quote = raw[i + 1..].contains(c).then_some(c),
            None if c == ',' => {
                pieces.push(Line { start: line.start + start, end: line.start + i });
                start = i + 1;
            }
            _ => {}
        }
    }
    pieces.push(Line { start: line.start + start, end: line.end });
    pieces
}

fn find_unquoted(text: &str, sought: char) -> Option<usize> {
    let mut quote = None;
    text.char_indices().find_map(|(i, c)| {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '"' || c == '\'' => quote = text[i + 1..].contains(c).then_some(c),
            None if c == sought => return Some(i),
            _ => {}
        }
        None
    })
}

fn is_comment(text: &str, line: Line) -> bool {
    text[line.start..line.end].trim_start().starts_with("**")
}

fn ends_in_comma(text: &str, line: Line) -> bool {
    text[line.start..line.end].trim_end().ends_with(',')
}

/// Whether a line after a keyword line with a trailing comma goes on with parameters: `NAME=value`, or a word that the
/// keyword knows as a parameter.
fn looks_like_parameters(text: &str, line: Line, keyword: &Keyword) -> bool {
    let raw = text[line.start..line.end].trim();
    if raw.is_empty() || raw.starts_with('*') {
        return false;
    }
    let first = raw.split(',').next().unwrap_or("").trim();
    let name = first.split('=').next().unwrap_or("").trim();
    let known = matches!(find_parameter(keyword, name), Lookup::Found(_));
    first.contains('=') || known && name.len() > 2
}
