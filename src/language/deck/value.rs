//! Allowed values and defaults of parameters and data fields. The values are read in `read.rs`.

use super::names::fold;
use super::number::parse_number;

/// Allowed range and default of a value of a card. Words are stored as their index in the list of allowed words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueSpec {
    /// Syntax of the value.
    pub kind: ValueKind,
    /// Lower bound, and whether the bound itself is allowed.
    low: Option<(f64, bool)>,
    /// Upper bound, and whether the bound itself is allowed.
    high: Option<(f64, bool)>,
    /// Whether the deck must give the value.
    pub required: bool,
    /// Default: the number, or the index of the word.
    pub default: Option<f64>,
    /// Value of a parameter that is given without `=VALUE`: the number, or the index of the word.
    pub bare: Option<f64>,
    /// Whether the value must ascend from row to row of a table.
    pub ascends: bool,
}

/// Syntax of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// Any text, for example a name.
    Text,
    /// A finite number.
    Number,
    /// A whole number.
    Integer,
    /// One word of the list.
    Word(&'static [&'static str]),
    /// A word of this list of supported variants. ABAQUS has other variants.
    Variant(&'static [&'static str]),
}

const fn value(kind: ValueKind) -> ValueSpec {
    ValueSpec { kind, low: None, high: None, required: false, default: None, bare: None, ascends: false }
}

/// Any text, for example a name.
pub const TEXT: ValueSpec = value(ValueKind::Text);
/// Any finite number.
pub const NUMBER: ValueSpec = value(ValueKind::Number);
/// A finite number above zero.
pub const POSITIVE: ValueSpec = NUMBER.above(0.0);
/// A finite number that is not negative.
pub const NOT_NEGATIVE: ValueSpec = NUMBER.from(0.0);
/// A whole number.
pub const INTEGER: ValueSpec = value(ValueKind::Integer);
/// A whole number above zero.
pub const COUNT: ValueSpec = INTEGER.from(1.0);
/// A finite number with the default 0.
pub const ZERO: ValueSpec = NUMBER.or(0.0);
/// The word NO or YES.
pub const YES_NO: ValueSpec = word(&["NO", "YES"]);
/// A parameter without value. YES is accepted, and NO means that it is not given.
pub const FLAG: ValueSpec = YES_NO.or(0.0).bare(1.0);
/// A temperature that must ascend from row to row of a table.
pub const TEMPERATURE: ValueSpec = NUMBER.ascending();

/// Returns the rule of a value that must be one of the given words.
pub const fn word(words: &'static [&'static str]) -> ValueSpec {
    value(ValueKind::Word(words))
}

/// Returns the rule of a value that must be one of the given supported variants.
pub const fn variant(words: &'static [&'static str]) -> ValueSpec {
    value(ValueKind::Variant(words))
}

impl ValueSpec {
    /// Sets an exclusive lower bound.
    pub const fn above(self, low: f64) -> ValueSpec {
        ValueSpec { low: Some((low, false)), ..self }
    }

    /// Sets an inclusive lower bound.
    pub const fn from(self, low: f64) -> ValueSpec {
        ValueSpec { low: Some((low, true)), ..self }
    }

    /// Sets an exclusive upper bound.
    pub const fn below(self, high: f64) -> ValueSpec {
        ValueSpec { high: Some((high, false)), ..self }
    }

    /// Sets an inclusive upper bound.
    pub const fn to(self, high: f64) -> ValueSpec {
        ValueSpec { high: Some((high, true)), ..self }
    }

    /// Makes the value mandatory.
    pub const fn required(self) -> ValueSpec {
        ValueSpec { required: true, ..self }
    }

    /// Sets the default: a number, or the index of a word.
    pub const fn or(self, default: f64) -> ValueSpec {
        ValueSpec { default: Some(default), ..self }
    }

    /// Sets the value of a parameter that is given without `=VALUE`: a number, or the index of a word.
    pub const fn bare(self, bare: f64) -> ValueSpec {
        ValueSpec { bare: Some(bare), ..self }
    }

    /// Requires that the value ascends from row to row of a table.
    pub const fn ascending(self) -> ValueSpec {
        ValueSpec { ascends: true, ..self }
    }

    /// Returns whether a number is finite and in range.
    pub fn allows(&self, number: f64) -> bool {
        let low = self.low.is_none_or(|(low, included)| number > low || included && number == low);
        let high = self.high.is_none_or(|(high, included)| number < high || included && number == high);
        number.is_finite() && low && high
    }

    /// Returns whether a parameter given with this text counts as absent: a flag with NO.
    pub fn is_off(&self, text: &str) -> bool {
        self.kind == YES_NO.kind && self.bare == Some(1.0) && self.number(text) == Some(0.0)
    }

    /// Describes the allowed words or range; empty if there is no restriction.
    pub fn allowed(&self) -> String {
        let words = |list: &[&str]| match list {
            [all @ .., last] if !all.is_empty() => format!("{} or {last}", all.join(", ")),
            _ => list.join(""),
        };
        let whole = if self.kind == ValueKind::Integer { "a whole number " } else { "" };
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
            ValueKind::Text => String::new(),
            ValueKind::Word(list) | ValueKind::Variant(list) => words(list),
            ValueKind::Number | ValueKind::Integer => range,
        }
    }

    /// Returns the allowed words; `None` for texts and numbers.
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.kind {
            ValueKind::Word(list) | ValueKind::Variant(list) => Some(list),
            ValueKind::Text | ValueKind::Number | ValueKind::Integer => None,
        }
    }

    /// Returns the default as text for the keyword manual.
    pub fn default_text(&self) -> Option<String> {
        let default = self.default?;
        Some(match self.words() {
            Some(words) => (*words.get(default as usize)?).into(),
            None => format!("{default}"),
        })
    }

    /// Converts a text to a number, or to the index of a word; `None` if the value is not allowed.
    pub fn number(&self, text: &str) -> Option<f64> {
        match self.words() {
            Some(words) => find_word(words, text).map(|place| place as f64),
            None => parse_number(text).ok().filter(|number| self.allows(*number)),
        }
    }
}

/// Minimum number of letters of an abbreviated word.
const ABBREVIATION: usize = 3;

/// Returns the index of a word in a list. Case and blanks are ignored; words may be abbreviated to three letters or
/// more.
pub fn find_word(words: &[&str], text: &str) -> Option<usize> {
    let folded = fold(text);
    let begins = |word: &&str| folded.len() >= ABBREVIATION && fold(word).starts_with(&folded);
    words.iter().position(|word| fold(word) == folded).or_else(|| words.iter().position(begins))
}
