//! Checks of values beyond the ranges of the keyword table. The readers of cards and [`Model::check`](super::Model::check)
//! share them, so that the same rules apply to decks and to models composed in Rust.

use std::fmt::Display;

use crate::deck::{Diagnostic, Span};

/// A value that is not allowed.
#[derive(Debug)]
pub struct ValueFault {
    /// Index of the data line at fault; `None` for the whole card.
    pub line: Option<usize>,
    pub message: String,
    /// Label of the place.
    pub label: &'static str,
    /// How to fix it; may be empty.
    pub help: &'static str,
}

pub type ValueCheck = Result<(), ValueFault>;

/// Returns a fault of the card unless `is_valid`. A message that is formatted is given as `format_args!`: it is written
/// only if there is a fault.
pub fn require(is_valid: bool, message: impl Display) -> ValueCheck {
    if is_valid {
        Ok(())
    } else {
        Err(ValueFault { line: None, message: message.to_string(), label: "here", help: "" })
    }
}

/// Returns a fault of a data line unless `is_valid`.
pub fn require_line(line: usize, is_valid: bool, message: impl Display) -> ValueCheck {
    require(is_valid, message).map_err(|fault| ValueFault { line: Some(line), ..fault })
}

impl ValueFault {
    /// Returns the diagnostic at a place; `owner` precedes the message.
    pub fn at(self, owner: &str, span: Span) -> Diagnostic {
        let diagnostic = Diagnostic::error("M103", format!("{owner}{}", self.message)).at(span, self.label);
        if self.help.is_empty() { diagnostic } else { diagnostic.help(self.help) }
    }
}

pub fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

pub fn is_non_negative(value: f64) -> bool {
    value >= 0.0 && value.is_finite()
}
