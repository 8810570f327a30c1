//! Conversion of the values of checked cards to Rust types: numbers, indices of words, tables.

use super::keywords::{CardPlace, DataShape, InputRule};
use super::number::parse_number;
use super::syntax::{Card, DataLine, Word};
use super::value::{TEXT, ValueKind};

/// A value as the deck gives it, with its rule of the keyword table.
#[derive(Clone, Copy, Debug)]
pub struct GivenValue<'a> {
    /// Rule of the parameter or field.
    pub rule: Option<&'static InputRule>,
    /// `None` if absent, `Some(None)` for a parameter without a value.
    pub word: Option<Option<&'a Word>>,
}

impl GivenValue<'_> {
    /// Returns the number or the index of the word; the default if the value is absent or invalid.
    fn number(&self) -> Option<f64> {
        let value = self.rule.map_or(TEXT, |rule| rule.value);
        match self.word {
            None => value.default,
            Some(None) => value.bare.or(value.default),
            Some(Some(word)) => value.number(&word.text).or(value.default),
        }
    }
}

/// Type to which a checked value can be converted.
pub trait FromValue: Sized {
    /// Converts a value; an absent or invalid one gives its default.
    fn from_value(given: GivenValue<'_>) -> Self;
}

impl FromValue for f64 {
    fn from_value(given: GivenValue<'_>) -> f64 {
        given.number().unwrap_or(f64::NAN)
    }
}

/// An integer, or the index of a word.
impl FromValue for usize {
    fn from_value(given: GivenValue<'_>) -> usize {
        given.number().map_or(0, |number| number as usize)
    }
}

/// For a choice of two words: whether the second word is given. For all others: whether the value is given.
impl FromValue for bool {
    fn from_value(given: GivenValue<'_>) -> bool {
        match given.rule.map(|rule| rule.value.kind) {
            Some(ValueKind::Word(_) | ValueKind::Variant(_)) => given.number() == Some(1.0),
            _ => given.word.is_some(),
        }
    }
}

impl FromValue for String {
    fn from_value(given: GivenValue<'_>) -> String {
        given.word.flatten().map_or(String::new(), |word| word.text.trim().to_uppercase())
    }
}

/// `None` if the value is absent or invalid.
impl<T: FromValue> FromValue for Option<T> {
    fn from_value(given: GivenValue<'_>) -> Option<T> {
        let value = given.rule.map_or(TEXT, |rule| rule.value);
        let is_valid = match given.word? {
            _ if value.kind == ValueKind::Text => true,
            Some(word) => value.number(&word.text).is_some(),
            None => value.bare.or(value.default).is_some(),
        };
        is_valid.then(|| T::from_value(given))
    }
}

/// Type to which the data lines of a card can be converted.
pub trait FromLines: Sized {
    /// Converts the data lines of a card.
    fn from_lines(card: &Card) -> Self;
}

impl FromLines for () {
    fn from_lines(_: &Card) -> Self {}
}

/// The first data line.
impl<const N: usize> FromLines for [f64; N] {
    fn from_lines(card: &Card) -> [f64; N] {
        row(card, 0)
    }
}

/// Reads every data line as N numbers.
impl<const N: usize> FromLines for Vec<[f64; N]> {
    fn from_lines(card: &Card) -> Vec<[f64; N]> {
        (0..card.lines.len()).map(|line| row(card, line)).collect()
    }
}

/// All values of all data lines.
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
    /// Returns the parameters and data lines of a checked card.
    pub fn values<T: ReadCard>(&self) -> T {
        T::read(self)
    }

    /// Returns a parameter converted to a type.
    pub fn read<T: FromValue>(&self, name: &str) -> T {
        let word = self.parameter(name).map(|parameter| parameter.value.as_ref());
        T::from_value(GivenValue { rule: self.keyword.rule(name), word })
    }

    /// Returns the data lines converted to a type.
    pub fn read_lines<T: FromLines>(&self) -> T {
        T::from_lines(self)
    }

    /// Returns a field of a data line with its rule.
    pub fn given_field(&self, line: usize, field: usize) -> GivenValue<'_> {
        let word = self.lines.get(line).and_then(|l: &DataLine| l.field(field));
        GivenValue { rule: self.shape().field(line, field, 0), word: word.map(Some) }
    }

    /// Returns whether the card needs at least one data line. A table may be empty on a card outside a material or
    /// interaction.
    pub fn needs_line(&self) -> bool {
        let lists = !matches!(self.keyword.place, CardPlace::Below(_));
        match self.shape() {
            DataShape::Lines(_, true) if lists => false,
            DataShape::Lines(lines, _) => lines.first().is_some_and(|rules| rules.iter().any(|r| r.value.required)),
            DataShape::List(rule) => rule.value.required,
            _ => false,
        }
    }
}

/// Type that holds the parameters and data lines of a checked card.
pub trait ReadCard: Sized {
    /// Converts the parameters and data lines of a card.
    fn read(card: &Card) -> Self;
}
