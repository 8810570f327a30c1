//! Types of the keyword table: what a card may be given, and what is done with it.
//! Never here: the rows.

use super::value::{self, Value};

/// What is done with a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Read and obeyed.
    Used,
    /// Read and checked; it cannot change a result here, and the ledger says why.
    Inert(&'static str),
    /// Changes only output files of another program: accepted, one summary note.
    OutputOnly,
    /// Known and not supported; ignoring it would change the physics: an error.
    UnsupportedPhysics,
    /// Known and not supported; ignoring it changes no result: a note.
    UnsupportedInert,
}

/// What is done with a parameter or a field of a data line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usage {
    /// It is obeyed: another value gives another result, or is told to be wrong.
    Read,
    /// These values say what is done anyway; every other is an error, for this reason.
    Only(&'static [&'static str], &'static str),
    /// It changes nothing here; the ledger says so with this note.
    Inert(&'static str),
    /// It is an error, for this reason.
    Refused(&'static str),
}

/// A parameter that a keyword line may carry, or a field of its data lines.
#[derive(Debug)]
pub struct Rule {
    /// Canonical name; of parameters upper case with single blanks.
    pub name: &'static str,
    /// What is done with it.
    pub usage: Usage,
    /// One line for the manual; empty where the name says it, or the usage does.
    pub help: &'static str,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// What it may be.
    pub value: Value,
}

/// What the data lines of a card hold.
#[derive(Debug)]
pub enum Shape {
    /// Nothing: the card has no data lines.
    Nothing,
    /// Lines of free text.
    Text(Rule),
    /// Any number of values on any number of lines.
    List(Rule),
    /// Values that repeat in this order over any number of lines; the reader of the card counts them.
    Stream(&'static [Rule]),
    /// Records of so many values, each of which begins on a line of its own and goes on on the next where it is full; the
    /// last rule stands for all values behind it.
    Wrapped(usize, &'static [Rule]),
    /// These lines in this order; `true`: the last of them repeats.
    Lines(&'static [&'static [Rule]], bool),
}

/// A shape, and when the data lines have it.
#[derive(Debug)]
pub struct Data {
    /// The parameter and the value that it must have (empty: any); `None`: in every other case.
    pub when: Option<(&'static str, &'static str)>,
    /// The shape.
    pub shape: Shape,
}

/// How often a card may be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    /// Any number of times.
    Any,
    /// Once in its place.
    Once,
    /// Once for each value of this parameter.
    Unique(&'static str),
}

/// Where a card stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Anywhere.
    Anywhere,
    /// In a step.
    Step,
    /// In a step, or before the first for all.
    EachStep,
    /// Below a card of this kind, with none between but its kin.
    Below(&'static str),
}

/// One keyword.
#[derive(Debug)]
pub struct Keyword {
    /// Canonical name, upper case, single blanks, no star.
    pub name: &'static str,
    /// What is done with it.
    pub tier: Tier,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// One line for the manual.
    pub summary: &'static str,
    /// How often it may be given.
    pub times: Times,
    /// Where it stands.
    pub place: Place,
    /// The parameters it may carry.
    pub parameters: &'static [Rule],
    /// What its data lines hold: the first entry that applies.
    pub data: &'static [Data],
}

impl Keyword {
    /// The rule of a parameter or a field, for values that no deck gives.
    pub fn value(&self, name: &str) -> Option<Value> {
        let fields = self.data.iter().flat_map(|d| d.shape.rules());
        self.parameters.iter().chain(fields).find(|rule| rule.name == name).map(|rule| rule.value)
    }

    /// The rule of a parameter by its canonical name.
    pub fn rule(&self, name: &str) -> Option<&'static Rule> {
        self.parameters.iter().find(|r| r.name == name)
    }

    /// What the data lines hold where `value` gives the text of a parameter (`Some(None)` for one without value).
    pub fn shape<'v>(&self, given: impl Fn(&str) -> Option<Option<&'v str>>) -> &'static Shape {
        let applies = |data: &&Data| match data.when {
            None => true,
            Some((name, wanted)) => {
                let is = |text: &str| value::find_word(&[wanted], text).is_some();
                given(name).is_some_and(|v| wanted.is_empty() || v.is_some_and(is))
            }
        };
        self.data.iter().find(applies).map_or(&Shape::Nothing, |data| &data.shape)
    }
}

impl Shape {
    /// The rule of a field, by the index of its line and its own; `None` for a value that the card does not take.
    /// `before` counts the values on the lines above, of streams and records that go on over lines.
    pub fn field(&'static self, line: usize, index: usize, before: usize) -> Option<&'static Rule> {
        match self {
            Shape::Nothing => None,
            Shape::Text(rule) | Shape::List(rule) => Some(rule),
            Shape::Stream(rules) => rules.get((before + index) % rules.len()),
            Shape::Wrapped(count, rules) => {
                let at = before % count + index;
                (at < *count).then(|| &rules[at.min(rules.len() - 1)])
            }
            Shape::Lines(lines, repeats) => {
                let row = if *repeats { line.min(lines.len() - 1) } else { line };
                lines.get(row)?.get(index)
            }
        }
    }

    /// All rules of its fields.
    pub fn rules(&self) -> Vec<&Rule> {
        match self {
            Shape::Nothing => Vec::new(),
            Shape::Text(rule) | Shape::List(rule) => vec![rule],
            Shape::Stream(rules) | Shape::Wrapped(_, rules) => rules.iter().collect(),
            Shape::Lines(lines, _) => lines.iter().flat_map(|l| l.iter()).collect(),
        }
    }
}
