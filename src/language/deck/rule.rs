//! Types of the keyword table. Its rows are in `table/`.

use super::value::{self, ValueSpec};

/// Level of support of a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeywordTier {
    /// Supported without restrictions.
    Used,
    /// Checked and ignored, because it cannot change a result here; the text is the reason in the ledger.
    Inert(&'static str),
    /// Ignored with a note: it changes only output files of ABAQUS.
    OutputOnly,
    /// Unsupported; an error, because ignoring it would change the result.
    UnsupportedPhysics,
    /// Unsupported; ignored with a note, because it does not affect the result.
    UnsupportedInert,
}

/// Level of support of a parameter or of a field of a data line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputUsage {
    /// Supported without restrictions.
    Read,
    /// Only these values are supported; any other is an error with this reason.
    Only(&'static [&'static str], &'static str),
    /// Ignored, because it has no effect here; the text is the reason in the ledger.
    Inert(&'static str),
    /// Unsupported; an error with this reason.
    Refused(&'static str),
}

/// A parameter of a keyword line, or a field of its data lines.
#[derive(Debug)]
pub struct InputRule {
    /// Canonical name. Names of parameters are upper case with single blanks.
    pub name: &'static str,
    /// Level of support.
    pub usage: InputUsage,
    /// One line for the keyword manual; empty if the name or the reason of `usage` is enough.
    pub help: &'static str,
    /// Whether the parameter or field is an extension that ABAQUS does not have.
    pub extension: bool,
    /// Allowed values and default.
    pub value: ValueSpec,
}

/// Layout of the data lines of a card.
#[derive(Debug)]
pub enum DataShape {
    /// The card has no data lines.
    Nothing,
    /// Lines of free text.
    Text(InputRule),
    /// Any number of values on any number of lines.
    List(InputRule),
    /// Groups of values in this order, one group after the other on any number of lines. The reader of the card checks
    /// the number of values.
    Stream(&'static [InputRule]),
    /// Records of a fixed number of values. Each record begins on a new line and may continue on further lines. The
    /// last rule also applies to all further values of the record.
    Wrapped(usize, &'static [InputRule]),
    /// The data lines in this order; with `true` the last one may be repeated.
    Lines(&'static [&'static [InputRule]], bool),
}

/// A layout of data lines and the condition under which it applies.
#[derive(Debug)]
pub struct ConditionalShape {
    /// Parameter and its values (none: any value); `None` applies in all other cases.
    pub when: Option<(&'static str, &'static [&'static str])>,
    /// Layout that applies under this condition.
    pub shape: DataShape,
}

/// Number of times that a card may be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardMultiplicity {
    /// Any number of times.
    Any,
    /// Once in its scope: the deck, the step or the parent card.
    Once,
    /// Once for each value of this parameter.
    Unique(&'static str),
}

/// Position at which a card is allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardPlace {
    /// Before the first step and within steps.
    Anywhere,
    /// Only within a step.
    Step,
    /// Within a step, or before the first step, where it applies to all steps.
    EachStep,
    /// After a card with one of the parent names; only cards with the same parent may be between them.
    Below(&'static [&'static str]),
}

impl CardPlace {
    /// Returns whether the card is allowed after a parent card with this name.
    pub fn is_below(&self, parent: &str) -> bool {
        matches!(self, CardPlace::Below(parents) if parents.contains(&parent))
    }
}

/// Returns the names of parent cards for texts: `*MATERIAL or *SURFACE INTERACTION`.
pub fn parent_names(parents: &[&str]) -> String {
    parents.iter().map(|parent| format!("*{parent}")).collect::<Vec<_>>().join(" or ")
}

/// A row of the keyword table.
#[derive(Debug)]
pub struct Keyword {
    /// Canonical name: upper case, single blanks, without star.
    pub name: &'static str,
    /// Level of support.
    pub tier: KeywordTier,
    /// Whether the keyword is an extension that ABAQUS does not have.
    pub extension: bool,
    /// Description of one line for the manual.
    pub summary: &'static str,
    /// Number of times that the card may be given.
    pub times: CardMultiplicity,
    /// Position at which the card is allowed.
    pub place: CardPlace,
    /// Parameters of the keyword line.
    pub parameters: &'static [InputRule],
    /// Layouts of the data lines; the first one that applies is used.
    pub data: &'static [ConditionalShape],
}

impl Keyword {
    /// Returns the rule of a parameter or field. In a constant, an unknown name is an error of the compiler.
    ///
    /// # Panics
    /// If the card has no such parameter or field.
    pub const fn field(&self, name: &str) -> &'static InputRule {
        let rule = match find(self.parameters, name) {
            None => find_in_data(self.data, name),
            found => found,
        };
        rule.expect("the card has no such parameter or field")
    }

    /// Returns the rule of a parameter by its canonical name.
    pub fn rule(&self, name: &str) -> Option<&'static InputRule> {
        self.parameters.iter().find(|r| r.name == name)
    }

    /// Returns the layout of the data lines. `given` returns the text of a parameter, `Some(None)` for one without a
    /// value.
    pub fn shape<'v>(&self, given: impl Fn(&str) -> Option<Option<&'v str>>) -> &'static DataShape {
        let applies = |data: &&ConditionalShape| match data.when {
            None => true,
            Some((name, wanted)) => {
                let is = |text: &str| value::find_word(wanted, text).is_some();
                given(name).is_some_and(|v| wanted.is_empty() || v.is_some_and(is))
            }
        };
        self.data.iter().find(applies).map_or(&DataShape::Nothing, |data| &data.shape)
    }
}

const fn find(rules: &'static [InputRule], name: &str) -> Option<&'static InputRule> {
    match rules {
        [] => None,
        [first, ..] if is_same(first.name.as_bytes(), name.as_bytes()) => Some(first),
        [_, rest @ ..] => find(rest, name),
    }
}

const fn find_in_lines(lines: &'static [&'static [InputRule]], name: &str) -> Option<&'static InputRule> {
    let [first, rest @ ..] = lines else { return None };
    if let Some(rule) = find(first, name) { Some(rule) } else { find_in_lines(rest, name) }
}

const fn find_in_data(shapes: &'static [ConditionalShape], name: &str) -> Option<&'static InputRule> {
    let [first, rest @ ..] = shapes else { return None };
    let rule_of_shape = match &first.shape {
        DataShape::Nothing => None,
        DataShape::Text(rule) | DataShape::List(rule) => find(std::slice::from_ref(rule), name),
        DataShape::Stream(rules) | DataShape::Wrapped(_, rules) => find(rules, name),
        DataShape::Lines(lines, _) => find_in_lines(lines, name),
    };
    if let Some(rule) = rule_of_shape { Some(rule) } else { find_in_data(rest, name) }
}

const fn is_same(name: &[u8], other: &[u8]) -> bool {
    match (name, other) {
        ([], []) => true,
        ([first, name @ ..], [second, other @ ..]) => *first == *second && is_same(name, other),
        _ => false,
    }
}

impl DataShape {
    /// Returns the rule of the field with index `index` on line `line`; `None` if the card has no such field. `before`
    /// is the number of values on the previous lines of a stream or record.
    pub fn field(&'static self, line: usize, index: usize, before: usize) -> Option<&'static InputRule> {
        match self {
            DataShape::Nothing => None,
            DataShape::Text(rule) | DataShape::List(rule) => Some(rule),
            DataShape::Stream(rules) => rules.get((before + index) % rules.len()),
            DataShape::Wrapped(count, rules) => {
                let position = before % count + index;
                (position < *count).then(|| &rules[position.min(rules.len() - 1)])
            }
            DataShape::Lines(lines, repeats) => {
                let row = if *repeats { line.min(lines.len() - 1) } else { line };
                lines.get(row)?.get(index)
            }
        }
    }

    /// Returns the argument `before` of [`DataShape::field`] for the line after one with `count` values, before which it
    /// was `before`.
    pub fn values_after(&self, before: usize, count: usize) -> usize {
        match self {
            DataShape::Wrapped(record, _) if before + count >= *record => 0,
            _ => before + count,
        }
    }

    /// Returns the rules of all fields.
    pub fn rules(&self) -> Vec<&InputRule> {
        match self {
            DataShape::Nothing => Vec::new(),
            DataShape::Text(rule) | DataShape::List(rule) => vec![rule],
            DataShape::Stream(rules) | DataShape::Wrapped(_, rules) => rules.iter().collect(),
            DataShape::Lines(lines, _) => lines.iter().flat_map(|l| l.iter()).collect(),
        }
    }
}
