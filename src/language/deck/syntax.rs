//! Syntax tree of a deck: cards with parameters and data lines; every word has its span.

use std::sync::Arc;

use super::diagnostic::{Diagnostic, Diagnostics};
use super::keywords::{DataShape, Keyword};
use super::number::{NumberError, parse_number};
use super::parameters::{ParameterDefinition, is_unresolved};
use super::source::{Sources, Span};

/// A deck with includes expanded and `<parameters>` substituted. Names are not resolved.
#[derive(Clone, Debug, Default)]
pub struct Deck {
    /// Files of the deck.
    pub sources: Arc<Sources>,
    /// Cards in the order of the deck.
    pub cards: Vec<Card>,
    /// Names and values of the numeric parameters after overrides, in order of definition.
    pub parameters: Vec<(String, f64)>,
    /// Definitions of all parameters, including text parameters, as written.
    pub definitions: Vec<ParameterDefinition>,
    /// Refinement or coarsening of the mesh; `None` without the setting `mesh`.
    pub mesh_scaling: Option<MeshScaling>,
    /// Elements whose edges are divided, by their index in the model of the deck without scaling; `None` divides all edges.
    pub refined_elements: Option<Arc<[bool]>>,
    /// Largest turning angle of smooth boundaries of a refined mesh, degrees; `None` if boundaries remain polylines.
    pub mesh_curves: Option<f64>,
    /// Parts of the deck that could not be read. Each has been reported as an error.
    pub unread: ParseGaps,
}

impl Deck {
    /// Requests that the edges of some elements are divided into two parts, in place of any other scaling of the mesh.
    pub fn refine_elements(&mut self, is_refined: Arc<[bool]>) {
        self.mesh_scaling = Some(MeshScaling::Refine(2));
        self.refined_elements = Some(is_refined);
    }

    /// Returns the uniform change of the element sizes; `None` if only some elements are refined.
    pub fn uniform_scaling(&self) -> Option<MeshScaling> {
        self.mesh_scaling.filter(|_| self.refined_elements.is_none())
    }
}

/// Parts of a deck that could not be read. References to names that these parts may define are not reported.
#[derive(Clone, Debug, Default)]
pub struct ParseGaps {
    /// Whether a file could not be read; it may have defined any name.
    pub files: bool,
    /// Number of cards that are unknown or unsupported.
    pub cards: usize,
    /// Values of the parameters on keyword lines of unknown or unsupported cards, in upper case.
    pub names: Vec<String>,
}

/// Uniform change of the element sizes of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshScaling {
    /// Each edge is divided into this number of parts.
    Refine(usize),
    /// This number of edges is merged into one.
    Coarsen(usize),
}

impl MeshScaling {
    /// Largest number of parts of an edge.
    pub const FINEST: f64 = 1000.0;

    /// Returns the factor on the lengths of edges.
    pub fn edge_factor(self) -> f64 {
        match self {
            MeshScaling::Refine(parts) => 1.0 / parts as f64,
            MeshScaling::Coarsen(edges) => edges as f64,
        }
    }

    /// Returns the refinement for a whole number of parts, the coarsening for the inverse of one; `None` for other values.
    pub fn from_factor(value: f64) -> Option<MeshScaling> {
        let whole =
            |x: f64| Some(x.round()).filter(|n| (x - n).abs() < 1e-6 * x && (1.0..=MeshScaling::FINEST).contains(n));
        match whole(value) {
            Some(factor) if factor == value => Some(MeshScaling::Refine(factor as usize)),
            _ => whole(1.0 / value).filter(|factor| *factor > 1.0).map(|factor| MeshScaling::Coarsen(factor as usize)),
        }
    }
}

/// A keyword line with its data lines.
#[derive(Clone, Debug)]
pub struct Card {
    /// Row of the keyword table.
    pub keyword: &'static Keyword,
    /// Span of the keyword, including the star.
    pub span: Span,
    /// Parameters of the keyword line.
    pub parameters: Vec<Parameter>,
    /// Data lines, without comments and blank lines. Empty for listings, which have `rows`.
    pub lines: Vec<DataLine>,
    /// Data lines of a listing (`*NODE`, `*ELEMENT`, `*NSET`, `*ELSET`).
    pub rows: Vec<ListingRow>,
    /// Whether an error has been reported for this card. Errors that follow from it are not reported.
    pub faulty: bool,
}

/// A parameter of a keyword line.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Canonical name of the keyword table, upper case with single blanks (`REF NODE`).
    pub name: &'static str,
    /// Span of the name.
    pub span: Span,
    /// Text after the equals sign.
    pub value: Option<Word>,
}

/// A piece of text: quotes removed, blanks trimmed, parameters substituted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Word {
    /// The text; its case is kept.
    pub text: String,
    /// Span of the text in the deck.
    pub span: Span,
    /// Whether the text was in quotes.
    pub quoted: bool,
}

/// A data line, split at its commas.
#[derive(Clone, Debug)]
pub struct DataLine {
    /// Comma-separated fields; an empty field is a [`Word`] with empty text. A trailing comma adds no field.
    pub fields: Vec<Word>,
    /// Span of the whole line.
    pub span: Span,
}

/// A data line of a listing. Plain lines are stored as spans to save memory, and split when they are needed.
#[derive(Clone, Debug)]
pub enum ListingRow {
    /// Span of a line without quotes and parameters.
    Text(Span),
    /// A line with quotes or parameters, split into words.
    Line(Box<DataLine>),
}

impl Card {
    /// Returns the parameter with a canonical name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// Returns the value of a parameter; `None` if the parameter is absent or has no value.
    pub fn value(&self, name: &str) -> Option<&Word> {
        self.parameter(name).and_then(|p| p.value.as_ref())
    }

    /// Returns the layout of the data lines, which may depend on the parameters.
    pub fn shape(&self) -> &'static DataShape {
        let given_parameter = |name: &str| self.parameter(name).filter(|_| self.has(name));
        self.keyword.shape(|name| given_parameter(name).map(|p| p.value.as_ref().map(|w| w.text.as_str())))
    }

    /// Returns whether a parameter is given, with or without a value; a flag with NO is not.
    pub fn has(&self, name: &str) -> bool {
        let is_off = |word: &Word| self.keyword.rule(name).is_some_and(|rule| rule.value.is_off(&word.text));
        self.parameter(name).is_some_and(|parameter| !parameter.value.as_ref().is_some_and(is_off))
    }

    /// Returns the position after the last parameter of the keyword line.
    pub fn keyword_end(&self) -> u32 {
        let end = |p: &Parameter| p.value.as_ref().map_or(p.span.end, |value| value.span.end);
        self.parameters.iter().map(end).fold(self.span.end, u32::max)
    }
}

impl DataLine {
    /// Returns the field at an index; `None` if it is absent or empty.
    pub fn field(&self, index: usize) -> Option<&Word> {
        self.fields.get(index).filter(|w| !w.text.is_empty())
    }
}

impl Word {
    /// Returns whether the text equals a name, ignoring case.
    pub fn is(&self, name: &str) -> bool {
        self.text.eq_ignore_ascii_case(name)
    }

    /// Parses the text as a finite number (`1.`, `.5`, `1.57d0`). If it is not one, reports an error and returns
    /// `None`.
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

    /// Parses the text as an integer. If it is not one, reports an error and returns `None`.
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
