//! Values of cards: what each may be, and what it is where the deck gives none.
//! Never here: reading them.

use super::names::fold;
use super::number::parse_number;

/// What a value of a card may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// How it is written.
    pub kind: Kind,
    /// Lower bound, and whether it is allowed itself.
    low: Option<(f64, bool)>,
    /// Upper bound, likewise.
    high: Option<(f64, bool)>,
    /// Whether the deck must give it.
    pub required: bool,
    /// The value, or the place among words, where the deck gives none.
    pub default: Option<f64>,
    /// The same of a parameter that is given without a value.
    pub bare: Option<f64>,
    /// Whether it ascends from row to row of a table.
    pub ascends: bool,
}

/// How a value is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A name or a text.
    Text,
    /// A finite number.
    Number,
    /// A whole number.
    Integer,
    /// One of these words.
    Word(&'static [&'static str]),
    /// One of these words; others name variants that are not simulated.
    Variant(&'static [&'static str]),
}

const fn value(kind: Kind) -> Value {
    Value { kind, low: None, high: None, required: false, default: None, bare: None, ascends: false }
}

/// A name or a text.
pub const TEXT: Value = value(Kind::Text);
/// A finite number.
pub const NUMBER: Value = value(Kind::Number);
/// A finite number above zero.
pub const POSITIVE: Value = NUMBER.above(0.0);
/// A finite number that is not negative.
pub const NOT_NEGATIVE: Value = NUMBER.from(0.0);
/// A whole number.
pub const INTEGER: Value = value(Kind::Integer);
/// A whole number above zero.
pub const COUNT: Value = INTEGER.from(1.0);
/// A number that is zero where the deck gives none.
pub const ZERO: Value = NUMBER.or(0.0);
/// NO or YES.
pub const YES_NO: Value = word(&["NO", "YES"]);
/// A temperature of a table, which ascends.
pub const TEMPERATURE: Value = NUMBER.ascending();

/// One of some words.
pub const fn word(words: &'static [&'static str]) -> Value {
    value(Kind::Word(words))
}

/// One of some variants, all that are simulated.
pub const fn variant(words: &'static [&'static str]) -> Value {
    value(Kind::Variant(words))
}

impl Value {
    /// Above a bound.
    pub const fn above(self, low: f64) -> Value {
        Value { low: Some((low, false)), ..self }
    }

    /// At a bound or above.
    pub const fn from(self, low: f64) -> Value {
        Value { low: Some((low, true)), ..self }
    }

    /// Below a bound.
    pub const fn below(self, high: f64) -> Value {
        Value { high: Some((high, false)), ..self }
    }

    /// At a bound or below.
    pub const fn to(self, high: f64) -> Value {
        Value { high: Some((high, true)), ..self }
    }

    /// The deck must give it.
    pub const fn required(self) -> Value {
        Value { required: true, ..self }
    }

    /// It is this, or the word at this place, where the deck gives none.
    pub const fn or(self, default: f64) -> Value {
        Value { default: Some(default), ..self }
    }

    /// It is this, or the word at this place, where the parameter is given without a value.
    pub const fn bare(self, bare: f64) -> Value {
        Value { bare: Some(bare), ..self }
    }

    /// It ascends from row to row.
    pub const fn ascending(self) -> Value {
        Value { ascends: true, ..self }
    }

    /// Whether a number is in range.
    pub fn allows(&self, number: f64) -> bool {
        let low = self.low.is_none_or(|(low, included)| number > low || included && number == low);
        let high = self.high.is_none_or(|(high, included)| number < high || included && number == high);
        number.is_finite() && low && high
    }

    /// What is allowed, in words; empty where everything is.
    pub fn allowed(&self) -> String {
        let words = |list: &[&str]| match list {
            [all @ .., last] if !all.is_empty() => format!("{} or {last}", all.join(", ")),
            _ => list.join(""),
        };
        let whole = if self.kind == Kind::Integer { "a whole number " } else { "" };
        let range = match (self.low, self.high) {
            (None, None) => whole.trim_end().into(),
            (Some((low, false)), None) => format!("{whole}above {low}"),
            (Some((low, true)), None) => format!("{whole}at least {low}"),
            (None, Some((high, false))) => format!("{whole}below {high}"),
            (None, Some((high, true))) => format!("{whole}at most {high}"),
            (Some((low, from)), Some((high, to))) => {
                let low = if from { format!("from {low}") } else { format!("above {low}") };
                let high = if to { format!("to {high}") } else { format!("and below {high}") };
                format!("{whole}{low} {high}")
            }
        };
        match self.kind {
            Kind::Text => String::new(),
            Kind::Word(list) | Kind::Variant(list) => words(list),
            Kind::Number | Kind::Integer => range,
        }
    }

    /// The words that it may be, if it is one of some.
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.kind {
            Kind::Word(list) | Kind::Variant(list) => Some(list),
            Kind::Text | Kind::Number | Kind::Integer => None,
        }
    }

    /// The default as the manual writes it.
    pub fn default_text(&self) -> Option<String> {
        let default = self.default?;
        Some(match self.words() {
            Some(words) => (*words.get(default as usize)?).into(),
            None => format!("{default}"),
        })
    }

    /// The number that a text stands for: of words, its place among them; `None` where it is none that is allowed.
    pub fn number(&self, text: &str) -> Option<f64> {
        match self.words() {
            Some(words) => find_word(words, text).map(|place| place as f64),
            None => parse_number(text).ok().filter(|number| self.allows(*number)),
        }
    }
}

/// Letters of a word that stand for all of it, at least.
const ABBREVIATION: usize = 3;

/// The place of a word among others: case and blanks aside, abbreviated to three letters or more.
pub fn find_word(words: &[&str], text: &str) -> Option<usize> {
    let wanted = fold(text);
    let begins = |word: &&str| wanted.len() >= ABBREVIATION && fold(word).starts_with(&wanted);
    words.iter().position(|word| fold(word) == wanted).or_else(|| words.iter().position(begins))
}
