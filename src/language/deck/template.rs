//! Deck templates: the words of a deck that depend on some parameters, and their values for new parameter values. A
//! search or sample of many runs uses them in place of parsing the deck for each run.

use super::expression::Expression;
use super::number::{format_number, parse_number};
use super::parameters::{ParameterReference, next_reference};
use super::syntax::{Card, Deck, ListingRow};

/// Words of a deck that depend on parameters.
#[derive(Debug)]
pub struct DeckTemplate {
    /// Values of all parameters in the deck.
    values: Vec<f64>,
    /// Indices of the varied parameters.
    varied: Vec<usize>,
    /// Parameters that depend on the varied ones, in the order of evaluation: index and expression.
    derived: Vec<(usize, Expression)>,
    names: Vec<String>,
    /// The words that depend on the varied parameters.
    pub words: Vec<ParametricWord>,
}

/// A word that depends on parameters.
#[derive(Debug)]
pub struct ParametricWord {
    /// Index of the card that contains the word.
    pub card: usize,
    /// Position of the word in the card.
    pub at: WordPosition,
    pieces: WordPieces,
}

/// Position of a word in its card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordPosition {
    /// Value of this parameter of the keyword line.
    Parameter(&'static str),
    /// Line and field index of a data line.
    Field(usize, usize),
}

/// Text of a word with the parameters in it.
#[derive(Debug)]
enum WordPieces {
    /// Only the value of a parameter, by its index.
    Whole(usize),
    /// Text and parameters: each text with the index of the parameter after it, then the text at the end.
    Mixed(Vec<(String, usize)>, String),
}

impl DeckTemplate {
    /// Finds the words that depend on the parameters `given`. Returns `None` if the deck must be parsed for each set of
    /// values: a varied parameter is not numeric, a parameter is defined more than once, or a word in quotes depends on
    /// one.
    pub fn of(deck: &Deck, given: &[String]) -> Option<DeckTemplate> {
        let (names, values): (Vec<String>, Vec<f64>) = deck.parameters.iter().cloned().unzip();
        let index_of = |name: &str| names.iter().position(|n| n == name);
        let varied: Vec<usize> = given.iter().map(|name| index_of(name)).collect::<Option<_>>()?;
        let mut follows = vec![false; names.len()];
        varied.iter().for_each(|&at| follows[at] = true);
        let mut derived = Vec::new();
        for (i, definition) in deck.definitions.iter().enumerate() {
            if deck.definitions[..i].iter().any(|d| d.name == definition.name) {
                return None;
            }
            // Text parameters do not depend on numbers.
            let Some(at) = index_of(&definition.name).filter(|at| !varied.contains(at)) else { continue };
            let expression = Expression::parse(&definition.text).ok()?;
            if expression.names().any(|name| index_of(name).is_some_and(|p| follows[p])) {
                follows[at] = true;
                derived.push((at, expression));
            }
        }
        let mut template = DeckTemplate { values, varied, derived, names, words: Vec::new() };
        // The heading does not affect the model.
        let read = deck.cards.iter().enumerate().filter(|(_, card)| card.keyword.name != "HEADING");
        for (index, card) in read {
            template.open_words(deck, index, card, &follows)?;
        }
        Some(template)
    }

    fn open_words(&mut self, deck: &Deck, index: usize, card: &Card, follows: &[bool]) -> Option<()> {
        let of_line = card.parameters.iter().filter_map(|p| Some((WordPosition::Parameter(p.name), p.value.as_ref()?)));
        // Plain lines of a listing contain no parameters.
        let listed = card.rows.iter().filter_map(|row| match row {
            ListingRow::Line(line) => Some(&**line),
            ListingRow::Text(_) => None,
        });
        let fields = card.lines.iter().chain(listed).enumerate().flat_map(|(l, line)| {
            line.fields.iter().enumerate().map(move |(f, word)| (WordPosition::Field(l, f), word))
        });
        for (at, word) in of_line.chain(fields) {
            let text = deck.sources.text(word.span);
            if !self.refers(text, follows) {
                continue;
            }
            // Only the parser can substitute parameters in quoted text.
            let pieces = if word.quoted { None } else { self.pieces(text) }?;
            self.words.push(ParametricWord { card: index, at, pieces });
        }
        Some(())
    }

    /// Returns whether a text contains a parameter that depends on the varied ones.
    fn refers(&self, text: &str, follows: &[bool]) -> bool {
        let mut remaining = text;
        while let Some(ParameterReference { name, after, .. }) = next_reference(remaining) {
            if self.names.iter().position(|n| n == name).is_some_and(|at| follows[at]) {
                return true;
            }
            remaining = after;
        }
        false
    }

    /// Splits a text into plain text and parameters; `None` if it contains a text parameter.
    fn pieces(&self, text: &str) -> Option<WordPieces> {
        let (mut mixed, mut remaining) = (Vec::new(), text);
        while let Some(ParameterReference { before, name, after }) = next_reference(remaining) {
            let index = self.names.iter().position(|n| n == name)?;
            mixed.push((before.to_owned(), index));
            remaining = after;
        }
        match &mixed[..] {
            [(before, at)] if before.trim().is_empty() && remaining.trim().is_empty() => Some(WordPieces::Whole(*at)),
            _ => Some(WordPieces::Mixed(mixed, remaining.to_owned())),
        }
    }

    /// Computes the numbers of all words for values of the varied parameters and stores them in `numbers`. Returns
    /// `false` if one is not a finite number; parsing the deck then gives the reason. `values` is a work array of the
    /// parameters.
    pub fn numbers(&self, given: &[f64], values: &mut Vec<f64>, numbers: &mut Vec<f64>) -> bool {
        values.clone_from(&self.values);
        self.varied.iter().zip(given).for_each(|(&at, &value)| values[at] = value);
        for (at, expression) in &self.derived {
            let known = |name: &str| self.names.iter().position(|n| n == name).map(|at| values[at]);
            match expression.evaluate(&known, &|_, _| None) {
                Ok(value) => values[*at] = value,
                Err(_) => return false,
            }
        }
        numbers.clear();
        numbers.extend(self.words.iter().map(|word| word.pieces.number(values)));
        numbers.iter().chain(given).all(|number| number.is_finite())
    }
}

impl WordPieces {
    /// Returns the number of a word, NaN if its text is not a number.
    fn number(&self, values: &[f64]) -> f64 {
        match self {
            // The sum removes the sign of -0.0, as formatting and parsing the value would.
            WordPieces::Whole(at) => values[*at] + 0.0,
            WordPieces::Mixed(pieces, rest) => {
                let mut text = String::new();
                for (before, at) in pieces {
                    text += before;
                    text += &format_number(values[*at]);
                }
                parse_number((text + rest).trim()).unwrap_or(f64::NAN)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deck;

    const DECK: &str =
        "*Parameter\nV = 5.\nw = 2.*V\nn = 'x'\nfixed = 3.\n*Heading\n <V>\n*Mass, elset=<n>\n <w>, -<V>e1, <fixed>\n";

    #[test]
    fn dependent_words_are_evaluated_for_new_values() {
        let (deck, _) = deck::read_text("t.inp", DECK, &[]);
        let template = DeckTemplate::of(&deck, &["V".to_owned()]).expect("a template");
        let (mut values, mut numbers) = (Vec::new(), Vec::new());
        assert!(template.numbers(&[0.1], &mut values, &mut numbers));
        // The heading contains <V>, but is left out.
        assert_eq!(numbers, [0.2, -1.0]);
        assert_eq!(template.words[0].at, WordPosition::Field(0, 0));
        // NaN is refused.
        assert!(!template.numbers(&[f64::NAN], &mut values, &mut numbers));
        assert!(DeckTemplate::of(&deck, &["n".to_owned()]).is_none());
        let (twice, _) =
            deck::read_text("t.inp", "*Parameter\nV = 1.\n*Mass, elset=A\n <V>\n*Parameter\nV = 2.\n", &[]);
        assert!(DeckTemplate::of(&twice, &["V".to_owned()]).is_none());
        // Listings are included.
        let (listed, _) = deck::read_text("t.inp", "*Parameter\nV = 1.\n*Node\n 1, 0., 0.\n 2, <V>, 0.\n", &[]);
        assert_eq!(DeckTemplate::of(&listed, &["V".to_owned()]).map(|t| t.words.len()), Some(1));
    }
}
