//! `*PARAMETER` definitions, `--set` overrides and substitution of `<name>`.

use std::collections::HashSet;

use indexmap::IndexMap;

use super::diagnostic::{Diagnostic, Diagnostics};
use super::expression::{Expression, ExpressionError};
use super::names;
use super::number::format_number;
use super::source::Span;
use super::syntax::{MeshScaling, Word};

/// Settings that request a refined mesh. The first one is not a valid parameter name.
pub const MESH_SETTINGS: [&str; 2] = ["mesh-refine", "mesh"];

/// Setting that fits smooth curves to the boundaries of a refined mesh; not a valid parameter name.
pub const CURVE_SETTING: &str = "mesh-curved";

/// Value that a `*PARAMETER` substitutes into the deck.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// A number, the result of an expression.
    Number(f64),
    /// A text that was given in quotes.
    Text(String),
}

impl ParameterValue {
    fn written(&self) -> String {
        match self {
            ParameterValue::Number(value) => format_number(*value),
            ParameterValue::Text(text) => text.clone(),
        }
    }
}

/// Parameters that are defined so far.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    values: IndexMap<String, ParameterValue>,
    /// Parameters whose value is unknown after an error, which has been reported.
    without_value: HashSet<String>,
    overrides: IndexMap<String, String>,
    definitions: Vec<ParameterDefinition>,
}

/// Definition of a parameter as written in the deck.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterDefinition {
    /// Name of the parameter.
    pub name: String,
    /// Text after the equals sign.
    pub text: String,
    /// Source position of the text.
    pub span: Span,
    /// Text of an override, in quotes if the value is a text.
    pub replacement: Option<String>,
}

impl Parameters {
    /// Creates an empty set of parameters with overrides (name, expression) of later definitions.
    pub fn new(overrides: &[(String, String)]) -> Self {
        let overrides = overrides.iter().cloned().collect();
        Parameters { overrides, ..Parameters::default() }
    }

    /// Returns the numeric parameters in order of definition.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        let number = |(name, value): (&String, &ParameterValue)| match value {
            ParameterValue::Number(x) => Some((name.clone(), *x)),
            ParameterValue::Text(_) => None,
        };
        self.values.iter().filter_map(number).collect()
    }

    /// Returns all definitions in order.
    pub fn definitions(self) -> Vec<ParameterDefinition> {
        self.definitions
    }

    /// Evaluates the definitions on a line of a `*PARAMETER` block, separated by `;`.
    pub fn define_all(&mut self, line: &str, span: Span, diagnostics: &mut Diagnostics) {
        for definition in statements(without_comment(line)) {
            self.define(definition, part(span, line, definition), diagnostics);
        }
    }

    fn define(&mut self, line: &str, span: Span, diagnostics: &mut Diagnostics) {
        if line.trim().is_empty() {
            return;
        }
        let Some((left, right)) = line.split_once('=') else {
            let what = Diagnostic::error("D404", "a parameter definition has no equals sign");
            return diagnostics.push(what.at(span, "expected `name = expression`"));
        };
        let name = left.trim();
        if !is_name(name) {
            let what = Diagnostic::error("D404", format!("`{name}` is not a valid parameter name"));
            return diagnostics.push(
                what.at(part(span, line, left.trim()), "not a name")
                    .help("names consist of letters, digits and `_`, and do not begin with a digit"),
            );
        }
        let text = right.trim();
        let span = part(span, line, text);
        let value = self.value_of(name, text, span, diagnostics);
        let replacement = self.overrides.get(name).map(|given| match &value {
            Some(ParameterValue::Text(text)) => format!("\"{text}\""),
            _ => given.clone(),
        });
        match value {
            Some(value) => {
                self.without_value.remove(name);
                self.values.insert(name.to_owned(), value);
            }
            None => {
                self.values.shift_remove(name);
                self.without_value.insert(name.to_owned());
            }
        }
        self.definitions.push(ParameterDefinition { name: name.to_owned(), text: text.to_owned(), span, replacement });
    }

    /// Returns the value of a definition or of its override; `None` after an error. An unknown value of another parameter
    /// is not reported again.
    fn value_of(&self, name: &str, text: &str, span: Span, diagnostics: &mut Diagnostics) -> Option<ParameterValue> {
        let defined = self.evaluate(text);
        let (evaluated, replacement) = match (self.overrides.get(name), defined) {
            (None, defined) => (defined, None),
            (Some(replacement), defined) => match (self.evaluate(replacement), defined) {
                (Err(_), Ok(ParameterValue::Text(_))) => (Ok(ParameterValue::Text(replacement.clone())), None),
                (found, _) => (found, Some(replacement)),
            },
        };
        let error = match evaluated {
            Ok(value) => return Some(value),
            Err(error) => error,
        };
        if error.unknown.as_ref().is_some_and(|unknown| self.without_value.contains(unknown)) {
            return None;
        }
        let what = match replacement {
            None => {
                Diagnostic::error("D402", "the parameter has no value").at(offset(span, &error), error.message.clone())
            }
            Some(replacement) => Diagnostic::error("D407", format!("`--set {name}={replacement}`: {}", error.message))
                .at(span, "the definition that it replaces"),
        };
        diagnostics.refuse(self.helped(what, &error))
    }

    fn evaluate(&self, text: &str) -> Result<ParameterValue, ExpressionError> {
        if let Some(inside) = unquoted(text) {
            return Ok(ParameterValue::Text(inside.to_owned()));
        }
        if let Some(ParameterValue::Text(other)) = self.values.get(text) {
            return Ok(ParameterValue::Text(other.clone()));
        }
        let lookup = |name: &str| match self.values.get(name) {
            Some(ParameterValue::Number(x)) => Some(*x),
            _ => None,
        };
        let value = Expression::parse(text)?.evaluate(&lookup, &|_, _| None)?;
        if value.is_finite() {
            return Ok(ParameterValue::Number(value));
        }
        Err(ExpressionError { start: 0, end: text.len(), message: format!("the value is {value}"), unknown: None })
    }

    fn helped(&self, what: Diagnostic, e: &ExpressionError) -> Diagnostic {
        match &e.unknown {
            Some(name) => what.help(self.suggestion(name)),
            None => what,
        }
    }

    fn suggestion(&self, name: &str) -> String {
        if let Some(like) = names::nearest(name, self.values.keys().map(String::as_str)) {
            return format!("did you mean `{like}`? (names of parameters are case-sensitive)");
        }
        if self.values.is_empty() {
            return "no parameter is defined before this line; define it in a *PARAMETER block".into();
        }
        let known: Vec<&str> = self.values.keys().map(String::as_str).take(10).collect();
        format!("parameters defined before this line: {}", known.join(", "))
    }

    /// Replaces every `<name>` in a word by the value of the parameter.
    pub fn substitute(&self, mut word: Word, diagnostics: &mut Diagnostics) -> Word {
        if !word.text.contains('<') {
            return word;
        }
        let (mut result, mut remaining) = (String::new(), word.text.as_str());
        while let Some(ParameterReference { before, name, after }) = next_reference(remaining) {
            result.push_str(before);
            match self.values.get(name) {
                Some(value) => result.push_str(&value.written()),
                None => {
                    if !self.without_value.contains(name) {
                        diagnostics.push(self.undefined(name, &word));
                    }
                    result.push_str(&format!("<{name}>"));
                }
            }
            remaining = after;
        }
        result.push_str(remaining);
        word.text = result;
        word
    }

    /// Returns whether a text refers to a parameter whose value is unknown after an error.
    pub fn lacks_value(&self, text: &str) -> bool {
        next_reference(text).is_some_and(|reference| self.without_value.contains(reference.name))
    }

    fn undefined(&self, name: &str, word: &Word) -> Diagnostic {
        let what = Diagnostic::error("D401", format!("parameter `{name}` is not defined"));
        what.at(word.span, "not defined").help(self.suggestion(name))
    }

    /// Returns name and value of the setting that refines or coarsens the mesh, if there is one, and its effect. A parameter
    /// of the deck with the name `mesh` takes precedence.
    pub fn mesh_scaling(&self, diagnostics: &mut Diagnostics) -> Option<((&'static str, f64), MeshScaling)> {
        let is_free = |name: &str| !self.values.contains_key(name);
        let (name, text) = MESH_SETTINGS.into_iter().find_map(|name| Some((name, self.overrides.get(name)?)))?;
        let name = if is_free(MESH_SETTINGS[1]) { MESH_SETTINGS[1] } else { name };
        if !is_free(name) {
            return None;
        }
        let value = match self.evaluate(text) {
            Ok(ParameterValue::Number(value)) => value,
            _ => f64::NAN,
        };
        let scaling = MeshScaling::from_factor(value);
        if scaling.is_none() {
            let what = Diagnostic::error("D408", format!("`{name}={text}`: invalid mesh refinement"));
            diagnostics.push(what.help(format!(
                "give a whole number of parts of each edge, from 1 to {}, or 1/2, 1/3 and so on to merge elements",
                MeshScaling::FINEST
            )));
        }
        Some(((name, value), scaling?))
    }

    /// Returns the largest turning angle of smooth boundaries of a refined mesh, degrees.
    pub fn mesh_curves(&self, diagnostics: &mut Diagnostics) -> Option<f64> {
        let text = self.overrides.get(CURVE_SETTING)?;
        match self.evaluate(text) {
            Ok(ParameterValue::Number(angle)) if angle > 0.0 && angle <= 60.0 => Some(angle),
            _ => {
                let what = Diagnostic::error("D408", format!("`{CURVE_SETTING}={text}`: invalid corner angle"));
                diagnostics.refuse(what.help(
                    "give an angle in degrees above 0 and up to 60; boundaries have corners \
                                              where they turn by more",
                ))
            }
        }
    }

    /// Reports overrides of undefined parameters.
    pub fn check_overrides(&self, diagnostics: &mut Diagnostics) {
        let is_known = |name: &String| self.values.contains_key(name) || self.without_value.contains(name);
        let is_unknown =
            |name: &&String| !is_known(name) && !MESH_SETTINGS.contains(&name.as_str()) && *name != CURVE_SETTING;
        for name in self.overrides.keys().filter(is_unknown) {
            let what = Diagnostic::error("D403", format!("`--set {name}`: the deck defines no parameter `{name}`"));
            diagnostics.push(what.help(self.suggestion(name)));
        }
    }
}

/// Returns whether a text contains a `<name>` that could not be replaced, for which an error has been reported.
pub fn is_unresolved(text: &str) -> bool {
    next_reference(text).is_some()
}

/// A `<name>` in a text.
#[derive(Clone, Copy, Debug)]
pub struct ParameterReference<'a> {
    /// Text before the reference.
    pub before: &'a str,
    /// Name of the parameter.
    pub name: &'a str,
    /// Text after the reference.
    pub after: &'a str,
}

/// Returns the first `<name>` of a text.
pub fn next_reference(text: &str) -> Option<ParameterReference<'_>> {
    let mut from = 0;
    while let Some(open) = text[from..].find('<').map(|i| i + from) {
        let close = text[open..].find('>')? + open;
        let name = text[open + 1..close].trim();
        if is_name(name) {
            return Some(ParameterReference { before: &text[..open], name, after: &text[close + 1..] });
        }
        from = open + 1;
    }
    None
}

/// Returns whether a text is a valid name of a parameter: letters, digits and `_`, without a digit at its start.
pub fn is_name(text: &str) -> bool {
    let letter = |c: char| c.is_alphabetic() || c == '_';
    text.starts_with(letter) && text.chars().all(|c| letter(c) || c.is_numeric())
}

/// Returns the line up to the first `#` outside quotes.
fn without_comment(line: &str) -> &str {
    outside_quotes(line, '#').next().map_or(line, |at| &line[..at])
}

/// Splits a line at each `;` outside quotes.
fn statements(line: &str) -> Vec<&str> {
    let mut from = 0;
    let mut parts: Vec<&str> = Vec::new();
    for at in outside_quotes(line, ';') {
        parts.push(&line[from..at]);
        from = at + 1;
    }
    parts.push(&line[from..]);
    parts.into_iter().map(str::trim).filter(|s| !s.is_empty()).collect()
}

/// Iterates over the positions of a character outside quotes.
fn outside_quotes(line: &str, wanted: char) -> impl Iterator<Item = usize> {
    let mut quote = None;
    line.char_indices().filter_map(move |(i, c)| {
        match (c, quote) {
            (c, None) if c == wanted => return Some(i),
            ('"' | '\'', None) => quote = Some(c),
            (c, Some(q)) if c == q => quote = None,
            _ => {}
        }
        None
    })
}

fn unquoted(text: &str) -> Option<&str> {
    let quote = text.chars().next().filter(|c| "'\"".contains(*c))?;
    let inside = text.strip_prefix(quote)?.strip_suffix(quote)?;
    (!inside.contains(quote)).then_some(inside)
}

/// Returns the span of `piece`, which is a part of `line`.
fn part(span: Span, line: &str, piece: &str) -> Span {
    let start = (piece.as_ptr() as usize).saturating_sub(line.as_ptr() as usize) as u32 + span.start;
    Span { file: span.file, start, end: start + piece.len() as u32 }
}

fn offset(span: Span, e: &ExpressionError) -> Span {
    Span { file: span.file, start: span.start + e.start as u32, end: span.start + e.end as u32 }
}
