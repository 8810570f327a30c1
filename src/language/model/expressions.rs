//! `*OUTPUT EXPRESSION`: names and texts of derived history columns. `plan/expressions.rs` resolves the names in the
//! text.

use super::context::Context;
use super::names::upper;
use super::types::OutputExpression;
use crate::deck::{Card, Diagnostic, Span, Word};

/// Reads data lines of the form `name = expression`.
pub fn read_output_expressions(context: &mut Context<'_>, card: &Card) {
    for word in card.lines.iter().filter_map(|line| line.fields.first()) {
        let Some((name, text)) = word.text.split_once('=') else {
            no_expression(context, word.span, "there is no equals sign");
            continue;
        };
        let (name, text) = (upper(name), text.trim());
        let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
        if !name.starts_with(letter) || !name.chars().all(|c| letter(c) || c.is_ascii_digit()) {
            let why = "a name consists of letters, digits and `_` and does not start with a digit";
            no_expression(context, word.span, why);
            continue;
        }
        let (text, position) = (text.to_owned(), place_of(word, text));
        context.model.output.expressions.push(OutputExpression { name, text, span: word.span, place: position });
    }
}

fn no_expression(context: &mut Context<'_>, span: Span, why: &str) {
    let diagnostic = Diagnostic::error("M171", format!("invalid history expression: {why}"));
    context.diagnostics.push(diagnostic.at(span, "expected `name = expression`"));
}

/// Returns the source position of a part of a word, or of the whole word if parameters were substituted in it.
fn place_of(word: &Word, piece: &str) -> Span {
    let start = (piece.as_ptr() as usize - word.text.as_ptr() as usize) as u32 + word.span.start;
    if word.text.len() as u32 != word.span.end - word.span.start {
        return word.span;
    }
    Span { start, end: start + piece.len() as u32, ..word.span }
}
