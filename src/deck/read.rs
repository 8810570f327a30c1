//! Values of cards as types: numbers, words by their place, tables. Whether they are allowed has been checked before.
//! Never here: what a value may be.

use super::keywords::{Place, Rule, Shape};
use super::number::parse_number;
use super::syntax::{Card, DataLine, Word};
use super::value::{Kind, TEXT};

/// A value where a deck gives it, and its rule.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// What its card says of it.
    pub rule: Option<&'static Rule>,
    /// `None` where it is absent, `Some(None)` where a parameter has no value.
    pub word: Option<Option<&'a Word>>,
}

impl Given<'_> {
    /// The number that is meant, or the place of the word: the default where there is none, or where it is at fault.
    fn number(&self) -> Option<f64> {
        let value = self.rule.map_or(TEXT, |rule| rule.value);
        match self.word {
            None => value.default,
            Some(None) => value.bare.or(value.default),
            Some(Some(word)) => value.number(&word.text).or(value.default),
        }
    }
}

/// A type that a value is read as. Whether the value is allowed has been checked before.
pub trait FromValue: Sized {
    /// The value.
    fn from_value(given: Given<'_>) -> Self;
}

impl FromValue for f64 {
    fn from_value(given: Given<'_>) -> f64 {
        given.number().unwrap_or(f64::NAN)
    }
}

/// Of words the place among them.
impl FromValue for usize {
    fn from_value(given: Given<'_>) -> usize {
        given.number().map_or(0, |number| number as usize)
    }
}

/// Of words the second; of others, whether it is given.
impl FromValue for bool {
    fn from_value(given: Given<'_>) -> bool {
        match given.rule.map(|rule| rule.value.kind) {
            Some(Kind::Word(_) | Kind::Variant(_)) => given.number() == Some(1.0),
            _ => given.word.is_some(),
        }
    }
}

impl FromValue for String {
    fn from_value(given: Given<'_>) -> String {
        given.word.flatten().map_or(String::new(), |word| word.text.trim().to_uppercase())
    }
}

/// `None` where the deck does not give it, or where it is at fault.
impl<T: FromValue> FromValue for Option<T> {
    fn from_value(given: Given<'_>) -> Option<T> {
        let value = given.rule.map_or(TEXT, |rule| rule.value);
        let good = match given.word? {
            _ if value.kind == Kind::Text => true,
            Some(word) => value.number(&word.text).is_some(),
            None => value.bare.or(value.default).is_some(),
        };
        good.then(|| T::from_value(given))
    }
}

/// A type that the data lines of a card are read as.
pub trait FromLines: Sized {
    /// What the lines hold.
    fn from_lines(card: &Card) -> Self;
}

impl FromLines for () {
    fn from_lines(_: &Card) -> Self {}
}

/// The first line.
impl<const N: usize> FromLines for [f64; N] {
    fn from_lines(card: &Card) -> [f64; N] {
        row(card, 0)
    }
}

/// All lines.
impl<const N: usize> FromLines for Vec<[f64; N]> {
    fn from_lines(card: &Card) -> Vec<[f64; N]> {
        (0..card.lines.len()).map(|line| row(card, line)).collect()
    }
}

/// All values, in a row.
impl FromLines for Vec<f64> {
    fn from_lines(card: &Card) -> Vec<f64> {
        let words = card.lines.iter().flat_map(|line| &line.fields).filter(|word| !word.text.is_empty());
        words.filter_map(|word| parse_number(&word.text).ok()).collect()
    }
}

fn row<const N: usize>(card: &Card, line: usize) -> [f64; N] {
    std::array::from_fn(|field| f64::from_value(card.given_field(line, field)))
}

impl Card {
    /// A parameter, read as a type.
    pub fn read<T: FromValue>(&self, name: &str) -> T {
        let word = self.parameter(name).map(|parameter| parameter.value.as_ref());
        T::from_value(Given { rule: self.keyword.rule(name), word })
    }

    /// Data lines, read as a type.
    pub fn read_lines<T: FromLines>(&self) -> T {
        T::from_lines(self)
    }

    /// A field of a data line, with what the card says of it.
    pub fn given_field(&self, line: usize, field: usize) -> Given<'_> {
        let word = self.lines.get(line).and_then(|l: &DataLine| l.field(field));
        Given { rule: self.shape().field(line, field, 0), word: word.map(Some) }
    }

    /// Whether one data line at least is needed: of a table alone where the card describes one thing and lists none.
    pub fn needs_line(&self) -> bool {
        let lists = !matches!(self.keyword.place, Place::Below(_));
        match self.shape() {
            Shape::Lines(_, true) if lists => false,
            Shape::Lines(lines, _) => lines.first().is_some_and(|rules| rules.iter().any(|r| r.value.required)),
            Shape::List(rule) => rule.value.required,
            _ => false,
        }
    }
}

/// A card as a type: its parameters and data lines, checked before it is read.
pub trait ReadCard: Sized {
    /// The values of a card.
    fn read(card: &Card) -> Self;
}
