//! A deck whose parameters stay open: which words follow from some of them, and their numbers for new values, without reading
//! the deck again.
//! Never here: what a word means.

use super::expression::Expression;
use super::number::{format_number, parse_number};
use super::parameters::next_reference;
use super::syntax::{Card, Deck, Row};

/// Words of a deck that follow from parameters.
#[derive(Debug)]
pub struct Template {
    /// Values of all parameters as the deck has them.
    values: Vec<f64>,
    /// Places of the parameters that are given, in their order.
    given: Vec<usize>,
    /// What follows from them, in order: place and expression.
    derived: Vec<(usize, Expression)>,
    names: Vec<String>,
    /// The words.
    pub words: Vec<OpenWord>,
}

/// A word that follows from parameters.
#[derive(Debug)]
pub struct OpenWord {
    /// Index of its card.
    pub card: usize,
    /// Where it stands there.
    pub at: At,
    pieces: Pieces,
}

/// Where a word stands in its card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// The value of a parameter of the keyword line.
    Parameter(&'static str),
    /// A field of a data line.
    Field(usize, usize),
}

/// What a word is made of.
#[derive(Debug)]
enum Pieces {
    /// The value of a parameter and nothing else.
    Whole(usize),
    /// Text with values between: before each of them, and behind the last.
    Mixed(Vec<(String, usize)>, String),
}

impl Template {
    /// What follows from the parameters `given` in a deck; `None` where that needs the deck to be read again: a parameter that is
    /// no number, or has several definitions.
    pub fn of(deck: &Deck, given: &[String]) -> Option<Template> {
        let (names, values): (Vec<String>, Vec<f64>) = deck.parameters.iter().cloned().unzip();
        let place = |name: &str| names.iter().position(|n| n == name);
        let given: Vec<usize> = given.iter().map(|name| place(name)).collect::<Option<_>>()?;
        let mut follows = vec![false; names.len()];
        given.iter().for_each(|&at| follows[at] = true);
        let mut derived = Vec::new();
        for (i, definition) in deck.definitions.iter().enumerate() {
            if deck.definitions[..i].iter().any(|d| d.name == definition.name) {
                return None;
            }
            // A text follows from no number.
            let Some(at) = place(&definition.name).filter(|at| !given.contains(at)) else { continue };
            let expression = Expression::parse(&definition.text).ok()?;
            if expression.names().any(|name| place(name).is_some_and(|p| follows[p])) {
                follows[at] = true;
                derived.push((at, expression));
            }
        }
        let mut template = Template { values, given, derived, names, words: Vec::new() };
        // A heading stays as it is written.
        let read = deck.cards.iter().enumerate().filter(|(_, card)| card.keyword.name != "HEADING");
        for (index, card) in read {
            template.open_words(deck, index, card, &follows)?;
        }
        Some(template)
    }

    fn open_words(&mut self, deck: &Deck, index: usize, card: &Card, follows: &[bool]) -> Option<()> {
        let of_line = card.parameters.iter().filter_map(|p| Some((At::Parameter(p.name), p.value.as_ref()?)));
        // Lines of a listing that stand in the text refer to nothing.
        let listed = card.rows.iter().filter_map(|row| match row {
            Row::Line(line) => Some(&**line),
            Row::Text(_) => None,
        });
        let fields = card
            .lines
            .iter()
            .chain(listed)
            .enumerate()
            .flat_map(|(l, line)| line.fields.iter().enumerate().map(move |(f, word)| (At::Field(l, f), word)));
        for (at, word) in of_line.chain(fields) {
            let text = deck.sources.text(word.span);
            if !self.refers(text, follows) {
                continue;
            }
            // What a quoted text becomes only the reader knows.
            let pieces = if word.quoted { None } else { self.pieces(text) }?;
            self.words.push(OpenWord { card: index, at, pieces });
        }
        Some(())
    }

    /// Whether a text refers to what follows from the given parameters.
    fn refers(&self, text: &str, follows: &[bool]) -> bool {
        let mut rest = text;
        while let Some((_, name, after)) = next_reference(rest) {
            if self.names.iter().position(|n| n == name).is_some_and(|at| follows[at]) {
                return true;
            }
            rest = after;
        }
        false
    }

    /// A text taken apart; `None` where it refers to what is no number.
    fn pieces(&self, text: &str) -> Option<Pieces> {
        let (mut mixed, mut rest) = (Vec::new(), text);
        while let Some((before, name, after)) = next_reference(rest) {
            let at = self.names.iter().position(|n| n == name)?;
            mixed.push((before.to_owned(), at));
            rest = after;
        }
        match &mixed[..] {
            [(before, at)] if before.trim().is_empty() && rest.trim().is_empty() => Some(Pieces::Whole(*at)),
            _ => Some(Pieces::Mixed(mixed, rest.to_owned())),
        }
    }

    /// The numbers of all open words for these values of the given parameters, in `numbers`; `false` where one of them is no
    /// number: reading the deck tells why. `values` is room for the parameters.
    pub fn numbers(&self, given: &[f64], values: &mut Vec<f64>, numbers: &mut Vec<f64>) -> bool {
        values.clone_from(&self.values);
        self.given.iter().zip(given).for_each(|(&at, &value)| values[at] = value);
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

impl Pieces {
    /// Not a number where the text is none.
    fn number(&self, values: &[f64]) -> f64 {
        match self {
            // Written and read back it is the same, but for a zero, which loses its sign.
            Pieces::Whole(at) => values[*at] + 0.0,
            Pieces::Mixed(pieces, rest) => {
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
    fn words_follow_from_what_is_given() {
        let (deck, _) = deck::read_text("t.inp", DECK, &[]);
        let template = Template::of(&deck, &["V".to_owned()]).expect("a template");
        let (mut values, mut numbers) = (Vec::new(), Vec::new());
        assert!(template.numbers(&[0.1], &mut values, &mut numbers));
        // What the heading says follows, too, but nothing is computed with it.
        assert_eq!(numbers, [0.2, -1.0]);
        assert_eq!(template.words[0].at, At::Field(0, 0));
        // Nothing to be read is nothing to be computed with.
        assert!(!template.numbers(&[f64::NAN], &mut values, &mut numbers));
        assert!(Template::of(&deck, &["n".to_owned()]).is_none());
        let (twice, _) =
            deck::read_text("t.inp", "*Parameter\nV = 1.\n*Mass, elset=A\n <V>\n*Parameter\nV = 2.\n", &[]);
        assert!(Template::of(&twice, &["V".to_owned()]).is_none());
        // In a listing as elsewhere.
        let (listed, _) = deck::read_text("t.inp", "*Parameter\nV = 1.\n*Node\n 1, 0., 0.\n 2, <V>, 0.\n", &[]);
        assert_eq!(Template::of(&listed, &["V".to_owned()]).map(|t| t.words.len()), Some(1));
    }
}
