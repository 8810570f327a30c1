//! `*OUTPUT EXPRESSION`: names of history columns that follow from others, and the text that says how.
//! Never here: what the names in the text stand for (`plan/expressions.rs`).

use super::builder::Builder;
use super::names::upper;
use super::types::OutputExpression;
use crate::deck::{Card, Diagnostic, Span, Word};

impl Builder<'_> {
    /// Lines `name = expression`.
    pub(super) fn output_expressions(&mut self, card: &Card) {
        for word in card.lines.iter().filter_map(|line| line.fields.first()) {
            let Some((name, text)) = word.text.split_once('=') else {
                self.no_expression(word.span, "it has no equals sign");
                continue;
            };
            let (name, text) = (upper(name), text.trim());
            let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
            if !name.starts_with(letter) || !name.chars().all(|c| letter(c) || c.is_ascii_digit()) {
                self.no_expression(
                    word.span,
                    "its name is not one of letters, digits and `_` that begins with no digit",
                );
                continue;
            }
            let (text, place) = (text.to_owned(), place_of(word, text));
            self.model.output.expressions.push(OutputExpression { name, text, span: word.span, place });
        }
    }

    fn no_expression(&mut self, span: Span, why: &str) {
        let finding = Diagnostic::error("M171", format!("this defines no history column: {why}"));
        self.diagnostics.push(finding.at(span, "expected `name = expression`"));
    }
}

/// Where a piece of a word stands; the whole word where parameters were put into it.
fn place_of(word: &Word, piece: &str) -> Span {
    let start = (piece.as_ptr() as usize - word.text.as_ptr() as usize) as u32 + word.span.start;
    if word.text.len() as u32 != word.span.end - word.span.start {
        return word.span;
    }
    Span { start, end: start + piece.len() as u32, ..word.span }
}
