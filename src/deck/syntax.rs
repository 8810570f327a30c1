//! The syntax tree of a deck: cards with parameters and data lines, every word with its span.
//! Never here: what a name refers to.

use std::sync::Arc;

use super::diagnostic::{Diagnostic, Diagnostics};
use super::keywords::{Keyword, Shape};
use super::number::{NumberError, parse_number};
use super::parameters::{Definition, is_unresolved};
use super::source::{Sources, Span};

/// A deck as read: includes expanded, `<parameters>` substituted, nothing resolved.
#[derive(Clone, Debug, Default)]
pub struct Deck {
    /// The files it came from.
    pub sources: Arc<Sources>,
    /// The cards in order.
    pub cards: Vec<Card>,
    /// The `*PARAMETER` values in force, overrides included, in order of definition.
    pub parameters: Vec<(String, f64)>,
    /// Their definitions as they are written, those of texts among them.
    pub definitions: Vec<Definition>,
    /// What could not be read, as an error has told.
    pub unread: Unread,
}

/// What could not be read of a deck: what misses it need not say so again.
#[derive(Clone, Debug, Default)]
pub struct Unread {
    /// Whether a file is missing, which may have defined anything.
    pub files: bool,
    /// Cards that are unknown or not supported.
    pub cards: usize,
    /// Names on keyword lines of cards that are unknown or not supported, upper case.
    pub names: Vec<String>,
}

/// One keyword line with its data lines.
#[derive(Clone, Debug)]
pub struct Card {
    /// The row of the keyword table.
    pub keyword: &'static Keyword,
    /// The keyword word, star included.
    pub span: Span,
    /// `NAME=value` words of the keyword line.
    pub parameters: Vec<Parameter>,
    /// The data lines below it (comments and blank lines dropped).
    pub lines: Vec<DataLine>,
    /// The data lines of a listing of nodes, elements or members, which has no `lines`.
    pub rows: Vec<Row>,
    /// Whether an error tells of a word of it already: what it lacks for that need not be told again.
    pub faulty: bool,
}

/// A parameter of a keyword line.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// The full canonical name of the keyword table, upper case with single blanks (`REF NODE`).
    pub name: &'static str,
    /// Where the name stands.
    pub span: Span,
    /// What follows the equals sign.
    pub value: Option<Word>,
}

/// A piece of text: quotes removed, blanks trimmed, parameters substituted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Word {
    /// The text as written (case kept).
    pub text: String,
    /// Where it stands.
    pub span: Span,
    /// Whether it stood in quotes.
    pub quoted: bool,
}

/// One data line.
#[derive(Clone, Debug)]
pub struct DataLine {
    /// The comma-separated fields; an empty field is a [`Word`] with empty text. A trailing comma gives no extra field.
    pub fields: Vec<Word>,
    /// The whole line.
    pub span: Span,
}

/// A data line of a listing.
#[derive(Clone, Debug)]
pub enum Row {
    /// Where it stands: its fields are what lies between commas.
    Text(Span),
    /// One with quotes or parameters, taken apart.
    Line(Box<DataLine>),
}

impl Card {
    /// The parameter of that canonical name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// The value of a parameter, if it is there and has one.
    pub fn value(&self, name: &str) -> Option<&Word> {
        self.parameter(name).and_then(|p| p.value.as_ref())
    }

    /// What its data lines hold, by its row of the table and its parameters.
    pub fn shape(&self) -> &'static Shape {
        self.keyword.shape(|name| self.parameter(name).map(|p| p.value.as_ref().map(|w| w.text.as_str())))
    }

    /// Whether a parameter is there, with or without value.
    pub fn has(&self, name: &str) -> bool {
        self.parameter(name).is_some()
    }
}

impl DataLine {
    /// The field with that index, `None` if absent or empty.
    pub fn field(&self, index: usize) -> Option<&Word> {
        self.fields.get(index).filter(|w| !w.text.is_empty())
    }
}

impl Word {
    /// Names are compared without regard to case.
    pub fn is(&self, name: &str) -> bool {
        self.text.eq_ignore_ascii_case(name)
    }

    /// The field as a finite number (`1.`, `.5`, `1.57d0`); otherwise a located diagnostic and `None`.
    pub fn number(&self, diagnostics: &mut Diagnostics) -> Option<f64> {
        match parse_number(&self.text) {
            Ok(value) => Some(value),
            Err(_) if is_unresolved(&self.text) => None,
            Err(e) => {
                diagnostics.push(self.number_finding(e));
                None
            }
        }
    }

    /// The field as a whole number; otherwise a located diagnostic and `None`.
    pub fn integer(&self, diagnostics: &mut Diagnostics) -> Option<i64> {
        let text = self.text.trim();
        if let Ok(value) = text.parse() {
            return Some(value);
        }
        if let Ok(value) = parse_number(text) {
            let what = Diagnostic::error("D304", format!("`{text}` is not a whole number"))
                .at(self.span, "whole number expected");
            let whole = value.fract() == 0.0 && value.abs() < 1e15;
            diagnostics.push(if whole { what.help(format!("write {value:.0}")) } else { what });
            return None;
        }
        self.number(diagnostics).and(None)
    }

    fn number_finding(&self, error: NumberError) -> Diagnostic {
        let text = &self.text;
        match error {
            NumberError::Empty => Diagnostic::error("D301", "a number is missing").at(self.span, "expected here"),
            NumberError::LookAlike(letter, meant) => Diagnostic::error("D302", format!("`{text}` is not a number"))
                .at(self.span, format!("letter {letter}"))
                .help(format!("did you mean {meant}?")),
            NumberError::NotFinite => {
                Diagnostic::error("D303", format!("`{text}` is too large")).at(self.span, "not finite")
            }
            NumberError::Malformed(guess) => {
                let what =
                    Diagnostic::error("D301", format!("`{text}` is not a number")).at(self.span, "number expected");
                match guess {
                    Some(guess) => what.help(format!("did you mean {guess}?")),
                    None => what,
                }
            }
        }
    }
}
